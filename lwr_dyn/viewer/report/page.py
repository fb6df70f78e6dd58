"""A report as one HTML file: what is told stands in it as HTML; the scripts add the 3D replay and the plots.

Nothing is loaded: the libraries (meshcat with three.js, plotly.js) and the numbers are in the page, compressed, and its
content security policy forbids requests and code made from text.
"""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Callable
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from lwr_dyn.errors import MissingDataError
from lwr_dyn.files import write_file
from lwr_dyn.viewer.html import PLAYER, beside_this_file, filled, made_by, meshcat_bundle
from lwr_dyn.viewer.report.content import VERDICTS, Page
from lwr_dyn.viewer.report.ledger import (
    checks_html,
    erratum_html,
    facts_html,
    figure_html,
    files_html,
    section_html,
)
from lwr_dyn.viewer.report.markup import Html, anchor, element, joined
from lwr_dyn.viewer.report.payload import all_plots, payload
from lwr_dyn.viewer.report.tables import CLASS, sign, table_html

_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src 'none'; base-uri 'none'; form-action 'none'"
)
_SCRIPTS = ("loader.js", "cells.js", "charts.js", "overlay.js", "report.js")
_WITHOUT_3D = PLAYER[:1]


def report_html(page: Page) -> str:
    """One self-contained page that shows a report; the same records give the same text.

    Parameters
    ----------
    page : Page
        Everything it shows.

    Raises
    ------
    OptionError
        A plot of a run or joint that is not on the page.
    ShapeError
        A run that is empty, not finite, or has other joints than its arm.
    MissingDataError
        The installed meshcat or plotly lacks its script.
    """
    data = json.dumps(payload(page), sort_keys=True, separators=(",", ":"), allow_nan=False)
    libraries = {"numbers": data}
    if page.replay is not None:
        libraries["player"] = "\n".join([meshcat_bundle(), *map(beside_this_file, PLAYER)])
    else:
        libraries["player"] = "\n".join(map(beside_this_file, _WITHOUT_3D))
    if all_plots(page):
        libraries["plotly"] = plotly_bundle()
    parts = {
        "title": element("title", page.title),
        "policy": _POLICY,
        "style": beside_this_file("player.css") + _beside_this_file("report.css"),
        "signs": _beside_this_file("signs.svg"),
        "navigation": _navigation(page),
        "header": _header(page),
        "main": joined(part for section in _SECTIONS for part in section(page)),
        "footer": _footer(page),
        "libraries": joined(_library(name, text) for name, text in libraries.items()),
        "scripts": "\n".join(map(_beside_this_file, _SCRIPTS)),
    }
    return filled(_beside_this_file("report.html"), parts)


def write_report(path: str | Path, page: Page) -> None:
    """Write `report_html(page)` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, report_html(page))


def plotly_bundle() -> str:
    """The installed plotly.js; raises `MissingDataError` when it is not there."""
    spec = find_spec("plotly")
    script = Path(spec.origin or "").parent / "package_data" / "plotly.min.js" if spec else Path()
    if not script.is_file():
        raise MissingDataError("plotly", "package_data/plotly.min.js", "a report; install plotly again")
    return script.read_text(encoding="utf-8")


def _library(name: str, text: str) -> Html:
    """A text, compressed, as the loader unpacks it."""
    packed = base64.b64encode(gzip.compress(text.encode(), compresslevel=9, mtime=0)).decode("ascii")
    return Html(f'<script type="text/plain" id="packed-{name}">{packed}</script>\n')


def _header(page: Page) -> Html:
    return element(
        "header",
        element("h1", page.title),
        element("p", page.subtitle, class_="subtitle") if page.subtitle else None,
        class_="head",
    )


def _footer(page: Page) -> Html:
    plotted = ", plots by plotly.js" if all_plots(page) else ""
    return element("footer", f"One file, nothing is loaded. Made by {made_by()}{plotted}.")


def _summary(page: Page) -> list[Html]:
    counts = page.counted
    total = sum(counts.values())
    tiles = [
        element(
            "li",
            sign(verdict),
            element("b", str(counts[verdict])),
            element("span", verdict),
            class_=f"tile {CLASS[verdict]}",
        )
        for verdict in VERDICTS
    ]
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


def _theatre(page: Page) -> list[Html]:
    if not (page.replay or page.plots):
        return []
    player = Html(filled(_beside_this_file("player.html"), {"controls": beside_this_file("controls.html")}))
    plots = element("div", map(figure_html, page.plots), class_="plots") if page.plots else None
    both = "both" if page.replay and page.plots else "one"
    return _part(
        "replay",
        _theatre_title(page),
        element("div", player if page.replay else None, plots, class_=f"theatre {both}"),
    )


def _theatre_title(page: Page) -> str:
    return "Replay and figures" if page.replay and page.plots else "Figures" if page.plots else "3D view"


def _tables(page: Page) -> list[Html]:
    known = {erratum.id for erratum in page.errata}
    legend = [element("span", sign(verdict), verdict, class_="key") for verdict in VERDICTS]
    help_ = "A cell tells its source, formula and conversion when it is pointed at, tapped or reached with the arrow keys."
    return _part(
        "tables",
        "Printed and recomputed",
        element("p", legend, class_="legend"),
        element("p", "Above what is printed, below ours. ", help_, class_="note"),
        *(table_html(table, known) for table in page.tables),
    ) if page.tables else []


def _errata(page: Page) -> list[Html]:
    switch = element("button", "open all", type="button", class_="open-all", aria_pressed="false")
    proven = sum(erratum.holds and erratum.status == "proven" for erratum in page.errata)
    told = f"{len(page.errata)} entries, {proven} of them proven by a computation that runs with this report."
    return _part(
        "errata", "Errata", element("p", told, " ", switch, class_="note"), *map(erratum_html, page.errata)
    ) if page.errata else []


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


_SECTIONS: tuple[Callable[[Page], list[Html]], ...] = (
    _summary, _theatre, _tables, _errata, _sections, _checks, _made_from
)  # fmt: skip


def _part(name: str, title: str, *children: Html | None) -> list[Html]:
    return [element("section", element("h2", title, id=name, tabindex=-1), children, class_="part", aria_labelledby=name)]


def _navigation(page: Page) -> Html:
    pairs = [
        ("summary", "Summary", True),
        ("replay", _theatre_title(page), bool(page.replay or page.plots)),
        ("tables", "Tables", bool(page.tables)),
        ("errata", "Errata", bool(page.errata)),
        *((anchor("section", section.id), section.title, True) for section in page.sections),
        ("checks", "Cross-checks", bool(page.checks)),
        ("audit", "Energy audit", bool(page.audit)),
        ("files", "Files", bool(page.files or page.versions)),
    ]
    links = [element("li", element("a", title, href=f"#{name}")) for name, title, there in pairs if there]
    return element("nav", element("ul", links), aria_label="parts of the report")


def _beside_this_file(name: str) -> str:
    return files("lwr_dyn.viewer.report").joinpath(name).read_text(encoding="utf-8")
