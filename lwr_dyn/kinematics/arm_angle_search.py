"""The largest joint-limit margin that one continuous arm angle can keep along a whole path, over all eight branches.

The largest margin at any one pose bounds what the path can keep. A corridor at that level proves that it can: one
interval of arm angles per pose, each overlapping the next. The intervals at a level are exact, so a level at which no
chain of overlapping intervals leads from the first pose to the last cannot be kept. Branches are tried in the order of
their bounds, until a bound is below what another branch has reached.
"""

from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.arm_geometry import SrsGeometry
from lwr_dyn.kinematics.branches import BRANCHES, TURN, Branch, JointRanges
from lwr_dyn.kinematics.srs_margins import AngleIntervals, MarginProblem, intervals_at_level, margin_problem, margins
from lwr_dyn.kinematics.srs_solver import best_angles

SLACK = 1e-5
"""[rad] How far below the best margin the corridor is taken, so that the curve can be smooth (0.0006 deg)."""
RESOLUTION = 1e-6
"""[rad] Of a level where the corridor, not a single pose, decides."""
NO_MARGIN = -np.pi
"""[rad] A level that every joint keeps at every position."""
FIRST_LOOK = 65
"""Poses at which every branch is tried before the best branches are computed at all poses."""


@dataclass(frozen=True, slots=True, eq=False)
class Corridor:
    """Bounds low <= psi <= high (k,) [rad], unwrapped: neighbours overlap without turns between them."""

    low: Array
    high: Array


@dataclass(frozen=True, slots=True)
class CorridorBreak:
    """No chain leads past pose `index`: its intervals are empty, or none overlaps one reached so far."""

    index: int


@dataclass(frozen=True, slots=True, eq=False)
class BranchOptimum:
    """The best of one branch."""

    branch: Branch
    margin_bound: float
    """[rad] No continuous arm angle keeps more."""
    index: int
    """The pose that decides it, 0-based."""
    joint: int
    """The joint that decides it, 0-based."""
    passage: Corridor | None
    continuous: bool = True
    """False where every pose alone would allow more, but no arm angle leads through without a jump."""


def largest_margin(geometry: SrsGeometry, ranges: JointRanges, T: Array) -> BranchOptimum:
    """The best branch and its corridor for poses T (k, 4, 4) within reach; a bound below 0 is outside limits."""
    rows = np.unique(np.linspace(0, len(T) - 1, min(len(T), FIRST_LOOK)).round().astype(int))
    signs = np.repeat(np.array(BRANCHES), len(rows), axis=0)
    first = best_angles(margin_problem(geometry, ranges, np.tile(T[rows], (len(BRANCHES), 1, 1)), signs))
    margin, joint = (x.reshape(len(BRANCHES), len(rows)) for x in (first.margin, first.joint))
    starts = []
    for branch, at_poses, joints in zip(BRANCHES, margin, joint, strict=True):
        worst = int(np.argmin(at_poses))
        starts.append(BranchOptimum(branch, float(at_poses[worst]), int(rows[worst]), int(joints[worst]), None))
    starts.sort(key=lambda start: -start.margin_bound)
    inside = _best_above(geometry, ranges, T, starts, 0.0)
    return inside or _best_above(geometry, ranges, T, starts, NO_MARGIN) or starts[0]


def _best_above(
    geometry: SrsGeometry, ranges: JointRanges, T: Array, starts: list[BranchOptimum], floor: float
) -> BranchOptimum | None:
    """The best of the branches that keep at least `floor`, by bounds in falling order."""
    best: BranchOptimum | None = None
    for start in starts:
        if start.margin_bound < floor or (best is not None and start.margin_bound <= best.margin_bound):
            break
        optimum = _best_of_branch(margin_problem(geometry, ranges, T, start.branch), start, floor)
        if optimum is not None:
            best, floor = optimum, optimum.margin_bound
    return best


def _best_of_branch(problem: MarginProblem, start: BranchOptimum, floor: float) -> BranchOptimum | None:
    """The best of one branch, or None when it does not keep `floor`."""
    optimum, intervals = start, intervals_at_level(problem, _corridor_level(start.margin_bound))
    while intervals.empty.any():
        empty = np.flatnonzero(intervals.empty)
        tight = best_angles(problem.rows(empty))
        i = int(np.argmin(tight.margin))
        bound = float(tight.margin[i])
        optimum = replace(optimum, margin_bound=bound, index=int(empty[i]), joint=int(tight.joint[i]))
        if bound < floor:
            return None
        intervals = intervals_at_level(problem, _corridor_level(bound))
    passage = connected_arm_angles(intervals)
    if isinstance(passage, Corridor):
        return replace(optimum, passage=passage)
    return _highest_passage(problem, optimum, passage, floor)


def _highest_passage(
    problem: MarginProblem, start: BranchOptimum, blocked: CorridorBreak, floor: float
) -> BranchOptimum | None:
    """Bisection on the level: every pose has an interval, but they do not connect."""
    passage = connected_arm_angles(intervals_at_level(problem, floor))
    if isinstance(passage, CorridorBreak):
        return None
    low, high = floor, _corridor_level(start.margin_bound)
    while high - low > RESOLUTION:
        level = (low + high) / 2.0
        attempt = connected_arm_angles(intervals_at_level(problem, level))
        if isinstance(attempt, Corridor):
            low, passage = level, attempt
        else:
            high, blocked = level, attempt
    row = problem.rows(np.array([blocked.index]))
    edge = np.nan_to_num(intervals_at_level(row, high).end[:1, :1])
    joint = int(np.argmin(margins(row, edge)[0, 0]))
    return BranchOptimum(start.branch, high, blocked.index, joint, passage, continuous=False)


def _corridor_level(bound: float) -> float:
    """The level of the corridor below a bound: at the limits rather than outside them."""
    return max(bound - SLACK, 0.0) if bound >= 0.0 else bound - SLACK


def connected_arm_angles(intervals: AngleIntervals) -> Corridor | CorridorBreak:
    """The chain of intervals whose narrowest overlap is widest, or where every chain ends."""
    rows = [intervals.of(k) for k in range(len(intervals.start))]
    if not rows[0]:
        return CorridorBreak(0)
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
            return CorridorBreak(k)
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
            # a whole circle has no edge: it is cut opposite to the corridor
            middle = (bounds[-1][0] + bounds[-1][1]) / 2.0
            bounds.append((middle - np.pi, middle + np.pi))
            continue
        turn = overlap(bounds[-1], (start, end))[1]
        bounds.append((start + turn, end + turn))
    both = np.array(bounds)
    return Corridor(both[:, 0], both[:, 1])
