"""Sine and cosine of an angle from those of one nearby."""

import numpy as np

from lwr_dyn.codegen.rollouts.symbolic_model import SymbolicAngle
from lwr_dyn.codegen.rollouts.symbolic_plant import LARGEST, turned


def test_the_series_are_exact_up_to_the_largest_turn():
    angle, by = np.meshgrid(np.linspace(-7.0, 7.0, 29), np.linspace(-LARGEST, LARGEST, 41))
    found = turned(SymbolicAngle(np.cos(angle), np.sin(angle)), by)
    assert np.abs(found.cosine - np.cos(angle + by)).max() < 2e-15
    assert np.abs(found.sine - np.sin(angle + by)).max() < 2e-15
