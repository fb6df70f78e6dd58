"""A table against the formulas that its file declares: cells that do not follow, and the fault that explains them.

Single faults are two exchanged cells, a power of ten, the other sign, two exchanged digits. Arithmetic in sentences,
such as "1/2 x 0.0106 x 0.05^2 = 1.325e-7", is computed again.
"""

import ast
import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from lwr_dyn.checks.tables import arithmetic
from lwr_dyn.checks.tables.arithmetic import in_words, value_of
from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn, SheetTable, TableError, plain_name
from lwr_dyn.model.printed_number import PrintedNumber, power_of_ten, printed_number

Place = TypeVar("Place")
POWERS = (-3, -2, -1, 1, 2, 3)
"""Powers of ten by which a cell of a sum may be off."""


def exchanges(
    numbers: Mapping[Place, PrintedNumber], holds: Callable[[Mapping[Place, PrintedNumber]], bool]
) -> list[tuple[Place, Place]]:
    """Every two places that print each other's numbers: `holds` with the two numbers exchanged."""
    return [
        (one, other)
        for one, other in itertools.combinations(numbers, 2)
        if holds({one: numbers[other], other: numbers[one]})
    ]


def scale_or_sign(value: float, printed: Sequence[PrintedNumber], slack: float = 0.0) -> tuple[str, str] | None:
    """Rule and words of the fault that turns `value` into one of the printed numbers; None when there is none.

    >>> scale_or_sign(1.325e-5, [printed_number("1.325e-7")])
    ('power-of-ten', 'off by 1e2')
    """
    powers = [k for n in printed if (k := power_of_ten(value, n, slack))]
    if powers:
        return "power-of-ten", f"off by 1e{powers[0]}"
    return ("sign", "the sign is the other one") if any(n.meets(-value, slack) for n in printed) else None


def corrections(number: PrintedNumber) -> Iterator[tuple[float, str]]:
    """Values that a number may stand for when it has one fault, each with the fault in words.

    >>> [value for value, _ in corrections(printed_number("12"))][-2:]
    [-12.0, 21.0]
    """
    if not number.value:
        return
    for k in POWERS:
        yield number.value * 10.0**k, f"a factor 1e{k}"
    yield -number.value, "the other sign"
    text = number.text
    for i in range(len(text) - 1):
        if text[i].isdigit() and text[i + 1].isdigit() and text[i] != text[i + 1]:
            exchanged = printed_number(text[:i] + text[i + 1] + text[i] + text[i + 2 :])
            if exchanged is not None:
                yield exchanged.value, "two digits exchanged"


FORM = "NAME = numbers, names, + - * / ^ and functions such as sqrt, sin, hypot"
LEAST_SHIFTED = 3
"""Rows that must print the value of a neighbouring row before they count as shifted."""


@dataclass(frozen=True, slots=True, eq=False)
class FormulaCell:
    """A cell that a formula gives: what it prints, the formula's value from the other cells, and their rounding."""

    formula: str
    place: str
    row: int
    printed: PrintedNumber
    value: float
    slack: float

    @property
    def follows(self) -> bool:
        """It prints the formula's value, or the formula has none here."""
        return math.isnan(self.value) or self.meets(self.printed)

    def meets(self, number: PrintedNumber) -> bool:
        """A printed number is the formula's value here."""
        return number.meets(self.value, self.slack)


@dataclass(frozen=True, slots=True)
class Formula:
    """A declared formula with the columns that its names mean."""

    text: str
    table: SheetTable
    left: str
    target: SheetColumn
    tree: ast.expr
    names: Mapping[str, SheetColumn]

    def cells(self) -> Iterator[FormulaCell]:
        """Every cell of the left side that prints a number, with the value it should have."""
        scales = self.scales()
        for i, printed in enumerate(self.target.numbers):
            numbers = {name: c.numbers[i if len(c.cells) > 1 else 0] for name, c in self.names.items()}
            if printed is None or any(n is None for n in numbers.values()):
                continue
            values = {name: n.value * scales[name] for name, n in numbers.items() if n is not None}
            halves = {name: n.half * scales[name] * (not n.is_whole) for name, n in numbers.items() if n is not None}
            exact = value_of(self.tree, values)
            moved = [value_of(self.tree, {**values, x: values[x] + halves[x]}) - exact for x in values if halves[x]]
            slack = sum(abs(m) for m in moved if math.isfinite(m)) / scales[self.left]
            single = len(self.target.cells) == 1
            place = f"{self.table.name}, {self.left}" if single else self.table.place(i, self.left)
            yield FormulaCell(self.text, place, i, printed, exact / scales[self.left], slack)

    def scales(self) -> dict[str, float]:
        """Factor to SI of every name when all have units, else 1: then the formula holds in the printed units."""
        columns = {self.left: self.target, **self.names}
        units = {name: arithmetic.unit_of(c.unit) if c.unit else None for name, c in columns.items()}
        known = {name: unit.factor for name, unit in units.items() if unit is not None}
        return known if len(known) == len(columns) else dict.fromkeys(columns, 1.0)


def _formula(sheet: Sheet, table: SheetTable, text: str) -> Formula:
    left, sign, right = text.partition("=")
    tree = arithmetic.parsed(right)
    if not sign or tree is None or arithmetic.name_of(arithmetic.parsed(left) or ast.Constant(0)) is None:
        raise TableError(sheet.file, f"{table.name}, formula", repr(text), FORM)
    target = _named(sheet, table, left.strip(), text)
    names = {name: _named(sheet, table, name, text) for name in arithmetic.names_in(tree)}
    for name, column in names.items():
        if len(column.cells) not in (1, len(target.cells)):
            raise TableError(
                sheet.file, f"{table.name}, formula {text!r}", f"{name} has {len(column.cells)} rows",
                f"{len(target.cells)}, as {left.strip()} has, or one value",
            )  # fmt: skip
    return Formula(text, table, left.strip(), target, tree, names)


def _named(sheet: Sheet, table: SheetTable, name: str, text: str) -> SheetColumn:
    """The column or single value of a name, one of the same table first."""
    known: dict[str, SheetColumn] = {}
    for other in sheet.tables:
        inside = {plain_name(n): c for n, c in (*((c.name, c) for c in other.columns), *other.values.items())}
        known.update({f"{plain_name(other.name)}.{key}": c for key, c in inside.items()})
        if other.name == table.name:
            known.update(inside)
    if name not in known:
        allowed = ", ".join(sorted(known)[:20])
        raise TableError(sheet.file, f"{table.name}, formula {text!r}", f"no column or value {name!r}", allowed)
    return known[name]


def formulas(sheet: Sheet) -> Iterator[Finding]:
    """Rules 3, 4, 6 and 9 with formulas: exchanged cells, powers of ten, shifted rows, and dimensions that differ."""
    read = [_formula(sheet, table, text) for table in sheet.tables for text in table.declared.formulas]
    declared = [(formula, list(formula.cells())) for formula in read]
    for formula, _ in declared:
        yield from _dimensions(formula)
    wrong = {c: c.printed for _, cells in declared for c in cells if not c.follows}
    explained: set[str] = set()
    for one, other in exchanges(wrong, lambda exchanged: all(c.meets(n) for c, n in exchanged.items())):
        explained |= {one.place, other.place}
        yield _exchanged(one, other)
    for formula, cells in declared:
        yield from _shifted(formula, cells, explained)
    yield from (_wrong(cell) for cell in wrong if cell.place not in explained)


def _exchanged(a: FormulaCell, b: FormulaCell) -> Finding:
    texts = a.formula if a.formula == b.formula else f"{a.formula} and {b.formula}"
    return Finding(
        "swapped", "error", "certain", (a.place, b.place), f"{a.printed.text}, {b.printed.text}",
        f"{b.printed.text}, {a.printed.text}", f"{a.place} prints {a.printed.text} where {a.value:.6g} follows, "
        f"{b.place} prints {b.printed.text} where {b.value:.6g} follows ({texts}): the two are exchanged",
        {a.place: a.value, b.place: b.value},
    )  # fmt: skip


def _shifted(formula: Formula, cells: Sequence[FormulaCell], explained: set[str]) -> Iterator[Finding]:
    """Rows that print the formula's value of the row above or below."""
    by_row = {c.row: c for c in cells}
    wrong = [c for c in cells if not c.follows]
    for step in (1, -1):
        moved = [c for c in wrong if (other := by_row.get(c.row - step)) and other.meets(c.printed)]
        places = tuple(c.place for c in moved)
        if len(moved) < max(LEAST_SHIFTED, len(wrong) - 1) or explained & set(places):
            continue
        explained |= {c.place for c in wrong}
        yield Finding(
            "rows-shifted", "error", "certain", places, ", ".join(c.printed.text for c in moved),
            ", ".join(f"{c.value:.6g}" for c in moved), f"{len(moved)} rows of {formula.left} print what "
            f"{formula.text} gives one row {'above' if step == 1 else 'below'}: they are shifted", {"shift": step},
        )  # fmt: skip


def _wrong(cell: FormulaCell) -> Finding:
    off = "formula", f"off by {cell.printed.value - cell.value:.3g}"
    rule, how = scale_or_sign(cell.value, [cell.printed], cell.slack) or off
    return Finding(
        rule, "error", "certain", (cell.place,), cell.printed.text, f"{cell.value:.6g}",
        f"prints {cell.printed.text} where {cell.formula} gives {cell.value:.6g}: {how}", {"value": cell.value},
    )  # fmt: skip


def _dimensions(formula: Formula) -> Iterator[Finding]:
    """The two sides of a formula have different dimensions, or it adds unlike quantities: N m/rad is N m here."""
    columns = {formula.left: formula.target, **formula.names}
    units = {name: arithmetic.unit_of(c.unit) if c.unit else None for name, c in columns.items()}
    powers: dict[str, arithmetic.Powers] = {name: (*u.powers[:3], 0.0) for name, u in units.items() if u is not None}
    if len(powers) < len(columns):
        return
    left = powers[formula.left]
    try:
        right = arithmetic.dimension_of(formula.tree, powers)
        fault = "" if right in (None, left) else f"{in_words(left)} on the left, {in_words(right or left)} on the right"
    except arithmetic.UnlikeError as unlike:
        fault = str(unlike)
    if fault:
        printed = ", ".join(f"{name} [{c.unit}]" for name, c in columns.items())
        yield Finding(
            "dimension", "error", "certain", (f"{formula.table.name}, {formula.left}",), printed,
            "another unit or formula", f"{formula.text}: {fault}", {name: list(p) for name, p in powers.items()},
        )  # fmt: skip


_NUM = r"(?>\d+\.?\d*|\.\d+)(?>[eE][+-]?\d+)?"
_NAMES = "|".join(sorted(arithmetic.FUNCTIONS, key=len, reverse=True))
_TOKEN = rf"(?>{_NUM}|\b(?:{_NAMES})(?=\s*\()|[-+*/^(),]|\bx\b|\bdeg\b|\s)"
_LEFT = re.compile(rf"(?<![\w.]){_TOKEN}+$")
_RIGHT = re.compile(rf"\s*([-+]?{_NUM})((?:\s+or\s+[-+]?{_NUM})*)\s*([^\s\d].{{0,3}})?")
_INNER = re.compile(rf"(?<![\w.]){_NUM}")


@dataclass(frozen=True, slots=True)
class Equality:
    """An equation left = right in a sentence."""

    left: str
    tree: ast.expr
    right: tuple[PrintedNumber, ...]
    """All alternatives that the sentence gives ("= -90 or 11.01")."""

    @property
    def slack(self) -> float:
        """How much the rounding of the decimals on the left may change the result."""
        exact = value_of(self.tree, {})
        changes = []
        for match in _INNER.finditer(self.left):
            number = printed_number(match.group())
            if number is not None and not number.is_whole:
                rounded = self.left[: match.start()] + repr(number.value + number.half) + self.left[match.end() :]
                changes.append(abs(value_of(arithmetic.parsed(rounded), {}) - exact))
        return sum(x for x in changes if math.isfinite(x))


def equalities(text: str) -> Iterator[Equality]:
    """Every "= number" of a sentence whose left side is arithmetic on numbers.

    >>> [(e.left, e.right[0].text) for e in equalities("the shoulder: 350 + 820 = 1170, and a = 3")]
    [('350 + 820', '1170')]
    """
    for sign in re.finditer(r"(?<![=<>!])=(?!=)", text):
        begin = max(0, sign.start() - 2 * arithmetic.LONGEST)  # a longer left side is no formula, and costs no time
        before = _LEFT.search(text[begin : sign.start()].rstrip())
        after = _RIGHT.match(text[sign.end() :])
        if before is None or after is None:
            continue
        left = _balanced(before.group().replace("deg", "").strip(" ,"))
        tree = arithmetic.parsed(left) if left else None
        rest = (after.group(3) or " ").lstrip()
        goes_on = rest[:1] in tuple("+*/^-x(")
        if tree is None or goes_on or not any(isinstance(node, ast.BinOp | ast.Call) for node in ast.walk(tree)):
            continue
        texts = [after.group(1), *re.findall(rf"or\s+([-+]?{_NUM})", after.group(2))]
        numbers = tuple(n for t in texts if (n := printed_number(t)) is not None)
        if numbers and math.isfinite(value_of(tree, {})):
            yield Equality(left, tree, numbers)


def _balanced(text: str) -> str:
    """The longest end of the text whose brackets close and that begins with a number, a function or a bracket."""
    depth, start = 0, len(text)
    for k in range(len(text) - 1, -1, -1):
        depth += {")": 1, "(": -1}.get(text[k], 0)
        if depth < 0 or (depth == 0 and text[k] == ","):
            break
        start = k
    out = text[start:].strip()
    return "" if out[:1] in tuple("+*/^,x)") else out


def sentences(sheet: Sheet) -> Iterator[Finding]:
    """Rule 4 on sentences: the left side does not give the number on the right."""
    for sentence in sheet.sentences:
        for equality in equalities(sentence.text):
            values = [value_of(equality.tree, {}, degrees) for degrees in (False, True)]
            if not any(n.meets(v, equality.slack) for v in values for n in equality.right):
                yield _wrong_equality(sentence.place, equality, values[-1])


def _wrong_equality(place: str, equality: Equality, value: float) -> Finding:
    printed = " or ".join(n.text for n in equality.right)
    off = "arithmetic", f"off by {value - equality.right[0].value:.3g}"
    rule, how = scale_or_sign(value, equality.right, equality.slack) or off
    return Finding(
        rule, "error", "certain", (place,), printed, f"{value:.8g}",
        f"{equality.left} = {value:.8g}, printed as {printed}: {how}", {"value": value, "formula": equality.left},
    )  # fmt: skip
