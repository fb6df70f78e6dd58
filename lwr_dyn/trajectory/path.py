"""A path in space: lines and arcs end to end, with the length travelled as its one parameter, and its joints."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays, real_array
from lwr_dyn.foundation.errors import OptionError

SHORTEST = 1e-6
"""[m] A segment below this has no direction that survives rounding."""

PLANE = 1e-9
"""[m] How far the start of an arc may lie off its plane."""


@dataclass(frozen=True, slots=True, eq=False)
class PathSample:
    """A path at k lengths s: p (k, 3) [m], dp = dp/ds (k, 3) of unit length, ddp = d2p/ds2 (k, 3) [1/m]."""

    p: Array
    dp: Array
    ddp: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "p", "dp", "ddp")


class Segment(Protocol):
    """A smooth curve in space with the length on it as its parameter."""

    @property
    def length(self) -> float:
        """[m]"""

    def at(self, s: Array) -> PathSample:
        """Position, tangent and curvature vector at lengths s (k,) [m] from 0 to `length`."""


@dataclass(frozen=True, slots=True, eq=False)
class LineSegment:
    """A straight line: p(s) = start + s direction."""

    start: Array
    direction: Array
    length: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "start", "direction")

    def at(self, s: Array) -> PathSample:
        """Position, tangent and curvature vector at s (k,) [m]."""
        p = self.start + s[:, None] * self.direction
        return PathSample(p, np.broadcast_to(self.direction, p.shape), np.zeros_like(p))


@dataclass(frozen=True, slots=True, eq=False)
class ArcSegment:
    """A circular arc: p(s) = centre + radius (cos(s/radius) x + sin(s/radius) y), x and y unit and orthogonal."""

    centre: Array
    radius: float
    x: Array
    y: Array
    length: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "centre", "x", "y")

    def at(self, s: Array) -> PathSample:
        """Position, tangent and curvature vector at s (k,) [m]."""
        angle = s[:, None] / self.radius
        out = np.cos(angle) * self.x + np.sin(angle) * self.y
        dp = np.cos(angle) * self.y - np.sin(angle) * self.x
        return PathSample(self.centre + self.radius * out, dp, -out / self.radius)


def line(start: ArrayLike, end: ArrayLike) -> LineSegment:
    """The straight line between two points (3,) [m].

    Raises `ShapeError`: not points; `OptionError`: the points are the same.

    >>> line((0, 0, 0), (0, 3, 4)).length
    5.0
    """
    a, b = fixed_array("start", start, (3,)), fixed_array("end", end, (3,))
    length = float(np.linalg.norm(b - a))
    if length < SHORTEST:
        raise OptionError("line", f"{length:g} m long", f"at least {SHORTEST:g} m from start to end")
    return LineSegment(a, (b - a) / length, length)


def arc(start: ArrayLike, centre: ArrayLike, normal: ArrayLike, angle: float) -> ArcSegment:
    """The arc from `start` around `centre` by `angle` [rad], right-handed about `normal`.

    Parameters
    ----------
    start, centre : (3,) array_like
        [m]
    normal : (3,) array_like
        Normal of the plane, of any length.
    angle : float
        [rad], from -2 pi to 2 pi; negative turns the other way.

    Raises
    ------
    ShapeError
        Not points.
    OptionError
        No radius, a start off the plane, or an angle outside its range.

    >>> arc((1, 0, 0), (0, 0, 0), (0, 0, 1), math.pi).at(np.array([math.pi])).p.round(12) + 0.0
    array([[-1.,  0.,  0.]])
    """
    begin, middle = fixed_array("start", start, (3,)), fixed_array("centre", centre, (3,))
    z = fixed_array("normal", normal, (3,))
    radius, size = float(np.linalg.norm(begin - middle)), float(np.linalg.norm(z))
    if size == 0.0:
        raise OptionError("normal", "the zero vector", "a direction")
    turn = float(angle)
    if not (math.isfinite(turn) and radius * abs(turn) >= SHORTEST and abs(turn) <= 2.0 * math.pi):
        raise OptionError(
            "arc", f"radius {radius:g} m, angle {turn:g} rad", f"|angle| up to 2 pi, length at least {SHORTEST:g} m"
        )
    x = (begin - middle) / radius
    z = math.copysign(1.0, turn) * z / size
    if abs(x @ z) * radius > PLANE:
        raise OptionError("start", f"{abs(x @ z) * radius:g} m off the arc's plane", f"at most {PLANE:g} m")
    return ArcSegment(middle, radius, x, np.cross(z, x), radius * abs(turn))


GAP = 1e-9
"""[m] How far apart two segments may be where they join."""

TURN = 1e-6
"""[rad] A smaller turn of the tangent is rounding."""

BEND = 1e-6
"""[1/m] A smaller step of the curvature vector is rounding."""


@dataclass(frozen=True, slots=True)
class PathJoint:
    """Where two segments meet: at s [m], with a turn of the tangent [rad] and a step of the curvature vector [1/m]."""

    s: float
    turn: float
    bend: float

    @property
    def is_corner(self) -> bool:
        """The tangent jumps, and at speed the velocity."""
        return self.turn > TURN

    @property
    def is_bend(self) -> bool:
        """Only the curvature jumps, and at speed v the acceleration by v^2 bend."""
        return not self.is_corner and self.bend > BEND


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Segments end to end; s runs from 0 to `length` over all of them."""

    segments: tuple[Segment, ...]

    @property
    def starts(self) -> Array:
        """Where each segment begins, and where the last one ends: (m + 1,) [m]."""
        return np.concatenate([[0.0], np.cumsum([segment.length for segment in self.segments])])

    @property
    def length(self) -> float:
        """[m]"""
        return float(self.starts[-1])

    def at(self, s: ArrayLike) -> PathSample:
        """Position, tangent and curvature vector at s (k,) [m]; at a joint, those of the segment that begins there.

        >>> from lwr_dyn.trajectory.path import line
        >>> path_of([line((0, 0, 0), (1, 0, 0)), line((1, 0, 0), (1, 2, 0))]).at([2.5]).p
        array([[1. , 1.5, 0. ]])
        """
        starts = self.starts
        where = np.clip(np.atleast_1d(real_array("s", s)), 0.0, starts[-1])
        owner = np.searchsorted(starts[1:-1], where, side="right")
        p, dp, ddp = (np.empty((len(where), 3)) for _ in range(3))
        for i in np.unique(owner):
            mine = owner == i
            part = self.segments[i].at(where[mine] - starts[i])
            p[mine], dp[mine], ddp[mine] = part.p, part.dp, part.ddp
        return PathSample(p, dp, ddp)

    def joints(self) -> tuple[PathJoint, ...]:
        """Where the segments meet, and what jumps there."""
        starts = self.starts[1:-1]
        return tuple(_joint(float(s), a, b) for s, (a, b) in zip(starts, pairwise(self.segments), strict=True))

    def corners(self) -> tuple[PathJoint, ...]:
        """The joints where the tangent jumps."""
        return tuple(joint for joint in self.joints() if joint.is_corner)

    def sections(self) -> tuple[float, ...]:
        """Lengths [m] from corner to corner, each followed without a stop."""
        marks = [0.0, *(corner.s for corner in self.corners()), self.length]
        return tuple(b - a for a, b in pairwise(marks))


def path_of(segments: Sequence[Segment]) -> Path:
    """Segments joined end to end.

    Raises `OptionError`: no segment, or a gap between two of them; says where and how wide.
    """
    if not segments:
        raise OptionError("segments", "none", "at least one segment")
    for i, (a, b) in enumerate(pairwise(segments)):
        gap = float(np.linalg.norm(end_of(a).p - start_of(b).p))
        if gap > GAP:
            raise OptionError("segments", f"a gap of {gap:g} m between {i} and {i + 1}", f"at most {GAP:g} m")
    return Path(tuple(segments))


def start_of(segment: Segment) -> PathSample:
    """The segment where it begins, k = 1."""
    return segment.at(np.array([0.0]))


def end_of(segment: Segment) -> PathSample:
    """The segment where it ends, k = 1."""
    return segment.at(np.array([segment.length]))


def _joint(s: float, a: Segment, b: Segment) -> PathJoint:
    before, after = end_of(a), start_of(b)
    u, v = before.dp[0], after.dp[0]
    turn = math.atan2(float(np.linalg.norm(np.cross(u, v))), float(u @ v))
    return PathJoint(s, turn, float(np.linalg.norm(after.ddp[0] - before.ddp[0])))
