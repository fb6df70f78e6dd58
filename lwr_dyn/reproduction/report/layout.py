"""The layout of a report: top bar, result, motion, numbers, errata, evidence."""

from collections.abc import Iterator, Sequence
from itertools import count

from lwr_dyn.pages.replay.page_parts import fill_template, generator_line, resource_text
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.reproduction.report.blocks import (
    checks_html,
    erratum_html,
    facts_html,
    files_html,
    folded,
    section_html,
)
from lwr_dyn.reproduction.report.content import Page, ReportTable
from lwr_dyn.reproduction.report.figure_html import figure_html
from lwr_dyn.reproduction.report.markup import Html, element, joined
from lwr_dyn.reproduction.report.number_map import number_map
from lwr_dyn.reproduction.report.number_tables import FOLDED, number_table_html
from lwr_dyn.reproduction.report.run_table import rate_note, run_table_html
from lwr_dyn.reproduction.report.still_image import still_html

HERE = "lwr_dyn.reproduction.report"
"""The package of the templates, scripts and styles."""
Part = tuple[str, str, str, list[Html]]
"""A part of the page: its id, its name in the top bar, how many it has, its content."""
_HEADING = 2.0
"""Height of a table's heading in lines of numbers, to part the tables into two columns."""


def header(page: Page, parts: Sequence[Part]) -> Html:
    """The top bar: what the page is, and links to its parts."""
    links = [
        element("a", name, element("span", number, class_="cnt") if number else None, href=f"#{place}")
        for place, name, number, _ in parts
    ]
    what = f"reproduction of {page.subtitle or page.title}"
    return element(
        "header",
        element("div", element("b", "lwr_dyn"), element("span", what)),
        element("nav", links, aria_label="parts of the report"),
        class_="top",
    )


def footer() -> Html:
    """The program that made the page."""
    return element("footer", element("p", f"One file, nothing is loaded. Made by {generator_line()}."))


def parts_of(page: Page) -> list[Part]:
    """The parts of a page in their order, without those that are empty but the result."""
    runs = page.replay.runs if page.replay else ()
    numbers = count()
    parts: list[Part] = [
        ("motion", "Motion", "", [figure_html(figure, runs) for figure in page.figures]),
        ("numbers", "Numbers", str(sum(page.counted.values()) or ""), _numbers(page, numbers)),
        ("errata", "Errata", str(len(page.errata) or ""), _errata(page)),
        ("evidence", "Evidence", "", _evidence(page, runs)),
    ]
    return [("result", "Result", "", _result(page)), *(part for part in parts if part[-1])]


def main(parts: Sequence[Part]) -> Html:
    """The parts; all but the result under a heading."""
    return joined(
        element(
            "section",
            element("h2", name, id=f"{place}-title", class_="hidden-word" if place == "result" else None),
            element("div", body, class_="body"),
            id=place,
            class_="part",
            tabindex=-1,
            aria_labelledby=f"{place}-title",
        )
        for place, name, _, body in parts
    )


def _result(page: Page) -> list[Html]:
    title, byline = element("h1", page.title), page.byline or page.subtitle
    said = element("p", [element("b", text) if strong else text for text, strong in page.verdict], class_="say")
    words = element("details", element("summary", "How this is counted"), element("p", page.words), class_="words")
    lead = [
        title,
        element("p", byline, class_="by") if byline else None,
        said if page.verdict else None,
        number_map(page),
        words if page.words else None,
    ]
    stage = _stage(page)
    return [element("div", lead, class_="lead"), *([stage] if stage else [])]


def _stage(page: Page) -> Html | None:
    """The 3D view: a still until it is asked for; the runs under it."""
    if page.replay is None:
        return None
    runs, controls = page.replay.runs, {"controls": resource_text("controls.html")}
    button = element(
        "button",
        element("span", "\u25b6 ", aria_hidden="true"),
        "Replay in 3D" if runs else "Turn it in 3D",
        type="button",
        id="start-3d",
    )
    still = element("div", still_html(page.replay), button, class_="view")
    player = Html(fill_template(resource_text("player.html", HERE), controls))
    table = [run_table_html(runs), element("p", rate_note(runs), class_="rate")] if runs else []
    return element("section", still, player, table, class_="stage", aria_label="3D view and runs")


def _numbers(page: Page, numbers: Iterator[int]) -> list[Html]:
    known = {entry.erratum.id for entry in page.errata}

    def columns(tables: Sequence[ReportTable]) -> Html:
        cut = _cut([_height(table) for table in tables])
        halves = ([number_table_html(t, known, numbers) for t in half] for half in (tables[:cut], tables[cut:]))
        return element("div", [element("div", half, class_="column") for half in halves], class_="columns")

    out = [columns(page.tables)] if page.tables else []
    if page.derived:
        size = sum(len(table.verdict_cells) for table in page.derived)
        inside = [
            element("p", "Stated by this package, not printed in the paper.", class_="note"),
            columns(page.derived),
        ]
        out.append(folded("Derived numbers", str(size), *inside))
    return out


def _height(table: ReportTable) -> float:
    seen = sum(cell.verdict not in FOLDED for _, cell in table.lines)
    return _HEADING + (seen + _HEADING if seen else 0.0)


def _cut(heights: Sequence[float]) -> int:
    """Where to part a list so that both halves are about equally high."""
    half, total = 0.5 * sum(heights), 0.0
    for k, height in enumerate(heights):
        if total + 0.5 * height > half:
            return max(k, 1)
        total += height
    return len(heights)


def _errata(page: Page) -> list[Html]:
    if not page.errata:
        return []
    switch = element("button", "open all", type="button", class_="open-all", aria_pressed="false")
    proven = sum(entry.holds and entry.erratum.status == "proven" for entry in page.errata)
    summary = f"{len(page.errata)} entries, {proven} of them proven by a computation that runs with this report."
    return [
        element("p", summary, " ", switch, class_="note"),
        element("div", map(erratum_html, page.errata), class_="box errata"),
    ]


def _evidence(page: Page, runs: Sequence[ReplayedRun]) -> list[Html]:
    """What the result rests on, folded; what fails stands open."""
    facts = [*page.document, *page.versions]
    return [
        *([checks_html("Cross-checks of the models", page.checks)] if page.checks else []),
        *([checks_html("Audit of the runs: energy and inverse dynamics", page.audit)] if page.audit else []),
        *(section_html(section, runs) for section in page.sections),
        *([files_html(page.files)] if page.files else []),
        *([folded("The paper, and the versions used", "", facts_html(facts))] if facts else []),
    ]
