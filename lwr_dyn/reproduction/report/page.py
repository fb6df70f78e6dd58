"""A report as one HTML file: text, tables and figures are HTML and SVG; scripts add the 3D replay, cursors and zoom.

Nothing is loaded: the library of the 3D view (meshcat with three.js) and the numbers are in the page, compressed, and
its content security policy forbids requests and code made from text. Runs have 100 samples a second, packed once for
3D view and figures. The layout: top bar, result, motion, numbers, errata, evidence.
"""

import base64
import gzip
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from itertools import count
from pathlib import Path
from typing import Any, cast

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.files import write_file
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.figure import Curve, Figure, Series, SeriesName, run_series
from lwr_dyn.pages.markup import Html, element, joined
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.look import font_faces, look_css
from lwr_dyn.pages.replay.replay_page import PLAYER, RATE, fill_template, pack_int32, resource_text, subsample
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, pose_as_run, replayed_runs
from lwr_dyn.reproduction.report import blocks
from lwr_dyn.reproduction.report.content import Page, Replay, ReportTable
from lwr_dyn.reproduction.report.figure_html import figure_html
from lwr_dyn.reproduction.report.still_image import rate_note, run_table_html, still_html

LARGEST_CURVE = 1500
"""Points of a curve given as numbers; of longer ones points are left out."""

_AS_TEXT = 48
"""Shorter curves are written as decimal numbers."""

_FROM_PLAYER: tuple[SeriesName, ...] = ("q", "q_ref", "position error", "tip error")
"""Quantities that the player's own series hold."""


def script_data(page: Page) -> dict[str, Any]:
    """Runs, stills, arms and figures of a page; raises `OptionError` for a series of no run or joint of the page."""
    figures, replay = page.all_figures, page.replay
    series = [one for figure in figures for curve in figure.curves for one in curve.series]
    for one in series:
        one.values(replay.runs if replay else ())  # raises for a run or joint that is not there
    pool: dict[bytes, Array] = {}
    data: dict[str, Any] = {"figures": [_figure(figure, pool) for figure in figures]}
    data |= {"numbers": list(map(_packed_numbers, pool.values()))}
    return data if replay is None else data | _replay(replay, series)


def _replay(replay: Replay, series: Sequence[Series]) -> dict[str, Any]:
    """The runs with the series that the player does not hold, the stills, and the arms."""
    packed = [
        {
            name: run_series(one, name)
            for name in dict.fromkeys(name for s in series if s.run == i for name in _needed(s))
            if name not in _FROM_PLAYER
        }
        for i, one in enumerate(replay.runs)
    ]
    stills = [replayed_runs([pose_as_run(one.arm, one.q)], one.arm, [one.label])[0] for one in replay.stills]
    records = [_run(one, page_stride(one.run), more) for one, more in zip(replay.runs, packed, strict=True)]
    shapes = [command for i, one in enumerate([*replay.runs, *stills]) for command in replay_page.arm_commands(one, i)]
    return {
        "runs": records,
        "stills": [
            replay_page.run_record(one) | {"note": still.note} for one, still in zip(stills, replay.stills, strict=True)
        ],
        "scene": shapes,
        "made_by": replay_page.generator_line(),
        "start": {"trace": True, "frames": False, "beside": False},
    }


def _needed(series: Series) -> tuple[SeriesName, ...]:
    """The quantities behind a series: a path with its errors magnified takes its reference too."""
    quantity = series.quantity
    reference = quantity.replace("flange", "reference") if quantity.startswith("flange ") else quantity
    return quantity, cast(SeriesName, reference)


def page_stride(run: Run) -> int:
    """Which samples of a run a page has: every so many, for at least `RATE` a second."""
    lasts = float(run.t[-1] - run.t[0])
    return 1 if lasts == 0.0 else max(1, int((run.t.size - 1) / lasts / RATE + 1e-6))


def _run(one: ReplayedRun, stride: int, more: Mapping[SeriesName, Array]) -> dict[str, Any]:
    keep = subsample(one.run.t.size, stride)
    series = {name: pack_int32(values[keep]) for name, values in more.items()}
    return replay_page.run_record(one, stride) | {"series": series}


def _figure(figure: Figure, pool: dict[bytes, Array]) -> dict[str, Any]:
    panels = []
    for panel in figure.panels:
        curves = [_curve(figure, curve, pool) for curve in panel.curves]
        panels.append(_fields(panel) | {"curves": curves, "levels": [_fields(level) for level in panel.levels]})
    return _fields(figure) | {"panels": panels}


def _curve(figure: Figure, curve: Curve, pool: dict[bytes, Array]) -> dict[str, Any]:
    size = 1 if isinstance(curve.y, Series) else curve.y.size
    keep = subsample(size, -(-size // LARGEST_CURVE))
    x, y = (_source(value, keep, pool) for value in (curve.x, curve.y))
    text = [curve.text[i] for i in keep] if curve.text else []
    return _fields(curve) | {"x": x, "y": y, "text": text}


def _fields(record: Any) -> dict[str, Any]:
    """The fields of a record of `pages.figures.figure`, as they are."""
    return {field.name: getattr(record, field.name) for field in fields(record)}


def _source(values: Array | Series | None, keep: Any, pool: dict[bytes, Array]) -> Any:
    """A series by its name, numbers by their place in the pool, which keeps the same numbers once."""
    if isinstance(values, Series):
        return _fields(values)
    if values is None:
        return None
    kept = values[keep]
    pool.setdefault(kept.tobytes(), kept)
    return list(pool).index(kept.tobytes())


def _packed_numbers(values: Array) -> Any:
    """Numbers as a list with null for a gap, or packed with the places of its gaps."""
    gaps = np.flatnonzero(~np.isfinite(values))
    if values.size <= _AS_TEXT:
        return [float(x) if np.isfinite(x) else None for x in values]
    return pack_int32(np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)) | {"gaps": gaps.tolist()}


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
    return element("footer", element("p", f"One file, nothing is loaded. Made by {replay_page.generator_line()}."))


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
    byline = page.byline or page.subtitle
    said = element("p", [element("b", text) if strong else text for text, strong in page.verdict], class_="say")
    words = element("details", element("summary", "How this is counted"), element("p", page.words), class_="words")
    lead = [
        element("h1", page.title),
        element("p", byline, class_="by") if byline else None,
        said if page.verdict else None,
        blocks.number_map(page),
        words if page.words else None,
    ]
    return [element("div", lead, class_="lead"), *filter(None, [_stage(page)])]


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
        seen = [sum(cell.verdict not in blocks.FOLDED for _, cell in table.lines) for table in tables]
        cut = _cut([_HEADING + (lines + _HEADING if lines else 0.0) for lines in seen])
        halves = ([blocks.number_table_html(t, known, numbers) for t in half] for half in (tables[:cut], tables[cut:]))
        return element("div", [element("div", half, class_="column") for half in halves], class_="columns")

    out = [columns(page.tables)] if page.tables else []
    if page.derived:
        size = sum(len(table.verdict_cells) for table in page.derived)
        note = element("p", "Stated by this package, not printed in the paper.", class_="note")
        out.append(blocks.folded("Derived numbers", str(size), note, columns(page.derived)))
    return out


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
        element("div", map(blocks.erratum_html, page.errata), class_="box errata"),
    ]


def _evidence(page: Page, runs: Sequence[ReplayedRun]) -> list[Html]:
    """What the result rests on, folded; what fails stands open."""
    facts = [*page.document, *page.versions]
    return [
        *([blocks.checks_html("Cross-checks of the models", page.checks)] if page.checks else []),
        *([blocks.checks_html("Audit of the runs: energy and inverse dynamics", page.audit)] if page.audit else []),
        *(blocks.section_html(section, runs) for section in page.sections),
        *([blocks.files_html(page.files)] if page.files else []),
        *([blocks.folded("The paper, and the versions used", "", blocks.facts_html(facts))] if facts else []),
    ]


_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; font-src data:; "
    "connect-src 'none'; base-uri 'none'; form-action 'none'"
)

_SCRIPTS = ("loader.js", "series.js", "charts.js", "report.js")


def report_html(page: Page) -> str:
    """One self-contained page that shows a report; the same records give the same text.

    Parameters
    ----------
    page : Page
        Its content.

    Raises
    ------
    OptionError
        A figure of a run or joint that is not on the page.
    MissingDataError
        The installed meshcat lacks its script.
    """
    data = json.dumps(script_data(page), sort_keys=True, separators=(",", ":"), allow_nan=False)
    libraries = {"numbers": data}
    if page.replay is not None:
        libraries["player"] = "\n".join([replay_page.meshcat_bundle(), *map(resource_text, PLAYER[1:])])
    parts = parts_of(page)
    filling = {
        "title": element("title", page.title),
        "policy": _POLICY,
        "style": "\n".join((font_faces(), look_css(), resource_text("player.css"), resource_text("report.css", HERE))),
        "header": header(page, parts),
        "main": main(parts),
        "footer": footer(),
        "libraries": joined(_library(name, text) for name, text in libraries.items()),
        "scripts": "\n".join([resource_text(PLAYER[0]), *(resource_text(name, HERE) for name in _SCRIPTS)]),
    }
    return fill_template(resource_text("report.html", HERE), filling)


def write_report(path: str | Path, page: Page) -> None:
    """Write `report_html(page)` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, report_html(page))


def _library(name: str, text: str) -> Html:
    """A text, compressed; the loader unpacks it."""
    packed = base64.b64encode(gzip.compress(text.encode(), compresslevel=9, mtime=0)).decode("ascii")
    return Html(f'<script type="text/plain" id="packed-{name}">{packed}</script>\n')
