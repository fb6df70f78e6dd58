"""The report of an identification as one HTML file: the motion in 3D, torques, bodies, friction, parameters, checks."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file
from lwr_dyn.foundation.tables import Table
from lwr_dyn.identification.report.arm_stage import PACKAGE, stage_data, stage_html, stage_scripts
from lwr_dyn.identification.report.friction_charts import friction_maps_html
from lwr_dyn.identification.report.parameter_rows import link_table, parameter_table_html
from lwr_dyn.identification.report.shown_fit import ShownFit
from lwr_dyn.identification.report.torque_charts import KEY, torque_rows_html
from lwr_dyn.pages.plotting.document import document_html
from lwr_dyn.pages.replay.page_parts import resource_text
from lwr_dyn.pages.replay.replay_page import replay_policy

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
