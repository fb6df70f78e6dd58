"""The solutions of a pose, copies whole turns apart among them: rows are made when first read, then each `Solution`."""

from collections.abc import Callable, Iterator, Sequence
from itertools import repeat
from typing import Any, overload

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.records import quick_maker
from lwr_dyn.kinematics.solution_rows import Solution, SolutionRows

_new_solution = quick_maker(Solution)


class LazyRows:
    """All solutions of a pose by falling margin, so those inside the limits first."""

    __slots__ = ("_count", "_make", "_out", "_rows")

    def __init__(self, make: Callable[[Array, int], SolutionRows], out: Array, count: int) -> None:
        self._make, self._out, self._count = make, out, count
        self._rows: SolutionRows | None = None

    @property
    def rows(self) -> SolutionRows:
        """They are made once, of the numbers `out`."""
        if self._rows is None:
            self._rows = self._make(self._out, self._count)
        return self._rows

    def __reduce__(self) -> Any:
        return _rows_there, (self.rows,)


def _rows_there(rows: SolutionRows) -> LazyRows:
    there = LazyRows(lambda *_: rows, rows.numbers, len(rows.numbers))
    assert there.rows is rows
    return there


class LazySolutions(Sequence[Solution]):
    """Those from place `start` up to `stop`, as a tuple of them would be."""

    __slots__ = ("_lazy", "_made", "_start", "_stop")

    def __init__(self, lazy: LazyRows, start: int, stop: int) -> None:
        self._lazy, self._start, self._stop = lazy, start, stop
        self._made: dict[int, Solution] | tuple[Solution, ...] | None = None

    @property
    def q(self) -> Array:
        """(k, n) All joint positions [rad], read-only."""
        return self._lazy.rows.numbers[self._start : self._stop, :-3]

    def __len__(self) -> int:
        return self._stop - self._start

    @overload
    def __getitem__(self, place: int) -> Solution: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[Solution, ...]: ...
    def __getitem__(self, place: Any) -> Any:
        size = self._stop - self._start
        if isinstance(place, slice):
            return tuple(self._solution(i) for i in range(*place.indices(size)))
        i = place + size if place < 0 else place
        if not 0 <= i < size:
            raise IndexError(f"solution {place} of {size}")
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
        made = self._made
        if isinstance(made, tuple):
            return made
        every = list(map(_new_solution, repeat(self._lazy.rows), range(self._start, self._stop)))
        for i, one in (made or {}).items():  # a solution that was read stays the same one
            every[i] = one
        self._made = tuple(every)
        return self._made

    def _solution(self, i: int) -> Solution:
        if isinstance(self._made, tuple):
            return self._made[i]
        if self._made is None:
            self._made = {}
        if i not in self._made:
            self._made[i] = _new_solution(self._lazy.rows, self._start + i)
        return self._made[i]
