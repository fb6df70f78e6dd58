"""The solutions of a pose as rows of numbers, copies whole turns apart among them; a `Solution` is made when read."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from math import prod
from typing import Any, overload

import numpy as np

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.kinematics.solution import BRANCHES, SINGULARITIES, TOUCH, TURN, Solution

LABELS = tuple(branch.label for branch in BRANCHES)

NEAR = tuple(tuple(name for i, name in enumerate(SINGULARITIES) if code >> i & 1) for code in range(8))
"""Singularities by their code: 1 shoulder, 2 elbow, 4 wrist."""


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """Branches of one pose with what is known of them, rows (m, ...), each standing for its copies."""

    lower: Array
    """(n,) Position limits [rad], infinite where unknown."""
    upper: Array
    joint_names: tuple[str, ...]
    q: Array
    """(m, n) [rad]"""
    branch: tuple[int, ...]
    """Places in `BRANCHES`."""
    residual: tuple[float, ...]
    singular: tuple[int, ...]
    """Codes, the sum of 1 shoulder, 2 elbow, 4 wrist."""
    first: Array
    """(m, n) Whole turns to the first copy."""
    many: tuple[tuple[int, ...], ...]
    """Copies of each joint."""
    arm_angle: tuple[float | None, ...]


@cache
def _turns(many: tuple[int, ...]) -> Array:
    """All places (k, n) of a grid with so many of each, the last joint first."""
    return read_only(np.indices(many).reshape(len(many), -1).T.astype(np.float64))


class LazySolutions(Sequence[Solution]):
    """Solutions by falling margin, as a tuple of them would be; rows are made when first read, then each solution."""

    __slots__ = ("_found", "_made", "_rows", "_size")

    def __init__(self, size: int, found: Callable[[], Found]) -> None:
        self._found, self._size = found, size
        self._rows: tuple[Found, Array, list[float], list[int], list[int]] | None = None
        self._made: dict[int, Solution] = {}

    @property
    def q(self) -> Array:
        """(k, n) All joint positions [rad]."""
        return self._ranked()[1]

    def _ranked(self) -> tuple[Found, Array, list[float], list[int], list[int]]:
        """The branches; q (k, n), margins, joints, and which branch each belongs to, with the largest margin first."""
        if self._rows is None:
            x = self._found()
            if len(set(x.many)) == 1:
                q = (x.q[:, None] + TURN * (x.first[:, None] + _turns(x.many[0]))).reshape(self._size, -1)
            else:
                q = np.concatenate([x.q[i] + TURN * (x.first[i] + _turns(many)) for i, many in enumerate(x.many)])
            room = np.minimum(x.upper - q, q - x.lower)
            joint, margin = room.argmin(axis=1), room.min(axis=1)
            owner = np.repeat(np.arange(len(x.q)), [prod(many) for many in x.many])
            order = np.argsort(-margin, kind="stable")
            self._rows = (
                x, read_only(q[order]), margin[order].tolist(), joint[order].tolist(), owner[order].tolist(),
            )  # fmt: skip
        return self._rows

    def __len__(self) -> int:
        return self._size

    @overload
    def __getitem__(self, place: int) -> Solution: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[Solution, ...]: ...
    def __getitem__(self, place: Any) -> Any:
        if isinstance(place, slice):
            return tuple(self._solution(i) for i in range(*place.indices(self._size)))
        i = place + self._size if place < 0 else place
        if not 0 <= i < self._size:
            raise IndexError(f"solution {place} of {self._size}")
        return self._solution(i)

    def __iter__(self) -> Iterator[Solution]:
        return iter(self._all())

    def __add__(self, other: Sequence[Solution]) -> tuple[Solution, ...]:
        return (*self, *other)

    def __radd__(self, other: Sequence[Solution]) -> tuple[Solution, ...]:
        return (*other, *self)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, LazySolutions | tuple) and self._all() == tuple(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return repr(self._all())

    def _all(self) -> tuple[Solution, ...]:
        if len(self._made) < self._size:
            x, q, margins, joints, owners = self._ranked()
            kinds = list(zip((LABELS[b] for b in x.branch), x.arm_angle, x.residual, (NEAR[s] for s in x.singular),
                             strict=True))  # fmt: skip
            names, known = x.joint_names, self._made
            for i, (row, margin, joint, owner) in enumerate(zip(q, margins, joints, owners, strict=True)):
                if i not in known:
                    label, angle, residual, near = kinds[owner]
                    known[i] = Solution(row, label, angle, margin, names[joint], margin >= -TOUCH, residual, near)
        return tuple(self._made[i] for i in range(self._size))

    def _solution(self, i: int) -> Solution:
        if i not in self._made:
            x, q, margins, joints, owners = self._ranked()
            owner, margin = owners[i], margins[i]
            self._made[i] = Solution(
                q[i], LABELS[x.branch[owner]], x.arm_angle[owner], margin, x.joint_names[joints[i]],
                margin >= -TOUCH, x.residual[owner], NEAR[x.singular[owner]],
            )  # fmt: skip
        return self._made[i]
