"""The largest joint-limit margin that one continuous arm angle can keep along a whole path, over all eight branches.

The margin any arm angle can keep at a pose bounds what the path can keep; a corridor at that level proves that it can.
Branches are tried in the order of their bounds, and one whose bound is below what another has reached is left.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.branches import BRANCHES, Branch
from lwr_dyn.kinematics.corridor import Break, Corridor, corridor
from lwr_dyn.kinematics.srs import JointRanges, arm_triangle
from lwr_dyn.kinematics.srs_best import best_angles
from lwr_dyn.kinematics.srs_geometry import SrsGeometry
from lwr_dyn.kinematics.srs_limits import MarginProblem, arcs_at_level, margin_problem, margins

SLACK = 1e-5
"""[rad] How far below the best margin the corridor is taken: it gives the curve room to be smooth (0.0006 deg)."""
RESOLUTION = 1e-6
"""[rad] To which a level is found where the corridor, not a single pose, decides."""
NOTHING_KEPT = -np.pi
"""[rad] A level that every joint keeps: it turns freely."""
FIRST_LOOK = 65
"""Poses looked at in every branch before the best one is looked at whole."""


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """The best of one branch: `bound` [rad] is what no continuous arm angle exceeds, by pose `index` and `joint`."""

    branch: Branch
    bound: float
    index: int
    joint: int
    passage: Corridor | None
    continuous: bool = True
    """False where every pose alone would allow more, but no arm angle leads through without a jump."""


def largest_margin(geometry: SrsGeometry, ranges: JointRanges, T: Array) -> Found:
    """The best branch and its corridor for poses T (k, 4, 4) within reach; below zero, where the path must leave."""
    look = np.unique(np.linspace(0, len(T) - 1, min(len(T), FIRST_LOOK)).round().astype(int))
    some = T[look]
    signs = np.repeat(np.array(BRANCHES), len(look), axis=0)
    first = best_angles(_problem(geometry, ranges, np.tile(some, (len(BRANCHES), 1, 1)), signs))
    margin, joint = (x.reshape(len(BRANCHES), len(look)) for x in (first.margin, first.joint))
    starts = []
    for branch, row, joints in zip(BRANCHES, margin, joint, strict=True):
        worst = int(np.argmin(row))
        starts.append(Found(branch, float(row[worst]), int(look[worst]), int(joints[worst]), None))
    starts.sort(key=lambda start: -start.bound)
    inside = _best_above(geometry, ranges, T, starts, 0.0)
    return inside or _best_above(geometry, ranges, T, starts, NOTHING_KEPT) or starts[0]


def _best_above(
    geometry: SrsGeometry, ranges: JointRanges, T: Array, starts: list[Found], floor: float
) -> Found | None:
    """The best of the branches that keep at least `floor`, by bounds in falling order."""
    best: Found | None = None
    for start in starts:
        if start.bound < floor or (best is not None and start.bound <= best.bound):
            break
        problem = _problem(geometry, ranges, T, np.broadcast_to(start.branch, (len(T), 3)))
        found = _best_of_branch(problem, start, floor)
        if found is not None:
            best, floor = found, found.bound
    return best


def _problem(geometry: SrsGeometry, ranges: JointRanges, T: Array, signs: Array) -> MarginProblem:
    return margin_problem(geometry, ranges, T, arm_triangle(geometry, T), signs)


def _best_of_branch(problem: MarginProblem, start: Found, floor: float) -> Found | None:
    """The best of one branch, or None when it does not keep `floor`."""
    found, arcs = start, arcs_at_level(problem, _level(problem, _below(start.bound)))
    while arcs.empty.any():
        empty = np.flatnonzero(arcs.empty)
        tight = best_angles(problem.rows(empty))
        i = int(np.argmin(tight.margin))
        found = replace(found, bound=float(tight.margin[i]), index=int(empty[i]), joint=int(tight.joint[i]))
        if found.bound < floor:
            return None
        arcs = arcs_at_level(problem, _level(problem, _below(found.bound)))
    passage = corridor(arcs)
    if isinstance(passage, Corridor):
        return replace(found, passage=passage)
    return _highest_passage(problem, found, passage, floor)


def _highest_passage(problem: MarginProblem, start: Found, blocked: Break, floor: float) -> Found | None:
    """Bisection on the level: every pose has an interval, but they do not connect."""
    passage = corridor(arcs_at_level(problem, _level(problem, floor)))
    if isinstance(passage, Break):
        return None
    low, high = floor, _below(start.bound)
    while high - low > RESOLUTION:
        level = (low + high) / 2.0
        outcome = corridor(arcs_at_level(problem, _level(problem, level)))
        if isinstance(outcome, Corridor):
            low, passage = level, outcome
        else:
            high, blocked = level, outcome
    row = problem.rows(np.array([blocked.index]))
    edge = np.nan_to_num(arcs_at_level(row, np.array([high])).end[:1, :1])
    joint = int(np.argmin(margins(row, edge)[0, 0]))
    return Found(start.branch, high, blocked.index, joint, passage, continuous=False)


def _below(bound: float) -> float:
    """The level of the corridor under a bound: on the limits rather than outside them."""
    return max(bound - SLACK, 0.0) if bound >= 0.0 else bound - SLACK


def _level(problem: MarginProblem, value: float) -> Array:
    return np.full(len(problem.elbow_margin), value)
