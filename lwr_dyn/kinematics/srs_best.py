"""The arm angle at which the smallest joint-limit margin of an S-R-S arm is largest, certified over the whole circle.

Climb, then certify: the best place on a grid is refined until it moves no more, and the closed-form intervals of
`srs_limits` at a level just above tell whether any other arm angle is better; if so, climb from there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.srs import wrap
from lwr_dyn.kinematics.srs_limits import MarginProblem, arcs_at_level, margins

CERTAIN = 1e-9
"""[rad] No arm angle keeps a margin larger than the one returned by more than this."""
TIE = 1e-11
"""Weight of the sum of margins beside the smallest: decides between equals only."""
_GRID = np.linspace(-np.pi, np.pi, 48, endpoint=False)
_ZOOM = np.linspace(-1.0, 1.0, 13)
_ZOOMS = 13
_ROUNDS = 20


@dataclass(frozen=True, slots=True, eq=False)
class BestAngles:
    """For r rows: psi (r,) [rad], its smallest margin (r,) [rad], and the joint that has it (r,), 0-based."""

    psi: Array
    margin: Array
    joint: NDArray[np.intp]


def best_angles(problem: MarginProblem) -> BestAngles:
    """The best arm angle of every row, globally, to `CERTAIN`."""
    rows = len(problem.elbow_margin)
    grid = np.broadcast_to(_GRID, (rows, len(_GRID)))
    start = np.argmax(_moving_margin(problem, grid), axis=1)
    psi = _climb(problem, _GRID[start], np.full(rows, _GRID[1] - _GRID[0]))
    open_rows = np.arange(rows)
    for _ in range(_ROUNDS):
        part = problem.rows(open_rows)
        level = margins(part, psi[open_rows, None])[:, 0].min(axis=1) + CERTAIN
        arcs = arcs_at_level(part, level)
        better = ~arcs.empty
        if not better.any():
            break
        open_rows = open_rows[better]
        start_, end = arcs.start[better], arcs.end[better]
        widest = np.nanargmax(end - start_, axis=1)[:, None]
        low, high = (np.take_along_axis(side, widest, axis=1)[:, 0] for side in (start_, end))
        psi[open_rows] = _climb(problem.rows(open_rows), (low + high) / 2.0, (high - low) / 2.0)
    psi = wrap(psi)
    final = margins(problem, psi[:, None])[:, 0]
    return BestAngles(psi, final.min(axis=1), final.argmin(axis=1))


def _moving_margin(problem: MarginProblem, psi: Array) -> Array:
    """Smallest margin (r, m) of the joints that move with psi: the elbow's is the same everywhere.

    Where another joint stands still as well (arm or wrist aligned) the sum of the others decides.
    """
    moving = np.delete(margins(problem, psi), 3, axis=2)
    smallest: Array = moving.min(axis=2) + TIE * moving.sum(axis=2)
    return smallest


def _climb(problem: MarginProblem, psi: Array, width: Array) -> Array:
    for _ in range(_ZOOMS):
        near = psi[:, None] + width[:, None] * _ZOOM
        psi = np.take_along_axis(near, np.argmax(_moving_margin(problem, near), axis=1)[:, None], axis=1)[:, 0]
        width = width * (2.0 / (len(_ZOOM) - 1) * 1.2)
    return psi
