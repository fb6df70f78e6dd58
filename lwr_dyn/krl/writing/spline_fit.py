"""SPLINE blocks in place of many short motions: SPL through as few samples as keep the curve within the tolerance.

The curve is the one that `krl run` plans (cubic, through its points); KUKA's own is not published, so between the
points a controller's path may be another one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.pose_paths import PosePath
from lwr_dyn.krl.motion.settings import Speeds
from lwr_dyn.krl.motion.spline_path import SplinePoint, spline_pieces
from lwr_dyn.krl.writing.path_fit import FittedMotion, poses_at, within
from lwr_dyn.krl.writing.sampled_path import SampledPath

FEWEST = 3
"""Motions that a block replaces."""
LONG = 5.0
"""A motion so many times as long as the middle one stays as it is."""
ROUNDS, STEPS = 16, 6
MOST = 3000
"""Points of a block."""
_UNUSED = Speeds(np.zeros(6), np.zeros(6), 0.0, 0.0, 0.0, 0.0)


def with_splines(
    samples: SampledPath, motions: Sequence[FittedMotion], tolerance: tuple[float, float], wherever: bool = False
) -> tuple[FittedMotion, ...]:
    """The motions with SPL blocks for runs of LIN and CIRC that need more points; `wherever` it is possible at all."""
    out: list[FittedMotion] = []
    for group in _groups(samples, motions, wherever):
        points = sum(2 if motion.kind == "CIRC" else 1 for motion in group)
        knots = None
        if group[0].kind != "PTP" and (wherever or len(group) >= FEWEST):
            knots = _knots(samples, group[0].first, group[-1].last, tolerance, MOST if wherever else points - 1)
        out += group if knots is None else [FittedMotion("SPL", group[0].first, group[-1].last, None, knots)]
    return tuple(out)


def _groups(samples: SampledPath, motions: Sequence[FittedMotion], wherever: bool) -> Iterator[list[FittedMotion]]:
    """Runs of short LIN and CIRC without a pause; every other motion alone."""
    lengths = [0.0 if motion.kind == "PTP" else motion.path(samples).length for motion in motions]
    long = np.inf if wherever else LONG * float(np.median([x for x in lengths if x > 0.0] or [0.0]))
    group: list[FittedMotion] = []
    for motion, length in zip(motions, lengths, strict=True):
        short = motion.kind != "PTP" and length <= long
        if group and (not short or motion.first in samples.pauses):
            yield group
            group = []
        if short:
            group.append(motion)
        else:
            yield [motion]
    if group:
        yield group


def _knots(
    samples: SampledPath, first: int, last: int, tolerance: tuple[float, float], most: int
) -> tuple[int, ...] | None:
    """The samples at which the points of a block stand; None where it would take more than `most`."""
    if last - first < 2:
        return None
    places = samples.T[first : last + 1, :3, 3]
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1)))
    knots = sorted({0, *halves(way, [0, last - first])})
    for _ in range(ROUNDS):
        if len(knots) - 1 > most:
            return None
        path = _curve(samples, [first + k for k in knots])
        if path is None:
            return None
        good = within(poses_at(path[0], _nearest(path, way, knots, places)), samples.T[first : last + 1], tolerance)
        bad = [(a, b) for a, b in pairwise(knots) if not good[a : b + 1].all() and b > a + 1]
        if not bad:
            return tuple(first + k for k in knots[1:]) if good.all() else None
        knots = sorted({*knots, *(k for a, b in bad for k in halves(way, [a, b]))})
    return None


def halves(way: Array, ends: list[int]) -> list[int]:
    """Both ends and the sample half the way between them."""
    a, b = ends
    middle = int(np.searchsorted(way, 0.5 * (way[a] + way[b])))
    return [a, min(max(middle, a + 1), b - 1), b]


def _curve(samples: SampledPath, knots: Sequence[int]) -> tuple[PosePath, Array] | None:
    """The path through samples and the lengths at which it passes them."""
    points = [SplinePoint("SPL", samples.T[k], _UNUSED) for k in knots[1:]]
    try:
        pieces = list(spline_pieces(samples.T[knots[0]], points))
    except ExecutionError:
        return None
    if len(pieces) != 1 or len(pieces[0].motions) != len(points):
        return None
    return pieces[0].path, np.append(0.0, pieces[0].ends)


def _nearest(path: tuple[PosePath, Array], way: Array, knots: Sequence[int], places: Array) -> Array:
    """The lengths (k,) at which the curve is nearest to the places (k, 3), by Newton's steps from their share."""
    curve, marks = path
    s = np.interp(way, way[list(knots)], marks)
    for _ in range(STEPS):
        at = curve.segment.at(s)
        step = np.sum((places - at.p) * at.dp, axis=1) / np.maximum(np.sum(at.dp * at.dp, axis=1), 1e-12)
        s = np.clip(s + step, 0.0, marks[-1])
    return np.asarray(s)
