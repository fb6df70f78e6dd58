"""Motion segments from rest to rest, planned as a controller does: PTP along the axes, LIN and CIRC along a path.

A segment gives the axes at any time with exact derivatives; on a path in space by closed-form inverse kinematics on
the branch of its beginning (LIN keeps the Status), with rates by the Jacobian. Faults are reported.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.interpolate import CubicSpline

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose, jacobian_at, joint_axes, velocity_product_at
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.krl.diagnostics import ExecutionError, Report
from lwr_dyn.krl.motion import pose_paths
from lwr_dyn.krl.motion.pose_paths import FLIP, STILL, TURN, PosePath, ProfileBounds, Speeds, degrees_text
from lwr_dyn.krl.robot.kuka_pose import status
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.motion_profile import MotionProfile, trapezoid
from lwr_dyn.trajectory.path import Path
from lwr_dyn.trajectory.pose_path import TimedPosePath


@dataclass(frozen=True, slots=True, eq=False)
class AxisMotion:
    """The axes at k times: q, dq, ddq (k, n) [rad, per s, per s^2]."""

    q: Array
    dq: Array
    ddq: Array


@dataclass(frozen=True, slots=True, eq=False)
class PtpSegment:
    """PTP: all axes from `start` to `end` (n,) [rad] in one motion profile from 0 to 1."""

    arm: Arm
    start: Array
    end: Array
    profile: MotionProfile
    speeds: Speeds
    """The speeds that it is planned with."""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.profile.duration

    @property
    def bounds(self) -> ProfileBounds:
        """Of its profile."""
        return ptp_bounds(self.start, self.end, self.speeds)

    def axes(self, t: Array) -> AxisMotion:
        """The axes at times t (k,) [s] from the beginning of the segment."""
        profile, step = self.profile.at(t), self.end - self.start
        return AxisMotion(
            self.start + np.outer(profile.s, step), np.outer(profile.ds, step), np.outer(profile.dds, step)
        )

    def axes_at(self, share: Array) -> Array:
        """The axes (k, n) [rad] at shares (k,) of the way."""
        return np.asarray(self.start + np.outer(share, self.end - self.start))


@dataclass(frozen=True, slots=True, eq=False)
class AxisSplineSegment:
    """PTP_SPLINE: the axes (n,) on a curve through points, in a profile of its parameter [s at the set speed]."""

    arm: Arm
    curve: CubicSpline
    profile: MotionProfile
    speeds: Speeds

    @property
    def start(self) -> Array:
        """The axes (n,) [rad] where it begins."""
        return np.asarray(self.curve(0.0))

    @property
    def end(self) -> Array:
        """The axes (n,) [rad] where it ends."""
        return np.asarray(self.curve(self.profile.length))

    @property
    def duration(self) -> float:
        """[s]"""
        return self.profile.duration

    @property
    def bounds(self) -> ProfileBounds:
        """Of its profile, where it ends."""
        rate = np.maximum(np.abs(self.curve(self.profile.length, 1)), STILL)
        return ProfileBounds(float(np.min(self.speeds.axis / rate)), float(np.min(self.speeds.axis_ramp / rate)))

    def axes(self, t: Array) -> AxisMotion:
        """The axes at times t (k,) [s] from the beginning of the segment."""
        profile = self.profile.at(t)
        q, first, second = (np.asarray(self.curve(profile.s, i), dtype=np.float64) for i in range(3))
        ds = profile.ds[:, None]
        return AxisMotion(q, first * ds, first * profile.dds[:, None] + second * ds**2)

    def axes_at(self, share: Array) -> Array:
        """The axes (k, n) [rad] at shares (k,) of the way."""
        return np.asarray(self.curve(share * self.profile.length), dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class CartesianSegment:
    """LIN or CIRC: the tool centre point along a timed path of poses, on one branch of the inverse kinematics."""

    arm: Arm
    tool: Array
    """(4, 4) [m] The tool centre point in the flange."""
    path: PosePath
    timed: TimedPosePath
    """The path with its motion profile."""
    branch: int
    table: Array
    """(m, n) [rad] The axes at even steps along the path."""
    speeds: Speeds
    """The speeds that it is planned with."""

    @property
    def bounds(self) -> ProfileBounds:
        """Of its profile."""
        return pose_paths.path_bounds(self.path, self.speeds)

    @property
    def profile(self) -> MotionProfile:
        """The motion profile along the path."""
        return self.timed.profile

    @property
    def start(self) -> Array:
        """The axes (n,) [rad] where it begins."""
        return np.asarray(self.table[0])

    @property
    def end(self) -> Array:
        """The axes (n,) [rad] where it ends."""
        return np.asarray(self.table[-1])

    @property
    def duration(self) -> float:
        """[s]"""
        return self.profile.duration

    def axes(self, t: Array) -> AxisMotion:
        """The axes at times t (k,) [s] from the beginning of the segment."""
        motion = self.timed.at(t)
        grid = np.linspace(0.0, self.profile.length, len(self.table))
        near = np.stack([np.interp(motion.profile.s, grid, column) for column in self.table.T], axis=1)
        return axes_of_poses(self.arm, self.tool, self.branch, motion.T, motion.velocity, motion.acceleration, near)

    def shares_branch(self, other: CartesianSegment) -> bool:
        """Whether both move one tool on one branch, so that they may be added in space."""
        return self.branch == other.branch and np.array_equal(self.tool, other.tool)


MotionSegment: TypeAlias = PtpSegment | AxisSplineSegment | CartesianSegment


def ptp_bounds(start: Array, end: Array, speeds: Speeds) -> ProfileBounds:
    """Of a PTP that moves, its parameter from 0 to 1: the slowest axis counts."""
    way = np.abs(end - start)
    moved = way > STILL
    return ProfileBounds(
        float(np.min(speeds.axis[moved] / way[moved])), float(np.min(speeds.axis_ramp[moved] / way[moved]))
    )


def axes_of_poses(
    arm: Arm, tool: Array, branch: int, T: Array, velocity: Array, acceleration: Array, near: Array
) -> AxisMotion:
    """The axes at k poses of the tool centre point on one branch, each joint within half a turn of `near` (k, n).

    `T` (k, 4, 4) [m]; `velocity`, `acceleration` (k, 6), linear over angular, in the base frame. Raises
    `ExecutionError` where the Jacobian has no inverse, or a pose is out of reach.
    """
    q = all_branches(arm, T @ np.linalg.inv(tool)).q[:, branch]
    if np.isnan(q).any():
        raise ExecutionError("out-of-reach", "the path leaves the reach of the arm")
    q = q + TURN * np.round((near - q) / TURN)
    axes, p = joint_axes(arm.chain, q), T[:, :3, 3]
    J = jacobian_at(axes, p)
    try:
        dq: Array = np.linalg.solve(J, velocity[..., None])[..., 0].astype(np.float64)
        rest = acceleration - velocity_product_at(axes, p, dq)
        ddq: Array = np.linalg.solve(J, rest[..., None])[..., 0].astype(np.float64)
    except np.linalg.LinAlgError:
        raise ExecutionError("singularity", "the path meets a singularity", "move it, or go there by PTP") from None
    return AxisMotion(q, dq, ddq)


def is_held_back(segment: CartesianSegment) -> bool:
    """Whether v^2 / radius <= $ACC.CP makes an arc slower than $VEL.CP, where it is passed fastest."""
    profile, bound = segment.profile, pose_paths.fastest_on_arc(segment.path, segment.speeds)
    fastest = 2.0 * float(profile.coefficients[0, 2]) * float(profile.knots[1])
    return fastest > bound * (1.0 - 1e-9) and segment.speeds.cp > bound * (1.0 + 1e-9)


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
    profile = _profile(path.segment.length, pose_paths.path_bounds(path, speeds))
    timed = TimedPosePath(Path((path.segment,)), path.orientation, profile)
    steps = math.ceil(path.length / STEP_M) + math.ceil(path.angle / STEP_RAD)
    along = np.linspace(0.0, 1.0, int(np.clip(steps, FEWEST, MOST)) + 1)
    table = pose_paths.axes_along(arm, start, timed.poses(along * profile.length) @ np.linalg.inv(tool), along, report)
    if table is None:
        return None
    segment = CartesianSegment(arm, tool, path, timed, *table, speeds)
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
