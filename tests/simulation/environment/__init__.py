"""Tests of `lwr_dyn.simulation.environment`: what acts on an arm from outside."""
