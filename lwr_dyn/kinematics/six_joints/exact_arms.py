"""Six-joint arms with a closed form that is theirs as it stands: its text, and one pose solved by it, fast.

The text (`kinematics.closed_forms`) gives the branches, their residuals and singularities, and how often each fits into
the limits. Where two branches are one solution, or a copy lies on the line between inside and outside, the copies are
listed and compared one by one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics import inverse, solution
from lwr_dyn.kinematics.arm_geometry import required
from lwr_dyn.kinematics.closed_forms.arm_numbers import numbers_of_six_joints, numbers_of_solutions, places
from lwr_dyn.kinematics.closed_forms.judged import LABELS, Judge, judge_of
from lwr_dyn.kinematics.closed_forms.runners import runner
from lwr_dyn.kinematics.six_joints import snapped_arms, spherical_wrist
from lwr_dyn.kinematics.six_joints.snapped_arms import SnappedArm
from lwr_dyn.kinematics.six_joints.spherical_wrist import WRIST_ARM, SixJointBranches, SixJointGeometry
from lwr_dyn.kinematics.solution import REACH_SLACK, InverseResult, PoseProblem, joint_ranges
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import pose_array

_WORST = places(6)["WORST"]

_JUDGING = ("solutions", "solutions_six_joints", "rows")


@dataclass(frozen=True, slots=True, eq=False)
class SixJointForm:
    """The closed form of one arm."""

    texts: tuple[str, ...]
    """Names for `texts.closed_form_text`."""
    numbers: Mapping[str, Any]
    branches: Callable[[Array], SixJointBranches]
    """All branches for flange poses T (k, 4, 4), in NumPy."""


def six_joint_form(arm: Arm) -> SixJointForm | None:
    """Of an arm with a spherical wrist or three parallel axes; None for another, also for one that is nearly so."""
    geometry = spherical_wrist.wrist_arm_geometry(arm.chain)
    if geometry is not None:
        return _wrist_form(arm, geometry)
    snapped = snapped_arms.snapped_arm(arm.chain, 4)
    return None if snapped is None or snapped.off else _parallel_form(arm, snapped)


def _wrist_form(arm: Arm, geometry: SixJointGeometry) -> SixJointForm:
    numbers, form = numbers_of_six_joints(arm, geometry, REACH_SLACK), spherical_wrist.closed_form
    return SixJointForm(
        ("shared", "six_joints", "spherical_wrist"), numbers, partial(form, geometry, joint_ranges(arm))
    )


def _parallel_form(arm: Arm, snapped: SnappedArm) -> SixJointForm:
    slack, form = snapped_arms.ROUNDED, snapped_arms.three_parallel_closed_form
    numbers = numbers_of_six_joints(arm, snapped.geometry, slack)
    branches = partial(form, snapped.geometry, joint_ranges(arm), slack=slack)
    return SixJointForm(("shared", "six_joints", "three_parallel"), numbers, branches)


@dataclass(frozen=True, slots=True, eq=False)
class SixJointSolver:
    """Solves one pose after the other of one arm."""

    arm: Arm
    judge: Judge
    run: Callable[..., Array | None]
    """`Runner.run`."""
    largest: float
    """Largest residual [m and dimensionless] of solutions that need no polish."""
    texts: tuple[str, ...]
    numbers: Mapping[str, Any]
    """What the runner is made of."""

    def __call__(self, T: Array, limits: bool, arm_angle: float | None = None) -> InverseResult | None:
        """All solutions of T (4, 4) of float64; None for what is no pose, or needs a polish, or has an arm angle."""
        out = self.run(T) if arm_angle is None else None
        if out is None or out.item(_WORST) > self.largest:
            return None

        def one_by_one() -> InverseResult:
            problem, near = PoseProblem(self.arm, pose_array("T", T), limits), self.judge.near(out)
            q, which = self.judge.branches(out)
            return solution.turned_result(problem, q, True, [LABELS[b] for b in which], [near[b] for b in which])

        return self.judge.result(out, limits, one_by_one)


@lru_cache(maxsize=32)
def ready(arm: Arm) -> SixJointSolver | None:
    """What solves the poses of an arm with an exact closed form; None for another arm."""
    form = six_joint_form(arm)
    if form is None:
        return None
    is_polished = form.texts[-1] == "three_parallel"
    texts, numbers = (*form.texts, *_JUDGING), {**form.numbers, **numbers_of_solutions(arm, is_polished)}
    largest = inverse.SOLVED if is_polished else np.inf
    made = runner(texts, numbers)
    return SixJointSolver(arm, judge_of(arm, made.rows_of), made.run, largest, texts, numbers)


def _solve_wrist(problem: PoseProblem, geometry: SixJointGeometry) -> InverseResult:
    found = required(problem.arm, ready(problem.arm), WRIST_ARM)(problem.pose, problem.limits)
    return required(problem.arm, found, "a pose")


WRIST_SOLVER = solution.IkSolver(spherical_wrist.wrist_arm_geometry, _solve_wrist, WRIST_ARM, ready=ready)
"""The row "spherical-wrist" of the solvers."""

THREE_PARALLEL_SOLVER = solution.IkSolver(
    partial(snapped_arms.snapped_arm, ball_starts=4),
    partial(snapped_arms.solve_snapped, snapped_arms.three_parallel_closed_form),
    snapped_arms.PARALLEL_ARM,
    ready=ready,
)
"""The row "three-parallel" of the solvers."""
