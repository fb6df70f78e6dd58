"""Paths of the tool centre point with their orientation: lines, arcs, and what bounds the motion on them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.settings import ProfileBounds, Speeds
from lwr_dyn.trajectory.pose_path import Orientation, Slerp, slerp
from lwr_dyn.trajectory.segments import SHORTEST, ArcSegment, LineSegment, Segment

TURN = 2.0 * math.pi
STILL = 1e-9
"""[m, rad] A smaller motion is none."""


@dataclass(frozen=True, slots=True, eq=False)
class PosePath:
    """A line or arc of the tool centre point, with the orientation turning about one axis in proportion; or a spline.

    The parameter of both is the length [m]; of a turn in place, which has no length, it is the angle [rad].
    """

    segment: Segment
    orientation: Orientation
    length: float
    """[m]"""
    angle: float
    """[rad] Turn of the orientation."""

    @property
    def is_still(self) -> bool:
        """Whether nothing moves."""
        return self.length < STILL and self.angle < STILL


def path_bounds(path: PosePath, speeds: Speeds) -> ProfileBounds:
    """Of a path that is not still: the tighter of path and orientation; on an arc v^2 / radius <= $ACC.CP (assumed)."""
    whole = path.segment.length
    cp = min(speeds.cp, fastest_on_arc(path, speeds))
    both = [(path.length / whole, cp, speeds.cp_ramp), (path.angle / whole, speeds.ori, speeds.ori_ramp)]
    moving = [(rate, v, a) for rate, v, a in both if rate * whole > STILL]
    return ProfileBounds(min(v / rate for rate, v, _ in moving), min(a / rate for rate, _, a in moving))


def fastest_on_arc(path: PosePath, speeds: Speeds) -> float:
    """[m/s] At which the acceleration across an arc, v^2 / radius, is $ACC.CP; infinite on a line."""
    segment = path.segment
    return math.sqrt(speeds.cp_ramp * segment.radius) if isinstance(segment, ArcSegment) else math.inf


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
