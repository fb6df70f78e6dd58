"""The content of a report page as plain records, without HTML.

All text is plain: the page escapes it. Line breaks are kept in proofs, `ReportSection.text` and notes.
"""

from dataclasses import dataclass
from typing import Literal, get_args

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.pages.figures.figure import Figure
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.reproduction.case import LedgerEntry

CellVerdict = Literal[
    "reproduced", "after erratum", "differs", "structural", "repeated in print", "under assumed conditions",
    "not reproducible", "",
]  # fmt: skip
"""The class in which a printed number is counted (`ComparedNumber.outcome`); "" for a cell that is only shown."""
VERDICTS: tuple[CellVerdict, ...] = get_args(CellVerdict)[:-1]
Fact = tuple[str, str]
"""A name and its text."""


@dataclass(frozen=True, slots=True, eq=False)
class ReportCell:
    """One printed number beside ours; `source`, `formula` and `conversion` are shown when it is pointed at.

    `errata` are ids of the page's errata; an id that is not on the page is shown without a link.
    """

    printed: str
    ours: str = ""
    verdict: CellVerdict = ""
    source: str = ""
    formula: str = ""
    conversion: str = ""
    note: str = ""
    errata: tuple[str, ...] = ()
    digits: float | None = None
    """Ours less printed, in units of the last printed digit."""
    near: bool | None = None
    """Of a number under assumed conditions: whether ours is near."""

    def __post_init__(self) -> None:
        if self.verdict not in (*VERDICTS, ""):
            raise OptionError("verdict", repr(self.verdict), ", ".join(VERDICTS))


@dataclass(frozen=True, slots=True, eq=False)
class ReportRow:
    """A row of a table: its label and a cell per column."""

    label: str
    cells: tuple[ReportCell, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ReportTable:
    """A table of the document with our numbers; `columns` head the cells."""

    id: str
    title: str
    where: str
    columns: tuple[str, ...]
    rows: tuple[ReportRow, ...]
    unit: str = ""
    note: str = ""

    @property
    def lines(self) -> tuple[tuple[str, ReportCell], ...]:
        """Every cell with its place: the row's label, and the column's where there are several."""
        several = len(self.columns) > 1
        return tuple(
            (f"{row.label}, {column}" if several else row.label, cell)
            for row in self.rows
            for column, cell in zip(self.columns, row.cells, strict=True)
        )

    @property
    def verdict_cells(self) -> tuple[ReportCell, ...]:
        """The cells that have a verdict, row by row."""
        return tuple(cell for row in self.rows for cell in row.cells if cell.verdict)

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row.cells) != len(self.columns):
                where = f"table {self.id}, row {row.label!r}"
                raise OptionError(where, f"{len(row.cells)} cells", f"{len(self.columns)}, one a column")


@dataclass(frozen=True, slots=True, eq=False)
class Still:
    """An arm at rest at q (n,) [rad or m], shown with its DH frames, as a figure of the document."""

    label: str
    arm: Arm
    q: Array
    note: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Replay:
    """The 3D view: runs, and still poses; either may be empty, not both."""

    runs: tuple[ReplayedRun, ...] = ()
    stills: tuple[Still, ...] = ()

    def __post_init__(self) -> None:
        if not (self.runs or self.stills):
            raise OptionError("replay", "no run and no still", "at least one of either")


@dataclass(frozen=True, slots=True)
class Check:
    """An identity, an agreement or an audit: a value against what is allowed, both as text with their unit."""

    name: str
    value: str
    allowed: str
    holds: bool
    note: str = ""
    is_expected: bool = False
    """Whether a failure is the expected outcome: so of a reading whose models errata of the paper spoil."""


@dataclass(frozen=True, slots=True, eq=False)
class ReportSection:
    """A further part of the page: text, tables, figures; the navigation lists it under its title."""

    id: str
    title: str
    text: str = ""
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()


@dataclass(frozen=True, slots=True)
class FileFact:
    """A file beside the report or behind it."""

    name: str
    size: int
    sha256: str
    what: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Page:
    """A whole report; empty parts are left out of the page.

    `verdict` is the outcome in pieces of text, each with whether it stands out; `words` says how it is counted;
    `derived` are tables of numbers that the paper does not print. Ids of tables, errata, figures and
    sections are unique on a page.
    """

    title: str
    subtitle: str = ""
    byline: str = ""
    verdict: tuple[tuple[str, bool], ...] = ()
    words: str = ""
    document: tuple[Fact, ...] = ()
    tables: tuple[ReportTable, ...] = ()
    derived: tuple[ReportTable, ...] = ()
    errata: tuple[LedgerEntry, ...] = ()
    figures: tuple[Figure, ...] = ()
    replay: Replay | None = None
    checks: tuple[Check, ...] = ()
    audit: tuple[Check, ...] = ()
    sections: tuple[ReportSection, ...] = ()
    files: tuple[FileFact, ...] = ()
    versions: tuple[Fact, ...] = ()

    def __post_init__(self) -> None:
        ids = [one.id for one in (*self.tables, *self.derived)]
        ids += [one.erratum.id for one in self.errata] + [one.id for one in self.sections]
        ids += [one.id for one in self.all_figures]
        twice = sorted({one for one in ids if ids.count(one) > 1})
        if twice:
            raise OptionError("ids of a page", f"{', '.join(twice)} more than once", "unique ids")

    @property
    def all_figures(self) -> tuple[Figure, ...]:
        """In their order on the page: beside the replay, then section by section."""
        return (*self.figures, *(figure for section in self.sections for figure in section.figures))

    @property
    def counted(self) -> dict[CellVerdict, int]:
        """How many printed numbers got each verdict."""
        given = [cell.verdict for table in self.tables for cell in table.verdict_cells]
        return {verdict: given.count(verdict) for verdict in VERDICTS}
