"""What stands where on a report: header, navigation, and the parts from summary to files."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files

from lwr_dyn.reproduction.report.content import VERDICTS, Page, Verdict
from lwr_dyn.reproduction.report.ledger import (
    checks_html,
    erratum_html,
    facts_html,
    figure_html,
    files_html,
    section_html,
)
from lwr_dyn.reproduction.report.markup import Html, anchor, element
from lwr_dyn.reproduction.report.payload import all_figures
from lwr_dyn.reproduction.report.tables import CLASS, printed_table_html, sign
from lwr_dyn.viewer.page_parts import fill_template, generator_line, resource_text

_HELP = (
    "Above what is printed, below ours. A cell tells its source, formula and conversion when it is pointed at, tapped "
    "or reached with the arrow keys."
)


def header(page: Page) -> Html:
    """Title and what it is about."""
    return element(
        "header",
        element("h1", page.title),
        element("p", page.subtitle, class_="subtitle") if page.subtitle else None,
        class_="head",
    )


def footer(page: Page) -> Html:
    """What made the page."""
    plotted = ", plots by plotly.js" if all_figures(page) else ""
    return element("footer", f"One file, nothing is loaded. Made by {generator_line()}{plotted}.")


def _summary(page: Page) -> list[Html]:
    counts = page.counted
    total = sum(counts.values())
    tiles = [element("li", _tile(verdict, counts[verdict])) for verdict in VERDICTS]
    bar = [
        element("span", class_=CLASS[verdict], style=f"flex-grow: {counts[verdict]}")
        for verdict in VERDICTS
        if counts[verdict]
    ]
    shown = total > 0
    return _part(
        "summary",
        "Summary",
        element("p", page.words, class_="lead") if page.words else None,
        element("p", f"{total} printed numbers:", class_="total") if shown else None,
        element("ul", tiles, class_="tiles") if shown else None,
        element("div", bar, class_="share", aria_hidden="true") if shown else None,
        facts_html(page.document) if page.document else None,
    )


def _tile(verdict: Verdict, count: int) -> Html:
    inside = [sign(verdict), element("b", str(count)), element("span", verdict)]
    hint = f"show the next number that is: {verdict}" if count else None
    return element(
        "button",
        inside,
        type="button",
        class_=f"tile {CLASS[verdict]}",
        data_verdict=verdict,
        title=hint,
        disabled=not count,
    )


def _theatre(page: Page) -> list[Html]:
    if not (page.replay or page.figures):
        return []
    template = files("lwr_dyn.reproduction.report").joinpath("player.html").read_text(encoding="utf-8")
    player = Html(fill_template(template, {"controls": resource_text("controls.html")}))
    figures = element("div", map(figure_html, page.figures), class_="plots") if page.figures else None
    both = "both" if page.replay and page.figures else "one"
    return _part(
        "replay",
        _theatre_title(page),
        element("div", player if page.replay else None, figures, class_=f"theatre {both}"),
    )


def _theatre_title(page: Page) -> str:
    return "Replay and figures" if page.replay and page.figures else "Figures" if page.figures else "3D view"


def _tables(page: Page) -> list[Html]:
    known = {erratum.id for erratum in page.errata}
    legend = [element("span", sign(verdict), verdict, class_="key") for verdict in VERDICTS]
    return (
        _part(
            "tables",
            "Printed and recomputed",
            element("p", legend, class_="legend"),
            element("p", _HELP, class_="note"),
            *(printed_table_html(table, known) for table in page.tables),
        )
        if page.tables
        else []
    )


def _errata(page: Page) -> list[Html]:
    switch = element("button", "open all", type="button", class_="open-all", aria_pressed="false")
    proven = sum(erratum.holds and erratum.status == "proven" for erratum in page.errata)
    told = f"{len(page.errata)} entries, {proven} of them proven by a computation that runs with this report."
    return (
        _part("errata", "Errata", element("p", told, " ", switch, class_="note"), *map(erratum_html, page.errata))
        if page.errata
        else []
    )


def _sections(page: Page) -> list[Html]:
    return [part for s in page.sections for part in _part(anchor("section", s.id), s.title, *section_html(s))]


def _checks(page: Page) -> list[Html]:
    return [
        *(_part("checks", "Cross-checks", checks_html(page.checks)) if page.checks else []),
        *(_part("audit", "Energy audit", checks_html(page.audit)) if page.audit else []),
    ]


def _made_from(page: Page) -> list[Html]:
    versions = facts_html(page.versions) if page.versions else None
    listed = files_html(page.files) if page.files else None
    return _part("files", "Files and versions", versions, listed) if versions or listed else []


_PARTS: tuple[Callable[[Page], list[Html]], ...] = (
    _summary, _theatre, _tables, _errata, _sections, _checks, _made_from
)  # fmt: skip


def _part(name: str, title: str, *children: Html | None) -> list[Html]:
    return [
        element("section", element("h2", title, id=name, tabindex=-1), children, class_="part", aria_labelledby=name)
    ]


def navigation(page: Page) -> Html:
    """Links to the parts that are there."""
    pairs = [
        ("summary", "Summary", True),
        ("replay", _theatre_title(page), bool(page.replay or page.figures)),
        ("tables", "Tables", bool(page.tables)),
        ("errata", "Errata", bool(page.errata)),
        *((anchor("section", section.id), section.title, True) for section in page.sections),
        ("checks", "Cross-checks", bool(page.checks)),
        ("audit", "Energy audit", bool(page.audit)),
        ("files", "Files", bool(page.files or page.versions)),
    ]
    links = [element("li", element("a", title, href=f"#{name}")) for name, title, there in pairs if there]
    return element("nav", element("ul", links), aria_label="parts of the report")


def parts_of(page: Page) -> list[Html]:
    """All parts of a page, in their order."""
    return [html for part in _PARTS for html in part(page)]
