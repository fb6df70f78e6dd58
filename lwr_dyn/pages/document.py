"""A document as a page, one HTML file that needs no network.

The page is a shell around what stands in it; reports that compose their own `main` take the shell alone. Light and dark
follow the reader's system.
"""

from collections.abc import Iterator, Sequence
from html import escape
from itertools import groupby
from numbers import Real

from lwr_dyn.foundation.document import Document, Fact, Note, PageFigure, Part, Section
from lwr_dyn.foundation.number_text import raised
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.pages.markup import Html, element, joined
from lwr_dyn.pages.replay.look import font_faces, look_css
from lwr_dyn.pages.replay.replay_page import fill_template, replay_policy, resource_text

POLICY = "default-src 'none'; style-src 'unsafe-inline'; font-src data:; img-src data:; base-uri 'none'"
"""What a document without scripts may load: what stands in it."""
_PACKAGE = "lwr_dyn.pages"
_WIDE, _LONG_CELL, _LONG = 5, 150, 16
"""Columns of a table, or letters of a cell, beyond which it stands alone; rows beyond which it scrolls."""


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
    rows = [
        element("tr", [_cell(*one) for one in zip(table.columns, row, kinds, range(len(row)), strict=False)],
                data_state=None if pick is None else str(row[pick]))
        for row in table.rows
    ]  # fmt: skip
    caption = element("caption", table.title) if table.title else None
    whole = element("table", caption, element("thead", element("tr", head)), element("tbody", rows))
    tall = "scroll tall" if len(table.rows) > _LONG else "scroll"
    scrolled = element("div", whole, class_=tall, tabindex=0, role="region", aria_label=table.title or "table")
    note = element("p", table.note, class_="note") if table.note else None
    return joined([_choice(table, pick), scrolled, note])


def _is_numeric(table: Table, column: int) -> bool:
    values = [row[column].value for row in table.rows if row[column]]
    return bool(values) and all(isinstance(x, Real) and not isinstance(x, bool) for x in values)


def _cell(heading: Heading, cell: "str", kind: str | None, place: int) -> Html:
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
    return element("td", inside, class_=kind, style=style)


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
