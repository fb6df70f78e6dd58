"""The report of a study as one HTML file: distributions, what each parameter does, lines of runs, the worst ones."""

from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path

from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.tables import Table
from lwr_dyn.pages.plotting.document import POLICY, document_html
from lwr_dyn.pages.replay.page_parts import resource_text
from lwr_dyn.pages.replay.replay_page import replay_policy
from lwr_dyn.pages.replay.replayed_runs import run_places
from lwr_dyn.studies.sweep.report.distribution_charts import histograms_html, limit_words, same_words, worst_share_html
from lwr_dyn.studies.sweep.report.influence_charts import indices_html, outwards_html, tornado_html
from lwr_dyn.studies.sweep.report.parallel_lines import parallel_html
from lwr_dyn.studies.sweep.report.worst_runs import WorstRun, replay_scripts, worst_table_html
from lwr_dyn.studies.sweep.statistics.summary import TORNADO, SweepSummary
from lwr_dyn.studies.sweep.statistics.summary_tables import event_table, quantile_table
from lwr_dyn.studies.sweep.statistics.summary_words import about_text, notes, share_text

_PACKAGE = "lwr_dyn.studies.sweep.report"


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
