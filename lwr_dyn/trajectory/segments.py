"""Segments in space: a straight line and a circular arc, as functions of the length travelled on them."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays
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

    Raises
    ------
    ShapeError
        Not points.
    OptionError
        The points are the same.

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
