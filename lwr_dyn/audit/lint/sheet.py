"""What a file of numbers says, freed of its format: tables of printed cells, square matrices, sentences."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from lwr_dyn.errors import FaultError
from lwr_dyn.papers.printed_number import PrintedNumber, printed_number


class TableError(FaultError, ValueError):
    """A file of tables cannot be read: which `file` and which `place` in it."""

    def __init__(self, file: str, place: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {place}", found, allowed)
        self.file, self.place = file, place


@dataclass(frozen=True, slots=True)
class Column:
    """One column: its heading, its cells as printed, its unit if any, the number in each cell."""

    name: str
    cells: tuple[str, ...]
    unit: str = ""
    numbers: tuple[PrintedNumber | None, ...] = ()
    """One per cell, none where it prints no number; filled in by `column`."""
    group: str = ""
    """The vector or matrix that it is a component of."""

    @property
    def numeric(self) -> bool:
        """At least half of its cells print numbers."""
        return 2 * sum(n is not None for n in self.numbers) >= len(self.cells) > 0


def column(name: str, cells: tuple[str, ...], unit: str = "", group: str = "") -> Column:
    """A column of cells.

    >>> column("Kp", ("7310", "-")).numbers[0].value
    7310.0
    """
    return Column(name, cells, unit, tuple(printed_number(c) for c in cells), group)


@dataclass(frozen=True, slots=True)
class Declared:
    """What a file says of a table, so that nothing has to be guessed: all optional."""

    formulas: tuple[str, ...] = ()
    """ "Kp = omega_n^2 * b" over the rows; names are columns or single values, of this table or as "table.name"."""
    ratios: tuple[str, ...] = ()
    """ "Kp / Kd", the same in every row."""
    totals: Mapping[str, str] = field(default_factory=dict)
    """Column -> the sum that is printed."""
    roles: Mapping[str, str] = field(default_factory=dict)
    """Column -> mean, mean_abs, max, min, rms, label."""
    joints: str = ""
    """ "revolute" or "prismatic": what the joints of the rows are."""
    symmetric: tuple[str, ...] = ()
    """Matrices that are."""


@dataclass(frozen=True, slots=True)
class Table:
    """Columns whose rows belong together, single values beside them, and what is declared."""

    name: str
    columns: tuple[Column, ...]
    values: Mapping[str, Column] = field(default_factory=dict)
    """Single values by name, as columns of one cell."""
    where: str = ""
    declared: Declared = field(default_factory=Declared)
    labels: tuple[str, ...] = ()
    """What the rows are called, where the file says so beside the table."""

    @property
    def rows(self) -> int:
        """How many rows it has."""
        return len(self.columns[0].cells) if self.columns else 0

    def place(self, row: int, column: str) -> str:
        """A cell in words, rows counted from 1 as papers do."""
        return f"{self.name}, row {row + 1}, {column}"


@dataclass(frozen=True, slots=True)
class Matrix:
    """A square matrix as printed."""

    name: str
    cells: tuple[tuple[str, ...], ...]
    symmetric: bool
    """It is named or declared as one that has to be."""


@dataclass(frozen=True, slots=True)
class Statement:
    """A sentence of the file, where arithmetic may be written out."""

    place: str
    text: str


@dataclass(frozen=True, slots=True)
class Sheet:
    """All of a file."""

    file: str
    tables: tuple[Table, ...]
    matrices: tuple[Matrix, ...] = ()
    statements: tuple[Statement, ...] = ()
    errata: Mapping[str, str] = field(default_factory=dict)
    """How the name of a place begins -> the erratum of the file that is about it."""
