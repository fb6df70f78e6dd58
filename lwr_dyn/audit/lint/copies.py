"""Copied neighbours: a number that repeats the digits of the row above or below where nothing else repeats.

Mirror-image links repeat whole rows up to signs, and equal links repeat their masses: that is no slip. A number is
suspected when its row and the neighbour's are otherwise far apart, or when the copy has other digits than the original.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.roles import role_of
from lwr_dyn.audit.lint.sheet import Column, Sheet, Table
from lwr_dyn.papers.printed_number import PrintedNumber

SHARED = 5
"""Leading digits in common that no accident explains, in numbers printed with different lengths."""
EXACT = 4
"""Digits of a number that repeats exactly in a row that is otherwise another one."""
NOISE = 1e-7
"""Relative: what arithmetic of floating point or ten printed digits of pi leave of a simple number."""
MOST_ROWS = 300
"""Rows of a table in which every two are compared."""
CLOSE = 0.1
"""Rows are twins when most of their numbers are within this share of each other."""


def copies(sheet: Sheet) -> Iterator[Finding]:
    """Rule 5, with numbers that differ in one digit between rows that are else mirror images."""
    for table in sheet.tables:
        columns = [c for c in table.columns if c.numeric and role_of(c.name, table.declared.roles) != "label"]
        for column in columns:
            repeats = Counter(abs(n.value) for n in column.numbers if n is not None)
            usual = sum(count > 1 for value, count in repeats.items() if value) > 1
            for i in range(table.rows - 1):
                yield from _copied(sheet.file, table, columns, column, i, {} if usual else repeats)
        if table.rows <= MOST_ROWS:
            yield from _twins(sheet.file, table, columns)


def shared_digits(a: PrintedNumber, b: PrintedNumber) -> int:
    """Leading significant digits in common.

    >>> from lwr_dyn.papers.printed_number import printed_number
    >>> shared_digits(printed_number("-0.004375432"), printed_number("-0.00437543"))
    6
    """
    count = 0
    for x, y in zip(a.digits, b.digits, strict=False):
        if x != y:
            return count
        count += 1
    return count


def simple(number: PrintedNumber) -> bool:
    """A number that comes up again by itself: few digits, or a whole number of degrees in radians.

    >>> from lwr_dyn.papers.printed_number import printed_number
    >>> [simple(printed_number(t)) for t in ("0.0450", "1.0471975512", "0.019999999999999", "0.00437543")]
    [True, True, True, False]
    """
    few = float(f"{number.value:.{EXACT - 1}g}")
    degrees = math.degrees(number.value)
    return abs(number.value - few) <= NOISE * abs(few) or abs(degrees - round(degrees)) <= NOISE * abs(degrees)


def _copied(
    file: str, table: Table, columns: Sequence[Column], column: Column, i: int, repeats: Mapping[float, int]
) -> Iterator[Finding]:
    """`repeats` counts the sizes in the column; it is empty where repeats are usual, so that one more is no sign."""
    a, b = column.numbers[i], column.numbers[i + 1]
    if a is None or b is None or not a.value or not b.value:
        return
    count = shared_digits(a, b)
    tens = abs(a.value) / abs(b.value)
    if not 0.5 < tens < 2.0 or simple(a) or simple(b):
        return
    near = _near(columns, column, i)
    least = EXACT if near is False else SHARED
    prefix = count >= least and count == min(len(a.digits), len(b.digits)) < max(len(a.digits), len(b.digits))
    exact = abs(a.value) == abs(b.value) and repeats.get(abs(a.value)) == 2
    if near is True or not (prefix or (exact and near is False)):
        return
    odds = (len(column.cells) - 1) * 10.0 ** (1 - count)
    cells = table.place(i, column.name), table.place(i + 1, column.name)
    yield Finding(
        "copied", "warning", "likely", file, cells[0], cells, f"{a.text}, {b.text}", "one of the two is a copy",
        f"{a.text} and {b.text} in {table.name}.{column.name}, rows {i + 1} and {i + 2}, share their first {count} "
        f"digits (by accident about once in {1 / odds:.0g} such columns), while the rest of the two rows differs",
        {"shared_digits": count, "odds": odds},
    )  # fmt: skip


def _near(columns: Sequence[Column], column: Column, i: int) -> bool | None:
    """Most other numbers of the two rows are close up to sign; nothing when there are no others to compare."""
    verdicts = []
    for other in columns:
        a, b = other.numbers[i], other.numbers[i + 1]
        if other is column or a is None or b is None or not (a.value or b.value):
            continue
        verdicts.append(abs(abs(a.value) - abs(b.value)) <= CLOSE * max(abs(a.value), abs(b.value)))
    return 2 * sum(verdicts) > len(verdicts) if verdicts else None


def _twins(file: str, table: Table, columns: Sequence[Column]) -> Iterator[Finding]:
    """Two rows that are equal up to signs but for one number, which differs in one digit."""
    for i in range(table.rows):
        for j in range(i + 1, table.rows):
            rows = [(c, c.numbers[i], c.numbers[j]) for c in columns if c.numbers[i] and c.numbers[j]]
            told = [(c, a, b) for c, a, b in rows if a and b and len(a.digits.rstrip("0")) >= EXACT]
            off = [(c, a, b) for c, a, b in rows if a and b and abs(a.value) != abs(b.value)]
            places = {c.group or c.name for c, _, _ in off}
            if len(told) < 4 or len(off) == 0 or len(places) > 1 or len({(a.text, b.text) for _, a, b in off}) > 1:
                continue
            column, a, b = off[0]
            if one_digit_apart(a, b):
                cells = table.place(i, column.name), table.place(j, column.name)
                yield Finding(
                    "one-digit", "warning", "possible", file, cells[0], cells, f"{a.text}, {b.text}",
                    f"{a.text} or {b.text} in both",
                    f"rows {i + 1} and {j + 1} of {table.name} are equal up to signs in {len(rows) - len(off)} numbers"
                    f"; {column.name} differs in one digit: {a.text} and {b.text}",
                    {"equal": len(rows) - len(off)},
                )  # fmt: skip


def one_digit_apart(a: PrintedNumber, b: PrintedNumber) -> bool:
    """The two print the same but for one digit.

    >>> from lwr_dyn.papers.printed_number import printed_number
    >>> one_digit_apart(printed_number("0.03935326"), printed_number("0.03935426"))
    True
    """
    x, y = a.text.lstrip("+-"), b.text.lstrip("+-")
    if simple(a) or simple(b):
        return False
    return len(x) == len(y) and sum(p != q for p, q in zip(x, y, strict=True)) == 1
