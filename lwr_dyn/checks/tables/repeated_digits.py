"""Copied neighbours: a number that repeats the digits of the row above or below where the rest of the rows differs.

Mirror-image links repeat whole rows up to signs, and equal links repeat their masses: these are not faults. A number is
suspected when its row and its neighbour's differ otherwise, or when the copy has other digits than the original.
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from lwr_dyn.checks.tables.roles import role_of
from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn, SheetTable
from lwr_dyn.model.printed_number import PrintedNumber

SHARED = 5
"""Leading digits in common that no accident explains, in numbers printed with different lengths."""
EXACT = 4
"""Digits of a number that repeats exactly in a row that differs otherwise."""
NOISE = 1e-7
"""Relative error that floating-point arithmetic or ten printed digits of pi leave in a simple number."""
MOST_ROWS = 300
"""Rows of a table up to which every two rows are compared."""
CLOSE = 0.1
"""Rows are alike when most of their numbers are within this share of each other."""


def repeated_digits(sheet: Sheet) -> Iterator[Finding]:
    """Rule 5; and numbers that differ in one digit between rows that are mirror images otherwise."""
    for table in sheet.tables:
        columns = [c for c in table.columns if c.numeric and role_of(c.name, table.declared.roles) != "label"]
        for column in columns:
            counts = Counter(abs(n.value) for n in column.numbers if n is not None)
            usual = sum(count > 1 for value, count in counts.items() if value) > 1
            for i in range(table.rows - 1):
                yield from _copied(table, columns, column, i, {} if usual else counts)
        if table.rows <= MOST_ROWS:
            yield from _one_digit(table, columns)


def shared_digits(a: PrintedNumber, b: PrintedNumber) -> int:
    """Leading significant digits in common.

    >>> from lwr_dyn.model.printed_number import printed_number
    >>> shared_digits(printed_number("-0.004375432"), printed_number("-0.00437543"))
    6
    """
    same = [x == y for x, y in zip(a.digits, b.digits, strict=False)]
    return same.index(False) if False in same else len(same)


def is_simple(number: PrintedNumber) -> bool:
    """A number that recurs by itself: few digits, or a whole number of degrees in radians.

    >>> from lwr_dyn.model.printed_number import printed_number
    >>> [is_simple(printed_number(t)) for t in ("0.0450", "1.0471975512", "0.019999999999999", "0.00437543")]
    [True, True, True, False]
    """
    few = float(f"{number.value:.{EXACT - 1}g}")
    degrees = math.degrees(number.value)
    return abs(number.value - few) <= NOISE * abs(few) or abs(degrees - round(degrees)) <= NOISE * abs(degrees)


def _copied(
    table: SheetTable, columns: Sequence[SheetColumn], column: SheetColumn, i: int, counts: Mapping[float, int]
) -> Iterator[Finding]:
    """`counts` are of the sizes in the column; empty where repeats are usual, so that one more is no sign."""
    a, b = column.numbers[i], column.numbers[i + 1]
    if a is None or b is None or not a.value or not b.value:
        return
    count = shared_digits(a, b)
    if not 0.5 < abs(a.value) / abs(b.value) < 2.0 or is_simple(a) or is_simple(b):
        return
    alike = _alike(columns, column, i)
    shorter, longer = sorted((len(a.digits), len(b.digits)))
    prefix = count >= (EXACT if alike is False else SHARED) and count == shorter < longer
    exact = abs(a.value) == abs(b.value) and counts.get(abs(a.value)) == 2
    if alike is True or not (prefix or (exact and alike is False)):
        return
    odds = (len(column.cells) - 1) * 10.0 ** (1 - count)
    yield Finding(
        "copied", "warning", "likely", (table.place(i, column.name), table.place(i + 1, column.name)),
        f"{a.text}, {b.text}", "one of the two is a copy",
        f"{a.text} and {b.text} in {table.name}.{column.name}, rows {i + 1} and {i + 2}, share their first {count} "
        f"digits (by accident about once in {1 / odds:.0g} such columns), while the rest of the two rows differs",
        {"shared_digits": count, "odds": odds},
    )  # fmt: skip


def _alike(columns: Sequence[SheetColumn], column: SheetColumn, i: int) -> bool | None:
    """Most other numbers of rows i and i + 1 are close up to sign; None when there are no others."""
    verdicts = []
    for other in columns:
        a, b = other.numbers[i], other.numbers[i + 1]
        if other is column or a is None or b is None or not (a.value or b.value):
            continue
        verdicts.append(abs(abs(a.value) - abs(b.value)) <= CLOSE * max(abs(a.value), abs(b.value)))
    return 2 * sum(verdicts) > len(verdicts) if verdicts else None


def _one_digit(table: SheetTable, columns: Sequence[SheetColumn]) -> Iterator[Finding]:
    """Two rows that are equal up to signs but for one number, which differs in one digit."""
    for i in range(table.rows):
        for j in range(i + 1, table.rows):
            pairs = [(c, a, b) for c in columns if (a := c.numbers[i]) and (b := c.numbers[j])]
            unequal = [(c, a, b) for c, a, b in pairs if abs(a.value) != abs(b.value)]
            places = {c.group or c.name for c, _, _ in unequal}
            telling = sum(len(a.digits.rstrip("0")) >= EXACT for _, a, _ in pairs)
            if telling < 4 or len(places) != 1 or len({(a.text, b.text) for _, a, b in unequal}) > 1:
                continue
            column, a, b = unequal[0]
            if one_digit_apart(a, b):
                equal = len(pairs) - len(unequal)
                yield Finding(
                    "one-digit", "warning", "possible", (table.place(i, column.name), table.place(j, column.name)),
                    f"{a.text}, {b.text}", f"{a.text} or {b.text} in both",
                    f"rows {i + 1} and {j + 1} of {table.name} are equal up to signs in {equal} numbers"
                    f"; {column.name} differs in one digit: {a.text} and {b.text}",
                    {"equal": equal},
                )  # fmt: skip


def one_digit_apart(a: PrintedNumber, b: PrintedNumber) -> bool:
    """The two print the same but for one digit.

    >>> from lwr_dyn.model.printed_number import printed_number
    >>> one_digit_apart(printed_number("0.03935326"), printed_number("0.03935426"))
    True
    """
    x, y = a.text.lstrip("+-"), b.text.lstrip("+-")
    if is_simple(a) or is_simple(b):
        return False
    return len(x) == len(y) and sum(p != q for p, q in zip(x, y, strict=True)) == 1
