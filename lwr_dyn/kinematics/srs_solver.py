"""One pose of an S-R-S arm: on each branch the arm angle whose smallest joint-limit margin is largest, proven so.

The best angle of a grid is refined until it moves no more. The intervals of `srs_margins` at a level just above it show
whether any other arm angle on the circle is better; if one is, it is refined instead.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.arm_geometry import SRS_ARM, SrsGeometry, srs_geometry
from lwr_dyn.kinematics.branches import BRANCHES, joint_ranges, wrap
from lwr_dyn.kinematics.solution import IkSolver, InverseResult, PoseProblem, turned_result
from lwr_dyn.kinematics.srs import arm_triangle, closed_form
from lwr_dyn.kinematics.srs_margins import MarginProblem, intervals_at_level, margin_problem, margins

NO_LIMIT = -2.0 * np.pi
"""[rad] A margin that every joint keeps at every position."""
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
    """The best arm angle of every row, over the whole circle, to `CERTAIN`."""
    rows = len(problem.elbow_margin)
    grid = np.broadcast_to(_GRID, (rows, len(_GRID)))
    start = np.argmax(_moving_margin(problem, grid), axis=1)
    psi = _climb(problem, _GRID[start], np.full(rows, _GRID[1] - _GRID[0]))
    open_rows = np.arange(rows)
    for _ in range(_ROUNDS):
        part = problem.rows(open_rows)
        level = margins(part, psi[open_rows, None])[:, 0].min(axis=1) + CERTAIN
        intervals = intervals_at_level(part, level)
        better = ~intervals.empty
        if not better.any():
            break
        open_rows = open_rows[better]
        begin, end = intervals.start[better], intervals.end[better]
        widest = np.nanargmax(end - begin, axis=1)[:, None]
        low, high = (np.take_along_axis(side, widest, axis=1)[:, 0] for side in (begin, end))
        psi[open_rows] = _climb(problem.rows(open_rows), (low + high) / 2.0, (high - low) / 2.0)
    psi = wrap(psi)
    final = margins(problem, psi[:, None])[:, 0]
    return BestAngles(psi, final.min(axis=1), final.argmin(axis=1))


def _moving_margin(problem: MarginProblem, psi: Array) -> Array:
    """Smallest margin (r, m) of the joints that move with psi: the elbow's is the same at every psi.

    Where another joint has the same margin at every psi too (arm or wrist aligned) the sum of the others decides.
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


def solve_pose(problem: PoseProblem, geometry: SrsGeometry) -> InverseResult:
    """The branches of one flange pose with their `whole_turns`, at `problem.arm_angle` or each at its best.

    Raises `OptionError`.
    """
    psi, arm = problem.arm_angle, problem.arm
    if psi is not None and not math.isfinite(psi):
        raise OptionError("arm_angle", psi, "a finite number of radians")
    geometry, ranges = geometry.with_reference(problem.reference), joint_ranges(arm)
    T, signs = np.broadcast_to(problem.pose, (len(BRANCHES), 4, 4)), np.array(BRANCHES)
    excess = float(arm_triangle(geometry, T[:1]).reach_excess[0])
    if excess > 0.0:
        return InverseResult("out of reach", (), (), True, distance=excess)
    margin = margin_problem(geometry, ranges, T, signs)
    intervals = intervals_at_level(margin, 0.0 if problem.limits else NO_LIMIT)
    angles = best_angles(margin).psi if psi is None else np.full(len(BRANCHES), float(psi))
    q = closed_form(geometry, ranges, T, angles, signs)
    labels = [branch.label for branch in BRANCHES]
    result, psi_of = turned_result(problem, q, True, labels), dict(zip(labels, angles.tolist(), strict=True))
    solutions, outside = (
        tuple(replace(s, arm_angle=psi_of[s.branch]) for s in each) for each in (result.solutions, result.outside)
    )
    intervals_of = {label: intervals.of(b) for b, label in enumerate(labels)}
    return replace(result, solutions=solutions, outside=outside, arm_angle_intervals=intervals_of)


SOLVER = IkSolver(srs_geometry, solve_pose, SRS_ARM, has_arm_angle=True)
"""The row "srs" of the solvers."""
