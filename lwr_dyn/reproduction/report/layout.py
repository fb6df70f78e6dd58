"""The layout of a report: header, navigation, and the parts from summary to files."""

from collections.abc import Sequence

from lwr_dyn.reproduction.report.blocks import (
    checks_html,
    erratum_html,
    facts_html,
    figure_html,
    files_html,
    section_html,
)
from lwr_dyn.reproduction.report.content import VERDICTS, CellVerdict, Page
from lwr_dyn.reproduction.report.markup import Html, anchor, element, joined
from lwr_dyn.reproduction.report.printed_tables import CLASS, printed_table_html, sign
from lwr_dyn.reproduction.report.script_data import all_figures
from lwr_dyn.viewer.page_parts import fill_template, generator_line, resource_text

HERE = "lwr_dyn.reproduction.report"
"""The package of the templates, scripts and styles."""
Part = tuple[str, str, str, list[Html]]
"""A part of the page: its id, its name in the navigation, its heading, its content."""
_HELP = (
    "Above what is printed, below ours. A cell tells its source, formula and conversion when it is pointed at, tapped "
    "or reached with the arrow keys."
)


def header(page: Page) -> Html:
    """Title and subtitle."""
    return element(
        "header",
        element("h1", page.title),
        element("p", page.subtitle, class_="subtitle") if page.subtitle else None,
        class_="head",
    )


def footer(page: Page) -> Html:
    """The programs that made the page."""
    plotted = ", plots by plotly.js" if all_figures(page) else ""
    return element("footer", f"One file, nothing is loaded. Made by {generator_line()}{plotted}.")


def parts_of(page: Page) -> list[Part]:
    """The parts of a page in their order, without those that are empty but the summary."""
    theatre = "Replay and figures" if page.replay and page.figures else "Figures" if page.figures else "3D view"
    parts: list[Part] = [
        ("replay", theatre, theatre, _theatre(page)),
        ("tables", "Tables", "Printed and recomputed", _tables(page)),
        ("errata", "Errata", "Errata", _errata(page)),
        *((anchor("section", s.id), s.title, s.title, section_html(s)) for s in page.sections),
        ("checks", "Cross-checks", "Cross-checks", [checks_html(page.checks)] if page.checks else []),
        (
            "audit",
            "Audit",
            "Audit of the runs: energy and inverse dynamics",
            [checks_html(page.audit)] if page.audit else [],
        ),
        ("files", "Files", "Files and versions", _files(page)),
    ]
    return [("summary", "Summary", "Summary", _summary(page)), *(part for part in parts if part[-1])]


def navigation(parts: Sequence[Part]) -> Html:
    """Links to the parts."""
    links = [element("li", element("a", link, href=f"#{name}")) for name, link, _, _ in parts]
    return element("nav", element("ul", links), aria_label="parts of the report")


def main(parts: Sequence[Part]) -> Html:
    """The parts under their headings."""
    return joined(
        element("section", element("h2", title, id=name, tabindex=-1), body, class_="part", aria_labelledby=name)
        for name, _, title, body in parts
    )


def _summary(page: Page) -> list[Html]:
    counts = page.counted
    total = sum(counts.values())
    body = [element("p", page.words, class_="lead")] if page.words else []
    if total:
        bar = [
            element("span", class_=CLASS[verdict], style=f"flex-grow: {count}")
            for verdict, count in counts.items()
            if count
        ]
        tiles = [element("li", _tile(verdict, count)) for verdict, count in counts.items()]
        body += [
            element("p", f"{total} printed numbers:", class_="total"),
            element("ul", tiles, class_="tiles"),
            element("div", bar, class_="share", aria_hidden="true"),
        ]
    return [*body, facts_html(page.document)] if page.document else body


def _tile(verdict: CellVerdict, count: int) -> Html:
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
    inside = []
    if page.replay:
        controls = {"controls": resource_text("controls.html")}
        inside.append(Html(fill_template(resource_text("player.html", HERE), controls)))
    if page.figures:
        inside.append(element("div", map(figure_html, page.figures), class_="plots"))
    count = {0: "", 1: "one", 2: "both"}[len(inside)]
    return [element("div", inside, class_=f"theatre {count}")] if inside else []


def _tables(page: Page) -> list[Html]:
    if not page.tables:
        return []
    known = {entry.erratum.id for entry in page.errata}
    legend = [element("span", sign(verdict), verdict, class_="key") for verdict in VERDICTS]
    return [
        element("p", legend, class_="legend"),
        element("p", _HELP, class_="note"),
        *(printed_table_html(table, known) for table in page.tables),
    ]


def _errata(page: Page) -> list[Html]:
    if not page.errata:
        return []
    switch = element("button", "open all", type="button", class_="open-all", aria_pressed="false")
    proven = sum(entry.holds and entry.erratum.status == "proven" for entry in page.errata)
    summary = f"{len(page.errata)} entries, {proven} of them proven by a computation that runs with this report."
    return [element("p", summary, " ", switch, class_="note"), *map(erratum_html, page.errata)]


def _files(page: Page) -> list[Html]:
    versions = [facts_html(page.versions)] if page.versions else []
    return [*versions, files_html(page.files)] if page.files else versions
