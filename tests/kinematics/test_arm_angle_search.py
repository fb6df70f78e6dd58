"""Corridors of arm angles: intervals that overlap from pose to pose, unwrapped, or where they end."""

import numpy as np
import pytest

from lwr_dyn.kinematics.arm_angle import Corridor, CorridorBreak, connected_arm_angles, overlap
from lwr_dyn.kinematics.srs_margins import AngleIntervals


def test_corridors_across_the_seam_are_unwrapped():
    intervals = AngleIntervals(np.array([[3.0], [-3.2], [-3.1]]), np.array([[3.3], [-2.8], [-2.5]]))
    result = connected_arm_angles(intervals)
    assert isinstance(result, Corridor)
    assert result.low == pytest.approx([3.0, 2 * np.pi - 3.2, 2 * np.pi - 3.1])


def test_a_chain_that_ends_is_found():
    nan = np.nan
    intervals = AngleIntervals(
        np.array([[0.0, 2.0], [0.1, nan], [2.0, nan]]), np.array([[1.0, 3.0], [0.9, nan], [3.0, nan]])
    )
    assert connected_arm_angles(intervals) == CorridorBreak(2)
    assert connected_arm_angles(AngleIntervals(np.array([[nan]]), np.array([[nan]]))) == CorridorBreak(0)
    assert overlap((0.0, 1.0), (2.0, 3.0))[0] == pytest.approx(-1.0)
    assert overlap((-np.pi, np.pi), (3.0, 3.5))[0] == pytest.approx(0.5)


@pytest.mark.parametrize("middle", [-3.0, -0.2, 0.2, 3.0])
def test_beside_a_whole_circle_an_interval_stays_where_it_is(middle):
    whole, narrow = (-np.pi, np.pi), (middle - 0.1, middle + 0.1)
    for a, b in ((whole, narrow), (narrow, whole)):
        width, turn = overlap(a, b)
        assert (width, turn) == (pytest.approx(0.2), 0.0)
