"""The fastest speeds along a path of which everything is known: two passes over a grid.

With s the parameter of the path, x = ds^2 and u = dds constant between two nodes, x grows by 2 h u over a step h. All
bounds have the form |first u + second x| <= most and hold at both ends of a step. Backwards: the largest x from which
the end can be reached; forwards: the largest u that stays below it (Pham and Pham, TOPP-RA, IEEE T-RO 34, 2018).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.trajectory.motion_profile import DEGREE, MotionProfile

FINE = np.array([1.0, 4.0, 16.0]) / 64.0
"""Shares of a step."""
HUGE = 1e30
"""Stands for no bound."""


@dataclass(frozen=True, slots=True, eq=False)
class PathLimits:
    """Bounds at k nodes s (k,) of a path: x <= `fastest` (k,), and |first u + second x| <= most, each (k, m)."""

    s: Array
    fastest: Array
    first: Array
    second: Array
    most: Array


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """The bounds of the steps between nodes: |u + ratio x| <= bound, (k - 1, 2 m), at the two ends of each step."""

    h: Array
    ratio: Array
    bound: Array
    cap: Array
    """(k,) Largest x that leaves a u."""


def fastest_speeds(limits: PathLimits, ends: Sequence[int] = (), ahead: Sequence[int] = ()) -> Array:
    """x = ds^2 at the nodes (k,), from rest to rest.

    With `ends`, the nodes at which motions end, and `ahead`, how many motions further each of them knows, it is
    everywhere possible to stop at the end of what is known.
    """
    steps = _steps(limits)
    cap = steps.cap.copy()
    first = 0
    for i, n in enumerate(ahead):
        known = ends[min(i + n, len(ends) - 1)]
        if known < ends[-1]:
            stop = cap.copy()
            stop[known] = 0.0
            _backwards(steps, stop, first, known)
            np.minimum(cap[first + 1 : ends[i] + 1], stop[first + 1 : ends[i] + 1], out=cap[first + 1 : ends[i] + 1])
        first = ends[i]
    cap[0] = cap[-1] = 0.0
    _backwards(steps, cap, 0, len(cap) - 1)
    return _forwards(steps, cap)


def _steps(limits: PathLimits) -> _Steps:
    h = np.diff(limits.s)
    # at its end a step has x + 2 h u
    first = np.hstack([limits.first[:-1], limits.first[1:] + 2.0 * h[:, None] * limits.second[1:]])
    second = np.hstack([limits.second[:-1], limits.second[1:]])
    most = np.hstack([limits.most[:-1], limits.most[1:]])
    size = np.maximum(np.abs(first), 1e-12)
    ratio, bound = np.where(first < 0.0, -second, second) / size, most / size
    cap = limits.fastest.copy()
    with np.errstate(divide="ignore", invalid="ignore"):
        for j in range(ratio.shape[1]):
            # some u meets bounds i and j together
            apart = np.abs(ratio - ratio[:, j : j + 1])
            x = np.where(apart > 0.0, (bound + bound[:, j : j + 1]) / apart, HUGE).min(axis=1)
            cap[:-1] = np.minimum(cap[:-1], x)
        # and the next x is not negative
        slope = ratio - 0.5 / h[:, None]
        cap[:-1] = np.minimum(cap[:-1], np.where(slope > 0.0, bound / slope, HUGE).min(axis=1))
    return _Steps(h, ratio, bound, np.minimum(cap, HUGE))


def _backwards(steps: _Steps, cap: Array, begin: int, end: int) -> None:
    """Lower `cap` (k,) so that the x of node `end` can be reached from each node from `begin` on."""
    h = 2.0 * steps.h[begin:end, None]
    denominator = 1.0 - h * steps.ratio[begin:end]
    free = denominator <= 0.0
    gain = np.where(free, 0.0, 1.0 / np.where(free, 1.0, denominator))
    rest = np.where(free, HUGE, h * steps.bound[begin:end] * gain)
    x = float(cap[end])
    for k in range(end - 1, begin - 1, -1):
        x = min(float(cap[k]), float((x * gain[k - begin] + rest[k - begin]).min()))
        cap[k] = x


def _forwards(steps: _Steps, cap: Array) -> Array:
    out = np.zeros(len(cap))
    x = 0.0
    for k in range(len(steps.h)):
        u = float((steps.bound[k] - steps.ratio[k] * x).min())
        x = out[k + 1] = max(0.0, min(float(cap[k + 1]), x + 2.0 * float(steps.h[k]) * u))
    return out


def with_fine_ends(s: Array, begin: bool = True, end: bool = True) -> Array:
    """Nodes (k,) with a few more beside the first and the last one, where a ramp from rest may be short.

    >>> with_fine_ends(np.array([0.0, 1.0]), end=False)
    array([0.      , 0.015625, 0.0625  , 0.25    , 1.      ])
    """
    first = s[0] + FINE * (s[1] - s[0]) if begin else s[:0]
    last = s[-1] - FINE[::-1] * (s[-1] - s[-2]) if end else s[:0]
    return np.unique(np.concatenate([s, first, last]))


def times_along(s: Array, x: Array) -> Array:
    """The time (k,) [s] at each node."""
    v = np.sqrt(x)
    return np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / np.maximum(v[1:] + v[:-1], 1e-15))])


def profile_along(name: str, s: Array, x: Array) -> MotionProfile:
    """The motion profile with x = ds^2 at the nodes s, of constant dds from node to node."""
    u = np.diff(x) / (2.0 * np.diff(s))
    rows = np.zeros((len(u), DEGREE + 1))
    rows[:, 0], rows[:, 1], rows[:, 2] = s[:-1] - s[0], np.sqrt(x[:-1]), 0.5 * u
    return MotionProfile(name, float(s[-1] - s[0]), times_along(s, x), rows)


def seconds_at(profile: MotionProfile, s: Array) -> Array:
    """The time (k,) [s] at which a profile of constant dds from knot to knot reaches s (k,)."""
    c = profile.coefficients
    piece = np.clip(np.searchsorted(c[:, 0], s, side="right") - 1, 0, len(c) - 1)
    way, v, u = s - c[piece, 0], c[piece, 1], 2.0 * c[piece, 2]
    later = np.sqrt(np.maximum(v**2 + 2.0 * u * way, 0.0))
    return np.asarray(profile.knots[piece] + 2.0 * way / np.maximum(v + later, 1e-15))
