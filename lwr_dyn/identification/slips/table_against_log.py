"""A table against a log, cell by cell: what each cell would be if it alone were wrong, and how far off it is."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips.hypotheses import Hypothesis, as_printed, free_cells
from lwr_dyn.identification.slips.log_evidence import log_evidence
from lwr_dyn.identification.slips.printed_cells import Cell, printed_cells
from lwr_dyn.identification.slips.shown_cells import shown_cells
from lwr_dyn.identification.slips.trace import DEVIATION, checked_deviation
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
    evidence = log_evidence(information, table, checked_deviation(deviation))
    shown = shown_cells(information, table)
    # cells of a repair that were freed count as the others do
    base = as_printed(evidence, table)
    free = free_cells(evidence, base, table.cells)
    rows = []
    for i, cell in enumerate(table.cells):
        printed, sigma, hidden = table.value(cell), float(free.sigma[i]), cell in shown.hidden
        hidden = hidden or not np.isfinite(sigma)
        pull = 0.0 if hidden else float(free.step[i]) / sigma
        state = HIDDEN if hidden else OFF if abs(pull) > PULL else FAINT if sigma > abs(printed) else AGREES
        value = float("nan") if hidden else printed + float(free.step[i])
        like = tuple(c for c in shown.like(cell) if c != cell)
        rows.append(
            CellAgainstLog(
                cell, printed, value, float("inf") if hidden else sigma, pull, float(free.chi2[i]), state, like
            )
        )
    return tuple(rows)
