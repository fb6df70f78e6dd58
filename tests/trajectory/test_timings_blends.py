"""Blends: tangent and curvature are continuous, lengths are exact, the path stays near, and what is refused."""

import math
from itertools import pairwise

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.path import line, path_of
from lwr_dyn.trajectory.timings import blended
from tests.trajectory.test_path import letter
from tests.trajectory.test_path_segments import assert_smooth_curve


def test_blended_joints_have_continuous_tangent_and_curvature():
    path = blended(letter(), corners=0.03, bends=0.01)
    assert len(path.segments) == 5
    for joint in path.joints():
        assert joint.turn < 1e-7
        assert joint.bend < 1e-7
    assert path.corners() == ()
    for segment in path.segments:
        assert_smooth_curve(segment)


@pytest.mark.parametrize("turn_deg", [20, 90, 140])
def test_the_length_on_a_blend_is_the_length_of_its_chords(turn_deg):
    turn = math.radians(turn_deg)
    after = (math.cos(turn), math.sin(turn), 0)
    path = blended(path_of([line((-1, 0, 0), (0, 0, 0)), line((0, 0, 0), after)]), corners=0.3)
    blend = path.segments[1]
    ends = np.linspace(0.0, blend.length, 4)
    for a, b in pairwise(ends):
        chords = [np.linalg.norm(np.diff(blend.at(np.linspace(a, b, k)).p, axis=0), axis=1).sum() for k in (2001, 4001)]
        assert (4.0 * chords[1] - chords[0]) / 3.0 == pytest.approx(b - a, abs=1e-12)  # without the sagitta's square


def test_blends_stay_near_the_path_they_round():
    sharp, size = letter(), 0.005
    eased = blended(sharp, bends=size)
    dense = sharp.at(np.linspace(0, sharp.length, 200_001)).p
    near = eased.at(np.linspace(0.39, 0.41, 41)).p
    away = max(float(np.min(np.linalg.norm(dense - p, axis=1))) for p in near)
    assert 1e-6 < away < 0.1 * size**2 / 0.075  # a fraction of the sagitta size^2 / radius
    assert abs(eased.length - sharp.length) < 1e-5


def test_a_corner_that_turns_back_is_kept_for_a_stop():
    path = blended(path_of([line((0, 0, 0), (0, 1, 0)), line((0, 1, 0), (0, 0.5, 0))]), corners=0.1)
    (corner,) = path.corners()
    assert corner.turn == pytest.approx(math.pi)
    assert path.sections() == (1.0, 0.5)


def test_blends_may_use_up_a_segment_but_no_more():
    path = path_of([line((0, 0, 0), (1, 0, 0)), line((1, 0, 0), (1, 1, 0)), line((1, 1, 0), (0, 1, 0))])
    assert len(blended(path, corners=0.5).segments) == 4  # the middle line is gone
    with pytest.raises(OptionError, match=r"0\.6 m and 0\.6 m at the ends of segment 1; allowed: together at most"):
        blended(path, corners=0.6)
    with pytest.raises(OptionError, match=r"corners: -0\.1"):
        blended(path, corners=-0.1)
