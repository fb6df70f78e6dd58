"""Legs of a movement: from one stop to the next, in axes (PTP) or in space (LIN, CIRC), rest to rest.

A leg knows where its axes are at any time with exact derivatives; in space by the closed-form inverse kinematics on
the branch it began on (LIN keeps Status), rates by the Jacobian.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.jacobian import jacobian_at, joint_axes, velocity_product_at
from lwr_dyn.kinematics.spherical_wrist import all_branches
from lwr_dyn.krl.values import HaltError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import skew
from lwr_dyn.trajectory.motion_profile import MotionProfile
from lwr_dyn.trajectory.segments import ArcSegment, LineSegment

TURN = 2.0 * math.pi
STEP_M, STEP_RAD = 0.005, math.radians(1.0)
"""A path in space is looked at this densely."""
FEWEST, MOST = 24, 600


@dataclass(frozen=True, slots=True, eq=False)
class Axes:
    """Axes over k times: q, dq, ddq (k, n)."""

    q: Array
    dq: Array
    ddq: Array


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """A tool centre point over k times: p, v, a (k, 3) [m ...], R (k, 3, 3), w, dw (k, 3) [rad/s ...], base axes."""

    p: Array
    R: Array
    v: Array
    w: Array
    a: Array
    dw: Array


@dataclass(frozen=True, slots=True, eq=False)
class JointLeg:
    """PTP: all axes from `start` to `end` in one law from 0 to 1."""

    arm: Arm
    start: Array
    end: Array
    law: MotionProfile

    @property
    def duration(self) -> float:
        """[s]"""
        return self.law.duration

    def axes(self, t: Array) -> Axes:
        """At times t (k,) [s] from its beginning."""
        law, step = self.law.at(t), self.end - self.start
        return Axes(self.start + np.outer(law.s, step), np.outer(law.ds, step), np.outer(law.dds, step))


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A path of the tool centre point over s from 0 to 1: a line, an arc or a place, and one turn about an axis."""

    segment: LineSegment | ArcSegment | None
    place: Array
    """(3,) [m] Where it begins."""
    rotation: Array
    """(3, 3) The orientation it begins with."""
    axis: Array
    angle: float
    """[rad] Turned on the whole path, about `axis` (3,) in the base."""

    @property
    def length(self) -> float:
        """[m]"""
        return 0.0 if self.segment is None else self.segment.length

    def at(self, s: Array, ds: Array, dds: Array) -> Poses:
        """Pose and rates at s (k,) with its rates."""
        if self.segment is None:
            p, dp = np.broadcast_to(self.place, (len(s), 3)), np.zeros((len(s), 3))
            ddp = dp
        else:
            length = self.segment.length
            found = self.segment.at(s * length)
            p, dp, ddp = found.p, found.dp * length, found.ddp * length**2
        turn = (self.angle * s)[:, None, None]
        K = skew(self.axis)
        R = (np.eye(3) + np.sin(turn) * K + (1.0 - np.cos(turn)) * (K @ K)) @ self.rotation
        rate = self.angle * self.axis
        v = dp * ds[:, None]
        a = dp * dds[:, None] + ddp * ds[:, None] ** 2
        return Poses(p, R, v, np.outer(ds, rate), a, np.outer(dds, rate))


@dataclass(frozen=True, slots=True, eq=False)
class PoseLeg:
    """LIN or CIRC: the tool centre point on a track; `tool` is T_{flange,tcp}, `table` the axes at even steps of s."""

    arm: Arm
    tool: Array
    track: Track
    law: MotionProfile
    branch: int
    table: Array
    """(m, n) [rad]"""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.law.duration

    @property
    def start(self) -> Array:
        """Axes where it begins (n,)."""
        return np.asarray(self.table[0])

    @property
    def end(self) -> Array:
        """Axes where it ends (n,)."""
        return np.asarray(self.table[-1])

    def poses(self, t: Array) -> Poses:
        """The tool centre point at times t (k,) [s]."""
        law = self.law.at(t)
        return self.track.at(law.s, law.ds, law.dds)

    def axes(self, t: Array) -> Axes:
        """At times t (k,) [s] from its beginning."""
        s = self.law.at(t).s
        grid = np.linspace(0.0, 1.0, len(self.table))
        near = np.stack([np.interp(s, grid, column) for column in self.table.T], axis=1)
        return axes_of_poses(self.arm, self.tool, self.branch, self.poses(t), near)


Leg: TypeAlias = JointLeg | PoseLeg


def axes_of_poses(arm: Arm, tool: Array, branch: int, poses: Poses, near: Array) -> Axes:
    """Axes of poses of the tool centre point on one branch, each joint within half a turn of `near` (k, n).

    Raises `HaltError` where the Jacobian has no inverse, or a pose is out of reach.
    """
    T = np.zeros((len(poses.p), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = poses.R, poses.p, 1.0
    q = all_branches(arm, T @ np.linalg.inv(tool)).q[:, branch]
    if np.isnan(q).any():
        raise HaltError("out-of-reach", "the path leaves the reach of the arm", "")
    q = q + TURN * np.round((near - q) / TURN)
    axes = joint_axes(arm.chain, q)
    J = jacobian_at(axes, poses.p)
    try:
        dq: Array = np.linalg.solve(J, np.hstack([poses.v, poses.w])[..., None])[..., 0].astype(np.float64)
        rest = np.hstack([poses.a, poses.dw]) - velocity_product_at(axes, poses.p, dq)
        ddq: Array = np.linalg.solve(J, rest[..., None])[..., 0].astype(np.float64)
    except np.linalg.LinAlgError:
        raise HaltError("singularity", "the path meets a singularity", "move it, or go there by PTP") from None
    return Axes(q, dq, ddq)


def track_between(start: Array, end: Array, through: Array | None = None, angle: float | None = None) -> Track:
    """From one pose (4, 4) straight to another, or round through a third on an arc; `angle` [rad] is CIRC's CA.

    Raises `HaltError`: half a turn of the orientation, three points of an arc in line.
    """
    axis, turn = turn_between(start[:3, :3], end[:3, :3])
    if through is not None:
        segment: LineSegment | ArcSegment | None = _arc(start[:3, 3], through[:3, 3], end[:3, 3], angle)
    else:
        way = end[:3, 3] - start[:3, 3]
        length = float(np.linalg.norm(way))
        segment = LineSegment(start[:3, 3], way / length, length) if length > 1e-9 else None
    return Track(segment, start[:3, 3], start[:3, :3], axis, turn)


def turn_between(start: Array, end: Array) -> tuple[Array, float]:
    """The axis (3,) and angle [rad] of the shortest turn between rotations, in base axes; raises `HaltError`."""
    D = end @ start.T
    twice = np.array([D[2, 1] - D[1, 2], D[0, 2] - D[2, 0], D[1, 0] - D[0, 1]])
    sine = float(np.linalg.norm(twice))
    angle = math.atan2(sine, float(np.trace(D)) - 1.0)
    if angle > math.pi - 1e-6:
        raise HaltError(
            "half-turn", "the orientation turns by 180 deg", "put a point in between: either way is as short"
        )
    return (twice / sine if sine > 0.0 else np.array([0.0, 0.0, 1.0])), (angle if angle > 1e-12 else 0.0)


def _arc(a: Array, b: Array, c: Array, angle: float | None) -> ArcSegment:
    u, v = b - a, c - a
    normal = np.cross(u, v)
    area = float(normal @ normal)
    if area < 1e-12 * max(float(u @ u), 1e-12) * max(float(v @ v), 1e-12):
        raise HaltError("no-arc", "start, auxiliary point and end lie in line", "three points that make a circle")
    centre = a + (np.cross(normal, u) * (v @ v) + np.cross(v, normal) * (u @ u)) / (2.0 * area)
    radius = float(np.linalg.norm(a - centre))
    x, z = (a - centre) / radius, normal / math.sqrt(area)
    y = np.cross(z, x)
    whole = math.atan2(float((c - centre) @ y), float((c - centre) @ x)) % TURN
    if angle is not None:
        whole = abs(angle)
        y = math.copysign(1.0, angle) * y
    if whole * radius < 1e-9:
        raise HaltError("no-arc", "the arc has no length", "an angle CA that is not 0")
    return ArcSegment(centre, radius, x, y, radius * whole)


def steps_of(track: Track) -> int:
    """How many places a track is looked at."""
    return int(np.clip(math.ceil(track.length / STEP_M) + math.ceil(abs(track.angle) / STEP_RAD), FEWEST, MOST)) + 1
