"""A summary as tables for the terminal, and as a record for `--json`."""

from collections.abc import Iterator
from math import floor, log10
from typing import Any

from lwr_dyn.foundation.tables import Table
from lwr_dyn.studies.sweep.statistics.influence import Influence
from lwr_dyn.studies.sweep.statistics.intervals import QuantileEstimate, ShareEstimate
from lwr_dyn.studies.sweep.statistics.metric_words import MetricWords
from lwr_dyn.studies.sweep.statistics.outwards import FirstBreak
from lwr_dyn.studies.sweep.statistics.sobol_indices import SobolIndices
from lwr_dyn.studies.sweep.statistics.summary import TORNADO, ControllerFigures, MetricFigures, SweepSummary
from lwr_dyn.studies.sweep.statistics.summary_words import (
    OPEN,
    about_text,
    caveat,
    finite,
    hundredths,
    notes,
    quantile_text,
    share_text,
    value_text,
)

MOST_ROWS = 5
"""Parameters of one controller in a table of the terminal; the page has all."""


def summary_text(summary: SweepSummary) -> str:
    """All tables, and what their numbers rest on."""
    parts = [f"{summary.title}\n{about_text(summary)}", *(table.text() for table in summary_tables(summary))]
    return "\n\n".join([*parts, "\n".join(notes(summary))])


def summary_tables(summary: SweepSummary) -> tuple[Table, ...]:
    """Quantiles of each metric, what runs met, what each parameter does, which breaks a limit first."""
    tables = [quantile_table(summary, words) for words in summary.focus]
    tables += [event_table(summary), influence_table(summary)]
    tables += [index_table(summary)] if summary.study.method == "saltelli" else []
    tables += [outward_table(summary)] if any(one.outwards for one in summary.controllers.values()) else []
    return tuple(table for table in tables if table.rows)


def quantile_table(summary: SweepSummary, words: MetricWords) -> Table:
    """Share of the runs inside the limit, and quantiles over the runs, each with its interval."""
    figures = {name: one.metrics[words.name] for name, one in summary.controllers.items()}
    first = next(iter(figures.values()))
    heads = [_quantile_head(found, words) for found in first.quantiles]
    limit = f"{_bound(words, first)} kept" if first.within is not None else ""
    rows = [
        (name, str(one.sample.size), *([share_text(one.within, summary.is_sample)] if one.within is not None else []),
         *(quantile_text(words, found, summary.is_sample) for found in one.quantiles))
        for name, one in figures.items()
    ]  # fmt: skip
    headings = ("controller", "runs", *filter(None, [limit]), *heads)
    return Table(f"{words.title} [{words.unit}]", headings, rows)


def _quantile_head(found: QuantileEstimate, words: MetricWords) -> str:
    side = "at most" if words.worse > 0 else "at least"
    return "median" if found.share == 0.5 else f"{100 * found.share:g} % {side}"


def _bound(words: MetricWords, one: MetricFigures) -> str:
    sign = "<=" if words.worse > 0 else ">="
    return f"{sign} {value_text(words, words.worse * (one.bound or 0.0))}"


def event_table(summary: SweepSummary) -> Table:
    """Shares of the runs that keep all limits, that went to `simulate`, and why; whose torque was cut."""
    names = list(dict.fromkeys(event for one in summary.controllers.values() for event in one.events))
    limited = any(one.within is not None for one in summary.controllers.values())
    rows = [
        (name, *([share_text(one.within, summary.is_sample)] if one.within is not None else []),
         *(share_text(one.events[event], summary.is_sample) if event in one.events else OPEN for event in names))
        for name, one in summary.controllers.items()
    ]  # fmt: skip
    return Table("Of the runs", ("controller", *(["all limits kept"] if limited else []), *names), rows)


def influence_table(summary: SweepSummary) -> Table:
    """The parameters with the largest effect on a quantile of the first metric: its least and its largest part."""
    words = summary.focus[0]
    rows = [
        (name, one.path, *_parts(words, one))
        for name, figures in summary.controllers.items()
        for one in figures.metrics[words.name].influence[:MOST_ROWS]
    ]
    heads = ("controller", "parameter", "best part", "there", "worst part", "there", "clear", "rank correlation")
    title = f"{100 * TORNADO:g} % quantile of {words.title} [{words.unit}], runs cut by each parameter"
    return Table(title, heads, rows)


def _parts(words: MetricWords, one: Influence) -> Iterator[str]:
    for part in (one.best, one.worst):
        yield part_words(part.low, part.high, one.extent)
        yield value_text(words, part.estimate.value)
    yield f"or {', '.join(one.along)}" if one.along else "yes" if one.is_clear else "no"
    rho = one.correlation
    yield "" if rho is None else hundredths(words.worse * rho.value, "+")


def part_words(low: float | str, high: float | str, whole: float = 0.0) -> str:
    """The values of a part, rounded to a thousandth of the `whole` range of the parameter.

    >>> part_words(0.0001, 1.4, 7.0), part_words(2.0, 2.0), part_words("printed", "printed")
    ('0 to 1.4', '2', 'printed')
    """
    digits = 2 - floor(log10(whole)) if whole > 0.0 else 12
    ends = [end if isinstance(end, str) else f"{round(end, digits) + 0.0:.4g}" for end in (low, high)]
    return ends[0] if low == high else " to ".join(ends)


def index_table(summary: SweepSummary) -> Table:
    """Sobol indices of the first metric, each with its interval."""
    words, rows = summary.focus[0], []
    for name, figures in summary.controllers.items():
        found = figures.metrics[words.name].indices
        if found is not None:
            groups = str(found.groups)
            rows += [
                (name, path, *(_index(found, path, kind) for kind in ("first", "total")), groups)
                for path in found.total
            ]
    title = f"Sobol indices of {words.title}: shares of its variance [95 % intervals by bootstrap]"
    return Table(title, ("controller", "parameter", "alone", "with interactions", "groups"), rows)


def _index(found: SobolIndices, path: str, kind: str) -> str:
    one = getattr(found, kind)[path]
    return f"{hundredths(one.value)} [{hundredths(one.low)} to {hundredths(one.high)}]"


def outward_table(summary: SweepSummary) -> Table:
    """Where each parameter alone, from its nominal value outwards, breaks a limit; the first one in front."""
    rows: list[tuple[str, ...]] = []
    for name, figures in summary.controllers.items():
        search = figures.outwards
        if search is not None and search.at_nominal:
            rows.append((name, "none", "", "broken as modelled", ", ".join(search.at_nominal)))
        broken = [line for line in search.lines if line.share is not None] if search is not None else []
        rows += [(name, *_line(line)) for line in broken[:MOST_ROWS]]
        if search is not None and not broken and not search.at_nominal:
            rows.append((name, "none", "their ends", "", ""))
    heads = ("controller", "parameter", "kept up to", "broken at", "limit")
    return Table("Each parameter alone, from its nominal value outwards", heads, rows)


def _line(line: FirstBreak) -> tuple[str, ...]:
    share = 100 * (line.share or 0.0)
    return line.path, f"{line.kept:.4g}", f"{line.broken:.4g} ({share:.0f} % of the way)", line.metric or ""


def summary_record(summary: SweepSummary) -> dict[str, Any]:
    """The summary as JSON values, in SI units; None for what is not bounded or not finite."""
    study = summary.study
    return {
        "name": study.name, "robot": study.robot, "reading": study.reading, "task": study.task,
        "method": study.method, "seed": study.seed, "runs": study.count, "extra_runs": summary.extra_runs,
        "digest": study.digest, "limits": dict(study.limits), "level": 0.95, "caveat": caveat(summary),
        "missing": summary.missing, "not_searched": dict(summary.not_searched),
        "controllers": {name: _record(summary, one) for name, one in summary.controllers.items()},
        "worst": [{"controller": name, "run": run} for name, run in summary.worst()],
    }  # fmt: skip


def _record(summary: SweepSummary, one: ControllerFigures) -> dict[str, Any]:
    return {
        "runs": one.runs.count,
        "all_limits_kept": _share(one.within, summary.is_sample),
        "events": {event: _share(found, summary.is_sample) for event, found in one.events.items()},
        "metrics": {name: _metric(summary, found) for name, found in one.metrics.items()},
        "first_break": None if one.outwards is None else {
            "at_nominal": list(one.outwards.at_nominal),
            "lines": [{"parameter": line.path, "end": line.end, "share": line.share, "kept": line.kept,
                       "broken": line.broken, "limit": line.metric} for line in one.outwards.lines],
        },
    }  # fmt: skip


def _share(found: ShareEstimate | None, is_sample: bool) -> dict[str, Any] | None:
    if found is None:
        return None
    ends = {"low": found.low, "high": found.high} if is_sample else {}
    return {"count": found.count, "runs": found.runs, "share": finite(found.value), **ends}


def _metric(summary: SweepSummary, one: MetricFigures) -> dict[str, Any]:
    sign = one.words.worse
    quantiles = []
    for found in one.quantiles:
        ends = sorted((sign * found.low, sign * found.high))
        interval = {"low": finite(ends[0]), "high": finite(ends[1])} if summary.is_sample else {}
        value = {"share": found.share, "value": finite(sign * found.value), **interval}
        quantiles.append({**value, "runs": found.runs, "runs_needed": found.needed})
    return {
        "bound": one.bound, "kept": _share(one.within, summary.is_sample), "quantiles": quantiles,
        "influence": [
            {"parameter": each.path, "clear": each.is_clear, "goes_along_with": list(each.along),
             "rank_correlation": None if each.correlation is None else sign * each.correlation.value,
             "parts": [{"from": part.low, "to": part.high, "quantile": finite(sign * part.estimate.value),
                        "runs": part.estimate.runs} for part in each.parts]}
            for each in one.influence
        ],
        "sobol": None if one.indices is None else {
            "groups": one.indices.groups,
            **{kind: {path: {"value": x.value, "low": x.low, "high": x.high}
                      for path, x in getattr(one.indices, kind).items()} for kind in ("first", "total")},
        },
    }  # fmt: skip
