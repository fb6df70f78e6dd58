"""Sums that do not add up, and the one cell that would mend them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.sheet import Column, Sheet, Table
from lwr_dyn.papers.printed_number import ROUND, PrintedNumber, printed_number


def totals(sheet: Sheet) -> Iterator[Finding]:
    """Rule 7: a total that is not the sum of its column within the rounding of all its digits."""
    for table in sheet.tables:
        for column in table.columns:
            total = printed_number(table.declared.totals.get(column.name, ""))
            if total is not None and all(n is not None for n in column.numbers):
                yield from _checked(sheet.file, table, column, total)


def _checked(file: str, table: Table, column: Column, total: PrintedNumber) -> Iterator[Finding]:
    numbers = [n for n in column.numbers if n is not None]
    found = math.fsum(n.value for n in numbers)
    slack = math.fsum(n.half for n in numbers) + total.half
    if abs(found - total.value) <= slack * (1.0 + ROUND):
        return
    mends = list(_mends(table, column, numbers, total, found, slack))
    how = f"; it adds up if {' or '.join(mends)}" if 0 < len(mends) <= 3 else ""
    place = f"{table.name}, total of {column.name}"
    yield Finding(
        "total", "error", "certain", file, place, (place, *(table.place(i, column.name) for i in range(table.rows))),
        total.text, mends[0] if len(mends) == 1 else f"{found:.10g}",
        f"{total.text} is printed, the {len(numbers)} cells add up to {found:.10g}, "
        f"{found - total.value:+.4g} off where rounding allows {slack:.2g}{how}",
        {"sum": found, "difference": found - total.value, "rounding": slack},
    )  # fmt: skip


def _mends(
    table: Table, column: Column, numbers: Sequence[PrintedNumber], total: PrintedNumber, found: float, slack: float
) -> Iterator[str]:
    """Single slips that explain the difference: a power of ten, a sign, two digits exchanged."""
    for i, number in enumerate(numbers):
        for other, how in _readings(number):
            if abs(found - number.value + other - total.value) <= slack * (1.0 + ROUND):
                yield f"{table.place(i, column.name)} is {other:.10g} ({how}) and not {number.text}"
    for other, how in _readings(total):
        if abs(found - other) <= slack * (1.0 + ROUND):
            yield f"the total is {other:.10g} ({how})"


def _readings(number: PrintedNumber) -> Iterator[tuple[float, str]]:
    if not number.value:
        return
    for k in (-3, -2, -1, 1, 2, 3):
        yield number.value * 10.0**k, f"a factor 1e{k}"
    yield -number.value, "the other sign"
    text = number.text
    for i in range(len(text) - 1):
        if text[i].isdigit() and text[i + 1].isdigit() and text[i] != text[i + 1]:
            swapped = printed_number(text[:i] + text[i + 1] + text[i] + text[i + 2 :])
            if swapped is not None:
                yield swapped.value, "two digits exchanged"
