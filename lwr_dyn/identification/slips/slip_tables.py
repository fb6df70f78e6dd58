"""A table against a log, cell by cell: what each cell would be if it alone were wrong; text and record of it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.tables import Table
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips.hypotheses import Hypothesis, as_printed, free_cells, log_evidence
from lwr_dyn.identification.slips.printed_cells import (
    MASS,
    PRODUCTS,
    ROTOR,
    TENSOR,
    Cell,
    PrintedCells,
    printed_cells,
    shown_cells,
)
from lwr_dyn.identification.slips.repairs import CONVENTION, Repair
from lwr_dyn.identification.slips.trace import DEVIATION, SlipReport, checked_deviation
from lwr_dyn.model.arm import Arm

AGREES, OFF, HIDDEN, FAINT = "agrees", "off", "no motion shows it", "hardly shown by this log"
"""States of a cell."""
PULL = 3.0
"""Sigmas beyond which a cell is off."""


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
    state: str
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
    table = printed_cells(source) if at is None else at.table
    log = log_evidence(information, table, checked_deviation(deviation))
    shown = shown_cells(information, table)
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


OTHERS = 4
"""Other repairs that are named beside the likeliest."""


def slip_text(report: SlipReport, cells: tuple[CellAgainstLog, ...], paper: Paper | None = None) -> str:
    """The verdict, the repairs, every cell against the log, what have the same effect and what no motion shows.

    `cells` are those of `table_against_log` at the table that the report ends with (`best_table`). Errata of a paper
    that touch a repaired cell are named.
    """
    lines = [*slip_lines(report, paper), "", cell_table(report, cells).text()]
    if report.shown.together:
        groups = ", ".join(" = ".join(c.name for c in g) for g in report.shown.together)
        lines.append(f"one effect on all motions: {groups}")
    if report.shown.hidden:
        lines.append(f"no motion shows: {_names(report.shown.hidden)}")
    return "\n".join(lines)


def slip_lines(report: SlipReport, paper: Paper | None = None) -> tuple[str, ...]:
    """The verdict, then each repair with what may stand in its place."""
    lines = (_verdict(report), *_repairs(report, paper))
    if report.common_factor is None:
        return lines
    more = f"all masses and tensors times {report.common_factor:.3g}"
    also = f"or no cell is wrong: the table meets the log with {more} (a heavier arm, or torques off by that factor)"
    return (*lines, also)


def cell_table(report: SlipReport, cells: tuple[CellAgainstLog, ...]) -> Table:
    """A row for every cell that some motion shows."""
    head = ("cell", "in the table", "the log's, if it alone is off", "sigmas off", "state", "same effect")
    table = best_table(report).table
    return Table("", head, [_row(c, table) for c in cells if c.state != HIDDEN])


def best_table(report: SlipReport) -> Hypothesis:
    """The likeliest explanation, or the table as printed."""
    return report.explanations[0] if report.explanations else report.printed


def _verdict(report: SlipReport) -> str:
    arm = f"itself {report.deviation:.3g} off a right table" if report.deviation else "exactly as a right table"
    chi2 = f"chi^2 {report.printed.chi2:.4g}, at most {report.limit:.4g} with the arm {arm}"
    if report.fits:
        return f"the table meets the log: {chi2}"
    if not report.explanations:
        return f"the table does not meet the log ({chi2}), and no repairs were found with which it does"
    count = len(report.explanations[0].repairs)
    return f"the table does not meet the log ({chi2}); it does with {count} repair{'s' * (count > 1)}:"


def _repairs(report: SlipReport, paper: Paper | None) -> list[str]:
    if not report.explanations:
        return [f"nearest: {r.text}" for r in report.nearest.repairs] if not report.fits else []
    best, lines = report.explanations[0], []
    for k, repair in enumerate(best.repairs):
        known = f" (erratum {', '.join(names)})" if (names := _errata(repair, paper)) else ""
        lines.append(f"- {repair.text}{known}")
        others = list(dict.fromkeys(other.text for other in _instead(report, k)))
        lines += [f"  or {text}" for text in others[:OTHERS]]
        if len(others) > OTHERS:
            lines.append(f"  or one of {len(others) - OTHERS} more")
    lines.append(f"chi^2 with them: {best.chi2:.4g}")
    return lines


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
    errata = () if paper is None else (e for e in paper.errata if e.id not in paper.reading.errata)
    return [e.id for e in errata if any(p.at.startswith(_places(repair)) for p in e.of_tables())]


def _places(repair: Repair) -> tuple[str, ...]:
    """Where a data file has what is repaired."""
    quantities = {cell.quantity for cell in repair.cells}
    if repair.kind == CONVENTION:
        return ("inertial.inertia.products" if quantities <= set(PRODUCTS) else "inertial.inertia.about",)
    columns = {c.quantity: "mass" if c.quantity == MASS else "com" if c.quantity < TENSOR.start else "inertia"
               for c in repair.cells}  # fmt: skip
    cells = [f"inertial.{columns[c.quantity]}.values[{c.link}]" for c in repair.cells if c.quantity != ROTOR]
    return (*cells, *(("rotors.",) if ROTOR in quantities else ()))


def _row(row: CellAgainstLog, table: PrintedCells) -> tuple[str, ...]:
    value = f"{table.shown(row.cell, row.value)} +- {table.shown(row.cell, row.sigma).split()[0]}"
    printed = table.shown(row.cell, row.printed)
    return row.cell.name, printed, value, f"{row.pull:+.1f}", row.state, _names(row.like)


def _names(cells: tuple[Cell, ...]) -> str:
    return ", ".join(c.name for c in cells)


def slip_record(report: SlipReport, cells: tuple[CellAgainstLog, ...], paper: Paper | None = None) -> dict[str, Any]:
    """The same as a JSON object (numbers in SI)."""
    return {
        "fits": report.fits,
        "chi2": report.printed.chi2,
        "limit": report.limit,
        "deviation": report.deviation,
        "common_factor": report.common_factor,
        "sure": [_repair_record(r, paper) for r in report.sure],
        "explanations": [
            {"repairs": [_repair_record(r, paper) for r in e.repairs], "chi2": e.chi2, "evidence": e.evidence}
            for e in report.explanations
        ],
        "cells": [
            {
                "cell": c.cell.name, "printed": c.printed, "value": None if c.state == HIDDEN else c.value,
                "sigma": None if c.state == HIDDEN else c.sigma, "pull": c.pull, "state": c.state,
                "like": [other.name for other in c.like],
            }
            for c in cells
        ],
        "same_effect": [[c.name for c in group] for group in report.shown.together],
        "shown_by_no_motion": [c.name for c in report.shown.hidden],
    }  # fmt: skip


def _repair_record(repair: Repair, paper: Paper | None) -> dict[str, Any]:
    errata = _errata(repair, paper)
    return {"kind": repair.kind, "cells": list(repair.names), "text": repair.text, "errata": errata}
