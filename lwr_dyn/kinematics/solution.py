"""Inverse kinematics of one pose: the problem, the solver's interface, the result with its solutions in order.

Closed forms share the eight branches, joint ranges, whole turns, and the bend of the elbow.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import prod
from typing import Generic, Literal, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.document import Document, Fact, Section
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.solution_rows import TOUCH, Solution, SolutionRecord, SolutionRows
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.run import repr_html, short_repr

ALIGNED = 1e-13
"""Sine of a ball's tilt below which its two rolls turn about one line: only their sum (difference) is determined."""

REACH_SLACK = 1e-12
"""[m] The wrist of a stretched arm, recomputed from its pose, may be this far out of reach."""

TURN = 2.0 * np.pi

MOST_COPIES = 256
"""Copies of one branch, whole turns of joints apart, that are listed: two of each of seven joints, and twice that."""


class Branch(NamedTuple):
    """Which of the eight solutions.

    S-R-S arms: the signs of tilt 2, elbow 4 and tilt 6, counted from where rolls or arm align. Six joints with a
    spherical wrist: shoulder +1 with the wrist centre ahead of axis 1, elbow and wrist the signs of bend and tilt.
    """

    shoulder: int
    elbow: int
    wrist: int

    @property
    def label(self) -> str:
        """The three signs.

        >>> Branch(1, -1, 1).label
        '+-+'
        """
        return "".join("+" if sign > 0 else "-" for sign in self)


BRANCHES = tuple(Branch(*signs) for signs in product((1, -1), repeat=3))


@dataclass(frozen=True, slots=True, eq=False)
class JointRanges:
    """Position limits as middle and half width, (n,) each [rad]; half is infinite where a limit is not known."""

    middle: Array
    half: Array


def joint_ranges(arm: Arm) -> JointRanges:
    """The arm's limits; a joint with one known limit may make a whole turn from it."""
    lower, upper = arm.lower, arm.upper
    both, low, up = np.isfinite(lower) & np.isfinite(upper), np.isfinite(lower), np.isfinite(upper)
    lower, upper = np.where(low, lower, 0.0), np.where(up, upper, 0.0)
    one_sided = np.where(low, lower + np.pi, np.where(up, upper - np.pi, 0.0))
    half = np.where(both, (upper - lower) / 2.0, np.where(low | up, np.pi, np.inf))
    return JointRanges(np.where(both, (lower + upper) / 2.0, one_sided), half)


def drawing_range(turning: NDArray[np.bool_], lower: Array, upper: Array) -> tuple[Array, Array]:
    """Between which positions (n,) starts are drawn: the limits, and one turn [rad] or 2 m where one is not known."""
    wide = np.where(turning, np.pi, 1.0)
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - 2.0 * wide, -wide))
    return low, np.where(np.isfinite(upper), upper, low + 2.0 * wide)


def one_turn_note(arm: Arm) -> str:
    """Which joints with a range of more than one turn, or of unknown width, a path search counts as one; "" if none.

    >>> import lwr_dyn
    >>> one_turn_note(lwr_dyn.load("kr30ha"))
    'A1, A4, A6 counted as one turn about the middle of the range, which is wider'
    """
    wide = joint_ranges(arm).half > np.pi
    names = [name for name, is_wide in zip(arm.joint_names, wide, strict=True) if is_wide]
    return f"{', '.join(names)} counted as one turn about the middle of the range, which is wider" if names else ""


def wrap(angle: Array) -> Array:
    """The angle [rad] within -pi (excluded) and pi.

    >>> wrap(np.array([-np.pi, 4.0])).round(4)
    array([ 3.1416, -2.2832])
    """
    wrapped: Array = np.pi - np.mod(np.pi - angle, TURN)
    return wrapped


@dataclass(frozen=True, slots=True, eq=False)
class WholeTurns:
    """Positions q (k, n) [rad] whole turns of joints apart, and how many more there are inside the limits."""

    q: Array
    left_out: int


def whole_turns(arm: Arm, q: Array) -> WholeTurns:
    """All positions whole turns of joints away from q (n,) that are inside the limits, q included; q itself if none is.

    q is within half a turn of the middle of each range. A joint that lacks a limit keeps its position. Of more than
    `MOST_COPIES` only q is given.
    """
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    first = np.where(limited, np.ceil((np.where(limited, arm.lower, 0.0) - TOUCH - q) / TURN), 0.0)
    last = np.where(limited, np.floor((np.where(limited, arm.upper, 0.0) + TOUCH - q) / TURN), 0.0)
    counts = [int(count) for count in last - first + 1.0]
    total = prod(counts)
    if min(counts) < 1 or total > MOST_COPIES:
        return WholeTurns(q[None], max(total - 1, 0) if min(counts) >= 1 else 0)
    turns = product(*(np.arange(low, up + 1.0) for low, up in zip(first, last, strict=True)))
    return WholeTurns(q + TURN * np.array(list(turns)), 0)


def elbow_bend(lengths: tuple[float, float], distance: Array) -> tuple[Array, Array]:
    """Angle of the elbow from straight, 0 to pi [rad], and by how much the wrist is out of reach [m], <= 0 within.

    The wrist is at `distance` [m] from the shoulder; `lengths` [m] are those of upper arm and forearm.
    """
    first, second = lengths
    longest, shortest = first + second, abs(first - second)
    short, long = np.maximum(longest - distance, 0.0), np.maximum(distance - shortest, 0.0)
    bend = 2.0 * np.arctan2(np.sqrt(short * (longest + distance)), np.sqrt(long * (distance + shortest)))
    return bend, np.maximum(distance - longest, shortest - distance)


Geometry = TypeVar("Geometry")

Status = Literal["solved", "out of reach", "outside limits"]

SINGULARITIES = ("shoulder", "elbow", "wrist")

SAME = 1e-9
"""[rad] Branches whose joints agree to this are one solution (aligned rolls, a straight elbow)."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseProblem:
    """A flange pose (4, 4) [m] that an arm shall take; the options are those of `inverse_kinematics`."""

    arm: Arm
    pose: Array
    limits: bool = True
    arm_angle: float | None = None
    """[rad]"""
    reference: ArrayLike | None = None
    starts: int = 64
    seed: int = 0
    q0: Array | None = None
    """(n,) Where a search of a position starts [rad or m]; the middle of the ranges if not given."""


@dataclass(frozen=True, slots=True, eq=False)
class InverseResult:
    """Result of inverse kinematics for one pose; `solutions` with the largest margin first."""

    status: Status
    solutions: Sequence[Solution]
    """Inside the limits, or all with limits=False; a tuple, or a sequence that makes each solution when it is read."""
    outside: Sequence[Solution]
    """Those outside the limits, least outside first (empty with limits=False)."""
    complete: bool
    """True: these are all branches (of an S-R-S arm each at one arm angle) with all copies whole turns of joints apart
    that are inside the limits, and a status other than "solved" is proven. False: a numeric search, which proves
    nothing, or `turns_left_out`. A joint that lacks a limit has one position of its endless copies."""
    joint: str | None = None
    """Outside limits: the joint that is furthest outside at the best branch and arm angle."""
    excess: float | None = None
    """By how much it is outside [rad or m]."""
    distance: float | None = None
    """Out of reach: by how much [m] (numeric: the smallest position error found); 0 where `turn` is given."""
    turn: float | None = None
    """Out of reach with the position within reach: by how much the nearest orientation found is off [rad]."""
    arm_angle_intervals: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    """Branch -> intervals of the arm angle [rad] inside the limits; an end above pi wraps."""
    turns_left_out: int = 0
    """Copies of the solutions, whole turns of joints apart and inside the limits, that are too many to be listed."""
    position_only: bool = False
    """Only the position counts: one solution of mostly endlessly many."""
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def singular(self) -> tuple[str, ...]:
        """Singularities of any of the solutions, in order shoulder, elbow, wrist."""
        names = {name for solution in (*self.solutions, *self.outside) for name in solution.singular}
        return tuple(name for name in ("shoulder", "elbow", "wrist") if name in names)

    @property
    def document(self) -> Document:
        """The status, and the solutions; outside the limits those that are, where none is inside."""
        shown, where = (self.solutions, "inside") if self.solutions else (self.outside, "outside")
        why = ((f"{self.joint} outside", self.excess), ("out of reach", self.distance), ("turned away", self.turn))
        said = [
            f"{self.status}: {len(self.solutions)} solutions inside the limits, {len(self.outside)} outside",
            *(f"{what} by {value:.3g}" for what, value in why if value is not None),
            *(f"near the singularity {name}" for name in self.singular),
        ]
        rows = [(str(i), ", ".join(f"{x:.4f}" for x in one.q)) for i, one in enumerate(shown, 1)]
        maybe, records = float | None, list[SolutionRecord]
        facts = [
            Fact("status", self.status, "Whether there is a solution, and where not, why.", kind=Status),
            Fact("complete", self.complete,
                 "Whether these are proven to be all branches, with all copies whole turns of joints apart."),
            Fact("turns_left_out", self.turns_left_out, "Copies inside the limits that are too many to be listed."),
            Fact("joint", self.joint, "Outside limits: the joint that is furthest outside.", kind=str | None),
            Fact("excess", self.excess, "By how much it is outside, rad (m).", kind=maybe),
            Fact("distance", self.distance, "How far out of reach, m.", kind=maybe),
            Fact("turn_missed", self.turn,
                 "Where the position is within reach: how far off the nearest orientation found is, rad.", kind=maybe),
            Fact("position_only", self.position_only, "Whether the orientation was free."),
            Fact("singular", list(self.singular), "Singularities that some solution is near to.", kind=list[str]),
            Fact("arm_angle_intervals", dict(self.arm_angle_intervals),
                 "Branch -> intervals of the arm angle inside the limits, rad.", kind=dict[str, list[list[float]]]),
        ]  # fmt: skip
        solutions = Section("", [
            Fact("solutions", [one.record for one in self.solutions], "Inside the limits.", kind=records),
            Fact("outside", [one.record for one in self.outside], "Outside the limits.", kind=records),
            Table(f"{where} the limits", ("", Heading("q", "rad or m")), rows),
        ], brief=True)  # fmt: skip
        return Document("Inverse kinematics", "; ".join(said), [solutions], facts=facts)


ReadySolver = Callable[[Array, bool, float | None], InverseResult | None]
"""From a pose (4, 4) of float64, not checked, `limits` and an arm angle; None where `solve` shall look at it."""


@dataclass(frozen=True, slots=True)
class IkSolver(Generic[Geometry]):
    """A row of `inverse.IK_SOLVERS`."""

    recognise: Callable[[Chain], Geometry | None]
    """The constants that `solve` needs, or None for an arm that it cannot solve."""
    solve: Callable[[PoseProblem, Geometry], InverseResult]
    arms: str
    """Which arms it recognises, in words."""
    has_arm_angle: bool = False
    """Whether it uses `arm_angle` and `reference`."""
    ready: Callable[[Arm], ReadySolver | None] | None = None
    """Where one pose after the other is solved faster than by `solve`: of an arm, what does it."""


def make_solutions(
    problem: PoseProblem,
    q: Array,
    branches: Sequence[str] = (),
    singular: Sequence[tuple[str, ...]] = (),
    arm_angles: Sequence[float] = (),
) -> list[Solution]:
    """q (k, n) with their margins and residuals, and with branches, singularities and arm angles where known."""
    arm, k = problem.arm, len(q)
    margins = np.minimum(arm.upper - q, q - arm.lower)
    residuals = np.abs(flange_pose(arm.chain, q) - problem.pose).max(axis=(1, 2)).tolist()
    numbers = np.column_stack([q, margins.min(axis=1), margins.argmin(axis=1), np.arange(k)])
    rows = SolutionRows(
        arm.joint_names, read_only(numbers), branches or [""] * k, arm_angles or [None] * k, residuals,
        singular or [()] * k,
    )  # fmt: skip
    return [Solution(rows, place) for place in range(k)]


def ranked_result(
    problem: PoseProblem, solutions: Sequence[Solution], complete: bool, turns_left_out: int = 0
) -> InverseResult:
    """Solutions by falling margin, without duplicates; with turns left out it is not complete."""
    ordered = _each_once(problem.arm, sorted(solutions, key=lambda s: -s.margin))
    complete = complete and not turns_left_out
    if not problem.limits:
        return InverseResult("solved", tuple(ordered), (), complete, turns_left_out=turns_left_out)
    inside = tuple(s for s in ordered if s.inside_limits)
    outside = tuple(s for s in ordered if not s.inside_limits)
    if inside:
        return InverseResult("solved", inside, outside, complete, turns_left_out=turns_left_out)
    best = outside[0]
    return InverseResult("outside limits", (), outside, complete, joint=best.joint, excess=-best.margin)


def turned_result(
    problem: PoseProblem,
    q: Array,
    complete: bool,
    branches: Sequence[str] = (),
    singular: Sequence[tuple[str, ...]] = (),
    arm_angles: Sequence[float] = (),
) -> InverseResult:
    """Solutions q (k, n), each with all its copies of `whole_turns`."""
    copies = [whole_turns(problem.arm, row) for row in q]
    rows = np.repeat(np.arange(len(q)), [len(each.q) for each in copies]).tolist()
    labels, names = [branches[i] for i in rows if branches], [singular[i] for i in rows if singular]
    angles = [arm_angles[i] for i in rows if arm_angles]
    solutions = make_solutions(problem, np.concatenate([each.q for each in copies]), labels, names, angles)
    return ranked_result(problem, solutions, complete, sum(each.left_out for each in copies))


def _each_once(arm: Arm, solutions: Sequence[Solution]) -> list[Solution]:
    """Without those that an earlier one equals; whole turns count where a joint has limits."""
    endless = ~(np.isfinite(arm.lower) & np.isfinite(arm.upper))
    endless &= arm.chain.turning
    q = np.array([solution.q for solution in solutions])
    places = np.hstack([q[:, ~endless], np.cos(q[:, endless]), np.sin(q[:, endless])])
    again = {later for _, later in cKDTree(places).query_pairs(SAME, p=np.inf)}
    return [solution for i, solution in enumerate(solutions) if i not in again]


def joint_distance(solution: Solution, q: Array) -> float:
    """Sum of the joint motions from q (n,) to the solution, sum |dq_i| [rad]."""
    return float(np.abs(solution.q - q).sum())


def nearest_solution(solutions: Sequence[Solution], q: Array) -> Solution:
    """The solution with the smallest joint distance from q (n,); solutions must not be empty."""
    return min(solutions, key=lambda solution: joint_distance(solution, q))
