"""Inverse kinematics of one pose: the problem, the solver's interface, the result with its solutions in order."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.kinematics.branches import TOUCH, whole_turns
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.shown import repr_html, short_repr

Geometry = TypeVar("Geometry")
Status = Literal["solved", "out of reach", "outside limits"]
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
class Solution:
    """One set of joint positions q (n,) [rad or m] for a pose."""

    q: Array
    branch: str
    """Signs of shoulder, elbow and wrist ("+-+"); empty from the numeric search."""
    arm_angle: float | None
    """[rad]; None for an arm that has none, and from the numeric search."""
    margin: float
    """Smallest distance to a position limit [rad or m], negative outside, infinite when no limit is known."""
    joint: str
    """The joint that has it."""
    inside_limits: bool
    residual: float
    """Largest entry of FK(q) - T [m and dimensionless]."""
    singular: tuple[str, ...] = ()
    """Singularities (shoulder, elbow, wrist) nearer than `spherical_wrist.NEAR_SINGULAR`."""


@dataclass(frozen=True, slots=True, eq=False)
class InverseResult:
    """Result of inverse kinematics for one pose; `solutions` with the largest margin first."""

    status: Status
    solutions: tuple[Solution, ...]
    """Inside the limits, or all with limits=False."""
    outside: tuple[Solution, ...]
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


def make_solutions(
    problem: PoseProblem, q: Array, branches: Sequence[str] = (), singular: Sequence[tuple[str, ...]] = ()
) -> list[Solution]:
    """q (k, n) with their margins and residuals, and with branches and singularities where they are known."""
    arm, q = problem.arm, read_only(q)
    margins = np.minimum(arm.upper - q, q - arm.lower)
    names = np.array(arm.joint_names)[margins.argmin(axis=1)].tolist()
    residuals = np.abs(flange_pose(arm.chain, q) - problem.pose).max(axis=(1, 2)).tolist()
    return [
        Solution(row, branch, None, margin, joint, margin >= -TOUCH, residual, near)
        for row, branch, margin, joint, residual, near in zip(
            q,
            branches or [""] * len(q),
            margins.min(axis=1).tolist(),
            names,
            residuals,
            singular or [()] * len(q),
            strict=True,
        )
    ]


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
) -> InverseResult:
    """Solutions q (k, n), each with all its copies of `whole_turns`."""
    copies = [whole_turns(problem.arm, row) for row in q]
    rows = np.repeat(np.arange(len(q)), [len(each.q) for each in copies]).tolist()
    labels, names = [branches[i] for i in rows if branches], [singular[i] for i in rows if singular]
    solutions = make_solutions(problem, np.concatenate([each.q for each in copies]), labels, names)
    return ranked_result(problem, solutions, complete, sum(each.left_out for each in copies))


def _each_once(arm: Arm, solutions: Sequence[Solution]) -> list[Solution]:
    """Without those that an earlier one equals; whole turns count where a joint has limits."""
    endless = ~(np.isfinite(arm.lower) & np.isfinite(arm.upper))
    endless &= [link.kind is JointKind.REVOLUTE for link in arm.chain.links]
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
