"""Numbers, errata, checks, sections and files of a report as HTML that is readable without scripts.

The map of a paper's numbers, each a square, is the page's summary and contents. Numbers stand beside ours, one a line,
what came out as printed folded away. Behind each is a popover with its place in the paper, its formula and unit.
"""

import re
from collections.abc import Iterator, Sequence, Set

from lwr_dyn.foundation.number_text import raised, short
from lwr_dyn.pages.document import table_html
from lwr_dyn.pages.markup import Html, anchor, element, grid, joined
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.reproduction.case import LedgerEntry
from lwr_dyn.reproduction.report import content
from lwr_dyn.reproduction.report.figure_html import figure_html

GLYPHS: dict[content.CellVerdict, tuple[str, str]] = {
    "reproduced": ("v1", "reproduced"),
    "after erratum": ("v2", "after an erratum"),
    "differs": ("v4", "differ"),
    "structural": ("v5", "structural"),
    "repeated in print": ("v6", "repeated in print"),
    "under assumed conditions": ("v3", "assumed, not near"),
    "not reproducible": ("v7", "not reproducible"),
}
"""The class of a verdict's square (filled, half, crossed, ...; the shapes need no colour), and its words in the key."""

NEAR = "v8"
"""The class of an assumed number that is near."""

ALWAYS = ("reproduced", "after erratum", "differs")
"""Verdicts that the key names even where no number has them."""

_SMALL = 6
"""Tables of at most so many numbers share a line."""


def glyph(cell: content.ReportCell) -> Html | None:
    """The square of a number; nothing for a cell that is only shown."""
    return element("i", class_=f"g {NEAR if cell.near else GLYPHS[cell.verdict][0]}") if cell.verdict else None


def word(cell: content.ReportCell) -> str:
    """The verdict of a number in words."""
    if cell.near is not None:
        return "assumed, near" if cell.near else "assumed, not near"
    return {"after erratum": "after an erratum"}.get(cell.verdict, cell.verdict)


def number_map(page: content.Page) -> Html | None:
    """The key with its counts and a line for each table of the paper; None for a page without numbers."""
    cells = [cell for table in page.tables for cell in table.verdict_cells]
    if not cells:
        return None
    groups: dict[str, list[content.ReportTable]] = {}  # tables of one place in the paper together
    for table in page.tables:
        if table.verdict_cells:
            groups.setdefault(table.title, []).append(table)
    lines = list(map(_line, groups.values()))
    return element(
        "div", _key(page, cells), element("ul", lines, class_="map", aria_label="Every printed number by table")
    )


def _key(page: content.Page, cells: Sequence[content.ReportCell]) -> Html:
    """What the squares mean and how many there are."""
    near = sum(cell.near is True for cell in cells)
    items: list[tuple[str, int, str]] = []
    for verdict, count in page.counted.items():
        shape, words = GLYPHS[verdict]
        if verdict == "under assumed conditions" and count:
            items += [(NEAR, near, "assumed, near"), (shape, count - near, words)]
        elif count or verdict in ALWAYS:
            items.append((shape, count, words))
    shown = [element("li", element("i", class_=f"g {shape}"), f"{count} {name}") for shape, count, name in items]
    return element("ul", shown, class_="key", aria_label="Verdicts")


def _line(tables: Sequence[content.ReportTable]) -> Html:
    cells = [cell for table in tables for cell in table.verdict_cells]
    words = [word(cell) for cell in cells]
    said = ", ".join(f"{words.count(one)} {one}" for one in dict.fromkeys(words))
    title = tables[0].title
    link = element(
        "a",
        element("span", title, class_="ml"),
        element("span", [glyph(cell) for cell in cells], class_="mc", role="img", aria_label=said),
        element("span", str(len(cells)), class_="mn"),
        href=f"#{anchor('table', tables[0].id)}",
        title=f"{title}: {said}",
    )
    return element("li", link, class_=None if len(cells) > _SMALL else "small")


FOLDED: tuple[content.CellVerdict, ...] = ("reproduced", "structural", "repeated in print", "")
"""Verdicts of numbers that are folded away: nothing is wrong with them."""

_LONG = 14
"""Characters from which an expression is written over the whole line."""

Line = tuple[str, content.ReportCell]
"""The name of a number in its table, and the number."""


def number_table_html(table: content.ReportTable, errata: Set[str], numbers: Iterator[int]) -> Html:
    """A table of the paper, one line a number; `errata` are the ids on the page, `numbers` count the popovers."""
    lines = [(place, cell) for place, cell in table.lines if cell.printed or cell.ours]
    unit = raised(table.unit)
    title = [table.title, element("small", " \u00b7 ".join(text for text in (table.where, unit) if text))]
    name = anchor("table", table.id)
    folded = [line for line in lines if line[1].verdict in FOLDED]
    seen = [line for line in lines if line not in folded]

    def rows(chosen: Sequence[Line], what: str) -> Html:
        return _rows(table, chosen, f"{table.id}: {table.title} {table.where}{what}", errata, numbers)

    note = element("p", table.note, class_="note") if table.note else None
    if not seen:
        summary = element("summary", element("h3", title), _counts(folded))
        return element("details", summary, note, rows(folded, ""), class_="box ledger", id=name)
    more = element("details", element("summary", _counts(folded)), rows(folded, ", the others")) if folded else None
    body = [element("h3", title), note, rows(seen, ""), more]
    return element("div", body, class_="box ledger", id=name)


def _counts(lines: Sequence[Line]) -> Html:
    """How many numbers of each verdict, with their squares."""
    cells = {word(cell) or "shown": cell for _, cell in lines}
    words = [word(cell) or "shown" for _, cell in lines]
    counted = [part for text, cell in cells.items() for part in (glyph(cell), f"{words.count(text)} {text} ")]
    return element("span", counted, class_="count")


def _rows(
    table: content.ReportTable, lines: Sequence[Line], name: str, errata: Set[str], numbers: Iterator[int]
) -> Html:
    has_off = any(cell.digits is not None for _, cell in lines)
    heads = {"place": "number", "num": "printed", "ours num": "recomputed"}
    heads |= {"off": "off, in last digits", "verdict": "verdict"} if has_off else {"verdict": "verdict"}
    bound = element("small", "half is the bound")
    top = [
        element("th", raised(text), bound if kind == "off" else None, scope="col", class_=kind)
        for kind, text in heads.items()
    ]
    body = [_row(table, place, cell, errata, next(numbers), has_off) for place, cell in lines]
    whole = element("table", element("thead", element("tr", top)), element("tbody", body))
    return element("div", whole, class_="scroll", role="region", tabindex=0, aria_label=f"{name}, scrolls sideways")


def _row(
    table: content.ReportTable, place: str, cell: content.ReportCell, errata: Set[str], number: int, has_off: bool
) -> Html:
    printed = _printed(table, place, cell, number)
    verdict = element("td", _verdict(cell, errata), class_="verdict")
    name = element("th", _plain(place), scope="row")
    if max(len(cell.printed), len(cell.ours)) > _LONG and cell.digits is None:  # an expression, over the whole line
        both = [element("div", part) for part in (printed, cell.ours) if part]
        return element("tr", name, element("td", both, class_="expression", colspan=3 if has_off else 2), verdict)
    return element(
        "tr",
        name,
        element("td", printed, class_="num"),
        element("td", cell.ours, class_="num mono"),
        element("td", _residual(cell), class_="off") if has_off else None,
        verdict,
    )


def _printed(table: content.ReportTable, place: str, cell: content.ReportCell, number: int) -> Html | None:
    """The printed number, a button that shows where it comes from."""
    if not cell.printed:
        return None
    facts = {"": word(cell), "read from: ": cell.source, "computed as: ": cell.formula, "unit: ": cell.conversion}
    facts |= {"note: ": cell.note, "errata: ": ", ".join(cell.errata)}
    text = "\n".join(name + fact for name, fact in facts.items() if fact)
    title = element("h4", f"{table.title}: {_plain(place)}")
    popover = element("div", title, text, popover="auto", class_="pop", id=f"p{number}")
    return joined([element("button", cell.printed, class_="n", type="button", popovertarget=f"p{number}"), popover])


def _plain(place: str) -> str:
    """The place of a number in words: names of columns without underscores.

    >>> _plain("3, velocity_average"), _plain("K_p [s^2]")
    ('3, velocity average', 'K_p [s\u00b2]')
    """
    return re.sub("(?<=[a-z]{2})_(?=[a-z]{2})", " ", raised(place))


def _residual(cell: content.ReportCell) -> Html | None:
    """How far ours is off, as a bar and a number of last digits; the bar's end is half a digit."""
    if cell.digits is None:
        return None
    size = abs(cell.digits)
    place = f"{'left' if cell.digits >= 0.0 else 'right'}:50%;width:{100.0 * min(size, 0.5):.0f}%"
    text = "0" if size < 5e-3 else f"{'+' if cell.digits > 0 else ''}{short(cell.digits, 2)}"
    filled = element("u", class_="beyond" if size > 0.5 else None, style=place)
    bar = element("span", filled, class_="bar", aria_hidden="true")
    return joined([bar, element("span", text, class_="digits")])


def _verdict(cell: content.ReportCell, errata: Set[str]) -> Html | None:
    if not cell.verdict:
        return None
    links = [
        element("a", name, class_="erratum-link", href=f"#{anchor('erratum', name)}")
        if name in errata
        else element("span", name, class_="erratum-link")
        for name in cell.errata
    ]
    return joined([glyph(cell), element("span", word(cell), class_="hidden-word" if links else None), links])


def facts_html(facts: Sequence[content.Fact]) -> Html:
    """Names and their texts."""
    pairs = [item for name, text in facts for item in (element("dt", name), element("dd", text))]
    return element("dl", pairs, class_="facts-list")


def folded(title: str, count: str, *body: Html | None, fails: bool = False, name: str = "") -> Html:
    """A part that is folded away under its title; what fails stands open."""
    outcome = element("span", count, class_="count alarm" if fails else "count")
    summary = element("summary", element("h3", title), outcome)
    return element("details", summary, body, class_="box evidence", open=fails, id=name or None)


def erratum_html(entry: LedgerEntry) -> Html:
    """An erratum: what is printed and what is right in one line, the proof on demand."""
    e, proof = entry.erratum, entry.proof
    status, kind = (e.status, "proven" if e.status == "proven" else "likely")
    checked = "no computation decides it" if proof is None else "the computation comes out as stated"
    if not entry.holds:
        status, kind, checked = f"{status}, FAILS", "fails", "THE COMPUTATION DOES NOT COME OUT AS STATED"
    heading = [
        element("span", e.id, class_="id"),
        element("span", e.where, class_="where"),
        element(
            "span",
            element("span" if e.status == "open" else "del", e.printed),
            element("span", " \u2192 ", aria_hidden="true"),
            element("span", "right: ", class_="hidden-word"),
            element("ins", e.read_as),
            class_="change",
        ),
        element("span", status, class_=f"status {kind}"),
    ]
    reason = ("reason", e.why) if proof is None else ("proof", f"{e.why}\n{proof.text}")
    facts: list[content.Fact] = [reason, ("checked", checked), ("effect", e.effect), ("severity", e.severity)]
    body = facts_html([(name, text) for name, text in facts if text])
    return element(
        "details", element("summary", heading), body, id=anchor("erratum", e.id), class_="erratum", tabindex=-1
    )


def checks_html(title: str, checks: Sequence[content.Check]) -> Html:
    """Values against what is allowed, folded while all hold."""
    outcomes = ["holds" if c.holds else "fails as expected" if c.is_expected else "FAILS" for c in checks]
    rows = [
        (
            joined([check.name, element("small", check.note) if check.note else None]),
            element("td", check.value, class_="figure"),
            element("td", check.allowed, class_="figure"),
            element("td", outcome, class_="alarm" if outcome == "FAILS" else None),
        )
        for check, outcome in zip(checks, outcomes, strict=True)
    ]
    good, expected, wrong = (outcomes.count(one) for one in ("holds", "fails as expected", "FAILS"))
    words = [f"{good} hold"]
    if good == len(checks):
        words = [f"all {good} hold" if good > 1 else "it holds"]
    words += [f"{expected} fail as expected"] if expected else []
    words += [f"{wrong} FAIL"] if wrong else []
    table = grid(title, ("check", "value", "allowed", "outcome"), rows)
    return folded(title, ", ".join(words), table, fails=bool(wrong))


def section_html(section: content.ReportSection, runs: Sequence[ReplayedRun]) -> Html:
    """A section, folded away; columns of its text that are aligned with spaces are kept."""
    text = [
        element("pre", part, tabindex=0, role="region", aria_label=part.split("\n")[0][:60])
        if "  " in part
        else element("p", part)
        for part in section.text.split("\n\n")
        if part.strip()
    ]
    lines = len(section.text.splitlines()) + sum(len(table.rows) for table in section.tables)
    count = f"{lines} line{'s' if lines != 1 else ''}" if lines else ""
    return folded(
        section.title,
        count,
        element("div", text, class_="prose") if text else None,
        *(table_html(table.shown(page=True)) for table in section.tables),
        *(figure_html(figure, runs) for figure in section.figures),
        name=anchor("section", section.id),
    )


def files_html(files: Sequence[content.FileFact]) -> Html:
    """Files with their sizes and hashes."""
    rows = [
        (
            file.name,
            file.what,
            element("td", f"{file.size:,}".replace(",", "\u202f"), class_="figure"),
            element("td", element("code", file.sha256), class_="hash"),
        )
        for file in files
    ]
    size = sum(file.size for file in files)
    count = f"{len(files)}, {f'{size / 1e6:.1f} MB' if size > 1e5 else f'{size / 1e3:.0f} kB'}"
    return folded("Files beside this page", count, grid("files", ("file", "what", "bytes", "SHA-256"), rows))
