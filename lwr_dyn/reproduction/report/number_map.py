"""The map of a paper's numbers: each printed number a square, a line a table; it is the page's summary and contents."""

from collections.abc import Sequence

from lwr_dyn.reproduction.report.content import VERDICTS, CellVerdict, Page, ReportCell, ReportTable
from lwr_dyn.reproduction.report.markup import Html, anchor, element

GLYPHS: dict[CellVerdict, str] = {
    "reproduced": "v1",
    "after erratum": "v2",
    "differs": "v4",
    "structural": "v5",
    "repeated in print": "v6",
    "under assumed conditions": "v3",
    "not reproducible": "v7",
    "": "",
}
"""The class of a verdict's square: filled, half, crossed, ...; the shapes need no colour."""
NEAR = "v8"
"""The class of an assumed number that is near."""
_WORDS: dict[CellVerdict, str] = {
    "reproduced": "reproduced",
    "after erratum": "after an erratum",
    "differs": "differ",
    "structural": "structural",
    "repeated in print": "repeated in print",
    "under assumed conditions": "assumed, not near",
    "not reproducible": "not reproducible",
    "": "",
}
ALWAYS: tuple[CellVerdict, ...] = ("reproduced", "after erratum", "differs")
"""Verdicts that the key names even where no number has them."""
_SMALL = 6
"""Tables of at most so many numbers share a line."""


def glyph(cell: ReportCell) -> Html | None:
    """The square of a number; nothing for a cell that is only shown."""
    return element("i", class_=f"g {_class(cell)}") if cell.verdict else None


def word(cell: ReportCell) -> str:
    """The verdict of a number in words."""
    return cell.word or {"after erratum": "after an erratum"}.get(cell.verdict, cell.verdict)


def _class(cell: ReportCell) -> str:
    return NEAR if cell.near else GLYPHS[cell.verdict]


def number_map(page: Page) -> Html | None:
    """The key with its counts and a line for each table of the paper; None for a page without numbers."""
    cells = [cell for table in page.tables for cell in table.verdict_cells]
    if not cells:
        return None
    lines = [element("li", _line(tables), class_=_size(tables)) for tables in _grouped(page.tables)]
    return element(
        "div", _key(page, cells), element("ul", lines, class_="map", aria_label="Every printed number by table")
    )


def _key(page: Page, cells: Sequence[ReportCell]) -> Html:
    """What the squares mean and how many there are."""
    counted = page.counted
    near = sum(cell.near is True for cell in cells)
    items: list[tuple[str, int, str]] = []
    for verdict in VERDICTS:
        if verdict == "under assumed conditions" and counted[verdict]:
            items += [(NEAR, near, "assumed, near"), (GLYPHS[verdict], counted[verdict] - near, _WORDS[verdict])]
        elif counted[verdict] or verdict in ALWAYS:
            items.append((GLYPHS[verdict], counted[verdict], _WORDS[verdict]))
    shown = [element("li", element("i", class_=f"g {shape}"), f"{count} {name}") for shape, count, name in items]
    return element("ul", shown, class_="key", aria_label="Verdicts")


def _grouped(tables: Sequence[ReportTable]) -> list[list[ReportTable]]:
    """Tables of one place in the paper together."""
    groups: dict[str, list[ReportTable]] = {}
    for table in tables:
        if table.verdict_cells:
            groups.setdefault(table.title, []).append(table)
    return list(groups.values())


def _size(tables: Sequence[ReportTable]) -> str | None:
    return None if sum(len(table.verdict_cells) for table in tables) > _SMALL else "small"


def _line(tables: Sequence[ReportTable]) -> Html:
    cells = [cell for table in tables for cell in table.verdict_cells]
    words = [word(cell) for cell in cells]
    said = ", ".join(f"{words.count(one)} {one}" for one in dict.fromkeys(words))
    title = tables[0].title
    return element(
        "a",
        element("span", title, class_="ml"),
        element("span", [glyph(cell) for cell in cells], class_="mc", role="img", aria_label=said),
        element("span", str(len(cells)), class_="mn"),
        href=f"#{anchor('table', tables[0].id)}",
        title=f"{title}: {said}",
    )
