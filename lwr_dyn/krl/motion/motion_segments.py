"""Motion segments from rest to rest: PTP along the axes, LIN and CIRC along a path of the tool centre point.

A segment gives the axes at any time with exact derivatives; on a path in space by closed-form inverse kinematics on
the branch of its beginning (LIN keeps the Status), with rates by the Jacobian.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.interpolate import CubicSpline

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import jacobian_at, joint_axes, velocity_product_at
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.pose_paths import STILL, TURN, PosePath, fastest_on_arc, path_bounds
from lwr_dyn.krl.motion.settings import ProfileBounds, Speeds
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.motion_profile import MotionProfile
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
        return path_bounds(self.path, self.speeds)

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
    profile, bound = segment.profile, fastest_on_arc(segment.path, segment.speeds)
    fastest = 2.0 * float(profile.coefficients[0, 2]) * float(profile.knots[1])
    return fastest > bound * (1.0 - 1e-9) and segment.speeds.cp > bound * (1.0 + 1e-9)
