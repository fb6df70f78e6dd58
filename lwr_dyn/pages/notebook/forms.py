"""Results as one or two kilobytes of HTML, which a notebook shows in place of their text.

They are readable without a style sheet, and everything is escaped.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.kinematics.solution import InverseResult
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Run
from lwr_dyn.pages.document import notebook_html
from lwr_dyn.pages.replay.replayed_runs import facts
from lwr_dyn.simulation.audit import audit_words
from lwr_dyn.simulation.metrics import Metrics, metrics

ROWS = 12
"""Rows of a table that are shown; a line says how many are left out."""

_SOFT = "color:var(--soft,inherit)"

_LINE = 160
"""Letters of a line that are shown."""


def line(text: str, mark: str = "div") -> str:
    """A line of text, cut where it is long.

    >>> line("a < b")
    '<div>a &lt; b</div>'
    """
    shown = text if len(text) <= _LINE else f"{text[: _LINE - 4]} ..."
    return f"<{mark}>{escape(shown)}</{mark}>"


def table_html(table: Table) -> str:
    """A table with its title and its note; its first column names the rows."""
    head = "".join(f'<th scope="col">{escape(h.title)}</th>' for h in table.columns)
    rows = "".join(_row(cells) for cells in table.cells[:ROWS])
    left = len(table.cells) - ROWS
    notes = [f"and {left} more"] if left > 0 else []
    notes += [table.note] if table.note else []
    caption = f'<caption style="text-align:left">{escape(table.title)}</caption>' if table.title else ""
    body = f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    return body + "".join(f'<div style="{_SOFT}">{escape(note)}</div>' for note in notes)


def _row(cells: tuple[str, ...]) -> str:
    first, *rest = (escape(cell) for cell in cells)
    return f'<tr><th scope="row">{first}</th>{"".join(f"<td>{cell}</td>" for cell in rest)}</tr>'


UNKNOWN = "unknown"

SLIDING = "of a sliding joint in m, m/s, N, kg"


def arm_html(arm: Arm) -> str:
    """Joint by joint its range, speed, torque, mass and rotor; what the source does not give is "unknown"."""
    turning = [link.kind is JointKind.REVOLUTE for link in arm.chain.links]
    headings = (
        "joint", Heading("range", "deg"), Heading("speed", "deg/s"), Heading("torque", "N m"),
        Heading("mass", "kg"), Heading("rotor", "kg m^2"),
    )  # fmt: skip
    rows = [
        (link.joint, *_limits(limits, turns), _number(None if link.body is None else link.body.mass),
         _number(None if link.rotor is None else link.rotor.armature))
        for link, limits, turns in zip(arm.chain.links, arm.limits, turning, strict=True)
    ]  # fmt: skip
    title = f"{arm.title or arm.name}: {arm.n} joints, reading {arm.reading}"
    return table_html(Table(title, headings, rows, "" if all(turning) else SLIDING))


def _limits(limits: JointLimits, turns: bool) -> tuple[str, str, str]:
    scale = 180.0 / np.pi if turns else 1.0
    ends = [None if end is None else scale * end for end in (limits.lower, limits.upper)]
    span = UNKNOWN if ends == [None, None] else " to ".join(map(_number, ends))
    return span, _number(None if limits.velocity is None else scale * limits.velocity), _number(limits.effort)


def _number(value: float | None) -> str:
    return UNKNOWN if value is None else f"{value:.4g}"


def run_html(run: Run) -> str:
    """What was run, errors and torques joint by joint, the error of the tip, limits and the audit."""
    known = facts(run)
    parts = [known[name] for name in ("controller", "task", "payload", "plant") if name in known]
    parts += [f"{run.t[-1] if run.t.size else 0.0:g} s", f"{run.t.size} samples"]
    title = f"Run of {known.get('robot', 'an unknown robot')}: {', '.join(parts)}"
    if not run.t.size:
        return line(title, "b")
    try:
        arm = arm_of(run)
        figures = metrics(run, arm)
    except LwrDynError as fault:  # the robot's file is gone
        return line(title, "b") + line(f"{len(run.events)} events; no figures: {fault}")
    return line(title, "b") + metrics_html(figures) + line(f"{len(run.events)} events; audit: {audit_words(run.audit)}")


def metrics_html(figures: Metrics) -> str:
    """Errors and torques joint by joint, the error of the tip, and whether limits were kept."""
    headings = (
        "joint", Heading("RMS error", "mrad", ".3g"), Heading("largest", "mrad", ".3g"),
        Heading("peak torque", "N m", ".4g"), Heading("of limit", format=_share),
    )  # fmt: skip
    p = figures.position_mrad
    largest = np.maximum(np.abs(p.max), np.abs(p.min))
    columns: tuple[Any, ...] = (figures.stops.joints, p.rms, largest, figures.peak_torque, figures.torque_use)
    tip = f"tip error ({figures.caveat}): RMS {figures.tip_rms_mm:.4g} mm, largest {figures.tip_max_mm:.4g} mm"
    return table_html(Table("", headings, list(zip(*columns, strict=True)))) + line(tip) + line(_kept(figures))


def _kept(figures: Metrics) -> str:
    return f"limits of position, speed and torque: {figures.limits}"


def _share(use: float) -> str:
    return UNKNOWN if np.isnan(use) else f"{100 * use:.2g} %"


def check_html(report: Any) -> str:
    """How many checks hold; those that fail first."""
    return table_html(report.failing_first()) + "".join(line(f"not judged: {text}") for text in report.not_judged[:3])


def inverse_html(result: InverseResult) -> str:
    """The status, and the solutions."""
    shown, where = (result.solutions, "inside") if result.solutions else (result.outside, "outside")
    why = [f"{what} by {value:.3g}" for what, value in _shortfalls(result) if value is not None]
    about = f"{result.status}: {len(result.solutions)} solutions inside the limits, {len(result.outside)} outside"
    text = line("; ".join([about, *why, *(f"near the singularity {name}" for name in result.singular)]), "b")
    if not shown:
        return text
    rows = [(str(i), ", ".join(f"{x:.4f}" for x in s.q)) for i, s in enumerate(shown[:ROWS], 1)]
    return text + table_html(Table(f"{where} the limits", ("", Heading("q", "rad or m")), rows))


def _shortfalls(result: InverseResult) -> list[tuple[str, float | None]]:
    return [
        (f"{result.joint} outside", result.excess), ("out of reach", result.distance), ("turned away", result.turn)
    ]  # fmt: skip


def reproduction_html(result: Any) -> str:
    """Whether everything printed is reproduced or explained, and the count."""
    verdict = "everything printed is reproduced or explained" if result.holds else "printed numbers DIFFER"
    tables = [table for table in result.tables if isinstance(table, Table)]
    return line(verdict, "b") + "".join(map(table_html, tables[:1]))


def friction_html(result: Any) -> str:
    """The fit of each joint and direction with standard errors."""
    rows = [
        (f"{fit.joint}{'+' if fit.sign > 0 else '-'}", _values(fit), f"{fit.estimate.rms:.3g}") for fit in result.fits
    ]
    title = f"friction from {len(result.points)} cruises; value +- standard error"
    table = Table(title, ("joint", "magnitudes against the motion", Heading("RMS", "N m")), rows)
    return table_html(table) + "".join(line(f"not determined: {fault}") for fault in result.faults[:3])


def _values(fit: Any) -> str:
    e = fit.estimate
    return ", ".join(f"{n} {v:.4g} +- {s:.2g}" for n, v, s in zip(fit.names, e.values, e.standard_errors, strict=True))


FORMS: Mapping[str, Callable[[Any], str]] = {
    "Arm": arm_html,
    "Run": run_html,
    "Metrics": metrics_html,
    "CheckReport": check_html,
    "InverseResult": inverse_html,
    "Reproduction": reproduction_html,
    "FrictionIdentification": friction_html,
}
"""Class -> its HTML."""


def html_of(result: Any) -> str:
    """The HTML of a result: of one of the classes of `FORMS`, or of its `document`."""
    form = FORMS.get(type(result).__name__)
    return notebook_html(result.document) if form is None else form(result)
