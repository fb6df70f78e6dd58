"""Plans motions like a controller: profiles under the set speeds, paths on one branch; reports faults."""

import math

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import OptionError
from lwr_dyn.ik_solvers.spherical_wrist import all_branches
from lwr_dyn.kinematics.forward import forward_kinematics, jacobian_at, joint_axes
from lwr_dyn.krl.diagnostics import ExecutionError, Report
from lwr_dyn.krl.motion.motion_segments import (
    STILL,
    TURN,
    CartesianSegment,
    PosePath,
    PtpSegment,
    path_bounds,
    ptp_bounds,
)
from lwr_dyn.krl.motion.settings import ProfileBounds, Speeds
from lwr_dyn.krl.robot.kuka_pose import status
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.lspb import trapezoid
from lwr_dyn.trajectory.motion_profile import MotionProfile
from lwr_dyn.trajectory.path import Path
from lwr_dyn.trajectory.pose_path import TimedPosePath

NEAR = np.radians(1.0)
"""[rad] With A5 this near to 0 on a path, axes 4 and 6 are in line."""
FLIP = np.radians(90.0)
"""[rad] A4 or A6 that turns by more between two samples of a path has flipped."""
STEP_M, STEP_RAD = 0.005, math.radians(1.0)
"""[m], [rad] Distance of the samples on a path, between `FEWEST` and `MOST` steps."""
FEWEST, MOST = 24, 600


def ptp_segment(arm: Arm, start: Array, end: Array, speeds: Speeds) -> PtpSegment | None:
    """PTP: all axes begin and end together, the slowest sets the profile; None when nothing moves."""
    if not (np.abs(end - start) > STILL).any():
        return None
    return PtpSegment(arm, start, end, _profile(1.0, ptp_bounds(start, end, speeds)), speeds)


def cartesian_segment(
    arm: Arm, start: Array, tool: Array, path: PosePath, speeds: Speeds, report: Report
) -> CartesianSegment | None:
    """LIN or CIRC from axes `start` (n,); None when nothing moves, or the path leaves reach or limits (reported)."""
    if path.is_still:
        return None
    profile = _profile(path.segment.length, path_bounds(path, speeds))
    timed = TimedPosePath(Path((path.segment,)), path.orientation, profile)
    table = _axis_table(arm, start, tool, path, timed, report)
    if table is None:
        return None
    segment = CartesianSegment(arm, tool, path, timed, *table, speeds)
    return segment if _inside_limits(arm, segment.table, report) and _check_speeds(segment, report) else None


def _profile(length: float, bounds: ProfileBounds) -> MotionProfile:
    try:
        return trapezoid(length, bounds.speed, bounds.ramp)
    except OptionError as fault:
        raise ExecutionError("speed-range", f"the {fault.name} {fault.found} of this motion", fault.allowed) from None


def _axis_table(
    arm: Arm, start: Array, tool: Array, path: PosePath, timed: TimedPosePath, report: Report
) -> tuple[int, Array] | None:
    """The branch, and the axes (m, n) [rad] at even steps along the path; None with a fault that is reported."""
    steps = math.ceil(path.length / STEP_M) + math.ceil(path.angle / STEP_RAD)
    along = np.linspace(0.0, 1.0, int(np.clip(steps, FEWEST, MOST)) + 1)
    solutions = all_branches(arm, timed.poses(along * timed.profile.length) @ np.linalg.inv(tool))
    away = np.abs((solutions.q[0] - start + np.pi) % TURN - np.pi).max(axis=-1)
    branch = int(np.nanargmin(np.where(np.isnan(away), np.inf, away)))
    excess = solutions.reach_excess[:, branch]
    if (excess > 0.0).any():
        k = int(np.argmax(excess))
        message = f"the path is out of reach by {1e3 * excess[k]:.4g} mm, {100 * along[k]:.0f} % along"
        report("error", "out-of-reach", message, "move the points nearer, or go there by PTP")
        return None
    wrist = solutions.clearance[:, branch, 2]
    passed = int(np.argmin(wrist))
    q = np.unwrap(np.vstack([start, solutions.q[:, branch]]), axis=0)[1:]
    if wrist[passed] < NEAR:
        place = f"{100 * along[passed]:.0f} % along (A5 {_deg(q[passed, 4])} deg)"
        report(
            "error",
            "singularity",
            f"the path passes the wrist singularity {place}",
            "go there by PTP, or tilt the tool",
        )
    if np.abs(q[0] - start).max() > 1e-6:
        if wrist[passed] >= NEAR:
            report("error", "singularity", "the path begins where axes are not determined", "leave the place by PTP")
        return None
    return (branch, q) if _no_flip(q, along, report) else None


def _no_flip(q: Array, along: Array, report: Report) -> bool:
    step = np.abs(np.diff(q[:, [3, 5]], axis=0))
    k, axis = np.unravel_index(int(np.argmax(step)), step.shape)
    if step[k, axis] <= FLIP:
        return True
    name = ("A4", "A6")[int(axis)]
    message = f"the wrist flips: {name} turns by {_deg(step[k, axis])} deg at once, {100 * along[k]:.0f} % along"
    report("error", "wrist-flip", message, "go there by PTP, or keep A5 away from 0")
    return False


def _inside_limits(arm: Arm, q: Array, report: Report) -> bool:
    over = np.maximum(q - arm.upper, arm.lower - q)
    k, i = np.unravel_index(int(np.argmax(over)), over.shape)
    if over[k, i] <= 1e-9:
        return True
    along = 100.0 * k / max(len(q) - 1, 1)
    message = f"{arm.joint_names[int(i)]} leaves its range by {_deg(over[k, i])} deg, {along:.0f} % along the path"
    report("error", "outside-limits", message, "another Status at the start, or a PTP")
    return False


def _check_speeds(segment: CartesianSegment, report: Report) -> bool:
    """Report axes that would be too fast; False at a singularity."""
    arm, profile, whole = segment.arm, segment.profile, segment.profile.length
    s = np.linspace(0.0, whole, len(segment.table))
    half = float(profile.coefficients[0, 2])  # half the acceleration
    ds = np.minimum(np.sqrt(4.0 * half * np.minimum(s, whole - s)), 2.0 * half * profile.knots[1])
    place, turn = segment.path.segment.at(s), segment.path.orientation.at(s)
    try:
        J = jacobian_at(joint_axes(arm.chain, segment.table), place.p)
        dq = np.linalg.solve(J, (np.hstack([place.dp, turn.rate]) * ds[:, None])[..., None])[..., 0]
    except np.linalg.LinAlgError:
        report("error", "singularity", "the path meets a singularity", "go there by PTP")
        return False
    use = np.abs(dq) / arm.velocity
    k, i = np.unravel_index(int(np.argmax(use)), use.shape)
    if use[k, i] > 1.0 + 1e-9:
        name, needed, allowed = arm.joint_names[int(i)], _deg(abs(dq[k, i])), _deg(arm.velocity[i])
        where = f"{100 * s[k] / whole:.0f} % along"
        message = f"{name} would have to turn at {needed} deg/s, {where}; it can do {allowed} deg/s"
        report("error", "axis-speed", message, f"slower by the factor {use[k, i]:.3g} ($VEL.CP, $ACC.CP), or a PTP")
    return True


def warn_of_flip(arm: Arm, start: Array, end: Array, report: Report) -> None:
    """Warn when a PTP between two poses turns the wrist over: A5 changes its sign and A4 turns far."""
    if (status(arm, start) ^ status(arm, end)) & 4 and abs(end[3] - start[3]) > FLIP:
        wrist = f"A5 from {_deg(start[4])} to {_deg(end[4])} deg, A4 by {_deg(end[3] - start[3])} deg"
        hint = "S with the same bit 2 as the point before keeps the wrist"
        report("warning", "wrist-flip", f"the wrist turns over: {wrist}", hint)


def tool_pose(arm: Arm, q: Array, tool: Array) -> Array:
    """T_{base,tcp} (4, 4) [m] at q (n,)."""
    return np.asarray(forward_kinematics(arm.chain, q) @ tool)


def _deg(x: float) -> str:
    return f"{np.degrees(x):.4g}"
