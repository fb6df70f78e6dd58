"""KUKA's pose: mm, A B C, Status and Turn."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.six_joints.spherical_wrist import require_wrist_arm
from lwr_dyn.krl.robot.kuka_pose import (
    KukaPose,
    abc_of_rotation,
    degenerate_abc,
    has_kuka_axes,
    kuka_pose,
    pose_of_matrix,
    rotation_of_abc,
    status,
    turn,
    with_status_and_turn,
)
from lwr_dyn.model.spatial import rot_x, rot_y, rot_z

DIGITS = 1e-9
"""[mm, deg] A few roundings of a pose metres long."""


def six(pose):
    return (pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg)


def test_mastering_and_stretched_out(arm):
    home = kuka_pose(arm, np.array(arm.mastering))
    assert six(home) == pytest.approx((1340, 0, 1810, 0, 90, 0), abs=DIGITS)
    assert (home.s, home.t) == (2, 2)
    ahead = kuka_pose(arm, np.zeros(6))
    assert six(ahead) == pytest.approx((2190, 0, 960, 0, 90, 0), abs=DIGITS)
    assert (ahead.s, ahead.t) == (0, 0)


@pytest.mark.parametrize(("axis", "moves"), [(0, "-y"), (1, "-z"), (2, "-z")])
def test_axes_turn_the_way_kuka_counts_them(arm, axis, moves):
    step = lwr_dyn.forward_kinematics(arm, 1e-3 * np.eye(6)[axis])[:3, 3] - [2.19, 0, 0.96]
    assert np.sign(step["xyz".index(moves[1])]) == -1.0


@given(st.tuples(st.floats(-180, 180), st.floats(-90, 90), st.floats(-180, 180)))
def test_abc_there_and_back(abc):
    R = rotation_of_abc(abc)
    a, b, c = np.radians(abc)
    np.testing.assert_allclose(R, rot_z(a) @ rot_y(b) @ rot_x(c), atol=1e-15)
    np.testing.assert_allclose(rotation_of_abc(abc_of_rotation(R)), R, atol=1e-11)


@pytest.mark.parametrize("b", [90.0, -90.0])
def test_at_b_of_ninety_a_is_zero_and_c_takes_all(b):
    assert degenerate_abc((0, b, 0))
    a, back, c = abc_of_rotation(rotation_of_abc((20.0, b, 50.0)))
    assert (a, back) == (0.0, pytest.approx(b))
    assert c == pytest.approx(50.0 - 20.0 * np.sign(b))


def test_a_pose_is_its_matrix():
    pose = KukaPose(91.0, -1139.0, 1392.0, 10.0, 20.0, 30.0)
    assert six(pose_of_matrix(pose.matrix())) == pytest.approx(six(pose), abs=DIGITS)
    with pytest.raises(ShapeError):
        rotation_of_abc((1.0, 2.0))


def test_status_bits_one_by_one(arm):
    phi = np.degrees(np.arctan2(145, 820))
    assert np.degrees(require_wrist_arm(arm).straight) == pytest.approx(phi)
    for degrees, s in (
        ((0, -90, 90, 0, 0, 0), 0b010),
        ((0, -30, phi - 0.01, 0, 0, 0), 0b000),
        ((0, -30, phi + 0.01, 0, 0, 0), 0b010),
        ((0, -30, 0, 0, -5, 0), 0b100),
        ((0, -30, 0, 0, 5, 0), 0b000),
        ((0, -130, -30, 0, 5, 0), 0b001),
        ((100, -130, -30, 0, -5, 0), 0b101),
    ):
        assert status(arm, np.radians(degrees)) == s, degrees


def test_status_does_not_change_with_the_direction_of_the_arm(arm):
    rng = np.random.default_rng(0)
    for q in rng.uniform(arm.lower, arm.upper, (200, 6)):
        other = q.copy()
        other[0] = rng.uniform(arm.lower[0], arm.upper[0])
        assert status(arm, q) == status(arm, other)


def test_turn_bits():
    assert turn(np.radians([-1, 1, -1, 1, -1, 1])) == 0b010101
    assert turn(np.array([-1e-15, 0, 0, 0, 0, -0.0])) == 0


def test_branches_of_one_pose_differ_in_status(arm):
    q = np.radians([20.0, -110.0, 110.0, 40.0, 50.0, -70.0])
    result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q), limits=False)
    pairs = [(status(arm, s.q), turn(s.q)) for s in result.solutions]
    assert {s for s, _ in pairs} == set(range(8))
    assert len(set(pairs)) == len(pairs)


def test_status_and_turn_choose_and_what_no_branch_has_is_refused(arm):
    q = np.radians([20.0, -60.0, 100.0, 40.0, 50.0, -70.0])
    result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q)).solutions
    (only,) = with_status_and_turn(arm, result, status(arm, q), turn(q))
    assert np.abs(only.q - q).max() < 1e-9
    assert len(with_status_and_turn(arm, result)) == len(result)
    with pytest.raises(OptionError, match="no solution has S 7, T 1; allowed: S "):
        with_status_and_turn(arm, result, 7, 1)
    with pytest.raises(OptionError, match="the pose has no solution"):
        with_status_and_turn(arm, (), 0)


def test_kuka_axes_are_recognised(arm):
    assert has_kuka_axes(arm)
    assert not has_kuka_axes(lwr_dyn.load("kr30ha", "printed"))
    assert not has_kuka_axes(lwr_dyn.load("lwr4plus"))
