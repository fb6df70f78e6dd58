"""The card on the table against the log: a map of all cells, the cells that are off, and repairs of slips."""

from collections.abc import Sequence

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.document import Note, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips.printed_cells import QUANTITIES, Cell, PrintedCells, printed_cells
from lwr_dyn.identification.slips.slip_tables import (
    AGREES,
    HIDDEN,
    OFF,
    PULL,
    CellAgainstLog,
    table_against_log,
)
from lwr_dyn.identification.slips.trace import DEVIATION, SlipReport
from lwr_dyn.model.arm import Arm
from lwr_dyn.pages.figures.figure import short

FAR = 10.0
"""Sigmas at which a cell is darkest."""
_SHADE = 0.55
"""Darkness of a cell that is `FAR` sigmas off and more."""
_REPAIRS = 12
"""Explanations that are listed."""


def table_card(information: Information, source: Paper | Arm, deviation: float = DEVIATION) -> tuple[Section, ...]:
    """The card without repairs; none for a source without inertias, and for rotors that are fitted at their motors.

    Parameters
    ----------
    information : Information
    source : Paper or Arm
        As `table_against_log` takes them.
    deviation : float
        How far the arm is taken to be from a right table.
    """
    if information.columns.transmission is not None:
        return ()
    try:
        table = printed_cells(source)
    except OptionError:
        return ()
    notes = ("A slip pulls at many cells; lwr-dyn identify table looks for the repairs that explain them.",)
    return (_section(table_against_log(information, source, deviation=deviation), table, deviation, (), notes),)


def slips_card(information: Information, source: Paper | Arm, slips: SlipReport) -> Section:
    """The card with the repairs that were found, and the cells before and after the likeliest of them."""
    cells = table_against_log(information, source, deviation=slips.deviation)
    first = _repairs(slips)
    if slips.explanations:
        best = slips.explanations[0]
        after = table_against_log(information, source, deviation=slips.deviation, at=best)
        first.append(cell_map(after, best.table, "Sigmas off, after the repairs of explanation 1"))
    return _section(cells, slips.printed.table, slips.deviation, first, (_verdict(slips),))


def _section(
    cells: Sequence[CellAgainstLog], table: PrintedCells, deviation: float, first: Sequence[Table], said: Sequence[str]
) -> Section:
    off = [one for one in cells if one.state == OFF]
    tables = [*first, cell_map(cells, table, "Sigmas off, as printed")]
    tables += [_cells("Cells that are off, as printed", off, table)] if off else []
    notes = [
        *said,
        "Sigmas by which each cell alone would have to change for the logs, with the arm itself "
        f"{100 * deviation:.3g} % off a right table; off: beyond {PULL:g}. A dot: no motion shows the cell; empty: the "
        f"source does not print it. {sum(one.state == AGREES for one in cells)} of {len(cells)} cells agree.",
    ]
    pairs = _pairs(cells)
    notes += [f"No motion tells apart: {pairs}."] if pairs else []
    return Section("The table against the logs, cell by cell", [*tables, Note(notes)], page=True)


def cell_map(cells: Sequence[CellAgainstLog], table: PrintedCells, title: str) -> Table:
    """Links by rows, quantities by columns: sigmas off, darker the farther off; a dot where no motion shows a cell."""
    found = {one.cell: one for one in cells}
    rows = [
        (f"{i + 1}", *(found.get(Cell(i, quantity)) for quantity in range(len(QUANTITIES)))) for i in range(table.n)
    ]
    return Table(title, (Heading("link"), *(Heading(name, "", _pull, shade=_shade) for name in QUANTITIES)), rows)


def _pull(one: CellAgainstLog) -> str:
    return "\u00b7" if one.state == HIDDEN else short(round(one.pull, 1) + 0.0, 3)


def _shade(one: CellAgainstLog | None) -> float:
    return 0.0 if one is None or one.state != OFF else _SHADE * min(abs(one.pull), FAR) / FAR


def _cells(title: str, cells: Sequence[CellAgainstLog], table: PrintedCells) -> Table:
    rows = [
        (
            one.cell.name, table.shown(one.cell, one.printed), table.shown(one.cell, one.value),
            table.shown(one.cell, one.sigma), one.pull, ", ".join(c.name for c in one.like),
        )
        for one in sorted(cells, key=lambda one: -abs(one.pull))
    ]  # fmt: skip
    headings = (
        Heading("cell"), Heading("printed"), Heading("by the log, if it alone is off"), Heading("sigma"),
        Heading("sigmas off", "", ".3g"), Heading("same effect"),
    )  # fmt: skip
    return Table(title, headings, rows)


def _pairs(cells: Sequence[CellAgainstLog]) -> str:
    groups = {tuple(sorted((one.cell, *one.like))) for one in cells if one.like and one.state != HIDDEN}
    return ", ".join(" = ".join(cell.name for cell in group) for group in sorted(groups))


def _verdict(slips: SlipReport) -> str:
    chi2 = f"chi squared {short(slips.printed.chi2)}, at most {short(slips.limit)}"
    if slips.fits:
        return f"The table meets the logs as printed ({chi2})."
    if not slips.explanations:
        return f"The table does not meet the logs ({chi2}), and no repairs were found with which it does."
    return f"The table does not meet the logs ({chi2}); it does with the repairs of any one explanation."


def _repairs(slips: SlipReport) -> list[Table]:
    """A row an explanation, the likeliest first."""
    rows = [
        (str(k + 1), "; ".join(repair.text for repair in one.repairs), float(one.chi2))
        for k, one in enumerate(slips.explanations[:_REPAIRS])
    ]
    headings = (Heading("explanation"), Heading("repairs"), Heading("chi squared", "", ".4g"))
    title = "Repairs with which the table meets the logs, the likeliest first"
    return [Table(title, headings, rows)] if rows else []
