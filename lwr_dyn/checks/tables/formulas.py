"""A table against the formulas that its file declares: cells that do not follow, and the fault that explains them."""

import ast
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from lwr_dyn.checks.tables.arithmetic import name_of, names_in, parsed, value_of
from lwr_dyn.checks.tables.dimensions import Powers, Unit, UnlikeError, dimension_of, in_words, unit_of
from lwr_dyn.checks.tables.fault_search import exchanges, scale_or_sign
from lwr_dyn.checks.tables.roles import plain_name
from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn, SheetTable, TableError
from lwr_dyn.model.printed_number import PrintedNumber

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
        units = {name: unit_of(c.unit) if c.unit else None for name, c in columns.items()}
        known = {name: unit.factor for name, unit in units.items() if unit is not None}
        return known if len(known) == len(columns) else dict.fromkeys(columns, 1.0)


def formulas_of(sheet: Sheet) -> Iterator[Formula]:
    """The declared formulas; raises `TableError` for one that cannot be read."""
    for table in sheet.tables:
        for text in table.declared.formulas:
            yield _formula(sheet, table, text)


def _formula(sheet: Sheet, table: SheetTable, text: str) -> Formula:
    left, sign, right = text.partition("=")
    tree = parsed(right)
    if not sign or tree is None or name_of(parsed(left) or ast.Constant(0)) is None:
        raise TableError(sheet.file, f"{table.name}, formula", repr(text), FORM)
    target = _named(sheet, table, left.strip(), text)
    names = {name: _named(sheet, table, name, text) for name in names_in(tree)}
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
    declared = [(formula, list(formula.cells())) for formula in formulas_of(sheet)]
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
    """The two sides of a formula have different dimensions, or it adds unlike quantities."""
    columns = {formula.left: formula.target, **formula.names}
    units: dict[str, Unit] = {name: u for name, c in columns.items() if c.unit and (u := unit_of(c.unit)) is not None}
    if len(units) < len(columns):
        return
    powers: dict[str, Powers] = {name: u.without_angle for name, u in units.items()}
    left = powers[formula.left]
    try:
        right = dimension_of(formula.tree, powers)
        fault = "" if right in (None, left) else f"{in_words(left)} on the left, {in_words(right or left)} on the right"
    except UnlikeError as unlike:
        fault = str(unlike)
    if fault:
        printed = ", ".join(f"{name} [{c.unit}]" for name, c in columns.items())
        yield Finding(
            "dimension", "error", "certain", (f"{formula.table.name}, {formula.left}",), printed,
            "another unit or formula", f"{formula.text}: {fault}", {name: list(p) for name, p in powers.items()},
        )  # fmt: skip
