"""The path of a SPLINE block: lines, arcs and curves through points, with one orientation along all of it.

A run of SPL is a curve through its points, with their distance as the parameter: cubic, with continuous second
derivatives, and free at the ends of the block; beside a SLIN or SCIRC it takes that one's direction and curvature, and
is then of degree 5. Where a SLIN or SCIRC changes direction by more than `CORNER` the arm has to stop. The orientation
is a cubic curve of quaternions through all points. KUKA's own curve is not published: this one is assumed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.motion.orientation_curve import orientation_through
from lwr_dyn.krl.motion.pose_paths import PosePath, path_between
from lwr_dyn.krl.motion.settings import Speeds
from lwr_dyn.trajectory.path import Path
from lwr_dyn.trajectory.segments import SHORTEST, PathSample, Segment

CORNER = math.radians(1.0)
"""[rad]"""


@dataclass(frozen=True, slots=True, eq=False)
class SplinePoint:
    """A motion of a block: SPL, LIN or CIRC to a pose (4, 4) [m]; of CIRC the auxiliary pose and CA [rad]."""

    kind: str
    pose: Array
    speeds: Speeds
    through: Array | None = None
    angle: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PointCurve:
    """A curve through points; `curve` is a spline of scipy with its first two derivatives."""

    curve: tuple[Any, Any, Any]
    length: float
    """Of the parameter [m]: the sum of the distances."""

    def at(self, s: Array) -> PathSample:
        """Position and its derivatives at s (k,)."""
        return PathSample(*(np.asarray(f(s), dtype=np.float64) for f in self.curve))


@dataclass(frozen=True, slots=True, eq=False)
class SplinePiece:
    """A part of the path from stop to stop: poses along s, the s at which its motions end, and their indices."""

    path: PosePath
    ends: Array
    motions: tuple[int, ...]


def spline_pieces(start: Array, points: Sequence[SplinePoint]) -> Iterator[SplinePiece]:
    """The path from the pose `start` (4, 4) through all points, split where the arm stops.

    A point where the arm already stands is left out.
    """
    poses = [start, *(x.pose for x in points)]
    moved = [k for k, x in enumerate(points) if x.kind == "CIRC" or not path_between(poses[k], x.pose).is_still]
    lines = [_simple(poses[k], points[k]) for k in moved]
    begin = 0
    for i in range(1, len(moved) + 1):
        if i == len(moved) or _stops(lines[i - 1], lines[i]):
            part = moved[begin:i]
            yield _piece([poses[part[0]], *(poses[k + 1] for k in part)], lines[begin:i], part)
            begin = i


def _simple(start: Array, x: SplinePoint) -> Segment | None:
    """The line or arc of a motion; None for SPL, unless it only turns."""
    length = float(np.linalg.norm(x.pose[:3, 3] - start[:3, 3]))
    if x.kind == "SPL" and length >= SHORTEST:
        return None
    return path_between(start, x.pose, x.through, x.angle).segment


def _direction(line: Segment, at_end: bool) -> Array:
    return np.asarray(line.at(np.array([line.length if at_end else 0.0])).dp[0])


def _stops(before: Segment | None, after: Segment | None) -> bool:
    if before is None or after is None:
        # a curve takes the direction of a line or arc beside it, but there is none of a turn in place
        other = before or after
        return other is not None and float(np.linalg.norm(_direction(other, True))) < 0.5
    a, b = _direction(before, True), _direction(after, False)
    return float(a @ b) < math.cos(CORNER)


def _piece(poses: Sequence[Array], lines: Sequence[Segment | None], motions: Sequence[int]) -> SplinePiece:
    segments: list[Segment] = []
    ends: list[float] = []
    k = 0
    while k < len(lines):
        line, last, begin = lines[k], k, (ends[-1] if ends else 0.0)
        if line is not None:
            segments.append(line)
            ends.append(begin + line.length)
        else:
            while last + 1 < len(lines) and lines[last + 1] is None:
                last += 1
            points = np.array([pose[:3, 3] for pose in poses[k : last + 2]])
            before, after = (lines[k - 1] if k else None), (lines[last + 1] if last + 1 < len(lines) else None)
            knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
            segments.append(_curve(knots, points, before, after))
            ends += [begin + float(s) for s in knots[1:]]
        k = last + 1
    whole = Path(tuple(segments))
    marks = np.concatenate([[0.0], ends])
    orientation = orientation_through(marks, np.array([pose[:3, :3] for pose in poses]))
    s = np.linspace(0.0, whole.length, 40 * len(lines) + 1)
    length = float(np.trapezoid(np.linalg.norm(whole.at(s).dp, axis=1), s))
    angle = float(np.trapezoid(np.linalg.norm(orientation.at(s).rate, axis=1), s))
    return SplinePiece(PosePath(whole, orientation, length, angle), np.array(ends), tuple(motions))


def _curve(knots: Array, points: Array, before: Segment | None, after: Segment | None) -> PointCurve:
    """The curve through points (k, 3) at `knots` (k,)."""
    free = [(2, np.zeros(3))]
    degree, ends = 3, (free, free)
    if before is not None or after is not None:
        degree, free = 5, [(2, np.zeros(3)), (3, np.zeros(3))]
        ends = (_end(before, True) or free, _end(after, False) or free)
    bounds: Any = ends
    curve = make_interp_spline(knots, points, k=degree, bc_type=bounds)
    return PointCurve((curve, curve.derivative(1), curve.derivative(2)), float(knots[-1]))


def _end(line: Segment | None, at_end: bool) -> list[tuple[int, Array]] | None:
    if line is None:
        return None
    place = line.at(np.array([line.length if at_end else 0.0]))
    return [(1, place.dp[0]), (2, place.ddp[0])]
