"""Joint positions along curves: on the curve, inside the limits, in small steps, and where they stop."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.trajectory.cartesian.tracking import JUMP, ON_CURVE, attempts, is_inside, onto_pose, pose_error
from lwr_dyn.trajectory.pose_path import straight

START = np.array([0.2, 0.6, -0.3, -1.2, 0.4, 0.9, 0.1])


def line(arm, q, shift):
    T = lwr_dyn.forward_kinematics(arm, q)
    end = T.copy()
    end[:3, 3] += shift
    return straight(T, end)


@pytest.mark.slow
@pytest.mark.parametrize("turning", [True, False])
def test_tracked_positions_are_on_the_curve_inside_the_limits_and_without_jumps(turning):
    arm = lwr_dyn.load("lwr4plus")
    curve = line(arm, START, [0.1, 0.1, 0.05])
    for tracked in attempts(arm, curve, START, turning):
        assert tracked.is_whole
        errors, _ = pose_error(arm, curve.poses(tracked.u), tracked.q, turning)
        assert np.abs(errors).max() <= 10.0 * ON_CURVE
        assert all(is_inside(arm, q) for q in tracked.q)
        assert np.abs(np.diff(tracked.q, axis=0)).max() <= JUMP
        np.testing.assert_array_equal(tracked.q[0], START)


@pytest.mark.slow
def test_the_motion_in_the_null_space_leads_away_from_the_limits():
    arm = lwr_dyn.load("lwr4plus")
    plain, *guided = attempts(arm, line(arm, START, [0.1, 0.1, 0.05]), START, True)

    def crowding(q):  # the function whose gradient the motion follows
        return -np.log(1.05 - (q / arm.upper) ** 2).sum()

    assert all(crowding(x.q[-1]) < crowding(plain.q[-1]) for x in guided)


def test_newtons_method_says_where_it_does_not_arrive():
    arm = lwr_dyn.load("lwr4plus")
    far = np.eye(4)
    far[0, 3] = 5.0
    assert np.isnan(onto_pose(arm, far, START, True)).all()
