"""A path in space: segments end to end, with the length travelled as its one parameter, and its joints."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, real_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.segments import PathSample, Segment

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

        >>> from lwr_dyn.trajectory.segments import line
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

    Raises
    ------
    OptionError
        No segment, or a gap between two of them; says where and how wide.
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
