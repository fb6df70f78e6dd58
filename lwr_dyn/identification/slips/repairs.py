"""The slips that hands make in tables of inertias, undone: every table that one repair of a given one yields.

A cell: sign, powers of ten (1000: a unit). A rotor: gear ratio forgotten or counted twice. A column: its unit, its
sign, the point its tensors are about, the sign of its products. Cells that changed places: components, axes, moments of
one link; cells, rows and bodies of neighbouring links.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations
from typing import Literal

import numpy as np

from lwr_dyn.dynamics.regressor import ROW_BY_ROW
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.slips import printed_cells as printed
from lwr_dyn.identification.slips.printed_cells import Cell, PrintedCells

SlipKind = Literal[
    "sign", "power of ten", "two powers of ten", "unit", "gear ratio", "column", "exchange", "axes", "rows", "copy",
    "value", "convention",
]  # fmt: skip
"""Of a slip."""
POWERS: Mapping[float, SlipKind] = {
    10.0: "power of ten", 0.1: "power of ten", 100.0: "two powers of ten", 0.01: "two powers of ten", 1e3: "unit",
    1e-3: "unit",
}  # fmt: skip
"""Factors of one cell."""
_AXES = "xyz"
_EVERY = range(len(printed.QUANTITIES))
COLUMN_FACTORS = {"mass": (1e3, 1e-3), "com": (1e3, 1e2, 10.0, 0.1, 1e-2, 1e-3),
                  "tensor": (1e9, 1e7, 1e6, 1e4, 1e3, 10.0, 0.1, 1e-3, 1e-4, 1e-6, 1e-7, 1e-9),
                  "rotor": (1e6, 1e4, 1e3, 1e2, 10.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-6)}  # fmt: skip
"""Of a whole column: units of its quantity (kg mm^2, g cm^2, ...) and a slipped point."""
APART = 2
"""Rows that a cell may have slipped."""
SAME = 1e-6
"""Share by which two printed numbers may differ and one be a copy of the other, its last digits cut."""


@dataclass(frozen=True, slots=True, eq=False)
class Repair:
    """One change of a table: its kind, the cells it touches, what it says, and the table afterwards."""

    kind: SlipKind
    cells: tuple[Cell, ...]
    text: str
    table: PrintedCells
    again: Callable[[PrintedCells], "Repair"] = field(repr=False)
    """The same repair of another table."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of its cells."""
        return tuple(cell.name for cell in self.cells)


def of_cells(table: PrintedCells) -> Iterator[Repair]:
    """One cell with another sign or power of ten."""
    for cell in table.cells:
        if table.value(cell) == 0.0:
            continue
        if cell.quantity not in (printed.MASS, printed.ROTOR):
            yield _cell(table, cell, -1.0, "sign")
        for factor, kind in POWERS.items():
            yield _cell(table, cell, factor, kind)
        ratio = float(np.sqrt(table.rotor_factor[cell.link]))
        if cell.quantity == printed.ROTOR and ratio not in (0.0, 1.0):
            for factor in (ratio, 1.0 / ratio, ratio**2, ratio**-2):
                yield _cell(table, cell, factor, "gear ratio")


def _cell(table: PrintedCells, cell: Cell, factor: float, kind: SlipKind) -> Repair:
    value = factor * table.value(cell)
    text = f"{cell.name} = {table.shown(cell, value)}, printed {table.shown(cell)}"
    again = partial(_cell, cell=cell, factor=factor, kind=kind)
    return Repair(kind, (cell,), text, table.with_cell(cell, value), again)


def of_columns(table: PrintedCells) -> Iterator[Repair]:
    """A column, or a link's part of it, in another unit, of another sign, about another point."""
    every = np.ones(table.n, dtype=bool)
    for name, factors in COLUMN_FACTORS.items():
        for factor in factors:
            yield _scaled(table, every, name, factor, "column")
    yield _scaled(table, every, "com", -1.0, "sign")
    links = [every, *(np.arange(table.n) == i for i in range(table.n))]
    for rows in links:
        yield _turned(table, rows, "about_origin")
        yield _turned(table, rows, "integral")
    for rows in links[1:]:
        yield _scaled(table, rows, "com", -1.0, "sign")


def _of_links(rows: Array) -> str:
    return "all links" if rows.all() else f"link {int(np.flatnonzero(rows)[0]) + 1}"


def _cells(table: PrintedCells, rows: Array, quantities: Sequence[int]) -> tuple[Cell, ...]:
    return tuple(c for c in table.cells if rows[c.link] and c.quantity in quantities)


def _scaled(table: PrintedCells, rows: Array, column: str, factor: float, kind: SlipKind) -> Repair:
    values = table.values.copy()
    values[rows, printed.COLUMNS[column]] *= factor
    cells = _cells(table, rows, _EVERY[printed.COLUMNS[column]])
    text = f"{column} of {_of_links(rows)} times {factor:g}"
    again = partial(_scaled, rows=rows, column=column, factor=factor, kind=kind)
    return Repair(kind, cells, text, table.with_values(values), again)


def _turned(table: PrintedCells, rows: Array, flag: str) -> Repair:
    """The tensor of some links about the other point (`about_origin`), or its products of the other sign."""
    now, places = getattr(table, flag), printed.PRODUCTS if flag == "integral" else _EVERY[printed.TENSOR]
    kind: SlipKind = "sign" if flag == "integral" else "rows"
    if flag == "integral":
        text = f"products of inertia of {_of_links(rows)} of the other sign"
    else:
        point = "centre of mass" if now[rows].all() else "link's origin"
        text = f"tensor of {_of_links(rows)} about the {point}"
    changed = replace(table, **{flag: np.where(rows, ~now, now)})
    again = partial(_turned, rows=rows, flag=flag)
    return Repair("convention" if rows.all() else kind, _cells(table, rows, places), text, changed, again)


def possible(table: PrintedCells, before: PrintedCells) -> bool:
    """Whether no mass, rotor or diagonal moment is negative that was not before."""
    places = [printed.MASS, printed.ROTOR, *printed.DIAGONAL]
    return not ((table.values[:, places] < 0.0) & (before.values[:, places] >= 0.0)).any()


def repeats(table: PrintedCells, cell: Cell) -> Cell | None:
    """The cell of a neighbouring row whose number this one repeats; None where there is none, or the number is 0."""
    value = abs(table.value(cell))
    if value == 0.0:
        return None
    for link in (cell.link - 1, cell.link + 1):
        other = Cell(link, cell.quantity)
        if 0 <= link < table.n and table.known[other] and abs(abs(table.value(other)) - value) <= SAME * value:
            return other
    return None


Place = tuple[int, int]
Move = tuple[list[tuple[Place, Place]], str, SlipKind]
"""(from, to) of every place that moves, what is said of it, its kind."""


def exchanges(table: PrintedCells) -> Iterator[Repair]:
    """Every exchange of two places, or of two sets of places, that hold different numbers."""
    for places, text, kind in _permutations(table.n):
        if all(table.known[source] for source, _ in places):
            repair = _exchanged(table, places, text, kind)
            if repair.cells:
                yield repair
    for link in range(table.n):
        for axis in range(3):
            for sign in (1.0, -1.0):
                repair = _turned_com(table, link, axis, sign)
                if len(repair.cells) > 1:
                    yield repair


def _exchanged(table: PrintedCells, places: Sequence[tuple[Place, Place]], text: str, kind: SlipKind) -> Repair:
    values = table.values.copy()
    for source, target in places:
        values[target] = table.values[source]
    changed = tuple(Cell(*p) for p, _ in places if values[p] != table.values[p])
    again = partial(_exchanged, places=places, text=text, kind=kind)
    return Repair(kind, changed, text, table.with_values(values), again)


def _turned_com(table: PrintedCells, link: int, axis: int, sign: float) -> Repair:
    """The centre of mass of a link turned by 90 deg about an axis: its frame was another."""
    a, b = 1 + (axis + 1) % 3, 1 + (axis + 2) % 3
    values = table.values.copy()
    values[link, a], values[link, b] = -sign * table.values[link, b], sign * table.values[link, a]
    changed = tuple(Cell(link, k) for k in (a, b) if table.known[link, k] and values[link, k] != table.values[link, k])
    text = f"com of link {link + 1} turned by {90.0 * sign:+.0f} deg about {_AXES[axis]}"
    again = partial(_turned_com, link=link, axis=axis, sign=sign)
    return Repair("exchange", changed, text, table.with_values(values), again)


def _permutations(n: int) -> Iterator[Move]:
    for i in range(n):
        for a, b in combinations(range(3), 2):
            yield from _within(i, a, b)
        for j, k in (*combinations(printed.DIAGONAL, 2), *combinations(printed.PRODUCTS, 2)):
            yield _swap([(i, j)], [(i, k)])
    for i, j in combinations(range(n), 2):
        yield from _between(i, j)
    for name, part in printed.COLUMNS.items():
        for step in (1, -1):
            rows = [((i, k), ((i + step) % n, k)) for i in range(n) for k in _EVERY[part]]
            yield rows, f"{name}: every row belongs one {'lower' if step == 1 else 'higher'}", "rows"


def _between(i: int, j: int) -> Iterator[Move]:
    """The same cell of two links, the same part of two neighbours."""
    if j - i <= APART:
        for k in _EVERY:
            yield _swap([(i, k)], [(j, k)])
    if j - i == 1:
        for name, part in (("com", printed.COM), ("tensor", printed.TENSOR), ("row", slice(0, printed.ROTOR))):
            here, there = ([(link, k) for k in _EVERY[part]] for link in (i, j))
            yield _swap(here, there, f"{name} of links {i + 1} and {j + 1} exchanged", "rows")


def _within(i: int, a: int, b: int) -> Iterator[Move]:
    """Two axes of one link: of its centre of mass, of its tensor, of both."""
    third = 3 - a - b
    com_a, com_b = ([(i, 1 + axis)] for axis in (a, b))
    tensor_a, tensor_b = (
        [(i, 4 + ROW_BY_ROW.index((min(axis, x), max(axis, x)))) for x in (axis, third)] for axis in (a, b)
    )
    axes = f"{_AXES[a]} and {_AXES[b]}"
    yield _swap(com_a, com_b)
    yield _swap(tensor_a, tensor_b, f"axes {axes} of the tensor of link {i + 1} exchanged", "axes")
    yield _swap(com_a + tensor_a, com_b + tensor_b, f"axes {axes} of link {i + 1} exchanged", "axes")


def _swap(here: Sequence[Place], there: Sequence[Place], text: str = "", kind: SlipKind = "exchange") -> Move:
    text = text or f"{Cell(*here[0]).name} and {Cell(*there[0]).name} exchanged"
    return [*zip(here, there, strict=True), *zip(there, here, strict=True)], text, kind
