"""The slips that hands make in tables of inertias, undone: every table that one repair of a given one yields.

A cell: sign, powers of ten (1000: a unit). A rotor: gear ratio forgotten or counted twice. Cells that changed places:
`exchanges`. A column: its unit, its sign, the point its tensors are about, the sign of its products.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.slips.printed_cells import (
    COM,
    DIAGONAL,
    MASS,
    PRODUCTS,
    QUANTITIES,
    ROTOR,
    TENSOR,
    Cell,
    PrintedCells,
)

SIGN, POWER, POWERS_APART, UNIT, GEAR = "sign", "power of ten", "two powers of ten", "unit", "gear ratio"
COLUMN, EXCHANGE, AXES, ROWS, COPY, VALUE, CONVENTION = (
    "column",
    "exchange",
    "axes",
    "rows",
    "copy",
    "value",
    "convention",
)
"""Kinds of slips."""
POWERS = {10.0: POWER, 0.1: POWER, 100.0: POWERS_APART, 0.01: POWERS_APART, 1e3: UNIT, 1e-3: UNIT}
"""Factors of one cell."""
COLUMN_FACTORS = {"mass": (1e3, 1e-3), "com": (1e3, 1e2, 10.0, 0.1, 1e-2, 1e-3),
                  "tensor": (1e9, 1e7, 1e6, 1e4, 1e3, 10.0, 0.1, 1e-3, 1e-4, 1e-6, 1e-7, 1e-9),
                  "rotor": (1e6, 1e4, 1e3, 1e2, 10.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-6)}  # fmt: skip
"""Of a whole column: units of its quantity (kg mm^2, g cm^2, ...) and a slipped point."""
COLUMNS = {"mass": slice(MASS, MASS + 1), "com": COM, "tensor": TENSOR, "rotor": slice(ROTOR, ROTOR + 1)}
SAME = 1e-6
"""Share by which two printed numbers may differ and one be a copy of the other, its last digits cut."""


@dataclass(frozen=True, slots=True, eq=False)
class Repair:
    """One change of a table: its kind, the cells it touches, what it says, and the table afterwards."""

    kind: str
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
        if cell.quantity not in (MASS, ROTOR):
            yield _cell(table, cell, -1.0, SIGN)
        for factor, kind in POWERS.items():
            yield _cell(table, cell, factor, kind)
        ratio = float(np.sqrt(table.rotor_factor[cell.link]))
        if cell.quantity == ROTOR and ratio not in (0.0, 1.0):
            for factor in (ratio, 1.0 / ratio, ratio**2, ratio**-2):
                yield _cell(table, cell, factor, GEAR)


def _cell(table: PrintedCells, cell: Cell, factor: float, kind: str) -> Repair:
    value = factor * table.value(cell)
    text = f"{cell.name} = {table.shown(cell, value)}, printed {table.shown(cell)}"
    again = partial(_cell, cell=cell, factor=factor, kind=kind)
    return Repair(kind, (cell,), text, table.with_cell(cell, value), again)


def of_columns(table: PrintedCells) -> Iterator[Repair]:
    """A column, or a link's part of it, in another unit, of another sign, about another point."""
    every = np.ones(table.n, dtype=bool)
    for name, factors in COLUMN_FACTORS.items():
        for factor in factors:
            yield _scaled(table, every, name, factor, COLUMN)
    yield _scaled(table, every, "com", -1.0, SIGN)
    links = [every, *(np.arange(table.n) == i for i in range(table.n))]
    for rows in links:
        yield _turned(table, rows, "about_origin", TENSOR)
        yield _turned(table, rows, "integral", PRODUCTS)
    for rows in links[1:]:
        yield _scaled(table, rows, "com", -1.0, SIGN)


def _of_links(rows: Array) -> str:
    return "all links" if rows.all() else f"link {int(np.flatnonzero(rows)[0]) + 1}"


def _cells(table: PrintedCells, rows: Array, quantities: tuple[int, ...]) -> tuple[Cell, ...]:
    return tuple(c for c in table.cells if rows[c.link] and c.quantity in quantities)


def _scaled(table: PrintedCells, rows: Array, column: str, factor: float, kind: str) -> Repair:
    values, places = table.values.copy(), COLUMNS[column]
    values[rows, places] *= factor
    cells = _cells(table, rows, tuple(range(len(QUANTITIES))[places]))
    text = f"{column} of {_of_links(rows)} times {factor:g}"
    again = partial(_scaled, rows=rows, column=column, factor=factor, kind=kind)
    return Repair(kind, cells, text, table.with_values(values), again)


def _turned(table: PrintedCells, rows: Array, flag: str, quantities: slice | tuple[int, ...]) -> Repair:
    """The tensor of some links about the other point, or its products of the other sign."""
    now = getattr(table, flag)
    turned = np.where(rows, ~now, now)
    if flag == "integral":
        changed, text = replace(table, integral=turned), f"products of inertia of {_of_links(rows)} of the other sign"
    else:
        point = "centre of mass" if now[rows].all() else "link's origin"
        changed, text = replace(table, about_origin=turned), f"tensor of {_of_links(rows)} about the {point}"
    wanted = quantities if isinstance(quantities, tuple) else tuple(range(len(QUANTITIES))[quantities])
    again = partial(_turned, rows=rows, flag=flag, quantities=quantities)
    kind = CONVENTION if rows.all() else SIGN if flag == "integral" else ROWS
    return Repair(kind, _cells(table, rows, wanted), text, changed, again)


def possible(table: PrintedCells, before: PrintedCells) -> bool:
    """Whether no mass, rotor or diagonal moment is negative that was not before."""
    places = [MASS, ROTOR, *DIAGONAL]
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
