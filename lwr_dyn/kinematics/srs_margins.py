"""Joint-limit margins of an S-R-S arm over the arm angle, and the arm angles at which a margin is kept, in closed form.

The margin of a joint is half its range less its distance from the middle: its distance from the nearer limit, negative
outside. Along psi each roll is atan2 of two forms a cos(psi) + b sin(psi) + c and each tilt the arc cosine of one, so
a roll reaches a given angle L where y cos L - x sin L = 0 and a tilt where z - cos L = 0: at most two psi each, by one
arc cosine. Between neighbouring such psi no joint crosses its bound; one sample per piece decides it.

One pose of an S-R-S arm: on each branch the arm angle whose smallest joint-limit margin is largest, proven so.

The best angle of a grid is refined until it moves no more. The intervals of `srs_margins` at a level just above it show
whether any other arm angle on the circle is better; if one is, it is refined instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics import solution
from lwr_dyn.kinematics.arm_geometry import SrsGeometry
from lwr_dyn.kinematics.solution import ALIGNED, BRANCHES, TURN, JointRanges, joint_ranges, wrap
from lwr_dyn.kinematics.solution_rows import TOUCH
from lwr_dyn.kinematics.srs import arm_triangle, ball_forms, closed_form, elbow_angle

SQUARE_TOUCH = 1e-14
"""A cosine this near to +-1 at its extreme reaches it: there the ball aligns and its rolls jump by half a turn."""

UNLIMITED = 1e9
"""[rad] Half width of a range that is not known, as a number small enough for sines."""

_X, _Y, _X2, _Y2, _Z, _YA, _XA = range(7)

_ENTRIES = ((0, 2), (1, 2), (2, 0), (2, 1), (2, 2), (0, 1), (1, 1))
"""Entries of a ball's matrix behind roll, second roll, tilt, and the sum of the rolls when aligned."""


@dataclass(frozen=True, slots=True, eq=False)
class MarginProblem:
    """r rows, each one pose and one branch: the forms and ranges from which its margins over psi follow."""

    forms: Array
    """(r, 2, 8, 3): shoulder and wrist, coefficients of cos psi, sin psi, 1; the eighth is the constant tilt's sign."""
    middle: Array
    """(2, 3) middles of roll, tilt (with its offset), roll."""
    half: Array
    """(2, 3) half widths of their ranges."""
    elbow_margin: Array
    """(r,) the elbow's margin, the same at every psi."""

    def rows(self, index: NDArray[np.intp]) -> MarginProblem:
        """Some of the rows."""
        return MarginProblem(self.forms[index], self.middle, self.half, self.elbow_margin[index])


def margin_problem(geometry: SrsGeometry, ranges: JointRanges, T: Array, branch: ArrayLike) -> MarginProblem:
    """The problem of poses T (r, 4, 4) on branches (r, 3) or one for all."""
    signs = np.broadcast_to(np.asarray(branch, dtype=np.float64), (len(T), 3))
    triangle = arm_triangle(geometry, T)
    rows, columns = np.array(_ENTRIES).T
    forms = np.swapaxes(ball_forms(geometry, T, triangle, signs[:, 1])[:, :, :, rows, columns], 2, 3)
    turn = signs[:, [0, 2], None]
    forms[:, :, _X] *= turn
    forms[:, :, _Y] *= turn
    forms[:, :, _X2] *= -turn
    forms[:, :, _Y2] *= turn
    forms[:, :, _YA] *= -1.0
    middle = np.stack([ranges.middle[0:3], ranges.middle[4:7]])
    middle[:, 1] += geometry.first.offset, geometry.last.offset
    half = np.minimum(np.stack([ranges.half[0:3], ranges.half[4:7]]), UNLIMITED)
    q4 = elbow_angle(geometry, triangle, signs[:, 1])
    elbow = np.minimum(ranges.half[3], UNLIMITED) - np.abs(wrap(q4 - ranges.middle[3]))
    tilt_sign = np.zeros((*forms.shape[:2], 1, 3))
    tilt_sign[:, :, 0, 2] = signs[:, [0, 2]]
    return MarginProblem(np.concatenate([forms, tilt_sign], axis=2), middle, half, elbow)


def margins(problem: MarginProblem, psi: Array) -> Array:
    """Margins (r, m, 7) [rad] of all joints at psi (r, m); aligned rolls share their sum evenly."""
    weights = np.stack([np.cos(psi), np.sin(psi), np.ones_like(psi)], axis=1)
    values = problem.forms.reshape(len(psi), 16, 3) @ weights
    x, y, x2, y2, z, ya, xa, sign = np.moveaxis(values.reshape(len(psi), 2, 8, -1), 2, 0)
    tilt = np.hypot(x, y)
    aligned = tilt < ALIGNED
    centre, half = problem.middle[:, :, None], problem.half[:, :, None]
    out = np.empty((len(psi), 7, psi.shape[1]))
    rolls = [_away(x, y, centre[:, 0]), _away(x2, y2, centre[:, 2])]
    if aligned.any():
        both = centre[:, 0] + np.where(z > 0.0, 1.0, -1.0) * centre[:, 2]
        shared = np.abs(wrap(np.arctan2(ya, xa) - both)) / 2.0
        rolls = [np.where(aligned, shared, roll) for roll in rolls]
    away = (rolls[0], _away(z, sign * tilt, centre[:, 1]), rolls[1])
    for i in range(3):
        out[:, [i, i + 4]] = half[:, i] - away[i]
    out[:, 3] = problem.elbow_margin[:, None]
    return np.swapaxes(out, 1, 2)


def _away(x: Array, y: Array, centre: Array) -> Array:
    """|atan2(y, x) - centre|, wrapped, without loss of digits near the centre."""
    c, s = np.cos(centre), np.sin(centre)
    away: Array = np.arctan2(np.abs(y * c - x * s), x * c + y * s)
    return away


@dataclass(frozen=True, slots=True, eq=False)
class AngleIntervals:
    """Closed intervals of psi [rad] for r rows: `start` in [-pi, pi], `end` >= start (beyond pi where it wraps).

    Shape (r, a), NaN after the last one of a row; a whole circle is [-pi, pi]. Within an interval the joints move
    without a jump: it is cut where a ball aligns and its rolls would jump by half a turn.
    """

    start: Array
    end: Array

    def of(self, row: int) -> tuple[tuple[float, float], ...]:
        """The intervals of one row."""
        ends = zip(self.start[row].tolist(), self.end[row].tolist(), strict=True)
        return tuple((a, b) for a, b in ends if a == a)  # NaN fills the rows

    @property
    def empty(self) -> NDArray[np.bool_]:
        """(r,) rows without an interval."""
        empty: NDArray[np.bool_] = np.isnan(self.start[:, 0])
        return empty


def intervals_at_level(problem: MarginProblem, level: Array | float) -> AngleIntervals:
    """Where all seven margins are at least `level`, (r,) or one for all [rad]: exact, by each joint's crossings.

    A crossing is where a joint reaches the bound that the level leaves it.
    """
    level = np.broadcast_to(level, len(problem.elbow_margin))
    soft, hard = _crossings(problem, level), _alignments(problem.forms)
    seam = np.full((len(soft), 1), -np.pi)
    cuts = np.concatenate([seam, soft, hard], axis=1)
    order = np.argsort(cuts, axis=1, kind="stable")
    cuts = np.take_along_axis(cuts, order, axis=1)
    is_hard = (order >= 1 + soft.shape[1]) & (cuts > -np.pi)
    ends = np.concatenate([cuts[:, 1:], np.full((len(cuts), 1), np.pi)], axis=1)
    smallest = margins(problem, (cuts + ends) / 2.0).min(axis=2)
    return _joined(cuts, ends, smallest >= level[:, None] - TOUCH, is_hard)


def _joined(starts: Array, ends: Array, inside: NDArray[np.bool_], hard: NDArray[np.bool_]) -> AngleIntervals:
    """Neighbouring pieces that are inside, joined round the circle except at hard cuts."""
    opens = inside & (~np.roll(inside, 1, axis=1) | hard)
    closes = inside & (~np.roll(inside, -1, axis=1) | np.roll(hard, -1, axis=1))
    whole = inside.all(axis=1) & ~opens.any(axis=1)
    opens[whole, 0], closes[whole, -1] = True, True
    count = opens.sum(axis=1)
    wide = max(int(count.max(initial=0)), 1)
    start, end = np.full((len(starts), wide), np.nan), np.full((len(starts), wide), np.nan)
    row, column = np.nonzero(opens)
    place = (np.cumsum(opens, axis=1) - 1)[row, column]
    start[row, place] = starts[row, column]
    row, column = np.nonzero(closes)
    rank = (np.cumsum(closes, axis=1) - 1)[row, column]
    # where the first interval to close opened before the seam, every end moves one place back and that one wraps
    wraps = np.argmax(closes, axis=1) < np.argmax(opens, axis=1)
    shift = rank - wraps[row]
    over = shift < 0
    end[row, np.where(over, count[row] - 1, shift)] = ends[row, column] + TURN * over
    return AngleIntervals(start, end)


def _crossings(problem: MarginProblem, level: Array) -> Array:
    """psi (r, 24) at which a joint crosses its bound; -pi where there is none."""
    forms = problem.forms
    steady = (np.abs(forms[:, :, [_X, _Y]]).sum(axis=(2, 3)) < ALIGNED)[..., None]
    side = np.where(forms[:, :, _Z].sum(axis=2) > 0.0, 1.0, -1.0)
    allowed = problem.half - level[:, None, None]
    roots = []
    for joint, (x, y) in ((0, (_X, _Y)), (2, (_X2, _Y2))):
        # a ball that stays aligned at every psi: the two rolls share one angle, half each
        fx = np.where(steady, forms[:, :, _XA], forms[:, :, x])
        fy = np.where(steady, forms[:, :, _YA], forms[:, :, y])
        shared = problem.middle[:, 0] + side * problem.middle[:, 2]
        centre = np.where(steady[..., 0], shared, problem.middle[:, joint])
        reach = allowed[:, :, joint] * np.where(steady[..., 0], 2.0, 1.0)
        for bound in (centre - reach, centre + reach):
            c, s = np.cos(bound)[..., None], np.sin(bound)[..., None]
            roots.append(np.where((reach < np.pi)[..., None], _roots(fy * c - fx * s), np.nan))
    reach = allowed[:, :, 1]
    for bound in (problem.middle[:, 1] - reach, problem.middle[:, 1] + reach):
        form = forms[:, :, _Z].copy()
        form[..., 2] -= np.cos(bound)
        roots.append(np.where((reach < np.pi)[..., None], _roots(form), np.nan))
    cuts = np.concatenate(roots, axis=2).reshape(len(forms), -1)
    return np.where(np.isnan(cuts), -np.pi, cuts)


def _roots(form: Array) -> Array:
    """psi (..., 2) in [-pi, pi) where a cos(psi) + b sin(psi) + c = 0, NaN without one; a touch counts."""
    size = np.hypot(form[..., 0], form[..., 1])
    level = -form[..., 2] / np.where(size > ALIGNED, size, np.nan)
    near = np.where(np.abs(level) <= 1.0 + TOUCH, np.clip(level, -1.0, 1.0), np.nan)
    middle, spread = np.arctan2(form[..., 1], form[..., 0]), np.arccos(near)
    both = np.stack([middle - spread, middle + spread], axis=-1)
    roots: Array = np.mod(both + np.pi, TURN) - np.pi
    return roots


def _alignments(forms: Array) -> Array:
    """psi (r, 4) at which the tilt of a ball passes 0 or half a turn, -pi where it does not."""
    z = forms[:, :, _Z]
    size, top = np.hypot(z[..., 0], z[..., 1]), np.arctan2(z[..., 1], z[..., 0])
    out = np.full((len(forms), 2, 2), -np.pi)
    moving = size > ALIGNED
    out[..., 0] = np.where(moving & (z[..., 2] + size >= 1.0 - SQUARE_TOUCH), wrap(top), -np.pi)
    out[..., 1] = np.where(moving & (z[..., 2] - size <= -1.0 + SQUARE_TOUCH), wrap(top + np.pi), -np.pi)
    return out.reshape(len(forms), 4)


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


def solve_pose(problem: solution.PoseProblem, geometry: SrsGeometry) -> solution.InverseResult:
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
        return solution.InverseResult("out of reach", (), (), True, distance=excess)
    margin = margin_problem(geometry, ranges, T, signs)
    intervals = intervals_at_level(margin, 0.0 if problem.limits else NO_LIMIT)
    angles = best_angles(margin).psi if psi is None else np.full(len(BRANCHES), float(psi))
    q = closed_form(geometry, ranges, T, angles, signs)
    labels = [branch.label for branch in BRANCHES]
    result = solution.turned_result(problem, q, True, labels, arm_angles=angles.tolist())
    intervals_of = {label: intervals.of(b) for b, label in enumerate(labels)}
    return replace(result, arm_angle_intervals=intervals_of)
