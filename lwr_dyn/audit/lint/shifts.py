"""Rows shifted by one: two columns of a file that repeat each other's numbers only when one is moved up or down."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.sheet import Column, Sheet, Table

LEAST_MATCHES = 3
"""Different numbers other than nought that have to repeat."""
SAME = 1e-9
Named = tuple[str, Column, Sequence[float | None]]
"""Table and heading, the column, its sizes."""


def sizes(sheet: Sheet) -> Iterator[Named]:
    """Every column as sizes without sign: a vector by its length, so that a turned frame does not hide it."""
    for table in sheet.tables:
        groups: dict[str, list[Column]] = {}
        for column in table.columns:
            groups.setdefault(column.group or column.name, []).append(column)
        for name, columns in groups.items():
            if len(columns) <= 3 and all(c.numeric for c in columns):
                yield _place(table, name), columns[0], [_size(columns, i) for i in range(table.rows)]


def _place(table: Table, name: str) -> str:
    return f"{table.name}.{name}"


def _size(columns: Sequence[Column], row: int) -> float | None:
    numbers = [c.numbers[row] for c in columns]
    known = [n.value for n in numbers if n is not None]
    return float(sum(x * x for x in known) ** 0.5) if len(known) == len(numbers) else None


def shifts(sheet: Sheet) -> Iterator[Finding]:
    """Rule 6: whole columns, or all rows of one from some row on, that fit another column one row up or down."""
    for one, other in itertools.combinations(list(sizes(sheet)), 2):
        if one[1].unit == other[1].unit and len(one[2]) == len(other[2]):
            yield from _shifted(sheet.file, one, other)


def _shifted(file: str, one: Named, other: Named) -> Iterator[Finding]:
    a, b = one[2], other[2]
    straight = [_same(x, y) for x, y in zip(a, b, strict=True)]
    if all(straight):
        return
    for step in (1, -1):
        first = _first_shifted(a, b, straight, step)
        if first is None:
            continue
        sense = "lower" if step == 1 else "higher"
        since = "" if first == 0 else f" from row {first + 1} on"
        count = sum(straight)
        yield Finding(
            "rows-shifted", "error", "likely", file, one[0], (one[0], other[0]), _text(a), _text(b),
            f"{one[0]}{since} repeats the sizes of {other[0]} when each stands one row {sense}; as printed "
            f"{count} of {len(a)} rows agree: one of the two is shifted",
            {"shift": step, "from_row": first + 1, one[0]: list(a), other[0]: list(b)},
        )  # fmt: skip
        return


def _first_shifted(
    a: Sequence[float | None], b: Sequence[float | None], straight: Sequence[bool], step: int
) -> int | None:
    """The first row from which a, moved by `step` rows, is b; the rows before agree as they stand."""
    n = len(a)
    for first in range(n - LEAST_MATCHES):
        if first and not straight[first - 1]:
            return None
        source = range(first, n - 1) if step == 1 else range(max(first, 1), n)
        matched = [(a[i], b[i + step]) for i in source]
        if all(_same(x, y) for x, y in matched) and _tells([x for x, _ in matched], first, straight):
            return first
    return None


def _tells(values: Sequence[float | None], first: int, straight: Sequence[bool]) -> bool:
    """Enough different numbers repeat, and they do not also agree unmoved."""
    distinct = {x for x in values if x}
    return len(distinct) >= LEAST_MATCHES and not all(straight[first:-1])


def _same(x: float | None, y: float | None) -> bool:
    return x is not None and y is not None and abs(x - y) <= SAME * max(abs(x), abs(y))


def _text(values: Sequence[float | None]) -> str:
    return ", ".join("-" if x is None else f"{x:.6g}" for x in values)
