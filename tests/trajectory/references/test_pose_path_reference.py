"""A path as a reference for the joints: the flange follows it, q, dq, ddq are consistent, errors name the place."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, PathLimitError, ShapeError, SingularArmError
from lwr_dyn.kinematics.solution import Branch
from lwr_dyn.model.spatial import rot_x
from lwr_dyn.trajectory.motion_profile import quintic
from lwr_dyn.trajectory.path import line, path_of
from lwr_dyn.trajectory.pose_path import constant_orientation, slerp, timed_pose_path
from lwr_dyn.trajectory.references.ist import TOOL, ist_reference, timed_ist
from lwr_dyn.trajectory.references.pose_path_reference import FixedArmAngle, pose_path_reference
from lwr_dyn.trajectory.timings import MOTION_PROFILES, SmoothTiming

ARM = lwr_dyn.load("lwr4plus")
STENCIL = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
STEP = 2e-3
"""[s] Eighth-order differences over 16 ms."""
DIFFERENCE = 1e-9
"""[rad/s, rad/s^2] Rounding of the closed form (1e-14 rad) over the step, and the eighth-order remainder."""
POSE = 1e-12
"""[m, and entries of R] Closed-form IK and forward kinematics, both to rounding."""


@cache
def timed(timing):
    """The letters under a profile; not made when the tests are collected."""
    return ist_reference(ARM, timing)


def breaks(reference):
    """Times at which the path or the profile goes over into its next piece: differences must not reach across them."""
    poses = reference.poses
    t = np.linspace(0.0, poses.duration, 28_001)
    joints = np.interp(poses.path.starts, *_rising(poses.profile.at(t).s, t))
    knots = np.interp(getattr(reference.arm_angle, "knots", []), *_rising(poses.profile.at(t).s, t))
    return np.concatenate([poses.profile.knots, joints, knots])


def _rising(s, t):
    keep = np.concatenate([[True], np.diff(s) > 0.0])
    return s[keep], t[keep]


@pytest.mark.parametrize("timing", MOTION_PROFILES.rows)
def test_the_flange_draws_the_path(timing):
    reference = timed(timing)
    t = np.linspace(0.0, 14.0, 1401)
    T = lwr_dyn.forward_kinematics(ARM, reference.sample(t).q)
    np.testing.assert_allclose(T, reference.poses.at(t).T, atol=POSE)


@pytest.mark.parametrize("timing", MOTION_PROFILES.rows)
def test_dq_and_ddq_are_the_derivatives_of_q_between_the_breaks(timing):
    reference = timed(timing)
    t = np.linspace(0.013, 13.987, 431)
    away = np.abs(t[:, None] - breaks(reference)).min(axis=1)
    t = t[away > 5 * STEP]
    assert len(t) > 150
    here, around = reference.sample(t), reference.sample((t[:, None] + STEP * STENCIL).ravel())
    dq = np.einsum("ksj,s->kj", around.q.reshape(len(t), -1, 7), WEIGHTS) / STEP
    ddq = np.einsum("ksj,s->kj", around.dq.reshape(len(t), -1, 7), WEIGHTS) / STEP
    np.testing.assert_allclose(here.dq, dq, atol=DIFFERENCE)
    np.testing.assert_allclose(here.ddq, ddq, atol=DIFFERENCE)


@pytest.mark.slow
@pytest.mark.parametrize("timing", ["quintic", "smooth", "smooth-blended"])
def test_q_dq_and_ddq_have_no_jump_anywhere(timing):
    h = 5e-4
    motion = timed(timing).sample(np.arange(-0.1, 14.1, h))
    # a step is at most the peak rate times h (0.8 rad/s, 3.5 rad/s^2, 56 rad/s^3 on IST); a jump does not shrink with h
    for value, most in (("q", 1.0), ("dq", 5.0), ("ddq", 80.0)):
        assert np.abs(np.diff(getattr(motion, value), axis=0)).max() < most * h


@pytest.mark.slow
def test_the_same_look_finds_the_jump_of_ddq_at_a_bend_that_is_not_eased():
    sharp = ist_reference(ARM, smoothness=SmoothTiming(ease=0.0)).sample(np.arange(-0.1, 14.1, 5e-4))
    assert np.abs(np.diff(sharp.ddq, axis=0)).max() > 0.5
    assert np.abs(np.diff(sharp.dq, axis=0)).max() < 5.0 * 5e-4


@pytest.mark.slow
def test_constant_speed_jumps_in_dq_at_its_corners_and_ends_and_nowhere_else():
    h = 5e-4
    reference = timed("constant")
    t = np.arange(-0.1, 14.1, h)
    steps = np.abs(np.diff(reference.sample(t).dq, axis=0)).max(axis=1)
    jumps = t[:-1][steps > 0.01]
    corners = np.array([c.s for c in reference.poses.path.corners()]) / reference.poses.length * 14.0
    expected = np.concatenate([[0.0], corners, [14.0]])
    assert len(jumps) == len(expected)
    np.testing.assert_allclose(jumps, expected, atol=2 * h)


def test_it_stands_still_before_and_after():
    motion = timed("constant").sample(np.array([-1.0, 0.0, 14.0, 20.0]))
    np.testing.assert_array_equal(motion.q[[0, 3]], motion.q[[1, 2]])
    assert not motion.dq[[0, 3]].any()
    assert not motion.ddq[[0, 3]].any()


@pytest.mark.parametrize("timing", MOTION_PROFILES.rows)
def test_the_tightest_place_is_joint_6_at_point_1_by_1_2_degrees(timing):
    reference = timed(timing)
    assert np.degrees(reference.margin) == pytest.approx(1.2, abs=0.05)
    assert reference.nearest_limit.joint == "joint_6"
    assert reference.nearest_limit.t == pytest.approx(0.0, abs=0.2)
    q = reference.sample(np.linspace(0, 14, 1401)).q
    assert np.min(np.minimum(ARM.upper - q, q - ARM.lower)) >= reference.margin


@pytest.mark.parametrize("timing", MOTION_PROFILES.rows)
def test_speed_limits_are_kept(timing):
    dq = timed(timing).sample(np.linspace(0, 14, 1401)).dq
    assert np.all(np.abs(dq).max(axis=0) < ARM.velocity)


def test_a_fixed_arm_angle_is_kept_on_the_branch_with_the_largest_margin():
    best = timed("smooth").arm_angle
    psi = float(np.mean(best.evaluate(np.linspace(0, 1.3, 50))[0]))
    reference = ist_reference(ARM, arm_angle=psi)
    assert reference.arm_angle.branch == best.branch
    assert 0.0 < reference.margin <= timed("smooth").margin + 1e-6
    t = np.linspace(0.0, 14.0, 141)
    T = lwr_dyn.forward_kinematics(ARM, reference.sample(t).q)
    np.testing.assert_allclose(T, reference.poses.at(t).T, atol=POSE)


def test_a_curve_of_ones_own_is_taken():
    own = timed("smooth").arm_angle
    reference = ist_reference(ARM, "quintic", arm_angle=own)
    assert reference.arm_angle is own
    assert reference.about["arm_angle"]["value"] == "a curve, given"


def test_a_turning_tool_is_followed():
    path = path_of([line((-0.05, -0.4, 0.5), (-0.05, -0.2, 0.5))])
    orientation = slerp(TOOL, rot_x(-0.4) @ np.array(TOOL), path.length)
    reference = pose_path_reference(ARM, timed_pose_path(path, orientation, quintic(path.length, 2.0)))
    t = np.linspace(0.1, 1.9, 19)
    away = np.abs(t[:, None] - breaks(reference)).min(axis=1)
    t = t[away > 5 * STEP]
    here, around = reference.sample(t), reference.sample((t[:, None] + STEP * STENCIL).ravel())
    ddq = np.einsum("ksj,s->kj", around.dq.reshape(len(t), -1, 7), WEIGHTS) / STEP
    np.testing.assert_allclose(here.ddq, ddq, atol=DIFFERENCE)
    np.testing.assert_allclose(lwr_dyn.forward_kinematics(ARM, here.q), reference.poses.at(t).T, atol=POSE)


def test_it_lists_what_is_printed_assumed_and_estimated():
    about = json.loads(json.dumps(dict(timed("smooth").about)))
    assert about["timing"]["kind"] == "assumed"
    assert about["timing"]["value"] == "smooth"
    assert about["points"]["kind"] == "printed"
    assert about["R_07"]["kind"] == "estimated"
    assert about["margin"]["joint"] == "joint_6"


def test_an_arm_without_limits_has_no_margin_to_speak_of():
    reference = ist_reference(lwr_dyn.load("lwr4"))
    assert reference.margin == np.inf
    assert json.loads(json.dumps(dict(reference.about), allow_nan=False))["margin"] is None


def test_a_tool_that_leads_out_of_the_limits_is_refused_with_its_place():
    down = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])
    with pytest.raises(PathLimitError, match=r"at t = .* s, point \(-0.05, .*\) m: .*joint_\d.* 0\.2\d* rad") as caught:
        ist_reference(ARM, R_07=down)
    fault = caught.value
    assert fault.joint in ARM.joint_names
    assert 0.0 <= fault.t <= 14.0
    assert np.degrees(fault.excess) == pytest.approx(12.6, abs=0.3)  # -z of the six axis directions


def test_a_fixed_arm_angle_outside_the_limits_is_refused_with_its_place():
    with pytest.raises(
        PathLimitError, match=r"point \(.*\) m: joint_\d at .* rad outside its limits; allowed"
    ) as caught:
        ist_reference(ARM, arm_angle=1.0)
    assert caught.value.excess > 0.0
    let_go = ist_reference(ARM, arm_angle=1.0, limits=False)
    assert let_go.margin == pytest.approx(-caught.value.excess)
    assert let_go.about["margin"]["limits_kept"] is False


def test_a_branch_of_ones_own_is_kept():
    # at psi = -150 deg two branches stay inside the limits by the same margin
    reference = ist_reference(ARM, arm_angle=FixedArmAngle(np.radians(-150.0), Branch(1, -1, 1)), limits=False)
    q = reference.sample(np.linspace(0, 14, 50)).q
    assert np.all(q[:, 3] < 0.0) or np.all(q[:, 3] > 0.0)
    other = ist_reference(ARM, arm_angle=FixedArmAngle(np.radians(-150.0), Branch(1, 1, 1)), limits=False)
    np.testing.assert_allclose(other.sample(np.linspace(0, 14, 50)).q[:, 3], -q[:, 3])


def range_of_joint_7(upper):
    return replace(ARM, limits=(*ARM.limits[:6], replace(ARM.limits[6], lower=-upper, upper=upper)))


def turning_flange(arm):
    """A path on which the flange turns about joint 7 by 0.6 rad, past half a turn, and an arm angle for it."""
    start, end = (lwr_dyn.forward_kinematics(arm, [0.3, 0.6, 0.2, -1.2, 0.3, 0.7, x]) for x in (2.9, 3.5))
    path = path_of([line(start[:3, 3], start[:3, 3] + [0.0, 0.02, 0.0])])
    poses = timed_pose_path(path, slerp(start[:3, :3], end[:3, :3], path.length), quintic(path.length, 2.0))
    solution = lwr_dyn.inverse_kinematics(arm, start).solutions[0]
    branch = Branch(*(1 if sign == "+" else -1 for sign in solution.branch))
    return poses, FixedArmAngle(solution.arm_angle, branch)


def test_a_joint_whose_range_is_wider_than_a_turn_does_not_jump_and_one_that_is_not_leaves_it():
    arm = range_of_joint_7(6.0)
    poses, angle = turning_flange(arm)
    reference = pose_path_reference(arm, poses, angle)
    motion = reference.sample(np.linspace(-0.5, 2.5, 801))
    assert np.abs(np.diff(motion.q, axis=0)).max() < 0.1
    assert np.ptp(motion.q[:, 6]) > 0.5
    assert np.abs(motion.q[:, 6]).max() > np.pi
    inside = reference.sample(np.linspace(0, 2, 101))
    np.testing.assert_allclose(lwr_dyn.forward_kinematics(arm, inside.q), poses.at(inside.t).T, atol=POSE)
    with pytest.raises(PathLimitError, match="joint_7"):
        pose_path_reference(range_of_joint_7(np.pi), poses, angle)


def test_bad_arm_angles_arms_and_times_are_refused():
    with pytest.raises(OptionError, match="arm_angle: nan"):
        ist_reference(ARM, arm_angle=float("nan"))
    with pytest.raises(ShapeError, match="nan"):
        timed("smooth").sample(np.array([np.nan]))


def test_the_trace_is_the_drawn_path():
    trace = timed("quintic").trace(11)
    assert trace.shape == (11, 3)
    np.testing.assert_allclose(trace[[0, -1]], timed_ist("quintic").at([0.0, 14.0]).T[:, :3, 3], atol=POSE)


def test_a_given_curve_out_of_reach_or_through_a_singularity_is_refused_with_its_place():
    far = path_of([line((0.3, 0.3, 0.5), (0.3, 2.3, 0.5))])
    own = FixedArmAngle(0.0, Branch(1, 1, 1))
    with pytest.raises(PathLimitError, match=r"at t = 2 s, point .* 1\.\d+ m out of reach"):
        pose_path_reference(ARM, timed_pose_path(far, constant_orientation(np.eye(3)), quintic(far.length, 2.0)), own)
    # the tool points away from the elbow's line as the arm passes upright: the wrist stands on the axis of joint 1
    over = path_of([line((-0.2, 0.0, 0.7), (0.2, 0.0, 0.7))])
    with pytest.raises(SingularArmError, match=r"at t = 1 s, point \(0, 0, 0\.7\) m"):
        pose_path_reference(
            ARM, timed_pose_path(over, constant_orientation(np.eye(3)), quintic(over.length, 2.0)), own, limits=False
        )


@pytest.mark.parametrize("arm_angle", [None, 0.0])
def test_the_time_is_that_of_the_farthest_place_inside_the_path(arm_angle):
    """There and back: the turning point, half a metre along, at half the time."""
    near, far = (0.3, 0.6, 0.5), (0.3, 1.1, 0.5)
    path = path_of([line(near, far), line(far, near)])
    poses = timed_pose_path(path, constant_orientation(np.eye(3)), quintic(path.length, 2.0))
    with pytest.raises(PathLimitError, match=r"at t = 1 s, point \(0\.3, 1\.1, 0\.5\) m: the wrist is"):
        pose_path_reference(ARM, poses, arm_angle)


@pytest.mark.parametrize("arm_angle", [None, 0.0])
def test_a_path_out_of_reach_is_refused_with_its_place(arm_angle):
    path = path_of([line((0.3, 0.3, 0.5), (0.3, 2.3, 0.5))])
    poses = timed_pose_path(path, constant_orientation(np.eye(3)), quintic(path.length, 2.0))
    message = r"at t = 2 s, point \(0\.3, 2\.3, 0\.5\) m: the wrist is 1\.\d+ m out of reach"
    with pytest.raises(PathLimitError, match=message):
        pose_path_reference(ARM, poses, arm_angle)
