"""Numbers that must agree and do not: a total and its column, a value printed twice, entries of symmetric matrices."""

import math
from collections.abc import Iterator

from lwr_dyn.checks.tables.fault_search import corrections
from lwr_dyn.checks.tables.roles import role_of
from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn, SheetMatrix, SheetTable
from lwr_dyn.model.printed_number import ROUND, PrintedNumber, printed_number

MOST_CORRECTIONS = 3
"""Corrections of a total that are listed; more explain nothing."""
Opposite = tuple[int, int, PrintedNumber, PrintedNumber]
"""Row, column, entry (row, column), entry (column, row)."""


def totals(sheet: Sheet) -> Iterator[Finding]:
    """Rule 7: a total that is not the sum of its column within the rounding of all its digits."""
    for table in sheet.tables:
        for column in table.columns:
            total = printed_number(table.declared.totals.get(column.name, ""))
            if total is not None and all(n is not None for n in column.numbers):
                yield from _total(table, column, total)


def _total(table: SheetTable, column: SheetColumn, total: PrintedNumber) -> Iterator[Finding]:
    numbers = [n for n in column.numbers if n is not None]
    value = math.fsum(n.value for n in numbers)
    rounding = math.fsum(n.half for n in numbers) + total.half
    slack = rounding * (1.0 + ROUND)
    if abs(value - total.value) <= slack:
        return
    cells = [table.place(i, column.name) for i in range(table.rows)]
    better = [
        f"{cell} is {other:.10g} ({how}) and not {number.text}"
        for cell, number in zip(cells, numbers, strict=True)
        for other, how in corrections(number)
        if abs(value - number.value + other - total.value) <= slack
    ]
    better += [f"the total is {other:.10g} ({how})" for other, how in corrections(total) if abs(value - other) <= slack]
    hint = f"; it adds up if {' or '.join(better)}" if 0 < len(better) <= MOST_CORRECTIONS else ""
    yield Finding(
        "total", "error", "certain", (f"{table.name}, total of {column.name}", *cells),
        total.text, better[0] if len(better) == 1 else f"{value:.10g}",
        f"{total.text} is printed, the {len(numbers)} cells add up to {value:.10g}, "
        f"{value - total.value:+.4g} off where rounding allows {rounding:.2g}{hint}",
        {"sum": value, "difference": value - total.value, "rounding": rounding},
    )  # fmt: skip


def repeats(sheet: Sheet) -> Iterator[Finding]:
    """Cells (row label R, column C) against the value R that stands alone in the table C."""
    alone = {(t.name.rsplit(".", 1)[-1], name): (t, c) for t in sheet.tables for name, c in t.values.items()}
    for table in sheet.tables:
        for column in table.columns:
            for i, label in enumerate(_labels(table)):
                other, column_alone = alone.get((column.name, label), (None, None))
                a, b = column.numbers[i], column_alone.numbers[0] if column_alone else None
                if other and a and b and abs(a.value - b.value) > max(a.half, b.half) * (1.0 + ROUND):
                    yield _printed_twice(table.place(i, column.name), f"{other.name}, {label}", a, b)


def _labels(table: SheetTable) -> tuple[str, ...]:
    """Names of the rows: declared in the file, or in a column of labels that are not numbers."""
    if len(table.labels) == table.rows:
        return table.labels
    named = (c for c in table.columns if not c.numeric and role_of(c.name, table.declared.roles) == "label")
    labels = next(named, None)
    return labels.cells if labels is not None else ()


def _printed_twice(place: str, other: str, a: PrintedNumber, b: PrintedNumber) -> Finding:
    return Finding(
        "printed-twice", "error", "certain", (place, other), f"{a.text}, {b.text}", "one value in both",
        f"{place} prints {a.text}, {other} prints {b.text}: the same value twice, off by {a.value - b.value:+.3g}",
        {"difference": a.value - b.value},
    )  # fmt: skip


def symmetry(sheet: Sheet) -> Iterator[Finding]:
    """Rule 8: entries (i, j) and (j, i) that print different numbers."""
    for matrix in sheet.matrices:
        pairs = list(_opposites(matrix))
        unequal = [p for p in pairs if not _agree(p[2], p[3])]
        if matrix.symmetric or _nearly_symmetric(pairs, unequal):
            for pair in unequal:
                yield _asymmetry(matrix, *pair)


def _asymmetry(matrix: SheetMatrix, i: int, j: int, a: PrintedNumber, b: PrintedNumber) -> Finding:
    must = matrix.symmetric
    return Finding(
        "not-symmetric", "error" if must else "warning", "certain" if must else "possible",
        (f"{matrix.name}[{i + 1},{j + 1}]", f"{matrix.name}[{j + 1},{i + 1}]"), f"{a.text}, {b.text}",
        f"{a.text} or {b.text} in both", f"({i + 1},{j + 1}) prints {a.text} and ({j + 1},{i + 1}) prints "
        f"{b.text} in a matrix that {'has to be' if must else 'else is'} symmetric{_difference(a, b)}",
        {"difference": a.value - b.value},
    )  # fmt: skip


def _opposites(matrix: SheetMatrix) -> Iterator[Opposite]:
    size = len(matrix.cells)
    for i in range(size):
        for j in range(i + 1, size):
            a, b = printed_number(matrix.cells[i][j]), printed_number(matrix.cells[j][i])
            if a is not None and b is not None:
                yield i, j, a, b


def _agree(a: PrintedNumber, b: PrintedNumber) -> bool:
    return a.value == b.value or abs(a.value - b.value) < max(a.half, b.half) * (a.half != b.half)


def _nearly_symmetric(pairs: list[Opposite], unequal: list[Opposite]) -> bool:
    """One pair differs, and at least three equal ones are neither 0 nor 1."""
    equal = [p for p in pairs if p not in unequal and len(p[2].digits.rstrip("0")) >= 3]
    return len(unequal) == 1 and len(equal) >= 3


def _difference(a: PrintedNumber, b: PrintedNumber) -> str:
    if a.value == -b.value:
        return ": their signs differ"
    larger, smaller = max(abs(a.value), abs(b.value)), min(abs(a.value), abs(b.value))
    power = next((k for k in range(1, 10) if smaller and abs(larger / smaller / 10**k - 1) < 1e-9), 0)
    return f": they differ by 1e{power}" if power else ""
