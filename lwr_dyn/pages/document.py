"""A document as HTML: a page, one file that needs no network, or what a notebook shows in place of a result's text.

A page is a shell around what stands in it; reports that compose their own `main` take the shell alone. Light and dark
follow the reader's system. A notebook gets one or two kilobytes that are readable without a style sheet; arms and runs,
which stand below documents, have theirs here.
"""

from collections.abc import Iterator, Sequence
from functools import singledispatch
from html import escape
from itertools import groupby
from numbers import Real
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.foundation.document import Document, Fact, Note, PageFigure, Part, Section
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.number_text import raised
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.model.arm import Arm, JointLimits, caveats_of
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Run
from lwr_dyn.pages.markup import Html, element, joined
from lwr_dyn.pages.replay.look import font_faces, look_css
from lwr_dyn.pages.replay.replay_page import fill_template, replay_policy, resource_text
from lwr_dyn.pages.replay.replayed_runs import facts
from lwr_dyn.simulation.audit import audit_words
from lwr_dyn.simulation.metrics import metrics

POLICY = "default-src 'none'; style-src 'unsafe-inline'; font-src data:; img-src data:; base-uri 'none'"
"""What a document without scripts may load: what stands in it."""
_PACKAGE = "lwr_dyn.pages"
_WIDE, _LONG_CELL, _LONG = 5, 150, 16
"""Columns of a table, or letters of a cell, beyond which it stands alone; rows beyond which it scrolls."""
_ON_PHONE = 3
"""Columns beyond which a row of a table is a list on a phone: each number with its heading beside it."""


def document_html(
    title: str, kind: str, main: str, command: str, *, style: str = "", scripts: str = "", policy: str = POLICY
) -> str:
    """One HTML file; the same parts give the same text.

    Parameters
    ----------
    title : str
        Plain text.
    kind : str
        What sort of document it is, in a word.
    main : str
        HTML, with a heading of the first level.
    command : str
        What made it, as "lwr-dyn compare".
    style, scripts : str, optional
        Rules of its own; script elements, which `policy` must allow.
    """
    parts = {
        "policy": policy,
        "title": escape(title),
        "kind": escape(kind),
        "style": "\n".join((look_css(), font_faces(), resource_text("document.css", _PACKAGE), style)),
        "main": main,
        "scripts": scripts,
        "footer": f"Made by lwr_dyn {VERSION}, {escape(command)}.",
    }
    return fill_template(resource_text("document.html", _PACKAGE), parts)


def page_html(document: Document) -> str:
    """One file that needs no network."""
    shown = document.there
    figures = [part for one in shown for part in one.parts if isinstance(part, PageFigure)]
    said = [
        *(document.caveats or ()),
        document.verdict,
        *(line for one in shown[:1] for line in _notes(one.parts) if not one.title),
    ]
    main = [
        element("h1", document.title),
        element("ul", [element("li", line) for line in said if line], class_="say"),
        _tiles(document.facts),
        [_card(one) for one in shown],
    ]
    scripts = "".join(dict.fromkeys(one.scripts() for one in figures if one.scripts))
    if any(h.pick for one in shown for part in one.parts if isinstance(part, Table) for h in part.columns):
        scripts += f"<script>\n{resource_text('pick.js', _PACKAGE)}\n</script>\n"
    policy = f"{replay_policy(live=False)}; base-uri 'none'" if scripts else POLICY
    style = "\n".join(dict.fromkeys(one.style for one in figures))
    return document_html(
        document.title, document.kind, joined(main), document.command, style=style, scripts=scripts, policy=policy
    )


def _notes(parts: Sequence[Part]) -> Iterator[str]:
    return (line for part in parts if isinstance(part, Note) for line in part.lines)


def _tiles(parts: Sequence[Part]) -> Html | None:
    shown = [one for one in parts if isinstance(one, Fact) and one.head and one.text]
    tiles = [element("div", element("b", one.text), element("span", one.head), title=one.says or None) for one in shown]
    return element("div", tiles, class_="tiles") if tiles else None


def _card(section: Section) -> Html | None:
    """Tables that follow each other stand beside each other where there is room; so do facts."""
    inside: list[Html | None] = []
    for kind, group in groupby(section.parts, type):
        parts = [*group]
        if kind is Fact:
            inside.append(_tiles(parts))
        elif kind is Table:
            tables = [one.shown(page=True) for one in parts if isinstance(one, Table) and one.is_shown]
            sides = [element("div", table_html(one), class_=_width(one)) for one in tables]
            inside.append(element("div", sides, class_="pairs") if sides else None)
        elif kind is PageFigure:
            inside += [Html(one.draw()) for one in parts if isinstance(one, PageFigure)]
        elif section.title:
            inside += [element("p", line, class_="note") for line in _notes(parts)]
    body = joined(filter(None, inside))
    heading = element("h2", section.title) if section.title else None
    return element("section", heading, body, class_="card") if body else None


def _width(table: Table) -> str:
    letters = max((len(cell) for row in table.cells for cell in row), default=0)
    return "wide" if len(table.columns) > _WIDE or letters > _LONG_CELL else "half"


def table_html(table: Table) -> Html:
    """A table as `Table.shown(page=True)` gives it; its first column names its rows, numbers stand at the right."""
    numeric = [k > 0 and _is_numeric(table, k) for k in range(len(table.columns))]
    kinds = ["n" if one else None for one in numeric]
    head = [
        element("th", raised(h.title), scope="col", class_=kind, title=h.says or None)
        for h, kind in zip(table.columns, kinds, strict=True)
    ]
    pick = next((k for k, h in enumerate(table.columns) if h.pick), None)
    stacks = len(table.columns) > _ON_PHONE
    rows = [
        element("tr", [_cell(*one, stacks) for one in zip(table.columns, row, kinds, range(len(row)), strict=False)],
                data_state=None if pick is None else str(row[pick]))
        for row in table.rows
    ]  # fmt: skip
    caption = element("caption", table.title) if table.title else None
    body = element("thead", element("tr", head)), element("tbody", rows)
    whole = element("table", caption, *body, class_="stacks" if stacks else None)
    tall = "scroll tall" if len(table.rows) > _LONG else "scroll"
    scrolled = element("div", whole, class_=tall, tabindex=0, role="region", aria_label=table.title or "table")
    note = element("p", table.note, class_="note") if table.note else None
    return joined([_choice(table, pick), scrolled, note])


def _is_numeric(table: Table, column: int) -> bool:
    values = [row[column].value for row in table.rows if row[column]]
    return bool(values) and all(isinstance(x, Real) and not isinstance(x, bool) for x in values)


def _cell(heading: Heading, cell: "str", kind: str | None, place: int, stacks: bool) -> Html:
    inside: Html | str = cell
    if heading.cut and len(cell) > heading.cut:
        start = f"{cell[: heading.cut - 1].rsplit(' ', 1)[0]} ..."
        inside = element("details", element("summary", start), cell)
    value = getattr(cell, "value", None)
    if heading.bar and isinstance(value, float) and cell:
        inside = _bar(value, heading.bar, cell)
    mark = getattr(value, "mark", "")
    if mark:
        kind = f"{kind or ''} bad".strip() if mark == "bad" else kind
        inside = element("b", cell) if mark == "best" else cell
    dark = heading.shade(value) if heading.shade and value is not None else 0.0
    style = f"background:color-mix(in srgb, var(--alarm) {100 * dark:.0f}%, transparent)" if dark else None
    if place == 0:
        return element("th", inside, scope="row", style=style)
    return element("td", inside, class_=kind, style=style, data_label=(stacks and heading.title) or None)


def _bar(value: float, full: float, text: str) -> Html:
    """A bar from the middle, full at `full`, and the number; from a third of it on it is marked."""
    half = 50.0 * min(abs(value), full) / full
    place = f"left:{50.0 if value > 0.0 else 50.0 - half:.1f}%;width:{half:.1f}%"
    bar = element("i", class_="bar far" if abs(value) > 0.3 * full else "bar", style=place)
    return element("span", element("span", bar, class_="track"), element("span", text, class_="m"), class_="pull")


def _choice(table: Table, pick: int | None) -> Html | None:
    """A list that shows the rows of one value."""
    found = [] if pick is None else [str(row[pick]) for row in table.rows]
    if len(set(found)) < 2:
        return None
    several = [element("option", f"{one} ({found.count(one)})", value=one) for one in dict.fromkeys(found)]
    options = [element("option", f"all ({len(found)})", value=""), *several]
    return element("p", element("label", "show ", element("select", options, class_="states")), class_="pick")


ROWS, LETTERS = 12, 160
"""Rows of a table, and letters of a line, that are shown."""


def html_of(result: Any) -> str:
    """The HTML of a result."""
    return notebook_html(document_of(result))


def notebook_html(document: Document) -> str:
    """Verdict, facts and notes of the first section, tables of sections that are `brief`."""
    first = [*document.facts, *(part for one in document.there[:1] for part in one.parts)]
    known = [f"{one.head}: {one.text}" for one in first if isinstance(one, Fact) and one.head and one.text]
    brief = [part for one in document.there if one.brief for part in one.parts]
    tables = [part.shown() for part in brief if isinstance(part, Table) and part.is_shown]
    said = [element("div", _short(line)) for line in [*(document.caveats or ()), *known, *_notes(first)]]
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
    notes = [element("div", note, style="color:var(--soft,inherit)") for note in [*left, table.note] if note]
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
