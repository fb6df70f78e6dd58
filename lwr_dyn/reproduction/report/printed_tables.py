"""The document's tables beside ours as HTML: a verdict per cell, and the source of each number."""

from collections.abc import Sequence, Set

from lwr_dyn.reproduction.report.content import CellVerdict, ReportCell, ReportRow, ReportTable
from lwr_dyn.reproduction.report.markup import Html, anchor, element, grid, joined, raised

CLASS: dict[CellVerdict, str] = {
    "reproduced": "reproduced",
    "after erratum": "after",
    "differs": "differs",
    "structural": "structural",
    "repeated in print": "repeated",
    "under assumed conditions": "assumed",
    "not reproducible": "open",
    "": "shown",
}
"""Of each verdict: the class of its cell and the name of its sign."""

QUIET: tuple[CellVerdict, ...] = ("", "reproduced", "structural", "repeated in print")
"""Verdicts whose sign is enough."""


def sign(verdict: CellVerdict) -> Html | None:
    """The shape that marks a verdict; the page shows it beside the word."""
    if verdict == "":
        return None
    use = element("use", href=f"#sign-{CLASS[verdict]}")
    return element("svg", use, class_=f"sign {CLASS[verdict]}", viewBox="0 0 16 16", aria_hidden="true")


def printed_table_html(table: ReportTable, errata: Set[str]) -> Html:
    """A table with its heading; `errata` are the ids that are on the page."""
    name = anchor("table", table.id)
    unit = f" [{raised(table.unit)}]" if table.unit else ""
    rows = [
        (
            row.label,
            *(_cell(c, f"{row.label}, {column}", errata) for c, column in zip(row.cells, table.columns, strict=True)),
        )
        for row in table.rows
    ]
    head = (table.row_heading, *table.columns)
    return element(
        "section",
        element("h3", table.title, element("span", f"{table.where}{unit}", class_="where"), id=name),
        element("p", table.note, class_="note") if table.note else None,
        grid(table.title, head, rows, "printed", aria_labelledby=name),
        _how(table),
        class_="block",
    )


def _cell(cell: ReportCell, place: str, errata: Set[str]) -> Html:
    quiet = "word" if cell.verdict in QUIET else "word seen"
    inside = [
        element("span", sign(cell.verdict), cell.printed, class_="number"),
        element("span", cell.ours, class_="ours") if cell.ours else None,
        element("span", cell.word or cell.verdict, class_=quiet) if cell.verdict else None,
    ]
    facts = {f"data_{name}": getattr(cell, name) or None for name in ("source", "formula", "conversion", "note")}
    button = element(
        "button", inside, type="button", class_="cell", data_place=place, data_verdict=cell.verdict, **facts
    )
    links = [_erratum_link(name, errata) for name in cell.errata]
    return element("td", button, links, class_=CLASS[cell.verdict])


def _erratum_link(name: str, errata: Set[str]) -> Html:
    if name not in errata:
        return element("span", name, class_="erratum-link")
    return element("a", name, class_="erratum-link", href=f"#{anchor('erratum', name)}")


def _how(table: ReportTable) -> Html | None:
    """Formulas and conversions as text: for print, for readers of the whole, for screen readers."""
    groups: dict[tuple[str, str, str], list[tuple[ReportRow, int]]] = {}
    for row in table.rows:
        for i, cell in enumerate(row.cells):
            groups.setdefault((cell.formula, cell.conversion, cell.note), []).append((row, i))
    groups.pop(("", "", ""), None)
    if not groups:
        return None
    items = [element("li", _sentence(*key), element("span", _places(table, cells))) for key, cells in groups.items()]
    return element("details", element("summary", "How each number was computed"), element("ul", items), class_="how")


def _sentence(formula: str, conversion: str, note: str) -> Html:
    words = [element("code", formula) if formula else None, conversion or None, note or None]
    return element("p", joined([[word, ". "] for word in words if word]))


def _places(table: ReportTable, cells: Sequence[tuple[ReportRow, int]]) -> str:
    """The places of a group of cells in the table, row by row, and in the document."""
    rows: dict[str, list[int]] = {}
    for row, i in cells:
        rows.setdefault(row.label, []).append(i)
    whole = len(cells) == sum(len(row.cells) for row in table.rows)
    named = [f"{label}: {_columns(table, columns)}" for label, columns in rows.items()]
    sources = list(dict.fromkeys(row.cells[i].source for row, i in cells if row.cells[i].source))
    read = f" Read from {'; '.join(sources)}." if sources else ""
    return ("All cells." if whole else f"{'; '.join(named)}.") + read


def _columns(table: ReportTable, columns: Sequence[int]) -> str:
    if len(columns) == len(table.columns) > 1:
        return "all"
    return ", ".join(raised(table.columns[i]) for i in columns)
