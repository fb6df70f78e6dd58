"""One pose of an S-R-S arm by the text of its closed form, fast, where it is machine code; else by NumPy.

In plain Python the search for the best arm angle would take longer than NumPy's for all branches at once.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.kinematics import solution, srs_margins
from lwr_dyn.kinematics.arm_geometry import SRS_ARM, require_srs, srs_geometry
from lwr_dyn.kinematics.closed_forms.arm_numbers import numbers_of_solutions, numbers_of_srs
from lwr_dyn.kinematics.closed_forms.judged import LABELS, Judge, judge_of
from lwr_dyn.kinematics.closed_forms.runners import RUNNERS
from lwr_dyn.kinematics.solution import InverseResult, PoseProblem
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import pose_array

Pairs = tuple[tuple[float, float], ...]

TEXTS = ("shared", "srs", "srs_intervals", "solutions", "solutions_srs", "rows")


class LazyIntervals(Mapping[str, Pairs]):
    """Branch -> intervals of the arm angle [rad], found when first read; a copy is a plain dictionary."""

    __slots__ = ("_find", "_found", "_margin", "_out")

    def __init__(self, find: Callable[[Array, float], dict[str, Pairs]], out: Array, margin: float) -> None:
        self._find, self._out, self._margin = find, out, margin
        self._found: dict[str, Pairs] | None = None

    def _all(self) -> dict[str, Pairs]:
        if self._found is None:
            self._found = self._find(self._out, self._margin)
        return self._found

    def __getitem__(self, branch: str) -> Pairs:
        return self._all()[branch]

    def __iter__(self) -> Iterator[str]:
        return iter(LABELS)

    def __len__(self) -> int:
        return len(LABELS)

    def __repr__(self) -> str:
        return repr(self._all())

    def __reduce__(self) -> Any:
        return dict, (self._all(),)


@dataclass(frozen=True, slots=True, eq=False)
class SrsSolver:
    """Solves one pose after the other of one arm."""

    arm: Arm
    judge: Judge
    run: Callable[..., Array | None]
    """`Runner.run`."""

    def __call__(self, T: Array, limits: bool, arm_angle: float | None) -> InverseResult | None:
        """All branches of T (4, 4) of float64 at an arm angle [rad] or each at its best; None for what is no pose."""
        if arm_angle is None:
            angle = math.nan
        elif isinstance(arm_angle, float | int) and math.isfinite(arm_angle):
            angle = float(arm_angle)
        else:
            return None
        out = self.run(T, angle, math.nan)
        if out is None:
            return None

        def one_by_one() -> InverseResult:
            problem = PoseProblem(self.arm, pose_array("T", T), limits, arm_angle)
            return srs_margins.solve_pose(problem, require_srs(self.arm))

        margin = 0.0 if limits else srs_margins.NO_LIMIT
        return self.judge.result(out, limits, one_by_one, LazyIntervals(self._intervals, out, margin))

    def _intervals(self, before: Array, margin: float) -> dict[str, Pairs]:
        at = self.judge.at
        out = self.run(before[at["POSE"] : at["POSE"] + 16].reshape(4, 4), 0.0, margin)
        assert out is not None  # it was a pose before
        counts, pairs = out[at["COUNTS"] : at["COUNTS"] + 8].tolist(), out[at["PAIRS"] : at["PAIRS"] + 256].tolist()
        return {
            label: tuple((pairs[i], pairs[i + 1]) for i in range(32 * b, 32 * b + 2 * int(counts[b]), 2))
            for b, label in enumerate(LABELS)
        }


@lru_cache(maxsize=32)
def ready(arm: Arm) -> SrsSolver | None:
    """What solves the poses of an S-R-S arm; None where there is no machine code."""
    geometry = srs_geometry(arm.chain)
    if geometry is None:
        return None
    try:
        make = RUNNERS.load("compiled")
    except MissingPackageError:
        return None
    numbers = {**numbers_of_srs(arm, geometry), **numbers_of_solutions(arm, False)}
    made = make(TEXTS, numbers)
    return SrsSolver(arm, judge_of(arm, made.rows_of), made.run)


SOLVER = solution.IkSolver(srs_geometry, srs_margins.solve_pose, SRS_ARM, has_arm_angle=True, ready=ready)
"""The row "srs" of the solvers."""
