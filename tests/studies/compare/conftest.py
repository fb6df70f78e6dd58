"""A short move of the arm."""

import numpy as np
import pytest

import lwr_dyn

POSE = np.radians([0, 30, 0, -60, 0, 30, 0])


@pytest.fixture(scope="session")
def move(arm):
    return lwr_dyn.reference("point-to-point", arm, start=POSE, end=POSE + 0.05, duration=0.3)
