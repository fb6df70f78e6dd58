"""The report of a study as one HTML file: distributions, what each parameter does, lines of runs, the worst ones.

The worst runs of a study in its page: their parameters in a table, and each as a replay inside the page.

What comes of a sweep once its runs are there: its figures, the worst runs again and whole, and the page.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import DivergenceError
from lwr_dyn.foundation.files import make_folder, write_file
from lwr_dyn.foundation.tables import Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.document import POLICY, document_html
from lwr_dyn.pages.replay.replay_page import (
    RATE,
    replay_html,
    replay_policy,
    resource_text,
    script_safe,
)
from lwr_dyn.pages.replay.replayed_runs import run_places
from lwr_dyn.studies.sweep.charts import (
    MOST_AXES,
    histograms_html,
    indices_html,
    limit_words,
    outwards_html,
    parallel_html,
    same_words,
    tornado_html,
    worst_share_html,
)
from lwr_dyn.studies.sweep.running.sweep import SweepResults
from lwr_dyn.studies.sweep.running.sweep_folder import folder_names
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop
from lwr_dyn.studies.sweep.summary import TORNADO, SweepSummary, draw_columns, summarise
from lwr_dyn.studies.sweep.summary_text import about_text, event_table, notes, quantile_table, share_text, value_text
from lwr_dyn.studies.sweep.sweep_study import SweepStudy

_PACKAGE = "lwr_dyn.studies.sweep"


def write_report(path: str | Path, summary: SweepSummary, worst: Sequence[WorstRun] = ()) -> Path:
    """Write `report_html(summary, worst)` to a file; raises `FileAccessError`."""
    write_file(path, report_html(summary, worst))
    return Path(path)


def report_html(summary: SweepSummary, worst: Sequence[WorstRun] = ()) -> str:
    """The page; the same runs give the same text.

    Parameters
    ----------
    summary : SweepSummary
    worst : sequence of WorstRun
        Those of `summary.worst()` that are to be replayed in the page.
    """
    inks, units = controller_inks(summary), column_units(summary)
    said = "".join(f"<li>{escape(one)}</li>" for one in _sentences(summary))
    main = [
        f'<h1>{escape(summary.title)}</h1><ul class="say">{said}</ul>',
        _card("Controllers", _tables(summary, inks) + _notes(notes(summary))),
        *(_distribution(summary, words.name, inks) for words in summary.focus),
        _influence(summary, inks, units),
        _first_breaks(summary, inks),
        _each(
            summary,
            inks,
            "Runs over all parameters",
            _LINES,
            lambda name: parallel_html(summary, name, inks[name], units),
        ),
        _card("Worst runs", worst_table_html(summary, inks, units, worst) + _replay_place(worst)),
        _card("What was varied", table_html(_parameter_table(summary), kind="words")),
    ]
    scripts = replay_scripts(worst)
    if scripts:
        scripts += f"<script>\n{resource_text('report.js', _PACKAGE)}</script>\n"
    policy = f"{replay_policy(live=False)}; frame-src 'self'; base-uri 'none'" if scripts else POLICY
    style = resource_text("report.css", _PACKAGE)
    return document_html(
        summary.title, "study", "".join(main), "lwr-dyn sweep", style=style, scripts=scripts, policy=policy
    )


_LINES = (
    "Each line is a run, from its first parameter down to the metric. Drawn are the parameters with the largest "
    "effect, each from its least to its largest value."
)


def controller_inks(summary: SweepSummary) -> dict[str, str]:
    """Controller -> the class of its colour, as in every picture of runs; where the grey comes again, it is dashed."""
    names = [(text.split(":")[0].split("+")[0], "", text) for text in summary.controllers]
    inks = [f"r{min(place, 4) + 1}" for place in run_places(names)]
    again = [min(inks[:k].count(ink), 2) for k, ink in enumerate(inks)]
    classes = [f"{ink} again{k}" if k else ink for ink, k in zip(inks, again, strict=True)]
    return dict(zip(summary.controllers, classes, strict=True))


def column_units(summary: SweepSummary) -> dict[str, str]:
    """Column of a parameter -> its unit."""
    return {name: one.unit for one in summary.study.varied for name in (one.path, *one.columns)}


def table_html(table: Table, inks: Mapping[str, str] | None = None, kind: str = "numbers") -> str:
    """A table whose first column names its rows; what stands in brackets is on a line of its own.

    `kind` is "numbers", which stand at the right, or "words".
    """
    head = "".join(f'<th scope="col">{escape(h.title)}</th>' for h in table.columns)
    body = ""
    for first, *rest in table.cells:
        mark = f'<i class="sw {inks[first]}"></i>' if inks and first in inks else ""
        body += f'<tr><th scope="row">{mark}{escape(first)}</th>{"".join(map(_cell, rest))}</tr>'
    label = escape(table.title)
    rows = f"<table class={kind}><caption>{label}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f'<div class="scroll" tabindex="0" role="region" aria-label="{label}">{rows}</div>'


def _cell(text: str) -> str:
    value, bracket, interval = text.partition(" [")
    small = f"<small>[{escape(interval)}</small>" if bracket else ""
    return f"<td>{escape(value)}{small}</td>"


def _sentences(summary: SweepSummary) -> list[str]:
    """How many runs, and how many of each controller keep all limits, the best first."""
    judged = [(one.within, name) for name, one in summary.controllers.items() if one.within is not None]
    judged.sort(key=lambda pair: -pair[0].value)
    said = [
        f"{name} keeps all limits in {share_text(one, summary.is_sample)} of {one.runs} runs." for one, name in judged
    ]
    return [about_text(summary), *said]


def _tables(summary: SweepSummary, inks: Mapping[str, str]) -> str:
    tables = [*(quantile_table(summary, words) for words in summary.focus), event_table(summary)]
    return "".join(table_html(table, inks) for table in tables)


def _notes(said: Sequence[str]) -> str:
    return "".join(f'<p class="note">{escape(note)}</p>' for note in said)


def _card(title: str, inside: str) -> str:
    return f'<section class="card"><h2>{escape(title)}</h2>{inside}</section>'


def _distribution(summary: SweepSummary, metric: str, inks: Mapping[str, str]) -> str:
    figures = {name: one.metrics[metric] for name, one in summary.controllers.items()}
    first = next(iter(figures.values()))
    title = f"{first.words.title[:1].upper()}{first.words.title[1:]}"
    same = same_words(list(figures.values()))
    if same:
        return _card(title, f"<p>{escape(same)}</p>")
    worse = "larger" if first.words.worse > 0 else "smaller"
    curve = (
        f"<h3>Share of the runs with a {worse} value <small>logarithmic; bars: intervals of the quantiles</small></h3>"
        f"{worst_share_html(figures, inks, summary.is_sample)}"
    )
    about = (
        f"<h3>Histograms <small>{escape(first.words.unit)}, {escape(limit_words(list(figures.values())))}</small></h3>"
    )
    return _card(title, f"{about}{histograms_html(figures, inks)}{curve}")


def _each(summary: SweepSummary, inks: Mapping[str, str], title: str, about: str, make: Callable[[str], str]) -> str:
    figures = "".join(
        f'<figure class="{inks[name]}"><figcaption><h3><span><i class="sw {inks[name]}"></i>{escape(name)}</span></h3>'
        f"</figcaption>{make(name)}</figure>"
        for name in summary.controllers
    )
    return _card(title, f'<p class="note">{escape(about)}</p><div class="many">{figures}</div>')


def _influence(summary: SweepSummary, inks: Mapping[str, str], units: Mapping[str, str]) -> str:
    words = summary.focus[0]
    about = (
        f"Bars: the {100 * TORNADO:g} % quantile of {words.title} among the runs of each fifth of a parameter (of each "
        "value where it has few), from the best fifth to the worst; all other parameters vary. The thin line is the "
        "95 % interval at the worst. A hollow bar could be chance (5 % over all parameters)."
    )
    tornado = _each(
        summary, inks, "What each parameter does", about,
        lambda name: tornado_html(summary.controllers[name].metrics[words.name], units),
    )  # fmt: skip
    if summary.study.method != "saltelli":
        return tornado
    about = f"Shares of the variance of {words.title}: filled alone, hollow with all interactions."

    def bars(name: str) -> str:
        found = summary.controllers[name].metrics[words.name].indices
        return '<p class="note">Too few complete groups.</p>' if found is None else indices_html(found)

    return tornado + _each(summary, inks, "Sobol indices", about, bars)


def _first_breaks(summary: SweepSummary, inks: Mapping[str, str]) -> str:
    searches = {name: one.outwards for name, one in summary.controllers.items()}
    if not any(searches.values()):
        return ""
    about = (
        "Each parameter alone goes from its nominal value to the ends of its range, all others stay nominal; what only "
        "a combination breaks is not seen here."
    )

    def gauges(name: str) -> str:
        search = searches[name]
        if search is None:
            return f'<p class="note">Not looked at: {escape(summary.not_searched.get(name, "no runs"))}.</p>'
        return outwards_html(search)

    return _each(summary, inks, "Which parameter breaks a limit first", about, gauges)


def _replay_place(worst: Sequence[WorstRun]) -> str:
    note = '<p class="note">A replay is the run again by simulate; the other figures are those of the study.</p>'
    return f'{note}<div id="replay-place" hidden></div>' if worst else ""


def _parameter_table(summary: SweepSummary) -> Table:
    rows = [
        (one.path, one.words, one.distribution_words, one.unit, "" if one.nominal is None else f"{one.nominal:g}",
         ", ".join(filter(None, (one.kind, one.note))))
        for one in summary.study.parameters
    ]  # fmt: skip
    return Table("Parameters", ("parameter", "what it is", "distribution", "unit", "nominal", "source"), rows)


_DATA = re.compile(r'(<script type="application/json" id="replay-data">)(.*?)(</script>)', re.DOTALL)


@dataclass(frozen=True, slots=True, eq=False)
class WorstRun:
    """A run of a study again, whole, with the arm that was simulated."""

    controller: str
    number: int
    run: Run
    arm: Arm

    @property
    def label(self) -> str:
        """Controller and number of the run."""
        return f"{self.controller}, run {self.number}"


def worst_table_html(
    summary: SweepSummary, inks: Mapping[str, str], units: Mapping[str, str], runs: Sequence[WorstRun]
) -> str:
    """The worst runs with their metrics and parameters; those that are in `runs` have a button for their replay."""
    replays = {(one.controller, one.number): place for place, one in enumerate(runs)}
    first = next(iter(summary.controllers.values()))
    paths, all_paths = _paths(summary), len(draw_columns(summary.study, first.runs))
    heads = [("controller", ""), ("run", ""), ("replay", ""), *((words.title, words.unit) for words in summary.focus)]
    heads += [("flag", ""), *((path, units.get(path, "")) for path in paths)]
    head = "".join(f'<th scope="col">{escape(name)} <small>{escape(unit)}</small></th>' for name, unit in heads)
    body = ""
    for name, figures in summary.controllers.items():
        drawn = draw_columns(summary.study, figures.runs)
        for row in figures.worst[: summary.study.keep]:
            number = int(figures.runs.run[row])
            cells = [value_text(w, float(figures.metrics[w.name].badness[row])) for w in summary.focus]
            cells += [str(figures.runs.flags[row]) or "none", *(_worst_cell(drawn[path][row]) for path in paths)]
            numbers = "".join(f'<td class="n">{escape(cell)}</td>' for cell in cells)
            who = f'<th scope="row"><i class="sw {inks[name]}"></i>{escape(name)}</th><td class="n">{number}</td>'
            body += f"<tr>{who}<td>{_button(name, number, replays.get((name, number)))}</td>{numbers}</tr>"
    more = f'<p class="note">{len(paths)} of {all_paths} parameters; the files of results have all.</p>'
    table = f'<table class="worst-runs"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    scrolled = f'<div class="scroll" tabindex="0" role="region" aria-label="Worst runs">{table}</div>'
    return scrolled + (more if all_paths > len(paths) else "")


def _button(name: str, number: int, place: int | None) -> str:
    if place is None:
        return ""
    more = f'<span class="unseen"> of {escape(name)}, run {number}</span>'
    return f'<button type="button" data-replay="{place}">Replay{more}</button>'


def _paths(summary: SweepSummary) -> list[str]:
    """The parameters that matter most to any controller."""
    ranks: dict[str, int] = {}
    for figures in summary.controllers.values():
        for place, each in enumerate(figures.metrics[summary.focus[0].name].influence):
            ranks[each.path] = min(place, ranks.get(each.path, place))
    first = next(iter(summary.controllers.values()))
    return (
        sorted(ranks, key=lambda path: ranks[path])[:MOST_AXES]
        or list(draw_columns(summary.study, first.runs))[:MOST_AXES]
    )


def _worst_cell(value: Any) -> str:
    return str(value) if isinstance(value, str) else f"{float(np.asarray(value)):.3g}"


def replay_scripts(runs: Sequence[WorstRun]) -> str:
    """Script elements: the page of a replay once without its runs, and the data of each run."""
    if not runs:
        return ""
    pages = [replay_html([one.run], one.arm, labels=[one.label], title="Worst runs", rate=RATE / 2) for one in runs]
    found = [_DATA.search(page) for page in pages]
    data = [json.loads(one[2]) for one in found if one is not None]
    frame = _DATA.sub(lambda one: one[1] + "@@data@@" + one[3], pages[0])
    made = {
        "page": frame,
        "runs": [json.dumps(one, sort_keys=True) for one in data],
        "labels": [one.label for one in runs],
    }
    return f'<script type="application/json" id="replays">{script_safe(json.dumps(made))}</script>\n'


PAGE, WORST = "report.html", "worst"

NO_KERNEL = "it has no kernel form"
"""Why a controller's parameters are not moved alone."""


@dataclass(frozen=True, slots=True, eq=False)
class FinishedSweep:
    """Figures, the page, and the files of the worst runs, which `lwr-dyn replay` shows; None without any run."""

    summary: SweepSummary
    page: Path
    worst: tuple[Path, ...]


def finish(study: SweepStudy, results: SweepResults) -> FinishedSweep | None:
    """Write the page and the worst runs into the folder of a sweep; None where it has no run.

    Which parameter breaks a limit first takes some hundred runs more of each controller; it is left out, and said, for
    one without a kernel. A worst run that diverges when it is made again is left out of the page.

    Raises `FileAccessError` for a folder that cannot be written.
    """
    if not results.controllers:
        return None
    workshop = SweepWorkshop(study)
    slow = {text: NO_KERNEL for text in results.controllers if workshop.is_slow(text)}
    evaluate = partial(workshop.evaluate, hand_over=True)
    summary = summarise(study, results.controllers, evaluate, workshop.arm, slow, results.failures)
    worst = list(_again(workshop, summary))
    place, names = results.folder / WORST, dict(zip(study.controllers, folder_names(study.controllers), strict=True))
    files = []
    for one in worst:
        files.append(make_folder(place) / f"{names[one.controller]}-run-{one.number}.npz")
        one.run.save(files[-1])
    return FinishedSweep(summary, write_report(results.folder / PAGE, summary, worst), tuple(files))


def _again(workshop: SweepWorkshop, summary: SweepSummary) -> Iterator[WorstRun]:
    for text, number in summary.worst():
        try:
            run = workshop.run(text, number)
        except DivergenceError:
            continue
        yield WorstRun(text, number, run, workshop.arm if run.setup is None else run.setup.plant.arm)
