"""The contents of a file of numbers, whatever its format: tables of printed cells, matrices, sentences; findings."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from lwr_dyn.foundation.errors import FaultError
from lwr_dyn.model.printed_number import PrintedNumber, printed_number

Severity = Literal["error", "warning", "note"]
"""An error cannot be right, a warning is most likely wrong, a note only states how a table was read."""
Confidence = Literal["certain", "likely", "possible"]


class TableError(FaultError, ValueError):
    """A file of tables cannot be read: which `file` and which `place` in it."""

    def __init__(self, file: str, place: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {place}", found, allowed)
        self.file, self.place = file, place


@dataclass(frozen=True, slots=True)
class SheetColumn:
    """One column: its heading, its cells as printed, its unit if any, the number in each cell."""

    name: str
    cells: tuple[str, ...]
    unit: str = ""
    group: str = ""
    """The vector or matrix that it is a component of."""
    numbers: tuple[PrintedNumber | None, ...] = field(init=False)
    """One per cell, None where it prints no number."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "numbers", tuple(printed_number(cell) for cell in self.cells))

    @property
    def numeric(self) -> bool:
        """At least half of its cells print numbers."""
        return 2 * sum(n is not None for n in self.numbers) >= len(self.cells) > 0


@dataclass(frozen=True, slots=True)
class Declared:
    """What a file declares of a table, in place of guesses; all optional."""

    formulas: tuple[str, ...] = ()
    """ "Kp = omega_n^2 * b" over the rows; names are columns or single values, of this table or as "table.name"."""
    ratios: tuple[str, ...] = ()
    """ "Kp / Kd", the same in every row."""
    totals: Mapping[str, str] = field(default_factory=dict)
    """Column -> the sum that is printed."""
    roles: Mapping[str, str] = field(default_factory=dict)
    """Column -> mean, mean_abs, max, min, rms, label."""
    joints: str = ""
    """ "revolute" or "prismatic": the kind of the joints in the rows."""
    symmetric: tuple[str, ...] = ()
    """Names of symmetric matrices."""


@dataclass(frozen=True, slots=True)
class SheetTable:
    """Columns whose rows belong together, single values beside them, and what is declared."""

    name: str
    columns: tuple[SheetColumn, ...]
    values: Mapping[str, SheetColumn] = field(default_factory=dict)
    """Single values by name, as columns of one cell."""
    where: str = ""
    declared: Declared = field(default_factory=Declared)
    labels: tuple[str, ...] = ()
    """Names of the rows, where the file gives them beside the table."""

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.columns[0].cells) if self.columns else 0

    def place(self, row: int, column: str) -> str:
        """A cell in words, rows counted from 1 as papers do."""
        return f"{self.name}, row {row + 1}, {column}"


@dataclass(frozen=True, slots=True)
class SheetMatrix:
    """A square matrix as printed."""

    name: str
    cells: tuple[tuple[str, ...], ...]
    symmetric: bool
    """Its name or a declaration requires it to be symmetric."""


@dataclass(frozen=True, slots=True)
class Sentence:
    """A text of the file, which may contain arithmetic."""

    place: str
    text: str


@dataclass(frozen=True, slots=True)
class Sheet:
    """The whole file."""

    file: str
    tables: tuple[SheetTable, ...]
    matrices: tuple[SheetMatrix, ...] = ()
    sentences: tuple[Sentence, ...] = ()
    errata: Mapping[str, str] = field(default_factory=dict)
    """Start of a place's name -> the erratum of the file that is about it."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A suspected fault: the cells, what they print, what is expected instead, and the numbers that show it."""

    rule: str
    severity: Severity
    confidence: Confidence
    cells: tuple[str, ...]
    """All cells that it is about: table, row (from 1), column."""
    printed: str
    suspected: str
    sentence: str
    numbers: Mapping[str, Any] = field(default_factory=dict)
    where: str = ""
    """The place in words; the first cell if empty."""
    file: str = ""
    known: tuple[str, ...] = ()
    """Errata of the file that are about these cells."""

    @property
    def place(self) -> str:
        """The place in words."""
        return self.where or self.cells[0]

    @property
    def counts(self) -> bool:
        """It makes the file fail."""
        return self.severity != "note"

    def line(self) -> str:
        """As text: file:place: severity rule: sentence."""
        known = f" [erratum {', '.join(self.known)}]" if self.known else ""
        return f"{self.file}:{self.place}: {self.severity} {self.rule}: {self.sentence}{known}"

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "rule": self.rule, "severity": self.severity, "sure": self.confidence, "file": self.file,
            "place": self.place, "cells": list(self.cells), "printed": self.printed, "suspected": self.suspected,
            "sentence": self.sentence, "numbers": dict(self.numbers), "known": list(self.known),
        }  # fmt: skip
