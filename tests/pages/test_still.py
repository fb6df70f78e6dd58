"""The picture of an arm: as large as the arm is, another at another pose, and with the path of a run over it."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from lwr_dyn.pages.replay.look import RUN_COLOURS
from lwr_dyn.pages.still import arm_still
from tests.pages.explorer.explored import explored_arm


def grey(png):
    return np.asarray(Image.open(BytesIO(png)).convert("L"), dtype=float)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lwr4plus computed", "tiago", "hung"])
def test_a_still_shows_the_arm_at_its_pose(name):
    arm = explored_arm(name)
    q = np.clip(np.full(arm.n, 0.4), arm.lower, arm.upper)
    picture = grey(arm_still(arm, q))
    assert 0.02 < (picture < 235).mean() < 0.6
    assert np.abs(picture - grey(arm_still(arm, np.clip(0.0 * q, arm.lower, arm.upper)))).max() > 50


def test_the_same_arm_gives_the_same_bytes(arm):
    assert arm_still(arm, np.zeros(7)) == arm_still(arm, np.zeros(7))


@pytest.mark.slow
def test_the_path_of_a_run_is_drawn_in_its_colour(arm, two_runs):
    run = two_runs[1]
    stills = [arm_still(arm, run.q[-1], one) for one in (run, None)]
    pictures = [np.asarray(Image.open(BytesIO(png)).convert("RGB")).astype(int) for png in stills]
    ink = [int(RUN_COLOURS[0][i : i + 2], 16) for i in (1, 3, 5)]
    with_path, alone = ((np.abs(picture - ink).max(axis=-1) <= 2).sum() for picture in pictures)
    assert with_path > 100
    assert alone == 0
