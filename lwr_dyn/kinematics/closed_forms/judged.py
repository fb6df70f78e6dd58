"""The result of inverse kinematics from the numbers that a text's `solutions` gives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.records import quick_maker
from lwr_dyn.kinematics.closed_forms.arm_numbers import places
from lwr_dyn.kinematics.closed_forms.lazy_solutions import LazyRows, LazySolutions
from lwr_dyn.kinematics.closed_forms.runners import RowsOf
from lwr_dyn.kinematics.solution import BRANCHES, SINGULARITIES, InverseResult
from lwr_dyn.kinematics.solution_rows import SolutionRows
from lwr_dyn.model.arm import Arm

Intervals = Mapping[str, tuple[tuple[float, float], ...]]

LABELS = tuple(branch.label for branch in BRANCHES)

NEAR = tuple(tuple(name for i, name in enumerate(SINGULARITIES) if code >> i & 1) for code in range(8))
"""Singularities by their code: 1 shoulder, 2 elbow, 4 wrist."""

_result = quick_maker(InverseResult)

_NO_ANGLES = (None,) * 8

_NONE_NEAR = ((),) * 8


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """Of one arm."""

    n: int
    joint_names: tuple[str, ...]
    at: Mapping[str, int]
    """`arm_numbers.places`."""
    tail: slice
    """Of the numbers that are one each, the last ones."""
    rows_of: RowsOf

    def result(
        self, out: Array, limits: bool, one_by_one: Callable[[], InverseResult], intervals: Intervals | None = None
    ) -> InverseResult:
        """Of the numbers `out`; `one_by_one` gives it where copies have to be listed and compared."""
        least, _, inside, outside, left_out, margin, joint, special = out[self.tail].tolist()
        count = int(inside + outside)
        if not count:
            return InverseResult("out of reach", (), (), True, distance=least)
        if special:
            return one_by_one()
        lazy, more, of = LazyRows(self.rows, out, count), int(left_out), {} if intervals is None else intervals
        within = count if not limits else int(inside)
        listed = LazySolutions(lazy, 0, within) if within else ()
        beyond = LazySolutions(lazy, within, count) if within < count else ()
        if within:
            return _result("solved", listed, beyond, not more, None, None, None, None, of, more, False)
        name = self.joint_names[int(joint)]
        return _result("outside limits", (), beyond, not more, name, -margin, None, None, of, more, False)

    def rows(self, out: Array, count: int) -> SolutionRows:
        """All copies of the branches."""
        at = self.at
        angles = out[at["ARM_ANGLE"] : at["ARM_ANGLE"] + 8].tolist() if "ARM_ANGLE" in at else _NO_ANGLES
        numbers = self.rows_of(out, count)  # which finds the residuals too
        residuals = out[at["RESIDUAL"] : at["RESIDUAL"] + 8].tolist()
        return SolutionRows(self.joint_names, numbers, LABELS, angles, residuals, self.near(out))

    def near(self, out: Array) -> tuple[tuple[str, ...], ...]:
        """The singularities that each branch is near to."""
        if self.n != 6:
            return _NONE_NEAR
        at = self.at["SINGULAR"]
        return tuple([NEAR[int(code)] for code in out[at : at + 8].tolist()])

    def branches(self, out: Array) -> tuple[Array, NDArray[np.intp]]:
        """q (m, n) of the branches within reach, and their places in `BRANCHES`."""
        q = out[: 8 * self.n].reshape(8, self.n)
        which = np.flatnonzero(q[:, 0] == q[:, 0])
        return q[which], which


def judge_of(arm: Arm, rows_of: RowsOf) -> Judge:
    """Of an arm."""
    at = places(arm.n)
    return Judge(arm.n, tuple(arm.joint_names), at, slice(at["LEAST"], at["SIZE"]), rows_of)
