"""The report of an identification as one HTML file: the motion in 3D, torques, bodies, friction, parameters, checks.

The arm in 3D that replays the recordings, with the ellipsoids of its links before and after, for report.js.

The card on the table against the log: a map of all cells, the cells that are off, and repairs of slips.
"""

import json
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.report.charts import KEY, ShownRecording, friction_maps_html, torque_rows_html
from lwr_dyn.identification.report.shown_fit import (
    FAR,
    Section,
    ShownFit,
    ellipsoid_matrix,
    link_table,
    number,
    parameter_table_html,
)
from lwr_dyn.identification.slips.printed_cells import QUANTITIES, Cell, PrintedCells, printed_cells
from lwr_dyn.identification.slips.slip_tables import AGREES, HIDDEN, OFF, PULL, CellAgainstLog, table_against_log
from lwr_dyn.identification.slips.trace import DEVIATION, SlipReport
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.document import document_html
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.replay_page import (
    RATE,
    generator_line,
    meshcat_bundle,
    replay_policy,
    resource_text,
    run_record,
    script_safe,
)
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs

PACKAGE = "lwr_dyn.identification.report"

_SCRIPTS = ("numbers.js", "drawing.js", "stage.js")

_PLACE = 1
"""Of the motion's colour in the palette: the result has the first."""

_SAMPLES = 3000
"""Of a recording in 3D at most: two minutes at 25 Hz."""


def stage_data(arm: Arm, recordings: Sequence[ShownRecording], before: Array, after: Array) -> dict[str, Any]:
    """The page's data.

    Parameters
    ----------
    arm : Arm
    recordings : sequence of ShownRecording
        At least one.
    before, after : (n, 10) array
        Inertial parameters of the links in the frames of the source, as in `INERTIAL`: the table's, the result's.
    """
    shown = [_shown(arm, one) for one in recordings]
    return {
        "scene": list(replay_page.arm_commands(shown[0], 0)),
        "runs": [run_record(shown[0], _stride(shown[0]))],
        "others": [run_record(one, _stride(one)) for one in shown[1:]],
        "native": [replay_page.column_major(link.after) for link in arm.chain.links],
        "before": _ellipsoids(before),
        "after": _ellipsoids(after),
        "made_by": generator_line(),
    }


def _ellipsoids(parameters: Array) -> list[list[float] | None]:
    found = [ellipsoid_matrix(row) for row in parameters]
    return [None if one is None else [float(x) for x in one.T.ravel()] for one in found]


def _shown(arm: Arm, one: ShownRecording) -> ReplayedRun:
    nothing, zero = np.zeros_like(one.q), np.zeros_like(one.t)
    run = Run(one.t, one.q, nothing, one.q, nothing, nothing, nothing, nothing, zero, {})
    return replace(replayed_runs([run], arm, [one.source])[0], place=_PLACE)


def _stride(shown: ReplayedRun) -> int:
    steps, duration = shown.run.t.size - 1, float(np.ptp(shown.run.t))
    return max(1, round(steps / max(duration * RATE / 2, 1.0)), -(-steps // _SAMPLES))


def stage_html(recordings: Sequence[ShownRecording]) -> str:
    """The place of the arm, its controls and switches."""
    names = [escape(one.source) for one in recordings]
    options = "".join(f'<option value="{k}">{name}</option>' for k, name in enumerate(names))
    choice = f'<label>recording <select id="recording">{options}</select></label>' if len(names) > 1 else ""
    switches = "".join(
        f'<label><input id="{ident}" type="checkbox" checked> {mark}{label}</label>'
        for ident, label, mark in (
            ("show-before", "table's ellipsoids", '<i class="sw ref"></i>'),
            ("show-after", "result's ellipsoids", '<i class="sw r1"></i>'),
            ("see-through", "see-through arm", ""),
            ("show-path", "path of the flange", ""),
        )
    )
    speeds = "".join(
        f'<option value="{x:g}"{" selected" if x == 1 else ""}>{x:g} &times;</option>' for x in (0.25, 0.5, 1, 2, 4)
    )
    return (
        '<div id="stage"></div><div class="controls">'
        '<button id="play" type="button" aria-label="play or pause">\u25b6</button>'
        '<input id="scrub" type="range" min="0" max="1" step="any" value="0" aria-label="time">'
        f'<output id="clock">0.00 s</output><label>speed <select id="speed">{speeds}</select></label>{choice}</div>'
        f'<div class="controls" role="group" aria-label="What is drawn">{switches}</div>'
    )


def stage_scripts(data: dict[str, Any]) -> str:
    """Script elements: the data, meshcat and the page's own code."""
    text = script_safe(json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False))
    code = "\n".join([*map(resource_text, _SCRIPTS), resource_text("report.js", PACKAGE)])
    return (
        f'<script type="application/json" id="stage-data">{text}</script>\n'
        f"<script>\n{meshcat_bundle()}\n</script>\n<script>\n{code}\n</script>\n"
    )


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
    return "The table against the logs, cell by cell", tuple(tables), tuple(notes)


def cell_map(cells: Sequence[CellAgainstLog], table: PrintedCells, title: str) -> Table:
    """Links by rows, quantities by columns: sigmas off, darker the farther off; a dot where no motion shows a cell."""
    found = {one.cell: one for one in cells}
    rows = [
        (f"{i + 1}", *(found.get(Cell(i, quantity)) for quantity in range(len(QUANTITIES)))) for i in range(table.n)
    ]
    return Table(title, (Heading("link"), *(Heading(name, "", _pull, shade=_cell_shade) for name in QUANTITIES)), rows)


def _pull(one: CellAgainstLog) -> str:
    return "\u00b7" if one.state == HIDDEN else number(round(one.pull, 1) + 0.0, 3)


def _cell_shade(one: CellAgainstLog | None) -> float:
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
    chi2 = f"chi squared {number(slips.printed.chi2)}, at most {number(slips.limit)}"
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


_WIDE, _LETTERS, _LONG = 5, 150, 16
"""Columns of a table, or letters of a cell, beyond which it stands alone; rows beyond which it scrolls."""


def check_report_path(path: str | Path) -> None:
    """Raise `FileAccessError` now for a path that a report could not be written to later."""
    if not ends_in(path, ".html", ".htm"):
        raise FileAccessError(str(path), f"ends in {Path(path).suffix or 'nothing'!r}", "a path in .html")
    check_writable(path)


def write_report(path: str | Path, shown: ShownFit) -> Path:
    """Write `report_html(shown)` to a file; raises `FileAccessError`."""
    write_file(path, report_html(shown))
    return Path(path)


def report_html(shown: ShownFit) -> str:
    """The page, without a request to any network; the same fit gives the same text."""
    said = "".join(f"<li>{escape(one)}</li>" for one in shown.said)
    tiles = "".join(f"<div><b>{escape(value)}</b><span>{escape(name)}</span></div>" for name, value in shown.figures)
    main = [
        f'<h1>{escape(shown.title)}</h1><ul class="say">{said}</ul><div class="tiles">{tiles}</div>',
        _bodies(shown),
        _torques(shown),
        _friction(shown),
        _card("Parameters", parameter_table_html(shown.parameters, shown.caption) + _notes(shown.notes)),
        *(_card(title, _beside(tables) + _notes(notes)) for title, tables, notes in shown.more),
    ]
    style = resource_text("report.css", PACKAGE)
    scripts = stage_scripts(stage_data(shown.arm, shown.recordings, shown.before, shown.after))
    policy = f"{replay_policy(live=False)}; base-uri 'none'"
    return document_html(
        shown.title, "identification", "".join(main), shown.command, style=style, scripts=scripts, policy=policy
    )


def _card(title: str, inside: str, kind: str = "") -> str:
    return f'<section class="card{kind}"><h2>{escape(title)}</h2>{inside}</section>'


def _beside(tables: Sequence[Table]) -> str:
    """Tables beside each other where there is room."""
    parts = (f'<div class="{_width(one)}">{table_html(one)}</div>' for one in tables)
    return f'<div class="pairs">{"".join(parts)}</div>'


def _width(table: Table) -> str:
    letters = max((len(cell) for row in table.cells for cell in row), default=0)
    return "wide" if len(table.columns) > _WIDE or letters > _LETTERS else "half"


def _notes(said: Sequence[str]) -> str:
    return "".join(f'<p class="note">{escape(one)}</p>' for one in said)


def table_html(table: Table) -> str:
    """A table whose first column names its rows; numbers stand at the right."""
    head = "".join(f'<th scope="col"{_kind(table, k)}>{escape(h.title)}</th>' for k, h in enumerate(table.columns))
    body = "".join(
        f'<tr><th scope="row">{escape(first)}</th>'
        + "".join(
            f"<td{_kind(table, k)}{_shade(dark)}>{escape(cell)}</td>"
            for k, (cell, dark) in enumerate(zip(rest, shades, strict=True), start=1)
        )
        + "</tr>"
        for (first, *rest), (_, *shades) in zip(table.cells, table.shades, strict=True)
    )
    label = escape(table.title)
    rows = f"<table><caption>{label}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    note = _notes([table.note]) if table.note else ""
    kind = "scroll tall" if len(table.rows) > _LONG else "scroll"
    return f'<div class="{kind}" tabindex="0" role="region" aria-label="{label}">{rows}</div>{note}'


def _shade(dark: float | None) -> str:
    return f' style="background:color-mix(in srgb, var(--alarm) {100 * dark:.0f}%, transparent)"' if dark else ""


def _kind(table: Table, column: int) -> str:
    """Class of a column: numbers stand at the right."""
    values = [row[column] for row in table.rows if row[column] is not None]
    numbers = column > 0 and bool(values) and not any(isinstance(x, str) for x in values)
    return ' class="n"' if numbers else ""


def _bodies(shown: ShownFit) -> str:
    about = (
        "Each ellipsoid is the solid of one density with the mass, the centre of mass and the inertia of a link: wires "
        "by the table, filled by the result. A link without an ellipsoid has values that no body can have."
    )
    table = table_html(link_table(shown.links, shown.before, shown.after, shown.sigma))
    inside = f'<p class="note lead">{about}</p>{stage_html(shown.recordings)}<div class="below">{table}</div>'
    return _card("The motion, and the links before and after", inside, " stage")


def _torques(shown: ShownFit) -> str:
    names = [escape(one.source) for one in shown.recordings]
    options = "".join(f'<option value="{k}">{name}</option>' for k, name in enumerate(names))
    choice = f'<p class="pick"><label>recording <select class="which">{options}</select></label></p>'
    charts = "".join(
        f'<div data-recording="{k}"{" hidden" if k else ""}>'
        f"{torque_rows_html(one, shown.noise, shown.joints, tuple(u[1] for u in shown.units))}</div>"
        for k, one in enumerate(shown.recordings)
    )
    return _card("Torque against prediction", (choice if len(names) > 1 else "") + KEY + charts)


def _friction(shown: ShownFit) -> str:
    about = (
        "Dots: measured torque less what the bodies and rotors of the result take. Line: the friction of the result; "
        "grey: that of the robot's data, if it has any."
    )
    maps = friction_maps_html(
        shown.speed, shown.friction_torque, shown.friction, shown.friction_before, shown.friction_at, shown.units
    )
    return _card("Friction", f'<p class="note">{about}</p>{maps}')
