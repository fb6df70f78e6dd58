"""What a notebook shows of a result in place of its text: its document in one or two kilobytes of HTML.

They are readable without a style sheet, and everything is escaped. Arms and runs, which stand below documents, have
theirs here.
"""

from functools import singledispatch
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.foundation.document import Document, Fact, Note, Part, Section
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm, JointLimits, caveats_of
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Run
from lwr_dyn.pages.markup import Html, element, joined
from lwr_dyn.pages.replay.replayed_runs import facts
from lwr_dyn.simulation.audit import audit_words
from lwr_dyn.simulation.metrics import metrics

ROWS, LETTERS = 12, 160
"""Rows of a table, and letters of a line, that are shown."""
_SOFT = "color:var(--soft,inherit)"


def html_of(result: Any) -> str:
    """The HTML of a result."""
    return notebook_html(document_of(result))


def notebook_html(document: Document) -> str:
    """Verdict, facts and notes of the first section, tables of sections that are `brief`."""
    first = [*document.facts, *(part for one in document.there[:1] for part in one.parts)]
    facts = [f"{one.head}: {one.text}" for one in first if isinstance(one, Fact) and one.head and one.text]
    brief = [part for one in document.there if one.brief for part in one.parts]
    tables = [part.shown() for part in brief if isinstance(part, Table) and part.is_shown]
    notes = [line for part in first if isinstance(part, Note) for line in part.lines]
    said = [element("div", _short(line)) for line in [*(document.caveats or ()), *facts, *notes]]
    return joined([element("b", _short(document.verdict or document.title)), said, map(_small, tables)])


def _short(text: str) -> str:
    return text if len(text) <= LETTERS else f"{text[: LETTERS - 4]} ..."


def _small(table: Table) -> Html:
    head = element("tr", [element("th", h.title, scope="col") for h in table.columns])
    rows = [
        element("tr", element("th", first, scope="row"), [element("td", cell) for cell in cells])
        for first, *cells in table.rows[:ROWS]
    ]
    caption = element("caption", table.title, style="text-align:left") if table.title else None
    left = [f"and {len(table.rows) - ROWS} more"] if len(table.rows) > ROWS else []
    notes = [element("div", note, style=_SOFT) for note in [*left, table.note] if note]
    return joined([element("table", caption, element("thead", head), element("tbody", rows)), notes])


@singledispatch
def document_of(result: Any) -> Document:
    """The document of a result: its own, or that of an arm or a run."""
    document: Document = result.document
    return document


UNKNOWN = "unknown"

SLIDING = "of a sliding joint in m, m/s, N, kg"


@document_of.register
def arm_document(arm: Arm) -> Document:
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
    table = Table("", headings, rows, "" if all(turning) else SLIDING)
    return Document(title, "", [Section("", [table], brief=True)], kind="arm", caveats=caveats_of([arm]))


def _limits(limits: JointLimits, turns: bool) -> tuple[str, str, str]:
    scale = 180.0 / np.pi if turns else 1.0
    ends = [None if end is None else scale * end for end in (limits.lower, limits.upper)]
    span = UNKNOWN if ends == [None, None] else " to ".join(map(_number, ends))
    return span, _number(None if limits.velocity is None else scale * limits.velocity), _number(limits.effort)


def _number(value: float | None) -> str:
    return UNKNOWN if value is None else f"{value:.4g}"


@document_of.register
def run_document(run: Run) -> Document:
    """What was run, errors and torques joint by joint, the error of the tip, limits and the audit."""
    known, happened = facts(run), f"{len(run.events)} events"
    shown: list[Part] = []
    said = [known[name] for name in ("controller", "task", "payload", "plant") if name in known]
    said += [f"{run.t[-1] if run.t.size else 0.0:g} s", f"{run.t.size} samples"]
    if run.t.size:
        try:
            shown = [*metrics(run, arm_of(run)).parts(), Note(f"{happened}; audit: {audit_words(run.audit)}")]
        except LwrDynError as fault:  # the robot's file is gone
            shown = [Note(f"{happened}; no figures: {fault}")]
    title = f"Run of {known.get('robot', 'an unknown robot')}: {', '.join(said)}"
    return Document(title, "", [Section("", shown, brief=True)], kind="run")
