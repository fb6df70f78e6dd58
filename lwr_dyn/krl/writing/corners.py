"""How a point between two written motions may be passed: the largest approximation that cuts the corner little enough.

Between two paths in space ($APO.CDIS = d) the corner is cut by a parabola, at most d sin(turn / 2) / 2 from it, and the
orientation is at most a quarter of what both turn within d away; between two PTP ($APO.CPTP) a quarter of what both
still go is missed. Passing between the two kinds, and to or from a
block, is left out: they stop there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.krl.motion.pose_paths import PosePath
from lwr_dyn.krl.writing.path_fit import FittedMotion, rotation_angle
from lwr_dyn.krl.writing.sampled_path import SampledPath

SMALLEST = 1e-5
"""[m] A smaller $APO.CDIS is none."""
DIGITS = 2
"""Of $APO.CDIS, rounded down."""


@dataclass(frozen=True, slots=True)
class Approximation:
    """C_DIS with $APO.CDIS [mm], or C_PTP with $APO.CPTP [%]."""

    keyword: str
    value: float


def approximations(
    samples: SampledPath, motions: Sequence[FittedMotion], tolerance: tuple[float, float], share: float = 1.0
) -> tuple[Approximation | None, ...]:
    """At the end of each motion, for corners cut by `tolerance` [m, rad] at most; `share` of each; none at the end."""
    found = [_at_corner(samples, a, b, tolerance, share) for a, b in pairwise(motions)]
    return (*found, None)


def _at_corner(
    samples: SampledPath, a: FittedMotion, b: FittedMotion, tolerance: tuple[float, float], share: float
) -> Approximation | None:
    if a.knots or b.knots or a.last in samples.pauses or (a.kind == "PTP") != (b.kind == "PTP"):
        return None
    if a.kind == "PTP":
        percent = np.floor(200.0 * share * _ptp_share(samples, a, b, tolerance))
        return Approximation("C_PTP", float(percent)) if percent >= 1.0 else None
    distance = share * _distance(a.path(samples), b.path(samples), tolerance)
    return Approximation("C_DIS", _rounded_down(1e3 * distance)) if distance >= SMALLEST else None


def _distance(a: PosePath, b: PosePath, tolerance: tuple[float, float]) -> float:
    """The largest $APO.CDIS [m] for which both position and orientation stay near the corner."""
    if min(a.length, b.length) < 2.0 * SMALLEST:
        return 0.0
    before, after = (a.segment.at(np.array([a.segment.length])), b.segment.at(np.array([0.0])))
    cut = float(np.linalg.norm(after.dp[0] - before.dp[0])) / 4.0
    ends = (a.orientation.at(np.array([a.segment.length])), b.orientation.at(np.array([0.0])))
    turn = float(np.linalg.norm(ends[1].rate[0] - ends[0].rate[0])) / 4.0
    # on arcs the chord of d leaves the path too: d^2 / (8 r)
    bend = float(np.linalg.norm(before.ddp[0]) + np.linalg.norm(after.ddp[0])) / 8.0
    d = 0.5 * min(a.length, b.length)
    d = min(d, tolerance[1] / turn) if turn > 0.0 else d
    return float(min(d, _root(bend, cut, tolerance[0])))


def _root(square: float, linear: float, most: float) -> float:
    """The d at which square d^2 + linear d = most; infinite without both."""
    if square == linear == 0.0:
        return np.inf
    return 2.0 * most / (linear + float(np.sqrt(linear**2 + 4.0 * square * most)))


def _ptp_share(samples: SampledPath, a: FittedMotion, b: FittedMotion, tolerance: tuple[float, float]) -> float:
    """The share of both motions, at most half, that may be blended."""
    q = samples.q
    miss = (q[b.last] - 2.0 * q[b.first] + q[a.first]) / 4.0
    T = _poses(samples, np.stack([q[b.first], q[b.first] + 1e-3 * miss]))
    position = float(np.linalg.norm(T[1, :3, 3] - T[0, :3, 3])) / 1e-3
    orientation = float(rotation_angle(T[1, :3, :3], T[0, :3, :3])) / 1e-3
    bounds = [most / found for most, found in zip(tolerance, (position, orientation), strict=True) if found > 0.0]
    return min([0.5, *bounds])


def _poses(samples: SampledPath, q: Array) -> Array:
    return np.asarray(flange_pose(samples.arm.chain, q) @ samples.tool)


def _rounded_down(x: float) -> float:
    unit = 10.0 ** (np.floor(np.log10(x)) + 1 - DIGITS)
    return float(np.round(np.floor(x / unit + 1e-9) * unit, 9))
