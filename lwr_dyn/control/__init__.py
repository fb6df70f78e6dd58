"""Controllers, their gains, and the worst-case inertia they are drawn from."""
