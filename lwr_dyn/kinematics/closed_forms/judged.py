"""The result of inverse kinematics from the numbers that a text's `solutions` gives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.closed_forms.arm_numbers import places
from lwr_dyn.kinematics.closed_forms.lazy_solutions import Found, LazySolutions
from lwr_dyn.kinematics.solution import InverseResult
from lwr_dyn.model.arm import Arm

Intervals = Mapping[str, tuple[tuple[float, float], ...]]


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """Of one arm."""

    lower: Array
    """(n,) Position limits [rad], infinite where unknown."""
    upper: Array
    joint_names: tuple[str, ...]
    at: Mapping[str, int]
    """`arm_numbers.places`."""

    def result(
        self, out: Array, limits: bool, one_by_one: Callable[[], InverseResult], intervals: Intervals | None = None
    ) -> InverseResult:
        """Of the numbers `out`; `one_by_one` gives it where copies have to be listed and compared."""
        tail = out[self.at["LEAST"] :].tolist()
        least, _, inside, outside, left_out, margin, joint, special = tail
        if not inside + outside:
            return InverseResult("out of reach", (), (), True, distance=least)
        if special:
            return one_by_one()
        complete, more, of = not left_out, int(left_out), {} if intervals is None else intervals
        if not limits:
            every = self._listed(out, int(inside + outside), True, True)
            return InverseResult("solved", every, (), complete, arm_angle_intervals=of, turns_left_out=more)
        beyond = self._listed(out, int(outside), False, True) if outside else ()
        if inside:
            within = self._listed(out, int(inside), True, False)
            return InverseResult("solved", within, beyond, complete, arm_angle_intervals=of, turns_left_out=more)
        name = self.joint_names[int(joint)]
        return InverseResult(
            "outside limits", (), beyond, complete, name, -margin, arm_angle_intervals=of, turns_left_out=more
        )

    def _listed(self, out: Array, size: int, inside: bool, outside: bool) -> LazySolutions:
        return LazySolutions(size, partial(self.found, out, inside, outside))

    def found(self, out: Array, inside: bool, outside: bool) -> Found:
        """The branches inside the limits, those outside, or both."""
        at, n = self.at, len(self.lower)
        q, copies = out[: 8 * n].reshape(8, n), out[at["COPIES"] :][:8]
        which = np.flatnonzero((q[:, 0] == q[:, 0]) & np.where(copies > 0.0, inside, outside))
        first, many = (out[at[name] :][: 8 * n].reshape(8, n)[which] for name in ("FIRST", "MANY"))
        beyond = copies[which, None] == 0.0
        codes = out[at["SINGULAR"] :][which].astype(int).tolist() if n == 6 else [0] * len(which)
        angles = out[at["ARM_ANGLE"] :][which].tolist() if "ARM_ANGLE" in at else [None] * len(which)
        return Found(
            self.lower, self.upper, self.joint_names, q[which], tuple(which.tolist()),
            tuple(out[at["RESIDUAL"] :][which].tolist()), tuple(codes), np.where(beyond, 0.0, first),
            tuple(map(tuple, np.where(beyond, 1, many).astype(int).tolist())), tuple(angles),
        )  # fmt: skip


def judge_of(arm: Arm) -> Judge:
    """Of an arm."""
    return Judge(arm.lower, arm.upper, tuple(arm.joint_names), places(arm.n))
