"""Closed loops in time: plant, sensors, integrators, position stops, the energy audit, and figures of merit."""
