"""A table against a log: what each cell would be if it alone were wrong; its slips as document and card of a page."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, TypedDict, get_args

import numpy as np

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.number_text import short
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips import printed_cells
from lwr_dyn.identification.slips.hypotheses import Hypothesis, as_printed, free_cells, log_evidence
from lwr_dyn.identification.slips.printed_cells import Cell, PrintedCells
from lwr_dyn.identification.slips.repairs import Repair, SlipKind
from lwr_dyn.identification.slips.trace import DEVIATION, SlipReport, checked_deviation
from lwr_dyn.model.arm import Arm

State = Literal["agrees", "off", "no motion shows it", "hardly shown by this log"]
"""Of a cell."""
AGREES, OFF, HIDDEN, FAINT = get_args(State)
PULL = 3.0
"""Sigmas beyond which a cell is off."""
OTHERS = 4
"""Other repairs that are named beside the likeliest."""
FAR = 10.0
"""Sigmas at which a cell is darkest."""
_SHADE = 0.55
"""Darkness of a cell that is `FAR` sigmas off and more."""
_REPAIRS = 12
"""Explanations that are listed."""


@dataclass(frozen=True, slots=True)
class CellAgainstLog:
    """A printed cell [SI] and the value with which it alone would meet the log best."""

    cell: Cell
    printed: float
    value: float
    """NaN where no motion shows the cell."""
    sigma: float
    """Of that value, the arm's own distance from a right table in it; infinite where no motion shows the cell."""
    pull: float
    """(value - printed)/sigma; 0 where no motion shows the cell."""
    left: float
    """chi^2 that is left with that value."""
    state: State
    """One of `AGREES`, `OFF`, `HIDDEN`, `FAINT` (sigma is larger than the printed number)."""
    like: tuple[Cell, ...]
    """Other cells that no motion distinguishes from this one."""


def table_against_log(
    information: Information, source: Paper | Arm, *, deviation: float = DEVIATION, at: Hypothesis | None = None
) -> tuple[CellAgainstLog, ...]:
    """Every printed cell of a table, in its order.

    A large slip somewhere pulls at many cells: read the pulls of a table with slips after its repair (`at`).

    Parameters
    ----------
    information, source, deviation
        As `trace_slips` takes them.
    at : Hypothesis, optional
        A repaired table of the same source, of a `SlipReport`; the table as printed if not given.

    Raises
    ------
    OptionError
        As `trace_slips`.
    """
    table = printed_cells.printed_cells(source) if at is None else at.table
    log = log_evidence(information, table, checked_deviation(deviation))
    shown = printed_cells.shown_cells(information, table)
    # cells of a repair that were freed count as the others do
    free = free_cells(as_printed(log, table), table.cells)
    rows = []
    for cell, *numbers in zip(table.cells, *free, strict=True):
        (step, sigma, left), printed = map(float, numbers), table.value(cell)
        if cell in shown.hidden or not np.isfinite(sigma):
            value, sigma, pull, state = float("nan"), float("inf"), 0.0, HIDDEN
        else:
            value, pull = printed + step, step / sigma
            state = OFF if abs(pull) > PULL else FAINT if sigma > abs(printed) else AGREES
        like = tuple(c for c in shown.like(cell) if c != cell)
        rows.append(CellAgainstLog(cell, printed, value, sigma, pull, left, state, like))
    return tuple(rows)


class RepairRecord(TypedDict):
    """A repair of a table."""

    kind: Annotated[SlipKind, "Of the slip."]
    cells: Annotated[list[str], "Cells that it touches: m1, c1x, I1xx, rotor1, ..."]
    text: Annotated[str, "What is done."]
    errata: Annotated[list[str], "Errata of the paper, not applied by the reading, that patch the same cells."]


class ExplanationRecord(TypedDict):
    """Repairs with which a table meets the logs."""

    repairs: Annotated[list[RepairRecord], "All of them together."]
    chi2: Annotated[float, "With them."]
    evidence: Annotated[float, "-2 log p up to a constant."]


class AgainstLogRecord(TypedDict):
    """A cell against the logs."""

    cell: Annotated[str, "m1, c1x, I1xx, rotor1, ..."]
    printed: Annotated[float, "SI."]
    value: Annotated[float | None, "With which the cell alone would meet the log best; null where no motion shows it."]
    sigma: Annotated[float | None, "Of that value, the arm's own distance from its table in it."]
    pull: Annotated[float, "(value - printed) / sigma."]
    state: Annotated[State, "Off: beyond 3 sigma."]
    like: Annotated[list[str], "Cells that no motion distinguishes from this one."]


def slip_document(
    report: SlipReport, cells: Sequence[CellAgainstLog], paper: Paper | None = None, *, robot: str = "",
    reading: str = "",
) -> Document:  # fmt: skip
    """The verdict, the repairs, every cell against the log, what have the same effect and what no motion shows.

    `cells` are those of `table_against_log` at the table that the report ends with (`best_table`). Errata of a paper
    that touch a repaired cell are named.
    """

    def records(repairs: Iterable[Repair]) -> list[RepairRecord]:
        return [{"kind": r.kind, "cells": list(r.names), "text": r.text, "errata": _errata(r, paper)} for r in repairs]

    explanations: list[ExplanationRecord] = [
        {"repairs": records(one.repairs), "chi2": one.chi2, "evidence": one.evidence} for one in report.explanations
    ]
    against: list[AgainstLogRecord] = [
        {
            "cell": c.cell.name, "printed": c.printed, "value": c.value, "sigma": c.sigma, "pull": c.pull,
            "state": c.state, "like": [other.name for other in c.like],
        }
        for c in cells
    ]  # fmt: skip
    factor, together, hidden = report.common_factor, report.shown.together, report.shown.hidden
    facts = [
        Fact("robot", robot, "Name of the robot."), Fact("reading", reading, "Its reading."),
        Fact("fits", report.fits, "Whether the table meets the logs as printed."),
        Fact("chi2", report.printed.chi2, "Of the table as printed."),
        Fact("limit", report.limit, "Largest chi2 of a table that meets the logs."),
        Fact("pull", report.pull.sigmas, "Sigmas by which the cell furthest off is off, if it alone is."),
        Fact("pull_limit", report.pull.limit, "Largest of it by chance among all cells."),
        Fact("deviation", report.deviation, "How far the arm itself may be from a right table, as a share."),
        Fact("closer", report.closer, "A smaller deviation, with which there is more to find than these repairs; null "
             "where there is not.", kind=float | None),
        Fact("common_factor", factor,
             "Of all masses and tensors, with which the table as printed meets the logs too.", kind=float | None),
        Fact("sure", records(report.sure), "Repairs that every explanation has.", kind=list[RepairRecord]),
        Fact("explanations", explanations, "The likeliest first.", kind=list[ExplanationRecord]),
        Fact("cells", against, "All that are printed.", kind=list[AgainstLogRecord]),
        Fact("same_effect", [[c.name for c in group] for group in together],
             "Groups of cells that no motion tells apart.", kind=list[list[str]]),
        Fact("shown_by_no_motion", [c.name for c in hidden], "Cells.", kind=list[str]),
    ]  # fmt: skip
    said = Note(
        f"or no cell is wrong: the table meets the log with all masses and tensors times {factor or 1.0:.3g} (a "
        "heavier arm, or torques off by that factor)",
        factor is not None,
    )
    further = report.closer or 0.0
    more = Note(
        f"an arm {report.deviation:.3g} off a right table explains what is left; one {further:.3g} off would not: "
        f"--deviation {further:.3g} looks further",
        report.closer is not None,
    )
    head = ("cell", "in the table", "the log's, if it alone is off", "sigmas off", "state", "same effect")
    table = best_table(report).table
    every = Section("Every cell", [
        Table("", head, [_row(c, table) for c in cells if c.state != HIDDEN]),
        Note(f"one effect on all motions: {_groups(together)}", bool(together)),
        Note(f"no motion shows: {_names(hidden)}", bool(hidden)),
    ])  # fmt: skip
    sections = [Section("", [Note(_repairs(report, paper)), more, said]), every]
    return Document(
        "A table against logs", _verdict(report), sections, "lwr-dyn identify table", facts=facts, caveats=()
    )


def best_table(report: SlipReport) -> Hypothesis:
    """The likeliest explanation, or the table as printed."""
    return report.explanations[0] if report.explanations else report.printed


def _verdict(report: SlipReport) -> str:
    arm = f"itself {report.deviation:.3g} off a right table" if report.deviation else "exactly as a right table"
    cell = "" if report.pull.cell is None else f" ({report.pull.cell.name})"
    chi2 = (
        f"chi^2 {report.printed.chi2:.4g}, at most {report.limit:.4g}, furthest cell {report.pull.sigmas:.3g} sigma"
        f"{cell}, at most {report.pull.limit:.2g}, with the arm {arm}"
    )
    if report.fits:
        return f"the table meets the log: {chi2}"
    if not report.explanations:
        return f"the table does not meet the log ({chi2}), and no repairs were found with which it does"
    count = len(report.explanations[0].repairs)
    return f"the table does not meet the log ({chi2}); it does with {count} repair{'s' * (count > 1)}:"


def _repairs(report: SlipReport, paper: Paper | None) -> list[str]:
    if not report.explanations:
        return [f"nearest: {r.text}{_known(r, paper)}" for r in report.nearest.repairs] if not report.fits else []
    best, lines = report.explanations[0], []
    for k, repair in enumerate(best.repairs):
        lines.append(f"- {repair.text}{_known(repair, paper)}")
        others = list(dict.fromkeys(other.text for other in _instead(report, k)))
        lines += [f"  or {text}" for text in others[:OTHERS]]
        if len(others) > OTHERS:
            lines.append(f"  or one of {len(others) - OTHERS} more")
    lines.append(f"chi^2 with them: {best.chi2:.4g}")
    return lines


def _known(repair: Repair, paper: Paper | None) -> str:
    names = _errata(repair, paper)
    return f" (erratum {', '.join(names)})" if names else ""


def _instead(report: SlipReport, k: int) -> list[Repair]:
    """What may stand in the place of one repair of the likeliest explanation, by the other explanations."""
    best = report.explanations[0]
    rest = {key for i, key in enumerate(best.keys) if i != k}
    out = []
    for other in report.explanations[1:]:
        away = [r for r, key in other.keyed if key not in rest]
        if len(other.keys) == len(best.keys) and len(away) == 1:
            out += away
    return out


def _errata(repair: Repair, paper: Paper | None) -> list[str]:
    """Ids of a paper's errata that patch what is repaired and that its reading does not apply."""
    if paper is None:
        return []
    errata = (e for e in paper.errata_of(paper.reading.set_name) if e.id not in paper.reading.errata)
    return [e.id for e in errata if any(p.at.startswith(_places(repair)) for p in e.of_tables())]


def _places(repair: Repair) -> tuple[str, ...]:
    """Where a data file has what is repaired."""
    if repair.kind == "convention":
        products = {cell.quantity for cell in repair.cells} <= set(printed_cells.PRODUCTS)
        return ("inertial.inertia.products" if products else "inertial.inertia.about",)
    names = {"mass": "mass", "com": "com", "tensor": "inertia"}
    return tuple(
        "rotors." if c.column == "rotor" else f"inertial.{names[c.column]}.values[{c.link}]" for c in repair.cells
    )


def _row(row: CellAgainstLog, table: PrintedCells) -> tuple[str, ...]:
    value = f"{table.shown(row.cell, row.value)} +- {table.shown(row.cell, row.sigma).split()[0]}"
    printed = table.shown(row.cell, row.printed)
    return row.cell.name, printed, value, f"{row.pull:+.1f}", row.state, _names(row.like)


def _names(cells: tuple[Cell, ...]) -> str:
    return ", ".join(c.name for c in cells)


def _groups(groups: Iterable[Sequence[Cell]]) -> str:
    return ", ".join(" = ".join(c.name for c in group) for group in groups)


def table_card(information: Information, source: Paper | Arm) -> tuple[Section, ...]:
    """The card without repairs; none for a source without inertias, and for rotors that are fitted at their motors.

    Parameters
    ----------
    information, source
        As `table_against_log` takes them.
    """
    if information.columns.transmission is not None:
        return ()
    try:
        table = printed_cells.printed_cells(source)
    except OptionError:
        return ()
    notes = ("A slip pulls at many cells; lwr-dyn identify table looks for the repairs that explain them.",)
    return (_section(table_against_log(information, source), table, DEVIATION, (), notes),)


def slips_card(information: Information, source: Paper | Arm, slips: SlipReport) -> Section:
    """The card with the repairs that were found, and the cells before and after the likeliest of them."""
    cells = table_against_log(information, source, deviation=slips.deviation)
    chi2 = f"chi squared {short(slips.printed.chi2)}, at most {short(slips.limit)}"
    said, first = f"The table does not meet the logs ({chi2}), and no repairs were found with which it does.", []
    if slips.fits:
        said = f"The table meets the logs as printed ({chi2})."
    if slips.explanations:
        said = f"The table does not meet the logs ({chi2}); it does with the repairs of any one explanation."
        best = slips.explanations[0]
        rows = [(str(k), "; ".join(repair.text for repair in one.repairs), float(one.chi2))
                for k, one in enumerate(slips.explanations[:_REPAIRS], 1)]  # fmt: skip
        headings = (Heading("explanation"), Heading("repairs"), Heading("chi squared", "", ".4g"))
        first = [Table("Repairs with which the table meets the logs, the likeliest first", headings, rows)]
        after = table_against_log(information, source, deviation=slips.deviation, at=best)
        first.append(cell_map(after, best.table, "Sigmas off, after the repairs of explanation 1"))
    return _section(cells, slips.printed.table, slips.deviation, first, (said,))


def _section(
    cells: Sequence[CellAgainstLog], table: PrintedCells, deviation: float, first: Sequence[Table], said: Sequence[str]
) -> Section:
    off = [one for one in cells if one.state == OFF]
    tables = [*first, cell_map(cells, table, "Sigmas off, as printed")]
    tables += [_cells(off, table)] if off else []
    notes = [
        *said,
        "Sigmas by which each cell alone would have to change for the logs, with the arm itself "
        f"{100 * deviation:.3g} % off a right table; off: beyond {PULL:g}. A dot: no motion shows the cell; empty: the "
        f"source does not print it. {sum(one.state == AGREES for one in cells)} of {len(cells)} cells agree.",
    ]
    groups = {tuple(sorted((one.cell, *one.like))) for one in cells if one.like and one.state != HIDDEN}
    notes += [f"No motion tells apart: {_groups(sorted(groups))}."] if groups else []
    return Section("The table against the logs, cell by cell", [*tables, Note(notes)], page=True)


def cell_map(cells: Sequence[CellAgainstLog], table: PrintedCells, title: str) -> Table:
    """Links by rows, quantities by columns: sigmas off, darker the farther off; a dot where no motion shows a cell."""
    found = {one.cell: one for one in cells}
    quantities = printed_cells.QUANTITIES
    rows = [(f"{i + 1}", *(found.get(Cell(i, k)) for k in range(len(quantities)))) for i in range(table.n)]
    return Table(title, (Heading("link"), *(Heading(name, "", _pull, shade=_shade) for name in quantities)), rows)


def _pull(one: CellAgainstLog) -> str:
    return "\u00b7" if one.state == HIDDEN else short(round(one.pull, 1) + 0.0, 3)


def _shade(one: CellAgainstLog | None) -> float:
    return 0.0 if one is None or one.state != OFF else _SHADE * min(abs(one.pull), FAR) / FAR


def _cells(cells: Sequence[CellAgainstLog], table: PrintedCells) -> Table:
    rows = []
    for one in sorted(cells, key=lambda one: -abs(one.pull)):
        numbers = (table.shown(one.cell, x) for x in (one.printed, one.value, one.sigma))
        rows.append((one.cell.name, *numbers, one.pull, _names(one.like)))
    headings = (
        Heading("cell"), Heading("printed"), Heading("by the log, if it alone is off"), Heading("sigma"),
        Heading("sigmas off", "", ".3g"), Heading("same effect"),
    )  # fmt: skip
    return Table("Cells that are off, as printed", headings, rows)
