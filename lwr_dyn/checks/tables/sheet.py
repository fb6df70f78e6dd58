"""The contents of a file of numbers, whatever its format: tables of printed cells, matrices, sentences; findings.

The heading of a column gives its role (mean, maximum, minimum, label, and of which quantity), its name and unit. A CSV
has one heading line; its lines that begin with # declare formulas, units and roles.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, TypedDict

from lwr_dyn.foundation.errors import FaultError
from lwr_dyn.model.printed_number import PrintedNumber, printed_number

ROLES: dict[str, tuple[str, ...]] = {
    "mean": ("mean", "avg", "average", "averages"),
    "mean_abs": ("meanabs", "mae"),
    "max": ("max", "maximum", "maxima", "upper", "highest", "largest"),
    "min": ("min", "minimum", "minima", "lower", "lowest", "smallest"),
    "rms": ("rms", "rmse"),
    "label": ("joint", "joints", "link", "links", "axis", "name", "row", "no", "i", "body", "part", "configuration"),
}
"""Role -> words of a heading that name it."""

TOTALS = ("total", "sum", "totals", "overall", "all")
"""Words in a row's label that make it the sum of the rows above."""
_UNIT = re.compile(r"[\[(]([^\])]*)[\])]\s*$")


def words_of(heading: str) -> list[str]:
    """The words of a heading, lower case, without its unit.

    >>> words_of("Avg. Pos. Error (mm)"), words_of("velocityMaximum")
    (['avg', 'pos', 'error'], ['velocity', 'maximum'])
    """
    bare = re.sub(r"([a-z])([A-Z])", r"\1 \2", _UNIT.sub("", heading))
    return re.findall(r"[a-z]+|\d+", bare.lower())


def unit_in(heading: str) -> str:
    """The unit in brackets at the end of a heading.

    >>> unit_in("Mass [kg]"), unit_in("Kp")
    ('kg', '')
    """
    match = _UNIT.search(heading.strip())
    return match.group(1).strip() if match else ""


def name_in(heading: str) -> str:
    """The heading without its unit.

    >>> name_in("Avg. Pos. Error (mm)")
    'Avg. Pos. Error'
    """
    return _UNIT.sub("", heading).strip() or heading


def plain_name(name: str) -> str:
    """A name that a formula can use.

    >>> plain_name("Avg. Pos. Error"), plain_name("K_P")
    ('Avg_Pos_Error', 'K_P')
    """
    return re.sub(r"\W+", "_", name).strip("_")


def role_of(heading: str, declared: Mapping[str, str]) -> str:
    """The declared role, or that of the first word that has one; "" without any.

    >>> role_of("velocity_average", {}), role_of("Kp", {})
    ('mean', '')
    """
    if heading in declared:
        return declared[heading]
    words = words_of(heading)
    return next((role for word in words for role, known in ROLES.items() if word in known), "")


def stem_of(heading: str) -> tuple[str, ...]:
    """The heading without its role: columns of one stem are statistics of one quantity.

    >>> stem_of("velocity_average") == stem_of("velocity_minimum"), stem_of("average")
    (True, ())
    """
    known = {word for role, words in ROLES.items() if role != "label" for word in words}
    return tuple(w for w in words_of(heading) if w not in known)


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


class SheetRecord(TypedDict):
    """`Finding.record`: a suspected fault of a table, with its cells."""

    rule: str
    severity: Annotated[str, "error, warning or note."]
    sure: Annotated[str, "certain or how likely."]
    file: str
    place: Annotated[str, "In words."]
    cells: Annotated[list[str], "All cells that it is about: table, row (from 1), column."]
    printed: str
    suspected: Annotated[str, "What is expected instead."]
    sentence: str
    numbers: Annotated[dict[str, Any], "The numbers that show it."]
    known: Annotated[list[str], "Errata of the file that are about these cells."]


SEPARATORS = ",;\t|"
DECLARATIONS = ("title", "formula", "ratio", "joints", "total", "role")


def _declarations(text: str) -> dict[str, list[str]]:
    """The lines "# WORD: text" of a CSV text by their word; others are comments."""
    found: dict[str, list[str]] = {word: [] for word in DECLARATIONS}
    for line in text.splitlines():
        word, sign, rest = line.lstrip("# ").partition(":")
        if line.lstrip().startswith("#") and sign:
            found.setdefault(word.strip().lower(), []).append(rest.strip())
    return found


def _pairs(lines: Sequence[str]) -> dict[str, str]:
    """Lines such as "mass = 14.4462" as a mapping."""
    return {name_in(key.strip()): value.strip() for key, _, value in (line.partition("=") for line in lines)}


def sheet_of_csv(text: str, file: str, name: str) -> Sheet:
    """The table of a CSV text; `file` and `name` are what messages call the file and the table.

    The text is a heading line ("Joint, Mass [kg]"), then rows; separated by , ; tab or |. The lines
    "# formula: Kp = 25 * Kd", "# ratio: Kp / Kd", "# total: Mass = 14.4462", "# joints: revolute", "# role: a = mean"
    and "# title: ..." declare. A last row labelled "total" is taken as the sum. Raises `TableError` for no CSV, no
    rows, a row of another length, two columns of one name.
    """
    declared = _declarations(text)
    headings, *cells = _rows([line for line in text.splitlines() if not line.lstrip().startswith("#")], file)
    bare = [name_in(h) for h in headings]
    head = [name if bare.count(name) == 1 else heading for name, heading in zip(bare, headings, strict=True)]
    roles = _pairs(declared["role"])
    labels = [j for j, h in enumerate(head) if role_of(h, roles) == "label"] or [0]
    summed = len(cells) > 2 and any(set(words_of(cells[-1][j])) & set(TOTALS) for j in labels)
    body_rows = cells[:-1] if summed else cells
    columns = tuple(
        SheetColumn(name, tuple(row[j] for row in body_rows), unit_in(heading))
        for j, (name, heading) in enumerate(zip(head, headings, strict=True))
    )
    sums = {h: cell for h, cell, c in zip(head, cells[-1], columns, strict=True) if summed and c.numeric}
    declarations = Declared(
        formulas=tuple(declared["formula"]), ratios=tuple(declared["ratio"]), roles=roles,
        totals={**sums, **_pairs(declared["total"])}, joints=" ".join(declared["joints"]),
    )  # fmt: skip
    title = " ".join(declared["title"])
    table = SheetTable(name, columns, where=title, declared=declarations)
    return Sheet(file, (table,), sentences=(Sentence("title", title),))


def _rows(lines: Sequence[str], file: str) -> list[list[str]]:
    """The heading line and the rows, all of one length."""
    try:
        separator = max(SEPARATORS, key=next((line for line in lines if line.strip()), "").count)
        stripped = [[c.strip() for c in row] for row in csv.reader(lines, delimiter=separator)]
    except csv.Error as fault:
        raise TableError(file, "table", str(fault), "CSV") from None
    rows = [row for row in stripped if any(row)]
    if len(rows) < 2:
        raise TableError(file, "table", f"{len(rows)} lines", "a heading line and at least one row")
    head = rows[0]
    for i, row in enumerate(rows):
        if len(row) != len(head):
            raise TableError(file, f"row {i}", f"{len(row)} cells", f"{len(head)}, as the heading has")
    for double in (h for h in head if head.count(h) > 1):
        raise TableError(file, "heading", f"{double!r} twice", "each column once")
    return rows
