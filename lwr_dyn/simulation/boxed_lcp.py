"""Boxed linear complementarity problem: the resisting force lies between bounds; at a bound the joint moves.

    low <= f <= high,   w = b - M f,   f < high => w <= 0,   f > low => w >= 0

With w the accelerations of joints at rest and f what resists them, this is dry friction at zero speed (Gauss's
principle of least constraint). A position stop has one infinite bound; an impact is the same problem with speeds as w.
M = J B^-1 J^T is positive definite, so there is one solution.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array

SIGN = 1e-12
"""Share of the largest datum below which a sign counts as zero: two zeros must not switch each other for ever."""

Sides = NDArray[np.int_]
"""One of +1 (moves on, positive), -1 (moves on, negative) and 0 (at rest) a joint, (n,)."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxedLcpSolution:
    """The resisting force (m,) and which joints move: `sides` +1 with f = high, -1 with f = low, 0 where w = 0."""

    force: Array
    sides: Sides


def boxed_lcp(M: Array, b: Array, low: Array, high: Array, start: Sides | None = None) -> BoxedLcpSolution:
    """The solution of the problem above for a positive definite M, by least-index pivoting (Murty).

    Parameters
    ----------
    M : (m, m) array
    b : (m,) array
        w without any resistance.
    low, high : (m,) arrays
        Bounds, low <= high; they may be infinite.
    start : (m,) array, optional
        Sides to begin from. On the border between rest and motion, where both are solutions, it decides.

    References
    ----------
    Cottle, Pang, Stone, *The Linear Complementarity Problem*, section 4.4.

    >>> boxed_lcp(np.eye(2), np.array([3.0, 0.5]), -np.ones(2), np.ones(2)).force
    array([1. , 0.5])
    """
    slack_w = SIGN * float(np.abs(b).max(initial=0.0))
    slack_f = slack_w / float(M.diagonal().max(initial=1e-300))
    sides = np.zeros(b.size, dtype=int) if start is None else start.copy()
    f = np.zeros(b.size)
    for _ in range(3 ** (b.size + 1)):
        moving, still = sides != 0, sides == 0
        f[moving] = np.where(sides > 0, high, low)[moving]
        f[still] = np.linalg.solve(M[np.ix_(still, still)], b[still] - M[np.ix_(still, moving)] @ f[moving])
        above, below = still & (f > high + slack_f), still & (f < low - slack_f)
        wrong = above | below | (moving & (sides * (b - M @ f) < -slack_w))
        if not wrong.any():
            break
        first = int(np.argmax(wrong))
        sides[first] = int(above[first]) - int(below[first])
    return BoxedLcpSolution(np.clip(f, low, high), sides)
