"""A table against the formulas that its file declares: cells that do not follow, and the slip that explains them."""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from lwr_dyn.audit.lint.arithmetic import name_of, names_in, parsed, value_of
from lwr_dyn.audit.lint.dimensions import Powers, Unit, UnlikeError, dimension_of, in_words, unit_of
from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.roles import plain_name
from lwr_dyn.audit.lint.sheet import Column, Sheet, Table, TableError
from lwr_dyn.papers.printed_number import PrintedNumber, power_of_ten

FORM = "NAME = numbers, names, + - * / ^ and functions such as sqrt, sin, hypot"


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell that a formula gives: what it prints, what the formula makes of the other cells, and their rounding."""

    place: str
    row: int
    printed: PrintedNumber
    value: float
    slack: float

    @property
    def follows(self) -> bool:
        """It prints what the formula gives, or the formula gives nothing there."""
        return math.isnan(self.value) or self.printed.meets(self.value, self.slack)


@dataclass(frozen=True, slots=True)
class Formula:
    """A declared formula with the columns that its names mean."""

    text: str
    table: Table
    left: str
    target: Column
    tree: ast.expr
    names: Mapping[str, Column]

    def cells(self) -> Iterator[Cell]:
        """Every cell of the left side that prints a number, with what it should be."""
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
            yield Cell(place, i, printed, exact / scales[self.left], slack)

    def scales(self) -> dict[str, float]:
        """Factor to SI of every name when all have units, else 1: then the formula is taken in the printed units."""
        columns = {self.left: self.target, **self.names}
        units = {name: unit_of(c.unit) if c.unit else None for name, c in columns.items()}
        known = {name: unit.factor for name, unit in units.items() if unit is not None}
        return known if len(known) == len(columns) else dict.fromkeys(columns, 1.0)


def formulas_of(sheet: Sheet) -> Iterator[Formula]:
    """The declared formulas; raises `TableError` for one that cannot be read."""
    for table in sheet.tables:
        for text in table.declared.formulas:
            yield _formula(sheet, table, text)


def _formula(sheet: Sheet, table: Table, text: str) -> Formula:
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


def _named(sheet: Sheet, table: Table, name: str, text: str) -> Column:
    """The column or single value of a name, looked for in the table first."""
    known: dict[str, Column] = {}
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
    found = list(formulas_of(sheet))
    for formula in found:
        yield from _dimensions(sheet.file, formula)
    cells = [(f, c) for f in found for c in f.cells()]
    wrong = [(f, c) for f, c in cells if not c.follows]
    told: set[str] = set()
    for (f, a), (g, b) in itertools.combinations(wrong, 2):
        if a.printed.meets(b.value, b.slack) and b.printed.meets(a.value, a.slack):
            told |= {a.place, b.place}
            yield _swapped(sheet.file, f, g, a, b)
    for formula in found:
        yield from _shifted(sheet.file, formula, [c for f, c in wrong if f is formula], told)
    for f, c in wrong:
        if c.place not in told:
            yield _off(sheet.file, f, c)


def _swapped(file: str, f: Formula, g: Formula, a: Cell, b: Cell) -> Finding:
    laws = f.text if f.text == g.text else f"{f.text} and {g.text}"
    return Finding(
        "swapped", "error", "certain", file, a.place, (a.place, b.place), f"{a.printed.text}, {b.printed.text}",
        f"{b.printed.text}, {a.printed.text}", f"{a.place} prints {a.printed.text} where {a.value:.6g} follows, "
        f"{b.place} prints {b.printed.text} where {b.value:.6g} follows ({laws}): the two are exchanged",
        {a.place: a.value, b.place: b.value},
    )  # fmt: skip


def _shifted(file: str, formula: Formula, wrong: Sequence[Cell], told: set[str]) -> Iterator[Finding]:
    """Three rows or more that print what the formula gives one row above or below."""
    values = {c.row: c for c in formula.cells()}
    for step in (1, -1):
        moved = [c for c in wrong if (o := values.get(c.row - step)) and c.printed.meets(o.value, o.slack)]
        if len(moved) < 3 or len(moved) < len(wrong) - 1 or told & {c.place for c in moved}:
            continue
        told |= {c.place for c in wrong}
        cells = tuple(c.place for c in moved)
        yield Finding(
            "rows-shifted", "error", "certain", file, cells[0], cells, ", ".join(c.printed.text for c in moved),
            ", ".join(f"{c.value:.6g}" for c in moved), f"{len(moved)} rows of {formula.left} print what "
            f"{formula.text} gives one row {'above' if step == 1 else 'below'}: they are shifted", {"shift": step},
        )  # fmt: skip


def _off(file: str, formula: Formula, cell: Cell) -> Finding:
    power = power_of_ten(cell.value, cell.printed, cell.slack)
    rule, how = "formula", f"off by {cell.printed.value - cell.value:.3g}"
    if power:
        rule, how = "power-of-ten", f"off by 1e{power}"
    elif cell.printed.meets(-cell.value, cell.slack):
        rule, how = "sign", "the sign is the other one"
    return Finding(
        rule, "error", "certain", file, cell.place, (cell.place,), cell.printed.text, f"{cell.value:.6g}",
        f"prints {cell.printed.text} where {formula.text} gives {cell.value:.6g}: {how}", {"value": cell.value},
    )  # fmt: skip


def _dimensions(file: str, formula: Formula) -> Iterator[Finding]:
    """The two sides of a formula have different dimensions, or it adds unlike things."""
    columns = {formula.left: formula.target, **formula.names}
    units: dict[str, Unit] = {name: u for name, c in columns.items() if c.unit and (u := unit_of(c.unit)) is not None}
    if len(units) < len(columns):
        return
    powers: dict[str, Powers] = {name: u.without_angle for name, u in units.items()}
    place, left = f"{formula.table.name}, {formula.left}", powers[formula.left]
    try:
        right = dimension_of(formula.tree, powers)
        fault = "" if right in (None, left) else f"{in_words(left)} on the left, {in_words(right or left)} on the right"
    except UnlikeError as found:
        fault = str(found)
    if fault:
        printed = ", ".join(f"{name} [{c.unit}]" for name, c in columns.items())
        yield Finding(
            "dimension", "error", "certain", file, place, (place,), printed, "another unit or formula",
            f"{formula.text}: {fault}", {name: list(p) for name, p in powers.items()},
        )  # fmt: skip
