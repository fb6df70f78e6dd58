"""Curves of poses: ends, constant rates, waypoints that are passed, and turns without a shortest way."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.cartesian.legs import Pace
from lwr_dyn.trajectory.motion_profile import quintic
from lwr_dyn.trajectory.pose_path import steps_between, straight, through


def pose(xyz, rotvec=(0.0, 0.0, 0.0)):
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = xyz, Rotation.from_rotvec(rotvec).as_matrix()
    return T


def test_a_straight_curve_moves_and_turns_at_a_constant_share():
    start, end = pose((0.1, 0.2, 0.3), (0.3, 0.0, 0.1)), pose((0.4, 0.2, 0.7), (0.0, 1.0, 0.0))
    curve = straight(start, end)
    T = curve.poses(np.linspace(0.0, 1.0, 5))
    np.testing.assert_allclose(T[[0, -1]], [start, end], atol=1e-15)
    np.testing.assert_allclose(np.diff(T[:, :3, 3], axis=0), [[0.075, 0.0, 0.1]] * 4, atol=1e-15)
    turns = [Rotation.from_matrix(b[:3, :3] @ a[:3, :3].T).as_rotvec() for a, b in pairwise(T)]
    np.testing.assert_allclose(turns, [turns[0]] * 4, atol=1e-15)
    assert curve.length == pytest.approx(0.5)
    assert curve.turn == pytest.approx(4.0 * np.linalg.norm(turns[0]))


def test_a_smooth_curve_passes_its_waypoints_without_a_corner():
    waypoints = np.array([pose((0, 0, 0)), pose((1, 0, 0), (0, 0, 1.0)), pose((1, 1, 0), (0, 1.0, 0)), pose((0, 1, 1))])
    curve = through(waypoints)
    np.testing.assert_allclose(curve.poses(np.array(curve.marks)), waypoints, atol=1e-14)
    for u in curve.marks[1:-1]:
        before, at, after = curve.poses(np.array([u - 1e-6, u, u + 1e-6]))
        np.testing.assert_allclose(at - before, after - at, atol=1e-9)
    assert curve.length > 2.0 + np.sqrt(2.0)


def test_half_a_turn_has_no_shortest_way():
    with pytest.raises(OptionError, match=r"waypoint 2: half a turn.*put a waypoint in between"):
        straight(pose((0, 0, 0)), pose((1, 0, 0), (np.pi, 0, 0)), "waypoint 2")


def test_waypoints_that_are_the_same_are_refused():
    with pytest.raises(OptionError, match="waypoints 2 and 3: the same pose"):
        through(np.array([pose((0, 0, 0)), pose((1, 0, 0)), pose((1, 0, 0))]))


@pytest.mark.slow
@pytest.mark.parametrize(
    "stops", [((0, 0), (0, 0.9), (0.05, 0.9), (0.05, 1.8)), ((0, 0), (0.3, 0), (0.3, 0.9), (0.6, 0.9))]
)
@pytest.mark.parametrize(("speed", "turn_speed"), [(0.05, 100.0), (100.0, 0.5)])
def test_a_smooth_curve_keeps_the_speeds_where_it_is_fastest(stops, speed, turn_speed):
    curve = through(np.array([pose((x, 0, 0), (0, 0, angle)) for x, angle in stops]))
    duration, moments = Pace(speed, turn_speed, turning=True).least(curve), 50_001
    at = quintic(1.0, duration).at(np.linspace(0.0, duration, moments))
    ways, turns = steps_between(curve.poses(at.s))
    shares = ways.max() / speed, turns.max() / turn_speed
    assert max(shares) * (moments - 1) / duration == pytest.approx(1.0, rel=1e-5)
