"""Timed pose paths: spatial velocity and acceleration against differences of the poses."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.spatial import rot_x, rot_y, rot_z
from lwr_dyn.trajectory.cartesian.legs import Pace
from lwr_dyn.trajectory.motion_profile import quintic
from lwr_dyn.trajectory.path import arc, line, path_of
from lwr_dyn.trajectory.pose_path import constant_orientation, slerp, steps_between, straight, through, timed_pose_path
from lwr_dyn.trajectory.timings import blended, double_s_in

STENCIL = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
STEP = 1e-3
"""[s] Eighth order of motions that last seconds: truncation below rounding, 1e-16 / 1e-3."""
DIFFERENCE = 1e-11
START, END = rot_x(0.4) @ rot_y(-1.0), rot_z(2.0) @ rot_x(1.0)


def turning_arc():
    path = path_of([arc((0.3, 0.1, 0), (0.2, 0.1, 0), (1, 0, 5) @ rot_y(math.atan2(1, 5)), 1.3)])
    return timed_pose_path(path, slerp(START, END, path.length), quintic(path.length, 2.0))


def vee(S):
    return np.stack([S[:, 2, 1], S[:, 0, 2], S[:, 1, 0]], axis=1)


def test_velocity_and_acceleration_are_the_derivatives_of_the_pose():
    poses = turning_arc()
    t = np.linspace(0.01, 1.99, 37)
    here, around = poses.at(t), poses.at((t[:, None] + STEP * STENCIL).ravel())
    dT = np.einsum("ksij,s->kij", around.T.reshape(len(t), -1, 4, 4), WEIGHTS) / STEP
    dv = np.einsum("ksi,s->ki", around.velocity.reshape(len(t), -1, 6), WEIGHTS) / STEP
    np.testing.assert_allclose(here.velocity[:, :3], dT[:, :3, 3], atol=DIFFERENCE)
    spin = dT[:, :3, :3] @ np.swapaxes(here.T[:, :3, :3], 1, 2)
    np.testing.assert_allclose(spin, -np.swapaxes(spin, 1, 2), atol=DIFFERENCE)
    np.testing.assert_allclose(here.velocity[:, 3:], vee(spin), atol=DIFFERENCE)
    np.testing.assert_allclose(here.acceleration, dv, atol=DIFFERENCE)


@pytest.mark.slow
def test_blended_path_with_a_smooth_law_has_no_jump_of_acceleration_anywhere():
    path = path_of([line((0, 0, 0.3), (0, 0, 0)), line((0, 0, 0), (0, 0.3, 0))])
    path = blended(path, corners=0.05)
    poses = timed_pose_path(path, constant_orientation(np.eye(3)), double_s_in(path.sections(), 3.0, 0.5, 5.0))
    h = 1e-5
    a = poses.at(np.arange(0.0, 3.0, h)).acceleration
    jerk = np.abs(np.diff(a, axis=0)).max() / h
    assert jerk < 30.0  # bounded: an unblended corner gives 0.2 m/s / h = 2e4


def test_slerp_reaches_both_ends_the_short_way_and_stands_still_outside():
    poses = turning_arc()
    ends = poses.at([-1.0, 0.0, 2.0, 9.0])
    np.testing.assert_allclose(ends.T[:2, :3, :3], [START, START], atol=1e-14)
    np.testing.assert_allclose(ends.T[2:, :3, :3], [END, END], atol=1e-14)
    assert not ends.velocity[[0, 3]].any()
    assert poses.orientation.rate * poses.length < math.pi
    assert slerp(START, START, 1.0).rate == 0.0


def test_what_is_no_rotation_or_no_match_is_refused():
    with pytest.raises(ShapeError, match="R: an array of 4 x 4 numbers"):
        constant_orientation(np.eye(4))
    with pytest.raises(OptionError, match="differs from 1"):
        constant_orientation(1.1 * np.eye(3))
    with pytest.raises(OptionError, match="left-handed"):
        constant_orientation(np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(OptionError, match="less than 180 deg"):
        slerp(np.eye(3), rot_z(math.pi), 1.0)
    path = path_of([line((0, 0, 0), (1, 0, 0))])
    with pytest.raises(OptionError, match="a length of 2; allowed: the path's length, 1 m"):
        timed_pose_path(path, constant_orientation(np.eye(3)), quintic(2.0, 1.0))
    with pytest.raises(ShapeError, match="nan"):
        turning_arc().at([np.nan])


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
