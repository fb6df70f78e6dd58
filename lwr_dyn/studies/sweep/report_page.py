"""The report of a study as one HTML file, and what comes of a finished sweep: figures, page, and the worst runs."""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path

from lwr_dyn.foundation.errors import DivergenceError
from lwr_dyn.foundation.files import make_folder, write_file
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.document import POLICY, document_html, table_html
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.replayed_runs import run_places
from lwr_dyn.studies.sweep import charts
from lwr_dyn.studies.sweep.intervals import share_text
from lwr_dyn.studies.sweep.running.sweep_folder import SweepResults, folder_names
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop
from lwr_dyn.studies.sweep.summary import TORNADO, SweepSummary, draw_columns, summarise
from lwr_dyn.studies.sweep.summary_document import about_text, event_table, notes, quantile_table, value_text
from lwr_dyn.studies.sweep.sweep_study import SweepStudy, study_caveats

_PACKAGE = "lwr_dyn.studies.sweep"
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


def report_html(summary: SweepSummary, worst: Sequence[WorstRun] = ()) -> str:
    """The page; the same runs give the same text.

    Parameters
    ----------
    worst : sequence of WorstRun
        Those of `summary.worst()` that are to be replayed in the page.
    """
    inks, units = controller_inks(summary), column_units(summary)
    judged = [(one.within, name) for name, one in summary.controllers.items() if one.within is not None]
    judged.sort(key=lambda pair: -pair[0].value)
    said = [*study_caveats(summary.study), about_text(summary)]
    said += [f"{name} keeps all limits in {share_text(x, summary.is_sample)} of {x.runs} runs." for x, name in judged]
    tables = [*(quantile_table(summary, words) for words in summary.focus), event_table(summary)]
    replays = '<p class="note">A replay is the run again by simulate; the other figures are those of the study.</p>'
    replays += '<div id="replay-place" hidden></div>'
    lines = (
        "Each line is a run, from its first parameter down to the metric. Drawn are the parameters with the largest "
        "effect, each from its least to its largest value."
    )

    def parallel(name: str) -> str:
        return charts.parallel_html(summary, name, inks[name], units)

    varied = table_html(_parameter_table(summary).shown(page=True))
    main = [
        f"<h1>{escape(summary.title)}</h1>",
        f'<ul class="say">{"".join(f"<li>{escape(one)}</li>" for one in said)}</ul>',
        _card("Controllers", "".join([*(_figures_html(x, inks) for x in tables), *map(_note, notes(summary))])),
        *(_distribution(summary, words.name, inks) for words in summary.focus),
        _influence(summary, inks, units),
        _first_breaks(summary, inks),
        _each(summary, inks, "Runs over all parameters", lines, parallel),
        _card("Worst runs", worst_table_html(summary, inks, units, worst) + (replays if worst else "")),
        _card("What was varied", f'<div class="pairs"><div class="wide">{varied}</div></div>'),
    ]
    style, scripts, policy = replay_page.resource_text("report.css", _PACKAGE), "", POLICY
    if worst:
        scripts = f"{_replay_data(worst)}<script>\n{replay_page.resource_text('report.js', _PACKAGE)}</script>\n"
        policy = f"{replay_page.replay_policy(live=False)}; frame-src 'self'; base-uri 'none'"
    return document_html(
        summary.title, "study", "".join(main), "lwr-dyn sweep", style=style, scripts=scripts, policy=policy
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


def _figures_html(table: Table, inks: Mapping[str, str]) -> str:
    """A table whose first column names its rows, with their colours; what stands in brackets has a line of its own."""
    head = "".join(f'<th scope="col">{escape(h.title)}</th>' for h in table.columns)
    body = ""
    for first, *rest in table.cells:
        mark = f'<i class="sw {inks[first]}"></i>'
        body += f'<tr><th scope="row">{mark}{escape(first)}</th>'
        for value, bracket, interval in (text.partition(" [") for text in rest):
            body += f"<td>{escape(value)}{f'<small>[{escape(interval)}</small>' if bracket else ''}</td>"
        body += "</tr>"
    rows = f"<caption>{escape(table.title)}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody>"
    return _scrolled(escape(table.title), f'<table class="numbers">{rows}</table>')


def _scrolled(label: str, table: str) -> str:
    return f'<div class="scroll" tabindex="0" role="region" aria-label="{label}">{table}</div>'


def _note(text: str) -> str:
    return f'<p class="note">{escape(text)}</p>'


def _card(title: str, inside: str) -> str:
    return f'<section class="card"><h2>{escape(title)}</h2>{inside}</section>'


def _each(summary: SweepSummary, inks: Mapping[str, str], title: str, about: str, make: Callable[[str], str]) -> str:
    """A card with a figure a controller."""
    figures = "".join(
        f'<figure class="{inks[name]}"><figcaption><h3><span><i class="sw {inks[name]}"></i>{escape(name)}</span></h3>'
        f"</figcaption>{make(name)}</figure>"
        for name in summary.controllers
    )
    return _card(title, f'{_note(about)}<div class="many">{figures}</div>')


def _distribution(summary: SweepSummary, metric: str, inks: Mapping[str, str]) -> str:
    figures = {name: one.metrics[metric] for name, one in summary.controllers.items()}
    every = list(figures.values())
    words, same = every[0].words, charts.same_words(every)
    title = f"{words.title[:1].upper()}{words.title[1:]}"
    if same:
        return _card(title, f"<p>{escape(same)}</p>")
    worse = "larger" if words.worse > 0 else "smaller"
    return _card(
        title,
        f"<h3>Histograms <small>{escape(words.unit)}, {escape(charts.limit_words(every))}</small></h3>"
        f"{charts.histograms_html(figures, inks)}"
        f"<h3>Share of the runs with a {worse} value <small>logarithmic; bars: intervals of the quantiles</small></h3>"
        f"{charts.worst_share_html(figures, inks, summary.is_sample)}",
    )


def _influence(summary: SweepSummary, inks: Mapping[str, str], units: Mapping[str, str]) -> str:
    words = summary.focus[0]
    figures = {name: one.metrics[words.name] for name, one in summary.controllers.items()}
    about = (
        f"Bars: the {100 * TORNADO:g} % quantile of {words.title} among the runs of each fifth of a parameter (of each "
        "value where it has few), from the best fifth to the worst; all other parameters vary. The thin line is the "
        "95 % interval at the worst. A hollow bar could be chance (5 % over all parameters)."
    )
    html = _each(summary, inks, "What each parameter does", about, lambda x: charts.tornado_html(figures[x], units))
    if summary.study.method == "saltelli":
        about = f"Shares of the variance of {words.title}: filled alone, hollow with all interactions."
        html += _each(summary, inks, "Sobol indices", about, lambda name: charts.indices_html(figures[name].indices))
    return html


def _first_breaks(summary: SweepSummary, inks: Mapping[str, str]) -> str:
    searches = {name: one.outwards for name, one in summary.controllers.items()}
    if not any(searches.values()):
        return ""

    def gauges(name: str) -> str:
        search = searches[name]
        why = summary.not_searched.get(name, "no runs")
        return _note(f"Not looked at: {why}.") if search is None else charts.outwards_html(search)

    about = (
        "Each parameter alone goes from its nominal value to the ends of its range, all others stay nominal; what only "
        "a combination breaks is not seen here."
    )
    return _each(summary, inks, "Which parameter breaks a limit first", about, gauges)


def worst_table_html(
    summary: SweepSummary, inks: Mapping[str, str], units: Mapping[str, str], runs: Sequence[WorstRun]
) -> str:
    """The worst runs with their metrics and parameters; those that are in `runs` have a button for their replay."""
    replays = {(one.controller, one.number): place for place, one in enumerate(runs)}
    drawn = {name: draw_columns(summary.study, figures.runs) for name, figures in summary.controllers.items()}
    every = list(next(iter(drawn.values())))
    ranks: dict[str, int] = {}  # of the parameters, for the controller to which each matters most
    for figures in summary.controllers.values():
        for place, each in enumerate(figures.metrics[summary.focus[0].name].influence):
            ranks[each.path] = min(place, ranks.get(each.path, place))
    paths = (sorted(ranks, key=lambda path: ranks[path]) or every)[: charts.MOST_AXES]
    heads = [("controller", ""), ("run", ""), ("replay", ""), *((words.title, words.unit) for words in summary.focus)]
    heads += [("flag", ""), *((path, units.get(path, "")) for path in paths)]
    head = "".join(f'<th scope="col">{escape(name)} <small>{escape(unit)}</small></th>' for name, unit in heads)
    body = ""
    for name, figures in summary.controllers.items():
        for row in figures.worst[: summary.study.keep]:
            number = int(figures.runs.run[row])
            cells = [value_text(w, float(figures.metrics[w.name].badness[row])) for w in summary.focus]
            values = [drawn[name][path][row] for path in paths]
            cells += [str(figures.runs.flags[row]) or "none"]
            cells += [str(value) if isinstance(value, str) else f"{float(value):.3g}" for value in values]
            numbers = "".join(f'<td class="n">{escape(cell)}</td>' for cell in cells)
            button = ""
            if (name, number) in replays:
                more = f'<span class="unseen"> of {escape(name)}, run {number}</span>'
                button = f'<button type="button" data-replay="{replays[name, number]}">Replay{more}</button>'
            who = f'<th scope="row"><i class="sw {inks[name]}"></i>{escape(name)}</th><td class="n">{number}</td>'
            body += f"<tr>{who}<td>{button}</td>{numbers}</tr>"
    table = f'<table class="worst-runs"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    more = _note(f"{len(paths)} of {len(every)} parameters; the files of results have all.")
    return _scrolled("Worst runs", table) + (more if len(every) > len(paths) else "")


def _replay_data(runs: Sequence[WorstRun]) -> str:
    """A script element: the page of a replay once without its runs, and the data of each run."""
    rate = replay_page.RATE / 2
    pages = [replay_page.replay_html([x.run], x.arm, labels=[x.label], title="Worst runs", rate=rate) for x in runs]
    found = [_DATA.search(page) for page in pages]
    data = [json.dumps(json.loads(one[2]), sort_keys=True) for one in found if one is not None]
    frame = _DATA.sub(r"\1@@data@@\3", pages[0])
    made = {"page": frame, "runs": data, "labels": [one.label for one in runs]}
    return f'<script type="application/json" id="replays">{replay_page.script_safe(json.dumps(made))}</script>\n'


def _parameter_table(summary: SweepSummary) -> Table:
    rows = [
        (one.path, one.words, one.distribution_words, one.unit, one.nominal,
         ", ".join(filter(None, (one.kind, one.note))))
        for one in summary.study.parameters
    ]  # fmt: skip
    headings = ("parameter", "what it is", "distribution", "unit", Heading("nominal", format="g"), "source")
    return Table("Parameters", headings, rows)


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
    names = dict(zip(study.controllers, folder_names(study.controllers), strict=True))
    worst, files = [], []
    for text, number in summary.worst():
        with suppress(DivergenceError):
            run = workshop.run(text, number)
            files.append(make_folder(results.folder / WORST) / f"{names[text]}-run-{number}.npz")
            run.save(files[-1])
            worst.append(WorstRun(text, number, run, workshop.arm if run.setup is None else run.setup.plant.arm))
    for old in set((results.folder / WORST).glob("*-run-*.npz")) - set(files):  # of fewer runs, or another `keep`
        old.unlink()
    page = results.folder / PAGE
    write_file(page, report_html(summary, worst))
    return FinishedSweep(summary, page, tuple(files))
