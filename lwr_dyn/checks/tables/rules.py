"""A file of numbers, examined by every rule; here the rules of numbers that must agree and of copied neighbours.

A total must agree with its column, a value printed twice with itself, a symmetric matrix with its transpose. A copied
neighbour repeats the digits of the row above or below where the rest of the rows differs. Mirror-image links repeat
whole rows up to signs, and equal links repeat their masses: these are no faults. A number is suspected when its row and
its neighbour's differ otherwise, or when the copy has other digits than the original.
"""

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from lwr_dyn.arms.papers.catalog import data_files, open_paper
from lwr_dyn.checks.tables.arithmetic import unit_sense
from lwr_dyn.checks.tables.formulas import corrections, formulas, sentences
from lwr_dyn.checks.tables.min_mean_max import min_mean_max
from lwr_dyn.checks.tables.proportions import proportions, shifts
from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn, SheetMatrix, SheetTable, role_of, sheet_of_csv
from lwr_dyn.checks.tables.toml_sheet import sheet_of_toml
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import read_text
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
                    places = table.place(i, column.name), f"{other.name}, {label}"
                    yield Finding(
                        "printed-twice", "error", "certain", places, f"{a.text}, {b.text}", "one value in both",
                        f"{places[0]} prints {a.text}, {places[1]} prints {b.text}: the same value twice, "
                        f"off by {a.value - b.value:+.3g}", {"difference": a.value - b.value},
                    )  # fmt: skip


def _labels(table: SheetTable) -> tuple[str, ...]:
    """Names of the rows: declared in the file, or in a column of labels that are not numbers."""
    if len(table.labels) == table.rows:
        return table.labels
    named = (c for c in table.columns if not c.numeric and role_of(c.name, table.declared.roles) == "label")
    labels = next(named, None)
    return labels.cells if labels is not None else ()


def symmetry(sheet: Sheet) -> Iterator[Finding]:
    """Rule 8: entries (i, j) and (j, i) that print different numbers."""
    for matrix in sheet.matrices:
        pairs = list(_opposites(matrix))
        unequal = [p for p in pairs if not _agree(p[2], p[3])]
        telling = sum(len(p[2].digits.rstrip("0")) >= 3 for p in pairs if p not in unequal)  # neither 0 nor 1
        if matrix.symmetric or (len(unequal) == 1 and telling >= 3):
            yield from (_asymmetry(matrix, *pair) for pair in unequal)


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
    for i, j in itertools.combinations(range(len(matrix.cells)), 2):
        a, b = printed_number(matrix.cells[i][j]), printed_number(matrix.cells[j][i])
        if a is not None and b is not None:
            yield i, j, a, b


def _agree(a: PrintedNumber, b: PrintedNumber) -> bool:
    """Whether they are equal, or one is the other with fewer digits.

    >>> from lwr_dyn.model.printed_number import printed_number
    >>> [_agree(printed_number("0.12"), printed_number(x)) for x in ("0.1234", "0.1263", "0.13")]
    [True, False, False]
    """
    return a.value == b.value or abs(a.value - b.value) < max(a.half, b.half) * (a.half != b.half)


def _difference(a: PrintedNumber, b: PrintedNumber) -> str:
    if a.value == -b.value:
        return ": their signs differ"
    larger, smaller = max(abs(a.value), abs(b.value)), min(abs(a.value), abs(b.value))
    power = next((k for k in range(1, 10) if smaller and abs(larger / smaller / 10**k - 1) < 1e-9), 0)
    return f": they differ by 1e{power}" if power else ""


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
    for i, j in itertools.combinations(range(table.rows), 2):
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
                f"; {column.name} differs in one digit: {a.text} and {b.text}", {"equal": equal},
            )  # fmt: skip


def one_digit_apart(a: PrintedNumber, b: PrintedNumber) -> bool:
    """The two print the same but for one digit.

    >>> from lwr_dyn.model.printed_number import printed_number
    >>> one_digit_apart(printed_number("0.03935326"), printed_number("0.03935426"))
    True
    >>> one_digit_apart(printed_number("0.5"), printed_number("0.4"))  # of two digits that says nothing
    False
    """
    x, y = a.text.lstrip("+-"), b.text.lstrip("+-")
    if is_simple(a) or is_simple(b):
        return False
    return len(x) == len(y) and sum(p != q for p, q in zip(x, y, strict=True)) == 1


Rule = Callable[[Sheet], Iterator[Finding]]

RULES: tuple[Rule, ...] = (
    min_mean_max, proportions, formulas, sentences, totals, shifts, repeated_digits, repeats, symmetry, unit_sense,
)  # fmt: skip
"""In the order of their findings; a fault that an earlier rule explains is not reported again."""

LARGEST = 20_000_000
"""Bytes of a file."""
FORMATS = "a .toml or .csv file of numbers"


def lint(sheet: Sheet) -> tuple[Finding, ...]:
    """The findings of all rules; raises `TableError` for a declaration that cannot be read.

    >>> from lwr_dyn.checks.tables.toml_sheet import sheet_of_toml
    >>> [f.sentence for f in lint(sheet_of_toml('why = "1/2 x 0.0106 x 0.05^2 = 1.325e-7"', "x.toml"))]
    ['1/2 x 0.0106 x 0.05^2 = 1.325e-05, printed as 1.325e-7: off by 1e2']
    """
    findings: dict[tuple[str, frozenset[str]], Finding] = {}
    for finding in (finding for rule in RULES for finding in rule(sheet)):
        ids = [label for place, label in sheet.errata.items() if any(c.startswith(place) for c in finding.cells)]
        known = tuple(dict.fromkeys(ids))
        findings.setdefault((finding.rule, frozenset(finding.cells)), replace(finding, file=sheet.file, known=known))
    return tuple(findings.values())


def sheet_of_file(path: str | Path) -> Sheet:
    """A .toml or .csv file as a sheet, the kind of its joints unknown where it does not state it.

    Raises `FileAccessError` for a file that cannot be read, is too large or is neither .toml nor .csv, `TableError` for
    one that can be read, but not as tables of numbers.
    """
    file = Path(path)
    if file.suffix.lower() not in (".toml", ".csv"):
        raise FileAccessError(str(path), "neither .toml nor .csv", FORMATS)
    text = read_text(path, FORMATS, "utf-8-sig", LARGEST)
    if file.suffix.lower() == ".csv":
        return sheet_of_csv(text, str(path), file.stem)
    return sheet_of_toml(text, str(path))


def sheets_of_robot(robot: str) -> tuple[Sheet, ...]:
    """All files that come with the package about a robot, a sheet each; raises `UnknownNameError`."""
    files = data_files(robot)
    kinds = {kind.value for kind in open_paper(robot).kinds}
    joints = kinds.pop() if len(kinds) == 1 else ""
    return tuple(sheet_of_toml(text, name, joints) for name, text in files.items())
