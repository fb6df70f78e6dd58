"""Blends: corners and bends of a path rounded by quintics, so that they can be passed at speed.

A blend leaves the path a given distance before a joint and comes back the same distance after it, with
position, tangent and curvature continuous: the acceleration along the path does not jump there.
"""

import math
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.motion_profile import positive_number
from lwr_dyn.trajectory.path import Path, PathJoint, end_of, path_of, start_of
from lwr_dyn.trajectory.segments import PathSample, Segment

PANELS, NODES = 32, 10
"""Gauss-Legendre panels for the length of a quintic: exact to rounding for the blends of this file."""
NEWTON = 3
"""Newton steps from the table's linear guess to u(s): each squares the error, two reach rounding, one is a reserve."""
REVERSAL = math.radians(170.0)
"""[rad] A corner that turns by more cannot be rounded: the path goes back on itself."""
_X, _W = np.polynomial.legendre.leggauss(NODES)


@dataclass(frozen=True, slots=True, eq=False)
class QuinticCurve:
    """A quintic curve p(u), u from 0 to 1, by its length: `coefficients` (6, 3) [m], lowest power first."""

    coefficients: Array
    lengths: Array
    """Length from 0 to the end of each panel, (PANELS + 1,) [m]."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "coefficients", "lengths")

    @property
    def length(self) -> float:
        """[m]"""
        return float(self.lengths[-1])

    def at(self, s: Array) -> PathSample:
        """Position, tangent and curvature vector at s (k,) [m]; u(s) is solved to rounding."""
        u = np.interp(s, self.lengths, np.linspace(0.0, 1.0, PANELS + 1))
        for _ in range(NEWTON):
            u = np.clip(u - (self._length_to(u) - s) / _speed(self.coefficients, u), 0.0, 1.0)
        p, v, a = (_evaluate(self.coefficients, u, order) for order in range(3))
        square = np.sum(v * v, axis=1, keepdims=True)
        along = np.sum(v * a, axis=1, keepdims=True)
        return PathSample(p, v / np.sqrt(square), (a - v * along / square) / square)

    def _length_to(self, u: Array) -> Array:
        panel = np.minimum((u * PANELS).astype(int), PANELS - 1)
        begin = panel / PANELS
        half = 0.5 * (u - begin)
        nodes = begin[:, None] + half[:, None] * (1.0 + _X)
        rates = _speed(self.coefficients, nodes.ravel()).reshape(nodes.shape)
        out: Array = self.lengths[panel] + half * (rates @ _W)
        return out


@dataclass(frozen=True, slots=True, eq=False)
class PartOfSegment:
    """A part of a segment: it begins at `start` [m] and is `length` [m] long."""

    segment: Segment
    start: float
    length: float

    def at(self, s: Array) -> PathSample:
        """The segment at s + start."""
        return self.segment.at(s + self.start)


def quintic_between(before: PathSample, after: PathSample, speed: float) -> QuinticCurve:
    """The quintic with the position, tangent and curvature of two samples (k = 1), and |dp/du| = speed at its ends."""
    p0, v0, a0 = before.p[0], speed * before.dp[0], speed**2 * before.ddp[0]
    p1, v1, a1 = after.p[0], speed * after.dp[0], speed**2 * after.ddp[0]
    step = p1 - p0 - v0 - a0 / 2.0
    turn, pull = v1 - v0 - a0, a1 - a0
    c3 = 10.0 * step - 4.0 * turn + 0.5 * pull
    c4 = -15.0 * step + 7.0 * turn - pull
    c5 = 6.0 * step - 3.0 * turn + 0.5 * pull
    c = np.array([p0, v0, a0 / 2.0, c3, c4, c5])
    edges = np.linspace(0.0, 1.0, PANELS + 1)
    nodes = edges[:-1, None] + (0.5 / PANELS) * (1.0 + _X)
    panels = _speed(c, nodes.ravel()).reshape(nodes.shape) @ _W * (0.5 / PANELS)
    return QuinticCurve(c, np.concatenate([[0.0], np.cumsum(panels)]))


def blended(path: Path, corners: float = 0.0, bends: float = 0.0) -> Path:
    """The path with its corners and bends rounded.

    A corner that turns back (by more than 170 deg) stays: it needs a stop.

    Parameters
    ----------
    corners : float
        [m] Distance from a corner at which the path is left and met again; 0 keeps the corners.
    bends : float
        [m] The same where only the curvature jumps (a line that runs into an arc); 0 keeps the bends.

    Raises
    ------
    OptionError
        A distance that is negative, or too long for a segment between two blends.
    """
    sizes = {"corners": corners, "bends": bends}
    for name, size in sizes.items():
        if size != 0.0:
            positive_number(name, size)
    reach = [0.0, *(_reach(joint, corners, bends) for joint in path.joints()), 0.0]
    out: list[Segment] = []
    for i, segment in enumerate(path.segments):
        left = segment.length - reach[i] - reach[i + 1]
        if left < 0.0:
            raise OptionError(
                "blend", f"{reach[i]:g} m and {reach[i + 1]:g} m at the ends of segment {i}",
                f"together at most its length, {segment.length:g} m",
            )  # fmt: skip
        part = PartOfSegment(segment, reach[i], left) if reach[i] or reach[i + 1] else segment
        if reach[i]:
            out.append(_blend(end_of(out[-1]), start_of(part), reach[i]))
        out.append(part)
    return path_of([segment for segment in out if segment.length > 0.0])


def _reach(joint: PathJoint, corners: float, bends: float) -> float:
    if joint.is_corner:
        return corners if joint.turn < REVERSAL else 0.0
    return bends if joint.is_bend else 0.0


def _blend(before: PathSample, after: PathSample, reach: float) -> QuinticCurve:
    """With |dp/du| half-way between chord and legs: both the curvature and its slope are near their least there."""
    chord = float(np.linalg.norm(after.p[0] - before.p[0]))
    return quintic_between(before, after, reach + 0.5 * chord)


def _evaluate(c: Array, u: Array, order: int) -> Array:
    for _ in range(order):
        c = c[1:] * np.arange(1, len(c))[:, None]
    out: Array = (u[:, None] ** np.arange(len(c))) @ c
    return out


def _speed(c: Array, u: Array) -> Array:
    out: Array = np.linalg.norm(_evaluate(c, u, 1), axis=1)
    return out
