"""Tests of `lwr_dyn.environment`: what acts on an arm from outside."""
