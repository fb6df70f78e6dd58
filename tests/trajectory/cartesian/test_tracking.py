"""Joint positions along curves: on the curve, inside the limits, in small steps, and where they stop."""

import re
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.model.arm import JointLimits
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
def test_tracked_positions_are_on_the_curve_inside_the_limits_and_without_jumps(arm, turning):
    """The motion in the null space leads away from the limits, by the function whose gradient it follows."""
    curve, crowding = line(arm, START, [0.1, 0.1, 0.05]), []
    for tracked in tracking.attempts(arm, curve, START, turning):
        assert tracked.is_whole
        errors, _ = tracking.pose_error(arm, curve.poses(tracked.u), tracked.q, turning)
        assert np.abs(errors).max() <= 10.0 * tracking.ON_CURVE
        assert all(tracking.is_inside(arm, q) for q in tracked.q)
        assert np.abs(np.diff(tracked.q, axis=0)).max() <= tracking.JUMP
        np.testing.assert_array_equal(tracked.q[0], START)
        crowding.append(-np.log(1.05 - (tracked.q[-1] / arm.upper) ** 2).sum())
    assert len(crowding) == 3
    assert max(crowding[1:]) < crowding[0]


def test_newtons_method_says_where_it_does_not_arrive(arm):
    assert np.isnan(tracking.onto_pose(arm, np.eye(4) + 5.0 * np.eye(4)[:, [3]] * np.eye(4)[0], START, True)).all()


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
    assert (fault.why, fault.joint, fault.line) == ("limit", "A2", "the line")
    margins = [np.minimum(arm.upper - s.q, s.q - arm.lower) for s in solutions(arm, place, False)]
    assert any(abs(m[1]) < 5e-3 for m in margins)
    x, y, z = place[:3, 3]
    assert str(fault) == (
        f"the line stops at {100.0 * fault.share:.3g} % of its way, point ({x:.4g}, {y:.4g}, {z:.4g}) m: A2 comes to "
        f"its limit ({arm.lower[1]:.4g} to {arm.upper[1]:.4g} rad); allowed: a line that the arm can follow"
    )


def test_a_singular_position_is_near_one_in_the_closed_form_too():
    arm, fault, place = stop("kr30ha", *KR30["singular"])
    assert (fault.why, fault.joint) == ("singular", "")
    assert re.search(r"singular there \(smallest singular value of J \d\S*\) and would have to jump", str(fault))
    smallest = [np.linalg.svd(jacobian(arm.chain, s.q), compute_uv=False).min() for s in solutions(arm, place, False)]
    assert min(smallest) < 5e-3


def test_a_line_out_of_reach_ends_where_the_closed_form_has_no_solution():
    arm, fault, place = stop("kr30ha", *KR30["reach"])
    assert (fault.why, fault.joint) == ("reach", "")
    assert "no joint positions reach the pose behind it (smallest singular value of J " in str(fault)
    assert solutions(arm, place, False)
    beyond = place.copy()
    beyond[:3, 3] += 0.01 * (np.array(KR30["reach"][1]) - place[:3, 3])
    assert not solutions(arm, beyond, False)


@pytest.mark.slow
def test_a_place_out_of_reach_is_one_for_a_free_orientation_too():
    _, fault, place = stop("lwr4plus", START, [-3.0, 0.1, 0.4], free_orientation=True)
    assert fault.why == "reach"
    assert np.linalg.norm(place[:3, 3]) == pytest.approx(0.4 + 0.39 + 0.078, abs=1e-3)  # stretched


@pytest.mark.parametrize("turning", [True, False])
def test_a_pose_is_reached_where_any_joint_positions_were_found_inside_the_limits_or_not(arm, turning):
    far, near = np.eye(4), lwr_dyn.forward_kinematics(arm, np.array([0.2, 2.3, 0.1, 1.0, 0.0, 0.5, 0.0]))
    far[0, 3] = 3.0
    assert [tracking._is_reached(arm, T, turning) for T in (far, near)] == [False, True]


def test_a_whole_curve_that_its_spline_leaves_stops_where_it_comes_nearest_to_a_limit(arm):
    curve = line(arm, START, [0.1, 0.1, 0.05])
    q = np.tile(START, (4, 1))
    q[2, 5] = arm.upper[5] - 1e-3
    tracked = tracking.Tracked(np.array([0.0, 0.25, 0.5, 1.0]), q)
    fault = tracking.stop_of(arm, curve, tracked, True, "the curve")
    assert (fault.share, fault.why, fault.joint) == (0.5, "limit", "joint_6")
    assert "point (" + ", ".join(f"{x:.4g}" for x in curve.poses(np.array([0.5]))[0, :3, 3]) in str(fault)


def test_places_are_close_and_z_is_the_linearly_implicit_step_down_the_gradient(arm):
    for shift, count in (([0.3, 0.0, 0.4], 251), ([0.01, 0.0, 0.0], 61)):
        np.testing.assert_allclose(np.diff(tracking.places_on(line(arm, START, shift))), 1.0 / (count - 1))
    gain, middle, half = 4.0, (arm.upper + arm.lower) / 2.0, (arm.upper - arm.lower) / 2.0
    x = (START - middle) / half
    slope = (1.05 + x**2) / (1.05 - x**2) ** 2
    z = -gain * half * x / (1.05 - x**2) / (1.0 + gain * slope)
    np.testing.assert_allclose(tracking._away_from_limits(arm, START, gain), z, rtol=1e-14)
    free = replace(arm, limits=(JointLimits(), *arm.limits[1:]))
    np.testing.assert_allclose(tracking._away_from_limits(free, START, gain), z * (np.arange(7) > 0), rtol=1e-14)
