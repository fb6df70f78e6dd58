"""A corridor of arm angles along a path: one interval per pose, each overlapping the next, all keeping a margin.

The intervals at a margin level are exact (`srs_limits`), so a level at which a chain of overlapping intervals leads
from the first pose to the last is a margin the whole path can keep, and one at which none does is a margin it cannot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.srs_limits import Arcs

TURN = 2.0 * np.pi


@dataclass(frozen=True, slots=True, eq=False)
class Corridor:
    """Bounds low <= psi <= high (k,) [rad], unwrapped: neighbours overlap without turns between them."""

    low: Array
    high: Array


@dataclass(frozen=True, slots=True)
class Break:
    """No chain leads past pose `index`: its intervals are empty, or none overlaps one reached so far."""

    index: int


def corridor(arcs: Arcs) -> Corridor | Break:
    """The chain of intervals whose narrowest overlap is widest, or where every chain ends."""
    rows = [arcs.of(k) for k in range(len(arcs.start))]
    if not rows[0]:
        return Break(0)
    reached: list[list[float]] = [[b - a for a, b in rows[0]]]
    came_from: list[list[int]] = [[-1] * len(rows[0])]
    for k in range(1, len(rows)):
        widths, sources = [], []
        for interval in rows[k]:
            options = [
                min(width, overlap(before, interval)[0]) for before, width in zip(rows[k - 1], reached[-1], strict=True)
            ]
            best = max(range(len(options)), key=options.__getitem__, default=-1)
            widths.append(options[best] if options else -np.inf)
            sources.append(best)
        if max(widths, default=-np.inf) < 0.0:
            return Break(k)
        reached.append(widths)
        came_from.append(sources)
    return _unwrapped(rows, _chain(reached[-1], came_from))


def overlap(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """Width of the widest overlap of two intervals on the circle (negative: the gap), and the turn of b that gives it.

    >>> overlap((3.0, 3.3), (-3.2, -3.0))[0].__round__(3)
    0.2
    """
    near = round((a[0] + a[1] - b[0] - b[1]) / 2.0 / TURN)
    if max(a[1] - a[0], b[1] - b[0]) >= TURN:
        return min(a[1] - a[0], b[1] - b[0]), near * TURN
    turns = ((near + i) * TURN for i in (-1, 0, 1))
    return max((min(a[1], b[1] + t) - max(a[0], b[0] + t), t) for t in turns)


def _chain(last: list[float], came_from: list[list[int]]) -> list[int]:
    at = max(range(len(last)), key=last.__getitem__)
    chain = [at]
    for sources in reversed(came_from[1:]):
        at = sources[at]
        chain.append(at)
    return chain[::-1]


def _unwrapped(rows: list[tuple[tuple[float, float], ...]], chain: list[int]) -> Corridor:
    low, high = rows[0][chain[0]]
    bounds = [(low, high)]
    for row, at in zip(rows[1:], chain[1:], strict=True):
        start, end = row[at]
        if end - start >= TURN:
            # a whole circle has no edge: it is opened opposite to where the corridor stands
            middle = (bounds[-1][0] + bounds[-1][1]) / 2.0
            bounds.append((middle - np.pi, middle + np.pi))
            continue
        turn = overlap(bounds[-1], (start, end))[1]
        bounds.append((start + turn, end + turn))
    found = np.array(bounds)
    return Corridor(found[:, 0], found[:, 1])
