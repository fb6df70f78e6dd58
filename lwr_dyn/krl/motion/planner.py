"""Plans motions like a controller: profiles under the set speeds, paths on one branch; reports faults."""

import math

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose, jacobian_at, joint_axes
from lwr_dyn.krl.diagnostics import ExecutionError, Report
from lwr_dyn.krl.motion.motion_segments import CartesianSegment, PtpSegment, ptp_bounds
from lwr_dyn.krl.motion.path_axes import FLIP, axes_along, degrees_text
from lwr_dyn.krl.motion.pose_paths import STILL, PosePath, path_bounds
from lwr_dyn.krl.motion.settings import ProfileBounds, Speeds
from lwr_dyn.krl.robot.kuka_pose import status
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.lspb import trapezoid
from lwr_dyn.trajectory.motion_profile import MotionProfile
from lwr_dyn.trajectory.path import Path
from lwr_dyn.trajectory.pose_path import TimedPosePath

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
    steps = math.ceil(path.length / STEP_M) + math.ceil(path.angle / STEP_RAD)
    along = np.linspace(0.0, 1.0, int(np.clip(steps, FEWEST, MOST)) + 1)
    table = axes_along(arm, start, timed.poses(along * profile.length) @ np.linalg.inv(tool), along, report)
    if table is None:
        return None
    segment = CartesianSegment(arm, tool, path, timed, table.branch, table.q, speeds)
    return segment if _check_speeds(segment, report) else None


def _profile(length: float, bounds: ProfileBounds) -> MotionProfile:
    try:
        return trapezoid(length, bounds.speed, bounds.ramp)
    except OptionError as fault:
        raise ExecutionError("speed-range", f"the {fault.name} {fault.found} of this motion", fault.allowed) from None


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
        name, needed, allowed = arm.joint_names[int(i)], degrees_text(abs(dq[k, i])), degrees_text(arm.velocity[i])
        where = f"{100 * s[k] / whole:.0f} % along"
        message = f"{name} would have to turn at {needed} deg/s, {where}; it can do {allowed} deg/s"
        report("error", "axis-speed", message, f"slower by the factor {use[k, i]:.3g} ($VEL.CP, $ACC.CP), or a PTP")
    return True


def warn_of_flip(arm: Arm, start: Array, end: Array, report: Report) -> None:
    """Warn when a PTP between two poses turns the wrist over: A5 changes its sign and A4 turns far."""
    if (status(arm, start) ^ status(arm, end)) & 4 and abs(end[3] - start[3]) > FLIP:
        a, b, far = (degrees_text(x) for x in (start[4], end[4], end[3] - start[3]))
        wrist = f"A5 from {a} to {b} deg, A4 by {far} deg"
        hint = "S with the same bit 2 as the point before keeps the wrist"
        report("warning", "wrist-flip", f"the wrist turns over: {wrist}", hint)


def tool_pose(arm: Arm, q: Array, tool: Array) -> Array:
    """T_{base,tcp} (4, 4) [m] at q (n,)."""
    return np.asarray(flange_pose(arm.chain, q) @ tool)
