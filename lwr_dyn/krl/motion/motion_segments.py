"""Motion segments from rest to rest: PTP along the axes, LIN and CIRC along a path of the tool centre point.

A segment gives the axes at any time with exact derivatives; on a path in space by closed-form inverse kinematics on
the branch of its beginning (LIN keeps the Status), with rates by the Jacobian.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import OptionError
from lwr_dyn.ik_solvers.spherical_wrist import all_branches
from lwr_dyn.kinematics.forward import jacobian_at, joint_axes, velocity_product_at
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.settings import ProfileBounds, Speeds
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.motion_profile import MotionProfile
from lwr_dyn.trajectory.pose_path import Slerp, TimedPosePath, slerp
from lwr_dyn.trajectory.segments import SHORTEST, ArcSegment, LineSegment

TURN = 2.0 * math.pi
STILL = 1e-9
"""[m, rad] A smaller motion is none."""


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


@dataclass(frozen=True, slots=True, eq=False)
class PosePath:
    """A line or arc of the tool centre point, with the orientation turning about one axis in proportion.

    The parameter of both is the length [m]; of a turn in place, which has no length, it is the angle [rad].
    """

    segment: LineSegment | ArcSegment
    orientation: Slerp
    length: float
    """[m]"""
    angle: float
    """[rad] Turn of the orientation."""

    @property
    def is_still(self) -> bool:
        """Whether nothing moves."""
        return self.length < STILL and self.angle < STILL


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


MotionSegment: TypeAlias = PtpSegment | CartesianSegment


def ptp_bounds(start: Array, end: Array, speeds: Speeds) -> ProfileBounds:
    """Of a PTP that moves, its parameter from 0 to 1: the slowest axis counts."""
    way = np.abs(end - start)
    moved = way > STILL
    return ProfileBounds(
        float(np.min(speeds.axis[moved] / way[moved])), float(np.min(speeds.axis_ramp[moved] / way[moved]))
    )


def path_bounds(path: PosePath, speeds: Speeds) -> ProfileBounds:
    """Of a path that is not still: the tighter of path and orientation."""
    whole = path.segment.length
    both = [(path.length / whole, speeds.cp, speeds.cp_ramp), (path.angle / whole, speeds.ori, speeds.ori_ramp)]
    moving = [(rate, v, a) for rate, v, a in both if rate * whole > STILL]
    return ProfileBounds(min(v / rate for rate, v, _ in moving), min(a / rate for rate, _, a in moving))


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


def path_between(start: Array, end: Array, through: Array | None = None, angle: float | None = None) -> PosePath:
    """The path from one pose (4, 4) to another: a line, or an arc through a third pose; `angle` [rad] is CIRC's CA.

    Raises `ExecutionError`: half a turn of the orientation, three points of an arc in line.
    """
    try:
        turn = slerp(start[:3, :3], end[:3, :3], 1.0)
    except OptionError:
        hint = "put a point in between: either way is as short"
        raise ExecutionError("half-turn", "the orientation turns by 180 deg", hint) from None
    if through is not None:
        segment: LineSegment | ArcSegment = _arc(start[:3, 3], through[:3, 3], end[:3, 3], angle)
        length = segment.length
    else:
        way = end[:3, 3] - start[:3, 3]
        length = float(np.linalg.norm(way))
        parameter = turn.rate if length < SHORTEST and turn.rate > STILL else max(length, STILL)
        segment = LineSegment(start[:3, 3], way / parameter, parameter)
    return PosePath(segment, Slerp(turn.R, turn.axis, turn.rate / segment.length), length, turn.rate)


def _arc(a: Array, b: Array, c: Array, angle: float | None) -> ArcSegment:
    """The arc from a through b to c (3,) [m]."""
    u, v = b - a, c - a
    normal = np.cross(u, v)
    area = float(normal @ normal)
    if area < 1e-12 * max(float(u @ u), 1e-12) * max(float(v @ v), 1e-12):
        raise ExecutionError("no-arc", "start, auxiliary point and end lie in line", "three points that make a circle")
    centre = a + (np.cross(normal, u) * (v @ v) + np.cross(v, normal) * (u @ u)) / (2.0 * area)
    radius = float(np.linalg.norm(a - centre))
    x, z = (a - centre) / radius, normal / math.sqrt(area)
    y = np.cross(z, x)
    whole = math.atan2(float((c - centre) @ y), float((c - centre) @ x)) % TURN
    if angle is not None:
        whole = abs(angle)
        y = math.copysign(1.0, angle) * y
    if whole * radius < 1e-9:
        raise ExecutionError("no-arc", "the arc has no length", "an angle CA that is not 0")
    return ArcSegment(centre, radius, x, y, radius * whole)
