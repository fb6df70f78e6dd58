"""Printed numbers beside ours as HTML: one line a number, what came out as printed folded away.

Behind each printed number is a popover, which needs no script, with its place in the paper, its formula and unit.
"""

import re
from collections.abc import Iterator, Sequence, Set

from lwr_dyn.pages.plotting.axes import raised, short
from lwr_dyn.reproduction.report.content import CellVerdict, ReportCell, ReportTable
from lwr_dyn.reproduction.report.markup import Html, anchor, element, joined
from lwr_dyn.reproduction.report.number_map import glyph, word

FOLDED: tuple[CellVerdict, ...] = ("reproduced", "structural", "repeated in print", "")
"""Verdicts of numbers that are folded away: nothing is wrong with them."""
_LONG = 14
"""Characters from which an expression is written over the whole line."""
Line = tuple[str, ReportCell]
"""The name of a number in its table, and the number."""


def number_table_html(table: ReportTable, errata: Set[str], numbers: Iterator[int]) -> Html:
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


def _rows(table: ReportTable, lines: Sequence[Line], name: str, errata: Set[str], numbers: Iterator[int]) -> Html:
    heads = {"place": table.row_heading or "number", "num": "printed", "ours num": "recomputed"}
    has_off = any(cell.digits is not None for _, cell in lines)
    heads |= {"off": "off, in last digits"} if has_off else {}
    heads |= {"verdict": "verdict"}
    bound = element("small", "half is the bound")
    top = [
        element("th", raised(text), bound if kind == "off" else None, scope="col", class_=kind)
        for kind, text in heads.items()
    ]
    body = [_row(table, place, cell, errata, next(numbers), has_off) for place, cell in lines]
    whole = element("table", element("thead", element("tr", top)), element("tbody", body))
    return element("div", whole, class_="scroll", role="region", tabindex=0, aria_label=f"{name}, scrolls sideways")


def _row(table: ReportTable, place: str, cell: ReportCell, errata: Set[str], number: int, has_off: bool) -> Html:
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


def _printed(table: ReportTable, place: str, cell: ReportCell, number: int) -> Html | None:
    """The printed number, a button that shows where it comes from."""
    if not cell.printed:
        return None
    facts = [
        ("", word(cell)),
        ("read from: ", cell.source),
        ("computed as: ", cell.formula),
        ("unit: ", cell.conversion),
        ("note: ", cell.note),
        ("errata: ", ", ".join(cell.errata)),
    ]
    text = "\n".join(name + fact for name, fact in facts if fact)
    title = element("h4", f"{table.title}: {_plain(place)}")
    popover = element("div", title, text, popover="auto", class_="pop", id=f"p{number}")
    return joined([element("button", cell.printed, class_="n", type="button", popovertarget=f"p{number}"), popover])


def _plain(place: str) -> str:
    """The place of a number in words: names of columns without underscores.

    >>> _plain("3, velocity_average"), _plain("K_p [s^2]")
    ('3, velocity average', 'K_p [s\u00b2]')
    """
    return re.sub("(?<=[a-z]{2})_(?=[a-z]{2})", " ", raised(place))


def _residual(cell: ReportCell) -> Html | None:
    """How far ours is off, as a bar and a number of last digits; the bar's end is half a digit."""
    if cell.digits is None:
        return None
    share = min(abs(cell.digits), 0.5) * 100.0
    side = "left" if cell.digits >= 0.0 else "right"
    beyond = " beyond" if abs(cell.digits) > 0.5 else ""
    text = "0" if abs(cell.digits) < 5e-3 else f"{'+' if cell.digits > 0 else ''}{short(cell.digits, 2)}"
    bar = element(
        "span",
        element("u", class_=beyond.strip() or None, style=f"{side}:50%;width:{share:.0f}%"),
        class_="bar",
        aria_hidden="true",
    )
    return joined([bar, element("span", text, class_="digits")])


def _verdict(cell: ReportCell, errata: Set[str]) -> Html | None:
    if not cell.verdict:
        return None
    links = [_erratum_link(name, errata) for name in cell.errata]
    quiet = "hidden-word" if links else None
    return joined([glyph(cell), element("span", word(cell), class_=quiet), links])


def _erratum_link(name: str, errata: Set[str]) -> Html:
    if name not in errata:
        return element("span", name, class_="erratum-link")
    return element("a", name, class_="erratum-link", href=f"#{anchor('erratum', name)}")
