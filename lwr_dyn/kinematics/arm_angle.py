"""A smooth arm angle along a path that maximises the smallest joint-limit margin.

Inside a corridor of arm angles the curve is the natural cubic spline with the least bending,

    minimise  integral of psi''^2 + PULL (psi - middle of the corridor)^2   subject to  low <= psi <= high,

by bounded least squares at a few knots; where it leaves the corridor between knots, a knot is added there.

The corridor has the largest joint-limit margin that one continuous arm angle can keep along the whole path, over all
eight branches. The largest margin at any one pose bounds what the path can keep. A corridor at that level proves that
it can: one interval of arm angles per pose, each overlapping the next. The intervals at a level are exact, so a level
at which no chain of overlapping intervals leads from the first pose to the last cannot be kept. Branches are tried in
the order of their bounds, until a bound is below what another branch has reached.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.optimize import lsq_linear

from lwr_dyn.foundation.arrays import Array, read_only, real_array
from lwr_dyn.foundation.errors import OptionError, OutOfReachError, OutsideLimitsError, ShapeError
from lwr_dyn.kinematics import srs_margins
from lwr_dyn.kinematics.arm_geometry import SrsGeometry, require_srs
from lwr_dyn.kinematics.solution import BRANCHES, TURN, Branch, JointRanges, joint_ranges, one_turn_note
from lwr_dyn.kinematics.srs import ON_AXIS, arm_triangle
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import pose_array

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
    first = srs_margins.best_angles(
        srs_margins.margin_problem(geometry, ranges, np.tile(T[rows], (len(BRANCHES), 1, 1)), signs)
    )
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
        optimum = _best_of_branch(srs_margins.margin_problem(geometry, ranges, T, start.branch), start, floor)
        if optimum is not None:
            best, floor = optimum, optimum.margin_bound
    return best


def _best_of_branch(problem: srs_margins.MarginProblem, start: BranchOptimum, floor: float) -> BranchOptimum | None:
    """The best of one branch, or None when it does not keep `floor`."""
    optimum, intervals = start, srs_margins.intervals_at_level(problem, _corridor_level(start.margin_bound))
    while intervals.empty.any():
        empty = np.flatnonzero(intervals.empty)
        tight = srs_margins.best_angles(problem.rows(empty))
        i = int(np.argmin(tight.margin))
        bound = float(tight.margin[i])
        optimum = replace(optimum, margin_bound=bound, index=int(empty[i]), joint=int(tight.joint[i]))
        if bound < floor:
            return None
        intervals = srs_margins.intervals_at_level(problem, _corridor_level(bound))
    passage = connected_arm_angles(intervals)
    if isinstance(passage, Corridor):
        return replace(optimum, passage=passage)
    return _highest_passage(problem, optimum, passage, floor)


def _highest_passage(
    problem: srs_margins.MarginProblem, start: BranchOptimum, blocked: CorridorBreak, floor: float
) -> BranchOptimum | None:
    """Bisection on the level: every pose has an interval, but they do not connect."""
    passage = connected_arm_angles(srs_margins.intervals_at_level(problem, floor))
    if isinstance(passage, CorridorBreak):
        return None
    low, high = floor, _corridor_level(start.margin_bound)
    while high - low > RESOLUTION:
        level = (low + high) / 2.0
        attempt = connected_arm_angles(srs_margins.intervals_at_level(problem, level))
        if isinstance(attempt, Corridor):
            low, passage = level, attempt
        else:
            high, blocked = level, attempt
    row = problem.rows(np.array([blocked.index]))
    edge = np.nan_to_num(srs_margins.intervals_at_level(row, high).end[:1, :1])
    joint = int(np.argmin(srs_margins.margins(row, edge)[0, 0]))
    return BranchOptimum(start.branch, high, blocked.index, joint, passage, continuous=False)


def _corridor_level(bound: float) -> float:
    """The level of the corridor below a bound: at the limits rather than outside them."""
    return max(bound - SLACK, 0.0) if bound >= 0.0 else bound - SLACK


def connected_arm_angles(intervals: srs_margins.AngleIntervals) -> Corridor | CorridorBreak:
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


PULL = 1e3
"""Weight of the distance from the corridor's middle, for a path of length 1: bends die out over 1/PULL^(1/4) of it."""

FIRST_KNOTS = 33

INSET = 0.05
"""Part of the corridor's width kept free at each side at the knots, so that between them the curve stays inside."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmAngleCurve:
    """psi(s) along one path, and the smallest joint-limit margin it keeps over the poses of that path."""

    branch: Branch
    margin: float
    """Smallest margin [rad] over all poses and joints."""
    joint: int
    """The joint that has it, 0-based."""
    at: float
    """The path parameter s where it has it."""
    margin_bound: float
    """[rad] No continuous arm angle, on any branch, keeps a larger smallest margin at these poses (see `one_turn`)."""
    reference: Array
    """(3,) The direction psi is counted from; pass it on to `follow`."""
    knots: Array
    """(m,) s of the spline's knots."""
    values: Array
    """(m,) psi at the knots [rad]."""
    one_turn: str = ""
    """What `margin_bound` leaves out, in words: the joints whose wider range counted as one turn; "" if none."""

    def evaluate(self, s: ArrayLike) -> tuple[Array, Array, Array]:
        """psi [rad], dpsi/ds and d2psi/ds2 at s (k,), each (k,); the second derivative is continuous."""
        spline, at = CubicSpline(self.knots, self.values, bc_type="natural"), real_array("s", s)
        return spline(at), spline(at, 1), spline(at, 2)


def best_arm_angle(arm: Arm, s: ArrayLike, T: ArrayLike, *, reference: ArrayLike | None = None) -> ArmAngleCurve:
    """The continuous arm angle that keeps the largest smallest joint-limit margin along a path, of all branches.

    A range of more than a turn, or an unknown one, counts as one turn about its middle, so that no position jumps; the
    result and the error name such joints. Beyond that turn there may be more margin, or a way where none is found.

    Parameters
    ----------
    arm : Arm
        An S-R-S arm.
    s : (k,) array_like
        Path parameter, increasing, k >= 2; its unit is the caller's.
    T : (k, 4, 4) array_like
        Flange poses in the base; the limits are checked at these poses only, so sample the path finely.
    reference : (3,) array_like, optional
        Direction psi is counted from (see `srs`); the axis of joint 1 if not given.

    Raises
    ------
    ShapeError
        Wrong shapes, s not increasing, T not poses.
    OptionError
        Not an S-R-S arm; or the wrist passes the line of `reference`, where psi has no zero: choose another direction.
    OutOfReachError
        `.at` is the s of the pose furthest out of reach, `.distance` by how much [m].
    OutsideLimitsError
        `.at` is the s where the limits are left, `.joint` which, `.excess` by how much at the best arm angle [rad].
    """
    geometry, ranges = require_srs(arm, reference), joint_ranges(arm)
    at, poses = _gate(s, T)
    triangle = arm_triangle(geometry, poses)
    if triangle.reach_excess.any():
        worst = int(np.argmax(triangle.reach_excess))
        raise OutOfReachError(arm.name, float(at[worst]), float(triangle.reach_excess[worst]))
    _require_zero(geometry, triangle.u, triangle.up, at)
    # a joint without limits still has a seam, half a turn from its middle, where its position would jump
    one_turn = JointRanges(ranges.middle, np.minimum(ranges.half, np.pi))
    best = largest_margin(geometry, one_turn, poses)
    if best.margin_bound < 0.0 or best.passage is None:
        why = "at the best arm angle" if best.continuous else "at least; no arm angle leads on without a jump"
        why = "; ".join(filter(None, (why, one_turn_note(arm))))
        joint, excess = arm.joint_names[best.joint], -best.margin_bound
        raise OutsideLimitsError(arm.name, float(at[best.index]), joint, excess, why)
    knots, values = _smooth(at, best.passage)
    return replace(_measured(geometry, ranges, at, poses, best, knots, values), one_turn=one_turn_note(arm))


def _gate(s: ArrayLike, T: ArrayLike) -> tuple[Array, Array]:
    at, poses = real_array("s", s), pose_array("T", T)
    if at.ndim != 1 or len(at) < 2 or poses.shape != (len(at), 4, 4):
        raise ShapeError("s, T", f"shapes {at.shape}, {poses.shape}", "(k,) and (k, 4, 4), k >= 2")
    if not (np.diff(at) > 0.0).all():
        where = int(np.argmin(np.diff(at) > 0.0))
        raise ShapeError("s", f"{at[where]} then {at[where + 1]}", "increasing values")
    return at, poses


def _require_zero(geometry: SrsGeometry, u: Array, up: Array, at: Array) -> None:
    sine = np.linalg.norm(np.cross(u, geometry.reference), axis=1)
    turned = np.append(np.einsum("ki,ki->k", up[1:], up[:-1]) <= 0.0, False)
    if (bad := (sine < ON_AXIS) | turned).any():
        where = float(at[int(np.argmax(bad))])
        fault = f"the wrist passes the line of {geometry.reference.tolist()} through the shoulder at s = {where:.6g}"
        raise OptionError("reference", fault, "a direction that the path keeps away from")


def _smooth(s: Array, passage: Corridor) -> tuple[Array, Array]:
    """Knots and values of the spline with the least bending inside the corridor."""
    x = (s - s[0]) / (s[-1] - s[0])
    middle, half_width = (passage.low + passage.high) / 2.0, (0.5 - INSET) * (passage.high - passage.low)
    chosen = np.unique(np.linspace(0, len(x) - 1, min(len(x), FIRST_KNOTS)).round().astype(int))
    while True:
        values = _least_bending(x[chosen], middle[chosen], half_width[chosen])
        psi = CubicSpline(x[chosen], values, bc_type="natural")(x)
        outside = np.maximum(passage.low - psi, psi - passage.high)
        outside[chosen] = 0.0
        if not (outside > 0.0).any():
            return s[chosen], values
        chosen = np.union1d(chosen, _worst_of_each_run(outside))


def _worst_of_each_run(outside: Array) -> Array:
    bad = np.flatnonzero(outside > 0.0)
    runs = np.split(bad, np.flatnonzero(np.diff(bad) > 1) + 1)
    return np.array([run[np.argmax(outside[run])] for run in runs])


def _least_bending(x: Array, middle: Array, half_width: Array) -> Array:
    """Values at the knots x (m,) within middle +- half_width (m,)."""
    spline = CubicSpline(x, np.eye(len(x)), bc_type="natural")
    bend, h = spline(x, 2), np.diff(x)[:, None]
    # psi'' is linear from a to b over each span: its square integrates to h [(a + b)^2 / 4 + (b - a)^2 / 12]
    total, change = np.sqrt(h) / 2.0 * (bend[:-1] + bend[1:]), np.sqrt(h / 12.0) * np.diff(bend, axis=0)
    pull = np.diag(np.sqrt(PULL * np.gradient(x)))
    target = np.concatenate([np.zeros(2 * len(h)), pull @ middle])
    half_width = np.maximum(half_width, np.finfo(float).eps * (1.0 + np.abs(middle)) * 4.0)
    fit = lsq_linear(
        np.concatenate([total, change, pull]), target, (middle - half_width, middle + half_width), method="bvls"
    )
    values: Array = fit.x
    return values


def _measured(
    geometry: SrsGeometry, ranges: JointRanges, s: Array, T: Array, best: BranchOptimum, knots: Array, values: Array
) -> ArmAngleCurve:
    """The curve with the margin that it keeps at the poses."""
    psi = CubicSpline(knots, values, bc_type="natural")(s)
    kept = srs_margins.margins(srs_margins.margin_problem(geometry, ranges, T, best.branch), psi[:, None])[:, 0]
    row, joint = (int(i) for i in np.unravel_index(np.argmin(kept), kept.shape))
    margin = float(kept[row, joint])
    return ArmAngleCurve(
        branch=best.branch,
        margin=margin,
        joint=joint,
        at=float(s[row]),
        margin_bound=max(best.margin_bound, margin),
        reference=read_only(geometry.reference),
        knots=read_only(knots),
        values=read_only(values),
    )
