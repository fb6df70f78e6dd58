"""Rows shifted by one: two columns of a file that repeat each other's numbers only when one is moved up or down."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn

LEAST_MATCHES = 3
"""Different numbers other than 0 that have to repeat."""
SAME = 1e-9
Sizes = Sequence[float | None]


@dataclass(frozen=True, slots=True)
class ColumnSizes:
    """A column, or the components of a vector, as sizes without sign: a turned frame does not hide a repeat."""

    name: str
    unit: str
    values: Sizes

    @property
    def text(self) -> str:
        """The sizes, a dash where a cell prints no number."""
        return ", ".join("-" if x is None else f"{x:.6g}" for x in self.values)


def column_sizes(sheet: Sheet) -> Iterator[ColumnSizes]:
    """The sizes of every column, or vector of up to three columns."""
    for table in sheet.tables:
        groups: dict[str, list[SheetColumn]] = {}
        for column in table.columns:
            groups.setdefault(column.group or column.name, []).append(column)
        for name, columns in groups.items():
            if len(columns) <= 3 and all(c.numeric for c in columns):
                sizes = [_size(columns, i) for i in range(table.rows)]
                yield ColumnSizes(f"{table.name}.{name}", columns[0].unit, sizes)


def _size(columns: Sequence[SheetColumn], row: int) -> float | None:
    values = [n.value for c in columns if (n := c.numbers[row]) is not None]
    return float(sum(x * x for x in values) ** 0.5) if len(values) == len(columns) else None


def shifts(sheet: Sheet) -> Iterator[Finding]:
    """Rule 6: whole columns, or all rows of one from some row on, that fit another column one row up or down."""
    for one, other in itertools.combinations(list(column_sizes(sheet)), 2):
        if one.unit == other.unit and len(one.values) == len(other.values):
            yield from _shifted(one, other)


def _shifted(one: ColumnSizes, other: ColumnSizes) -> Iterator[Finding]:
    a, b = one.values, other.values
    straight = [_same(x, y) for x, y in zip(a, b, strict=True)]
    for step, sense in ((1, "lower"), (-1, "higher")):
        first = None if all(straight) else _first_shifted(a, b, straight, step)
        if first is None:
            continue
        since = "" if first == 0 else f" from row {first + 1} on"
        yield Finding(
            "rows-shifted", "error", "likely", (one.name, other.name), one.text, other.text,
            f"{one.name}{since} repeats the sizes of {other.name} when each stands one row {sense}; as printed "
            f"{sum(straight)} of {len(a)} rows agree: one of the two is shifted",
            {"shift": step, "from_row": first + 1, one.name: list(a), other.name: list(b)},
        )  # fmt: skip
        return


def _first_shifted(a: Sizes, b: Sizes, straight: Sequence[bool], step: int) -> int | None:
    """The first row from which a, moved by `step` rows, is b; the rows before agree as they stand."""
    n = len(a)
    for first in range(n - LEAST_MATCHES):
        if first and not straight[first - 1]:
            return None
        source = range(first, n - 1) if step == 1 else range(max(first, 1), n)
        matched = [(a[i], b[i + step]) for i in source]
        distinct = {x for x, _ in matched if x}
        if all(_same(x, y) for x, y in matched) and len(distinct) >= LEAST_MATCHES and not all(straight[first:-1]):
            return first
    return None


def _same(x: float | None, y: float | None) -> bool:
    return x is not None and y is not None and abs(x - y) <= SAME * max(abs(x), abs(y))
