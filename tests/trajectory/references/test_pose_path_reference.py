"""A path as a reference for the joints: the flange follows it, q, dq, ddq are consistent, errors name the place."""

import json
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import PathLimitError, ShapeError, SingularArmError
from lwr_dyn.kinematics.solution import Branch
from lwr_dyn.model.spatial import rot_x
from lwr_dyn.trajectory.motion_profile import quintic
from lwr_dyn.trajectory.path import line, path_of
from lwr_dyn.trajectory.pose_path import constant_orientation, slerp, timed_pose_path
from lwr_dyn.trajectory.references.ist import TOOL, ist_reference
from lwr_dyn.trajectory.references.pose_path_reference import FixedArmAngle, pose_path_reference
from lwr_dyn.trajectory.timings import MOTION_PROFILES, SmoothTiming
from tests.trajectory.differences import check_derivatives

ARM = lwr_dyn.load("lwr4plus")
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


def check_motion(reference, t):
    """At times t away from the breaks: the flange draws the path, dq and ddq are the derivatives of q."""
    t = t[np.abs(t[:, None] - breaks(reference)).min(axis=1) > 5 * STEP]
    check_derivatives(reference.sample, t, STEP, ("q", "dq", "ddq"), atol=DIFFERENCE)
    drawn = lwr_dyn.forward_kinematics(reference.arm, reference.sample(t).q)
    np.testing.assert_allclose(drawn, reference.poses.at(t).T, atol=POSE)
    return t.size


@pytest.mark.parametrize("timing", MOTION_PROFILES.rows)
def test_the_flange_draws_the_path_with_exact_derivatives_inside_the_limits(timing):
    reference = timed(timing)
    assert check_motion(reference, np.linspace(0.013, 13.987, 431)) > 150
    motion = reference.sample(np.linspace(0, 14, 1401))
    assert np.all(np.abs(motion.dq).max(axis=0) < ARM.velocity)
    assert np.min(np.minimum(ARM.upper - motion.q, motion.q - ARM.lower)) >= reference.margin
    nearest = reference.nearest_limit  # joint 6 at point 1
    assert (np.degrees(reference.margin), nearest.t) == (pytest.approx(1.2, abs=0.05), pytest.approx(0.0, abs=0.2))
    assert nearest.joint == "joint_6"


H = 5e-4
"""[s] A step is at most the peak rate times h (0.8 rad/s, 3.5 rad/s^2, 56 rad/s^3 on IST); a jump does not shrink."""


def largest_steps(reference):
    motion = reference.sample(np.arange(-0.1, 14.1, H))
    return np.array([np.abs(np.diff(x, axis=0)).max() for x in (motion.q, motion.dq, motion.ddq)])


@pytest.mark.slow
@pytest.mark.parametrize("timing", ["quintic", "smooth", "smooth-blended"])
def test_q_dq_and_ddq_have_no_jump_but_at_a_bend_that_is_not_eased(timing):
    most = np.array([1.0, 5.0, 80.0]) * H
    assert (largest_steps(timed(timing)) < most).all()
    if timing == "smooth":
        sharp = largest_steps(ist_reference(ARM, smoothness=SmoothTiming(ease=0.0)))
        assert (sharp[:2] < most[:2]).all()
        assert sharp[2] > 0.5


@pytest.mark.slow
def test_constant_speed_jumps_in_dq_at_its_corners_and_ends_and_nowhere_else():
    reference, t = timed("constant"), np.arange(-0.1, 14.1, H)
    steps = np.abs(np.diff(reference.sample(t).dq, axis=0)).max(axis=1)
    corners = np.array([c.s for c in reference.poses.path.corners()]) / reference.poses.length * 14.0
    np.testing.assert_allclose(t[:-1][steps > 0.01], [0.0, *corners, 14.0], atol=2 * H)


def test_it_stands_still_before_and_after_and_its_trace_is_the_drawn_path():
    reference = timed("constant")
    motion = reference.sample(np.array([-1.0, 0.0, 14.0, 20.0]))
    np.testing.assert_array_equal(motion.q[[0, 3]], motion.q[[1, 2]])
    assert not np.any([motion.dq[[0, 3]], motion.ddq[[0, 3]]])
    with pytest.raises(ShapeError, match="nan"):
        reference.sample(np.array([np.nan]))
    trace = reference.trace(15)
    np.testing.assert_allclose(trace, reference.poses.at(np.arange(15.0)).T[:, :3, 3], atol=POSE)


def test_a_fixed_arm_angle_is_kept_on_the_branch_with_the_largest_margin_and_a_curve_of_ones_own_is_taken():
    best = timed("smooth").arm_angle
    psi = float(np.mean(best.evaluate(np.linspace(0, 1.3, 50))[0]))
    reference = ist_reference(ARM, arm_angle=psi)
    assert (reference.arm_angle.psi, reference.arm_angle.branch) == (psi, best.branch)
    assert 0.0 < reference.margin <= timed("smooth").margin + 1e-6
    check_motion(reference, np.linspace(0.0, 14.0, 141))
    own = ist_reference(ARM, "quintic", arm_angle=best)
    assert own.arm_angle is best
    values = [x.about["arm_angle"]["value"] for x in (reference, own)]
    assert values == [f"{psi!r} rad all along, given", "a curve, given"]


def timed_line(*points, orientation=None, duration=2.0):
    path = path_of([line(a, b) for a, b in pairwise(points)])
    turning = constant_orientation(np.eye(3)) if orientation is None else slerp(*orientation, path.length)
    return timed_pose_path(path, turning, quintic(path.length, duration))


def test_a_turning_tool_is_followed():
    tools = (TOOL, rot_x(-0.4) @ np.array(TOOL))
    poses = timed_line((-0.05, -0.4, 0.5), (-0.05, -0.2, 0.5), orientation=tools)
    check_motion(pose_path_reference(ARM, poses), np.linspace(0.1, 1.9, 19))


def test_it_lists_what_is_printed_assumed_and_estimated():
    about = json.loads(json.dumps(dict(timed("smooth").about)))
    kinds = {name: about[name]["kind"] for name in ("timing", "points", "R_07", "arm_angle", "duration", "smoothness")}
    assert kinds == {
        "timing": "assumed", "points": "printed", "R_07": "estimated", "arm_angle": "assumed", "duration": "printed",
        "smoothness": "assumed",
    }  # fmt: skip
    assert (about["timing"]["value"], about["margin"]["joint"], about["task"]) == ("smooth", "joint_6", "ist")
    free = ist_reference(lwr_dyn.load("lwr4"))  # it has no limits, and JSON no infinity
    assert (free.margin, json.loads(json.dumps(dict(free.about), allow_nan=False))["margin"]) == (np.inf, None)


def test_a_tool_or_a_fixed_arm_angle_that_leads_out_of_the_limits_is_refused_with_its_place():
    down = np.diag([1.0, -1.0, -1.0])
    with pytest.raises(PathLimitError, match=r"at t = .* s, point \(-0.05, .*\) m: .*joint_\d.* 0\.2\d* rad") as caught:
        ist_reference(ARM, R_07=down)
    fault = caught.value
    assert fault.joint in ARM.joint_names
    assert 0.0 <= fault.t <= 14.0
    assert np.degrees(fault.excess) == pytest.approx(12.6, abs=0.3)  # -z of the six axis directions
    outside = r"point \(.*\) m: joint_\d at .* rad outside its limits; allowed"
    with pytest.raises(PathLimitError, match=outside) as caught:
        ist_reference(ARM, arm_angle=1.0)
    let_go = ist_reference(ARM, arm_angle=1.0, limits=False)
    assert let_go.margin == pytest.approx(-caught.value.excess)
    assert let_go.margin < 0.0
    assert let_go.about["margin"]["limits_kept"] is False


def test_a_branch_of_ones_own_is_kept():
    """At psi = -150 deg two branches stay inside the limits by the same margin."""
    angles = (FixedArmAngle(np.radians(-150.0), Branch(1, elbow, 1)) for elbow in (-1, 1))
    references = [ist_reference(ARM, arm_angle=angle, limits=False) for angle in angles]
    one, other = (reference.sample(np.linspace(0, 14, 50)).q[:, 3] for reference in references)
    assert np.all(one < 0.0) or np.all(one > 0.0)
    np.testing.assert_allclose(other, -one)


def range_of_joint_7(upper):
    return replace(ARM, limits=(*ARM.limits[:6], replace(ARM.limits[6], lower=-upper, upper=upper)))


def turning_flange(arm):
    """A path on which the flange turns about joint 7 by 0.6 rad, past half a turn, and an arm angle for it."""
    start, end = (lwr_dyn.forward_kinematics(arm, [0.3, 0.6, 0.2, -1.2, 0.3, 0.7, x]) for x in (2.9, 3.5))
    tools = (start[:3, :3], end[:3, :3])
    poses = timed_line(start[:3, 3], start[:3, 3] + [0.0, 0.02, 0.0], orientation=tools)
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


OWN = FixedArmAngle(0.0, Branch(1, 1, 1))
NEAR, FAR = (0.3, 0.6, 0.5), (0.3, 1.1, 0.5)
OUT = r" m: the wrist is \d\.\d+ m out of reach"


@pytest.mark.parametrize("arm_angle", [None, 0.0, OWN])
@pytest.mark.parametrize(
    ("points", "place"),
    [([(0.3, 0.3, 0.5), (0.3, 2.3, 0.5)], r"at t = 2 s, point \(0\.3, 2\.3, 0\.5\)"),
     ([NEAR, FAR, NEAR], r"at t = 1 s, point \(0\.3, 1\.1, 0\.5\)")],
)  # fmt: skip
def test_a_path_out_of_reach_is_refused_with_the_time_of_its_farthest_place(points, place, arm_angle):
    with pytest.raises(PathLimitError, match=place + OUT):
        pose_path_reference(ARM, timed_line(*points), arm_angle)


def test_a_path_through_a_singularity_is_refused_with_its_place():
    """The tool points away from the elbow's line as the arm passes upright: the wrist is on the axis of joint 1."""
    with pytest.raises(SingularArmError, match=r"at t = 1 s, point \(0, 0, 0\.7\) m"):
        pose_path_reference(ARM, timed_line((-0.2, 0.0, 0.7), (0.2, 0.0, 0.7)), OWN, limits=False)
