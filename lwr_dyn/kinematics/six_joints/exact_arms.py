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
from lwr_dyn.kinematics.closed_forms.lazy_solutions import LABELS, NEAR, Found, LazySolutions
from lwr_dyn.kinematics.closed_forms.runners import Runner, runner
from lwr_dyn.kinematics.six_joints import snapped_arms, spherical_wrist
from lwr_dyn.kinematics.six_joints.snapped_arms import SnappedArm
from lwr_dyn.kinematics.six_joints.spherical_wrist import WRIST_ARM, SixJointBranches, SixJointGeometry
from lwr_dyn.kinematics.solution import REACH_SLACK, InverseResult, PoseProblem, joint_ranges
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import pose_array

Limits = tuple[Array, Array, tuple[str, ...]]
"""Lower and upper (n,) [rad], and the joints' names."""

_AT = places(6)

_TAIL = _AT["LEAST"]


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
    limits: Limits
    run: Runner
    largest: float
    """Largest residual [m and dimensionless] of solutions that need no polish."""

    def __call__(self, T: Array, limits: bool) -> InverseResult | None:
        """All solutions of a flange pose T (4, 4) of float64; None for what is no pose, or needs a polish."""
        out = self.run(T)
        if out is None:
            return None
        least, worst, inside, outside, left_out, margin, joint, special = out[_TAIL:].tolist()
        if worst > self.largest:
            return None
        if not inside + outside:
            return InverseResult("out of reach", (), (), True, distance=least)
        if special:
            return self._one_by_one(out, T, limits)
        complete, more = not left_out, int(left_out)
        if not limits:
            return InverseResult("solved", self._listed(out, True, True), (), complete, turns_left_out=more)
        beyond = self._listed(out, False, True) if outside else ()
        if inside:
            return InverseResult("solved", self._listed(out, True, False), beyond, complete, turns_left_out=more)
        return InverseResult(
            "outside limits", (), beyond, complete, self.limits[2][int(joint)], -margin, turns_left_out=more
        )

    def _listed(self, out: Array, inside: bool, outside: bool) -> LazySolutions:
        size = inside * out.item(_AT["INSIDE"]) + outside * out.item(_AT["OUTSIDE"])
        return LazySolutions(int(size), partial(_found, self.limits, out, inside, outside))

    def _one_by_one(self, out: Array, T: Array, limits: bool) -> InverseResult:
        found = _found(self.limits, out, True, True)
        names, labels = [NEAR[code] for code in found.singular], [LABELS[b] for b in found.branch]
        return solution.turned_result(PoseProblem(self.arm, pose_array("T", T), limits), found.q, True, labels, names)


def _found(limits: Limits, out: Array, inside: bool, outside: bool) -> Found:
    """The branches inside the limits, those outside, or both, of the numbers that a runner gives."""
    q, copies = out[:48].reshape(8, 6), out[_AT["COPIES"] :][:8]
    reached = q[:, 0] == q[:, 0]
    which = np.flatnonzero(reached & np.where(copies > 0.0, inside, outside))
    first, many = (out[_AT[name] :][:48].reshape(8, 6)[which] for name in ("FIRST", "MANY"))
    beyond = copies[which, None] == 0.0
    return Found(
        *limits, q[which], tuple(which.tolist()), tuple(out[_AT["RESIDUAL"] :][which].tolist()),
        tuple(out[_AT["SINGULAR"] :][which].astype(int).tolist()), np.where(beyond, 0.0, first),
        tuple(map(tuple, np.where(beyond, 1, many).astype(int).tolist())), (None,) * len(which),
    )  # fmt: skip


@lru_cache(maxsize=32)
def ready(arm: Arm) -> SixJointSolver | None:
    """What solves the poses of an arm with an exact closed form; None for another arm."""
    form = six_joint_form(arm)
    if form is None:
        return None
    texts = (*form.texts, "solutions", "solutions_six_joints")
    largest = inverse.SOLVED if form.texts[-1] == "three_parallel" else np.inf
    limits = (arm.lower, arm.upper, tuple(arm.joint_names))
    return SixJointSolver(arm, limits, runner(texts, {**form.numbers, **numbers_of_solutions(arm)}), largest)


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
