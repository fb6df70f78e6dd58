"""The picture of an arm: as large as the arm is, and another at another pose."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from lwr_dyn.pages.explorer.shown import arm_still
from tests.pages.explorer.explored import explored_arm


def grey(png):
    return np.asarray(Image.open(BytesIO(png)).convert("L"), dtype=float)


@pytest.mark.parametrize("name", ["lwr4plus computed", "tiago", "hung"])
def test_a_still_shows_the_arm_at_its_pose(name):
    arm = explored_arm(name)
    q = np.clip(np.full(arm.n, 0.4), arm.lower, arm.upper)
    picture = grey(arm_still(arm, q))
    assert 0.02 < (picture < 235).mean() < 0.6
    assert np.abs(picture - grey(arm_still(arm, np.clip(0.0 * q, arm.lower, arm.upper)))).max() > 50


def test_the_same_arm_gives_the_same_bytes(arm):
    assert arm_still(arm, np.zeros(7)) == arm_still(arm, np.zeros(7))
