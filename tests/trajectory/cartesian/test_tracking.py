"""Joint positions along curves: on the curve, inside the limits, in small steps, and where they stop."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.trajectory.cartesian import tracking
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
    for tracked in tracking.attempts(arm, curve, START, turning):
        assert tracked.is_whole
        errors, _ = tracking.pose_error(arm, curve.poses(tracked.u), tracked.q, turning)
        assert np.abs(errors).max() <= 10.0 * tracking.ON_CURVE
        assert all(tracking.is_inside(arm, q) for q in tracked.q)
        assert np.abs(np.diff(tracked.q, axis=0)).max() <= tracking.JUMP
        np.testing.assert_array_equal(tracked.q[0], START)


@pytest.mark.slow
def test_the_motion_in_the_null_space_leads_away_from_the_limits():
    arm = lwr_dyn.load("lwr4plus")
    plain, *guided = tracking.attempts(arm, line(arm, START, [0.1, 0.1, 0.05]), START, True)

    def crowding(q):  # the function whose gradient the motion follows
        return -np.log(1.05 - (q / arm.upper) ** 2).sum()

    assert all(crowding(x.q[-1]) < crowding(plain.q[-1]) for x in guided)


def test_newtons_method_says_where_it_does_not_arrive():
    arm = lwr_dyn.load("lwr4plus")
    far = np.eye(4)
    far[0, 3] = 5.0
    assert np.isnan(tracking.onto_pose(arm, far, START, True)).all()


KR30 = {
    "limit": ([-1.1, -2.293, 1.914, -2.629, -1.691, 2.779], [0.324, 0.137, 1.752]),
    "singular": ([1.148, -1.826, -0.172, -2.965, -0.987, -0.473], [-0.424, 0.198, 2.471]),
    "reach": ([2.368, -1.102, 0.766, -2.853, 0.721, 2.515], [-1.37, -1.124, 2.038]),
}


def stop(robot, q, to, **options):
    arm = lwr_dyn.load(robot)
    with pytest.raises(tracking.PathStopError) as caught:
        lwr_dyn.reference("line", arm, start=q, to_xyz=to, **options)
    begin = lwr_dyn.forward_kinematics(arm, q)
    place = begin.copy()
    place[:3, 3] += caught.value.share * (np.array(to) - begin[:3, 3])
    return arm, caught.value, place


def solutions(arm, T, limits):
    return lwr_dyn.inverse_kinematics(arm, T, limits=limits).solutions


def test_a_joint_at_its_limit_is_named_and_the_closed_form_agrees():
    arm, fault, place = stop("kr30ha", *KR30["limit"])
    assert (fault.why, fault.joint) == ("limit", "A2")
    margins = [np.minimum(arm.upper - s.q, s.q - arm.lower) for s in solutions(arm, place, False)]
    assert any(abs(m[1]) < 5e-3 for m in margins)


def test_a_singular_position_is_near_one_in_the_closed_form_too():
    arm, fault, place = stop("kr30ha", *KR30["singular"])
    assert fault.why == "singular"
    smallest = [np.linalg.svd(jacobian(arm.chain, s.q), compute_uv=False).min() for s in solutions(arm, place, False)]
    assert min(smallest) < 5e-3


def test_a_line_out_of_reach_ends_where_the_closed_form_has_no_solution():
    arm, fault, place = stop("kr30ha", *KR30["reach"])
    assert fault.why == "reach"
    assert solutions(arm, place, False)
    beyond = place.copy()
    beyond[:3, 3] += 0.01 * (np.array(KR30["reach"][1]) - place[:3, 3])
    assert not solutions(arm, beyond, False)


@pytest.mark.slow
def test_a_place_out_of_reach_is_one_for_a_free_orientation_too():
    _, fault, place = stop("lwr4plus", [0.2, 0.6, -0.3, -1.2, 0.4, 0.9, 0.1], [-3.0, 0.1, 0.4], free_orientation=True)
    assert fault.why == "reach"
    assert np.linalg.norm(place[:3, 3]) == pytest.approx(0.4 + 0.39 + 0.078, abs=1e-3)  # stretched


def test_the_message_says_where_why_and_what_is_allowed():
    _, fault, _ = stop("kr30ha", *KR30["limit"])
    assert str(fault).startswith("the line stops at ")
    assert "A2 comes to its limit" in str(fault)
    assert str(fault).endswith("allowed: a line that the arm can follow")
