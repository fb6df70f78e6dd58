"""Complementarity between bounds: what resists a joint takes any value between them; at a bound the joint gives way.

    lo <= f <= hi,   w = b - M f,   f < hi => w <= 0,   f > lo => w >= 0

With w the acceleration of joints at rest and f what resists them this is dry friction at zero speed, Gauss's principle
of least constraint; a position stop is the same with one bound infinite. M = J B^-1 J^T is positive definite, so there
is one solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array

SIGN = 1e-12
"""Share of the largest datum below which a sign counts as zero, as in `stops`."""

Sides = NDArray[np.int_]
"""One of +1 (moves on, positive), -1 (moves on, negative) and 0 (at rest) a joint, (n,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Resistance:
    """What resists (m,), and which joints give way: `sides` +1 with f = hi, -1 with f = lo, 0 where w = 0."""

    f: Array
    sides: Sides


def between_bounds(M: Array, b: Array, lo: Array, hi: Array, start: Sides | None = None) -> Resistance:
    """The solution of the problem above for a positive definite M (least-index pivoting, as Murty's).

    Parameters
    ----------
    M : (m, m) array
    b : (m,) array
        w with nothing that resists.
    lo, hi : (m,) arrays
        Bounds, lo <= hi; they may be infinite.
    start : (m,) array, optional
        Sides to begin from. On the border between rest and motion, where both are solutions, it decides.

    >>> between_bounds(np.eye(2), np.array([3.0, 0.5]), -np.ones(2), np.ones(2)).f
    array([1. , 0.5])
    """
    slack_w = SIGN * float(np.abs(b).max(initial=0.0))
    slack_f = slack_w / float(M.diagonal().max(initial=1e-300))
    sides = np.zeros(b.size, dtype=int) if start is None else start.copy()
    f = np.zeros(b.size)
    for _ in range(3 ** (b.size + 1)):
        bounded, still = sides != 0, sides == 0
        f[bounded] = np.where(sides > 0, hi, lo)[bounded]
        f[still] = np.linalg.solve(M[np.ix_(still, still)], b[still] - M[np.ix_(still, bounded)] @ f[bounded])
        above, below = still & (f > hi + slack_f), still & (f < lo - slack_f)
        wrong = above | below | (bounded & (sides * (b - M @ f) < -slack_w))
        if not wrong.any():
            break
        first = int(np.argmax(wrong))
        sides[first] = int(above[first]) - int(below[first])
    return Resistance(np.clip(f, lo, hi), sides)
