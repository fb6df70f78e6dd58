"""Sine and cosine of an angle from those of one nearby."""

import numpy as np

from lwr_dyn.codegen.kernels.lean_recursion import Turn
from lwr_dyn.codegen.rollouts.symbolic_arm import LARGEST, turned


def test_the_series_are_exact_up_to_the_largest_turn():
    angle, by = np.meshgrid(np.linspace(-7.0, 7.0, 29), np.linspace(-LARGEST, LARGEST, 41))
    found = turned(Turn(np.cos(angle), np.sin(angle)), by)
    assert np.abs(found.c - np.cos(angle + by)).max() < 2e-15
    assert np.abs(found.s - np.sin(angle + by)).max() < 2e-15
