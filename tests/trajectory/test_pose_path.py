"""Timed pose paths: spatial velocity and acceleration against differences of the poses; curves through poses."""

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
from tests.trajectory.differences import check_derivatives, places_around, slope

STEP = 1e-3
"""[s] Eighth order of motions that last seconds: truncation below rounding, 1e-16 / 1e-3."""
DIFFERENCE = 1e-11
START, END = rot_x(0.4) @ rot_y(-1.0), rot_z(2.0) @ rot_x(1.0)


def turning_arc():
    path = path_of([arc((0.3, 0.1, 0), (0.2, 0.1, 0), (1, 0, 5) @ rot_y(math.atan2(1, 5)), 1.3)])
    return timed_pose_path(path, slerp(START, END, path.length), quintic(path.length, 2.0))


def test_velocity_and_acceleration_are_the_derivatives_of_the_pose():
    poses, t = turning_arc(), np.linspace(0.01, 1.99, 37)
    here, dT = poses.at(t), slope(poses.at(places_around(t, STEP)).T, STEP)
    np.testing.assert_allclose(here.velocity[:, :3], dT[:, :3, 3], atol=DIFFERENCE)
    spin = dT[:, :3, :3] @ np.swapaxes(here.T[:, :3, :3], 1, 2)
    x, y, z = here.velocity[:, 3:].T
    wanted = np.array([[0 * x, -z, y], [z, 0 * x, -x], [-y, x, 0 * x]]).transpose(2, 0, 1)
    np.testing.assert_allclose(spin, wanted, atol=DIFFERENCE)
    check_derivatives(poses.at, t, STEP, ("velocity", "acceleration"), atol=DIFFERENCE)


@pytest.mark.slow
def test_blended_path_with_a_smooth_law_has_no_jump_of_acceleration_anywhere():
    path = path_of([line((0, 0, 0.3), (0, 0, 0)), line((0, 0, 0), (0, 0.3, 0))])
    path = blended(path, corners=0.05)
    poses = timed_pose_path(path, constant_orientation(np.eye(3)), double_s_in(path.sections(), 3.0, 0.5, 5.0))
    h = 1e-5
    a = poses.at(np.arange(0.0, 3.0, h)).acceleration
    assert np.abs(np.diff(a, axis=0)).max() / h < 30.0  # bounded: an unblended corner gives 0.2 m/s / h = 2e4


def test_slerp_reaches_both_ends_the_short_way_and_stands_still_outside():
    poses = turning_arc()
    ends = poses.at([-1.0, 0.0, 2.0, 9.0])
    np.testing.assert_allclose(ends.T[:, :3, :3], [START, START, END, END], atol=1e-14)
    assert not ends.velocity[[0, 3]].any()
    assert poses.orientation.rate * poses.length < math.pi
    assert slerp(START, START, 1.0).rate == 0.0
    assert slerp(np.eye(3), rot_z(math.pi - 2e-6), 2.0).rate == pytest.approx(math.pi / 2, abs=2e-6)


def pose(xyz, rotvec=(0.0, 0.0, 0.0)):
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = xyz, Rotation.from_rotvec(rotvec).as_matrix()
    return T


UNIT = path_of([line((0, 0, 0), (1, 0, 0))])
HALF = "half a turn from the pose before; allowed: less than 180 deg; put a waypoint in between"
BAD = [
    (lambda: constant_orientation(np.eye(4)), ShapeError, "R: an array of 4 x 4 numbers"),
    (lambda: constant_orientation(1.1 * np.eye(3)), OptionError, r"R: R R\^T differs from 1 by 0.21; allowed: a rotat"),
    (lambda: constant_orientation((1.0 + 6e-7) * np.eye(3)), OptionError, r"R R\^T differs from 1 by 1.2e-06"),
    (lambda: constant_orientation(np.diag([1.0, 1.0, -1.0])), OptionError, "R: left-handed; allowed: a rotation mat"),
    (lambda: slerp(np.eye(3), rot_z(math.pi - 5e-7), 1.0), OptionError, "R_end: half a turn .* less than 180 deg"),
    (lambda: slerp(2.0 * np.eye(3), np.eye(3), 1.0), OptionError, "R_start: R R"),
    (lambda: timed_pose_path(UNIT, constant_orientation(np.eye(3)), quintic(1.0 + 2e-9, 1.0)), OptionError,
     "profile: a length of 1; allowed: the path's length, 1 m"),
    (lambda: timed_pose_path(UNIT, constant_orientation(np.eye(3)), quintic(2.0, 1.0)), OptionError,
     "profile: a length of 2; allowed: the path's length, 1 m"),
    (lambda: turning_arc().at([np.nan]), ShapeError, "nan"),
    (lambda: straight(pose((0, 0, 0)), pose((1, 0, 0), (np.pi - 5e-7, 0, 0)), "waypoint 2"), OptionError,
     f"waypoint 2: {HALF}"),
    (lambda: through(np.array([pose((0, 0, 0)), pose((1, 0, 0)), pose((1, 0, 0), (np.pi, 0, 0))])), OptionError,
     f"waypoint 3: {HALF}"),
    (lambda: through(np.array([pose((0, 0, 0)), pose((1, 0, 0)), pose((1, 0, 0))])), OptionError,
     "waypoints 2 and 3: the same pose; allowed: waypoints apart from each other"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "error", "says"), BAD, ids=[says for *_, says in BAD])
def test_what_is_no_rotation_no_match_or_no_curve_is_refused(make, error, says):
    with pytest.raises(error, match=says):
        make()


def test_a_straight_curve_moves_and_turns_at_a_constant_share():
    start, end = pose((0.1, 0.2, 0.3), (0.3, 0.0, 0.1)), pose((0.4, 0.2, 0.7), (0.0, 1.0, 0.0))
    curve = straight(start, end)
    T = curve.poses(np.linspace(0.0, 1.0, 5))
    np.testing.assert_allclose(T[[0, -1]], [start, end], atol=1e-15)
    np.testing.assert_allclose(np.diff(T[:, :3, 3], axis=0), [[0.075, 0.0, 0.1]] * 4, atol=1e-15)
    turns = [Rotation.from_matrix(b[:3, :3] @ a[:3, :3].T).as_rotvec() for a, b in pairwise(T)]
    np.testing.assert_allclose(turns, [turns[0]] * 4, atol=1e-15)
    assert (curve.length, curve.turn) == pytest.approx((0.5, 4.0 * np.linalg.norm(turns[0])))
    assert curve.marks == (0.0, 1.0)


def test_a_smooth_curve_passes_its_waypoints_without_a_corner():
    """u is the share of the chords, in which a turn of 1 rad counts as 1 m."""
    waypoints = np.array([pose((0, 0, 0)), pose((1, 0, 0), (0, 0, 1.0)), pose((1, 1, 0), (0, 1.0, 0)), pose((0, 1, 1))])
    curve = through(waypoints)
    relative = Rotation.from_rotvec([0, 0, 1.0]).inv() * Rotation.from_rotvec([0, 1.0, 0])
    steps = [np.sqrt(2.0), np.hypot(1.0, relative.magnitude()), np.sqrt(3.0)]
    np.testing.assert_allclose(curve.marks, np.cumsum([0.0, *steps]) / sum(steps), rtol=1e-14)
    np.testing.assert_allclose(curve.poses(np.array(curve.marks)), waypoints, atol=1e-14)
    for u in curve.marks[1:-1]:
        before, at, after = curve.poses(np.array([u - 1e-6, u, u + 1e-6]))
        np.testing.assert_allclose(at - before, after - at, atol=1e-9)
    ways, turns = steps_between(curve.poses(np.linspace(0.0, 1.0, 20_001)))
    assert (curve.length, curve.turn) == pytest.approx((ways.sum(), turns.sum()), rel=1e-3)


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
