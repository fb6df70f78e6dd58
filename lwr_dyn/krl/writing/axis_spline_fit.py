"""PTP_SPLINE blocks from pause to pause: SPTP through as few samples as keep the tool's path within the tolerance.

The curve of the axes is the one that `krl run` plans (cubic, through its points); KUKA's own is not published.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.krl.writing.path_fit import FittedMotion, within
from lwr_dyn.krl.writing.sampled_path import SampledPath
from lwr_dyn.krl.writing.spline_fit import MOST, ROUNDS, STEPS, halves


def axis_splines(samples: SampledPath, tolerance: tuple[float, float]) -> tuple[FittedMotion, ...]:
    """A block for each way between two pauses; raises `OptionError` where one would have too many points."""
    marks = sorted({0, *samples.pauses, len(samples.q) - 1})
    found = []
    for first, last in pairwise(marks):
        knots = _knots(samples, first, last, tolerance)
        if knots is None:
            raise OptionError(samples.source, "a path too rough for SPTP", "a smooth path, or a larger tolerance")
        found.append(FittedMotion("SPTP", first, last, None, knots))
    return tuple(found)


def _knots(samples: SampledPath, first: int, last: int, tolerance: tuple[float, float]) -> tuple[int, ...] | None:
    q, wanted = samples.q[first : last + 1], samples.T[first : last + 1]
    way = _along(samples, q)
    knots = sorted({0, last - first, *(halves(way, [0, last - first]) if last - first > 1 else ())})
    for _ in range(ROUNDS):
        if len(knots) > MOST:
            return None
        T = flange_pose(samples.arm.chain, _nearest(samples, q, way, knots)) @ samples.tool
        good = within(T, wanted, tolerance)
        bad = [(a, b) for a, b in pairwise(knots) if not good[a : b + 1].all() and b > a + 1]
        if not bad:
            return tuple(first + k for k in knots[1:]) if good.all() else None
        knots = sorted({*knots, *(k for a, b in bad for k in halves(way, [a, b]))})
    return None


def _along(samples: SampledPath, q: Array) -> Array:
    """The time (k,) [s] that the axes need to each sample at their rated speeds, as the parameter of a block has it."""
    return np.append(0.0, np.cumsum((np.abs(np.diff(q, axis=0)) / samples.arm.velocity).max(axis=1)))


def _nearest(samples: SampledPath, q: Array, way: Array, knots: Sequence[int]) -> Array:
    """The places (k, n) of the block's curve that are nearest to axes q (k, n)."""
    points = q[list(knots)]
    marks = _along(samples, points)
    curve = CubicSpline(marks, points, bc_type="natural")
    s = np.interp(way, way[list(knots)], marks)
    for _ in range(STEPS):
        slope = np.asarray(curve(s, 1))
        step = np.sum((q - curve(s)) * slope, axis=1) / np.maximum(np.sum(slope * slope, axis=1), 1e-12)
        s = np.clip(s + step, 0.0, marks[-1])
    return np.asarray(curve(s))
