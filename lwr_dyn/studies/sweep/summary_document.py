"""A summary for people and programs: numbers with their intervals, tables, sections of a document and its record."""

from dataclasses import asdict
from math import floor, isinf, log10
from typing import Annotated, Any, NotRequired, TypedDict

import numpy as np

from lwr_dyn.foundation.document import Fact, Note, Section
from lwr_dyn.foundation.number_text import short
from lwr_dyn.foundation.tables import Table
from lwr_dyn.studies.sweep import intervals
from lwr_dyn.studies.sweep.outwards import OutwardSearch
from lwr_dyn.studies.sweep.summary import CUT, TORNADO, MetricFigures, SweepSummary
from lwr_dyn.studies.sweep.vocabulary import MetricWords

PLANS = {
    "grid": "a grid", "sobol": "Sobol points", "latin-hypercube": "a Latin hypercube", "random": "independent points",
    "saltelli": "a Saltelli design",
}  # fmt: skip
"""The methods of a study in words."""
LOST = "unbounded"
"""In place of a value that is not finite."""


def value_text(words: MetricWords, badness: float) -> str:
    """A value in the unit for people: three digits."""
    value = words.shown(badness)
    if isinf(badness):
        return LOST if badness > 0.0 else "never" if value > 0.0 else intervals.OPEN
    return short(value)


def quantile_text(words: MetricWords, found: intervals.QuantileEstimate, with_interval: bool = True) -> str:
    """A quantile with its interval in brackets, the lower end first; an end that is not bounded is "?"."""
    value = value_text(words, found.value)
    if not with_interval:
        return value
    ends = [value_text(words, end) for end in (found.low, found.high)]
    if not found.is_bounded:
        ends = [intervals.OPEN if isinf(x) else text for x, text in zip((found.low, found.high), ends, strict=True)]
    return f"{value} [{' to '.join(ends[:: words.worse])}]"


def about_text(summary: SweepSummary) -> str:
    """How many runs were made of which plan, in a sentence."""
    study = summary.study
    counts = [one.runs.count for one in summary.controllers.values()]
    least, most = min(counts, default=0), max(counts, default=0)
    made = f"{least} to {most} of " if least != most else f"{most} of " if least != study.runs else ""
    drawn = f"{PLANS[study.method]}, seed {study.seed}" if summary.is_sample else PLANS[study.method]
    lacking = []
    for text, count in summary.missing.items():
        failed = sorted(summary.failures.get(text, {}).items())[:1]
        lacking.append(f"{count} of {text}" + "".join(f" (chunk {number}: {why})" for number, why in failed))
    missing = f" Missing runs, which may be the worst: {', '.join(lacking)}." if lacking else ""
    extra = f"; {summary.extra_runs} more to see what breaks a limit first" if summary.extra_runs else ""
    return f"{made}{study.runs} runs a controller on the same plants ({drawn}){extra}.{missing}"


def notes(summary: SweepSummary) -> list[str]:
    """All that is said below the tables: of intervals, of what runs lack, of what was not looked for."""
    cut = [(name, one.events.get(CUT), one.events["simulated"].runs) for name, one in summary.controllers.items()]
    known = [f"{one.runs} of {runs} of {name}" for name, one, runs in cut if one is not None and one.runs < runs]
    of_known = f"{CUT.capitalize()}: of the runs of which it is known, {', '.join(known)}." if known else ""
    said = [f"Each parameter alone: {text} was not looked at, {why}." for text, why in summary.not_searched.items()]
    found = [interval_note(summary), caveat(summary), of_known, *said]
    for figures in summary.controllers.values():
        few = [one for one in next(iter(figures.metrics.values())).quantiles if not one.is_bounded]
        said = [f"{100 * one.share:g} % needs {one.needed} runs, and {one.runs} were drawn" for one in few]
        found += [f"{intervals.OPEN}: not bounded by the runs: {'; '.join(said)}."] if said else []
    return list(dict.fromkeys(filter(None, found)))


def interval_note(summary: SweepSummary) -> str:
    """What stands in brackets, and what it holds for."""
    if not summary.is_sample:
        return "A grid is no sample: shares and quantiles are those of its points, and have no interval."
    said = "In brackets: 95 % intervals, of quantiles by order statistics, of shares by Clopper and Pearson"
    if summary.study.method == "random":
        return f"{said}."
    if summary.study.method == "saltelli":
        return f"{said}; from the rows A and B of the design, two in {len(summary.study.varied) + 2} runs."
    return f"{said}, as for independent runs; runs that fill their box evenly vary less as a rule."


def caveat(summary: SweepSummary) -> str:
    """What the runs lack, and what became of those that met a stop or diverged."""
    loop, runs = summary.study.loop, [one.runs for one in summary.controllers.values()]
    left = sum(int(((one.flags != "") & ~one.simulated).sum()) for one in runs)
    lost = any(np.isposinf(x.badness).any() for each in summary.controllers.values() for x in each.metrics.values())
    has_stops, slow = loop.get("position_limits", True), [one.label for one in runs if one.simulated.all()]
    plant = "without friction" if loop.get("friction") == "none" else "with smooth friction, without stick"
    again = "those that reach a stop are computed again by simulate, and show its figures."
    if left:
        met = "met a stop or diverged" if has_stops else "diverged"
        again = f"{left} that {met} were not computed again, and have no figures."
    elif not loop.get("hand_over", True):
        again = "none of them reached one."
    whole = [f"{', '.join(slow)}: all runs by simulate{', with stops' if has_stops else ''}."] if slow else []
    if len(slow) == len(runs):
        ending = "."
    elif has_stops:
        ending = f" and without stops; {again}"
    else:
        ending = f"; positions have no limits{f'; {again}' if left else '.'}"
    why = "diverged" if not left else "have no figures"
    more = f" {LOST.capitalize()}: runs that {why}; they keep no limit." if lost else ""
    if any(CUT not in one.events and "saturated_s" in one.runs.metrics for one in summary.controllers.values()):
        more += " Torque limits are unknown: no run shows whether torques keep them."
    return " ".join([f"Runs are computed {plant}{ending}", *whole]) + more


MOST_ROWS = 5
"""Parameters of one controller in a table of the terminal; the page has all."""


def summary_tables(summary: SweepSummary) -> list[Table]:
    """Quantiles of each metric, what runs met, what each parameter does, which breaks a limit first."""
    tables = [*(quantile_table(summary, x) for x in summary.focus), event_table(summary), influence_table(summary)]
    tables += [index_table(summary)] if summary.study.method == "saltelli" else []
    return tables + ([outward_table(summary)] if any(one.outwards for one in summary.controllers.values()) else [])


def quantile_table(summary: SweepSummary, words: MetricWords) -> Table:
    """Share of the runs inside the limit, and quantiles over the runs, each with its interval."""
    figures = {name: one.metrics[words.name] for name, one in summary.controllers.items()}
    first = next(iter(figures.values()))
    side, sign = ("at most", "<=") if words.worse > 0 else ("at least", ">=")
    heads = [f"{100 * x.share:g} % {side}" if x.share != 0.5 else "median" for x in first.quantiles]
    limit = [f"{sign} {value_text(words, words.worse * (first.bound or 0.0))} kept"] * (first.within is not None)
    rows = [
        (name, str(one.sample.size), *(intervals.share_text(one.within, summary.is_sample) for _ in limit),
         *(quantile_text(words, found, summary.is_sample) for found in one.quantiles))
        for name, one in figures.items()
    ]  # fmt: skip
    return Table(f"{words.title} [{words.unit}]", ("controller", "runs", *limit, *heads), rows)


def event_table(summary: SweepSummary) -> Table:
    """Shares of the runs that keep all limits, that went to `simulate`, and why; whose torque was cut."""
    names = list(dict.fromkeys(event for one in summary.controllers.values() for event in one.events))
    limit = ["all limits kept"] * any(one.within is not None for one in summary.controllers.values())
    rows = []
    for name, one in summary.controllers.items():
        shares = [*(one.within for _ in limit), *(one.events.get(event) for event in names)]
        rows.append((name, *(intervals.share_text(share, summary.is_sample) for share in shares)))
    return Table("Of the runs", ("controller", *limit, *names), rows)


def influence_table(summary: SweepSummary) -> Table:
    """The parameters with the largest effect on a quantile of the first metric: its least and its largest part."""
    words, rows = summary.focus[0], []
    for name, figures in summary.controllers.items():
        for one in figures.metrics[words.name].influence[:MOST_ROWS]:
            best, worst = (
                (part_words(part.low, part.high, one.extent), value_text(words, part.estimate.value))
                for part in (one.best, one.worst)
            )
            clear = f"or {', '.join(one.along)}" if one.along else "yes" if one.is_clear else "no"
            rho = "" if one.correlation is None else intervals.hundredths(words.worse * one.correlation.value, "+")
            rows.append((name, one.path, *best, *worst, clear, rho))
    heads = ("controller", "parameter", "best part", "there", "worst part", "there", "clear", "rank correlation")
    title = f"{100 * TORNADO:g} % quantile of {words.title} [{words.unit}], runs cut by each parameter"
    return Table(title, heads, rows)


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
            texts = [{path: intervals.index_text(x) for path, x in each.items()} for each in (found.first, found.total)]
            rows += [(name, path, texts[0][path], whole, str(found.groups)) for path, whole in texts[1].items()]
    title = f"Sobol indices of {words.title}: shares of its variance [95 % intervals by bootstrap]"
    return Table(title, ("controller", "parameter", "alone", "with interactions", "groups"), rows)


def outward_table(summary: SweepSummary) -> Table:
    """Where each parameter alone, from its nominal value outwards, breaks a limit; the first one in front."""
    rows: list[tuple[str, ...]] = []
    for name, figures in summary.controllers.items():
        search = figures.outwards or OutwardSearch((), 0)
        if search.at_nominal:
            rows.append((name, "none", "", "broken as modelled", ", ".join(search.at_nominal)))
        elif figures.outwards is not None and not search.broken:
            rows.append((name, "none", "their ends", "", ""))
        for line in search.broken[:MOST_ROWS]:
            at = f"{line.broken:.4g} ({100 * (line.share or 0.0):.0f} % of the way)"
            rows.append((name, line.path, f"{line.kept:.4g}", at, line.metric or ""))
    heads = ("controller", "parameter", "kept up to", "broken at", "limit")
    return Table("Each parameter alone, from its nominal value outwards", heads, rows)


def summary_sections(summary: SweepSummary | None) -> list[Section]:
    """Of a document: all tables, what their numbers rest on, and the record; without a summary that there is none."""
    if summary is None:
        return [Section("", [], "summary", there=False)]
    sections = [Section("", [Note((summary.title, about_text(summary)))])]
    sections += [Section("", [table]) for table in summary_tables(summary)]
    return [*sections, Section("", [Note(notes(summary))]), _recorded(summary)]


class ShareRecord(TypedDict):
    """A share of the runs with its interval, without one of a grid."""

    count: Annotated[int, "Of the runs."]
    runs: Annotated[int, "Of which it is."]
    share: Annotated[float, "count / runs."]
    low: NotRequired[Annotated[float, "Lower end of its interval."]]
    high: NotRequired[Annotated[float, "Upper end."]]


class QuantileRecord(TypedDict):
    """A quantile over the runs with its interval, without one of a grid."""

    share: Annotated[float, "Of the runs that are not worse."]
    value: Annotated[float, "SI; null where it is not finite."]
    low: NotRequired[Annotated[float, "Null where the runs do not bound it."]]
    high: NotRequired[Annotated[float, "Likewise."]]
    runs: Annotated[int, "That were drawn."]
    runs_needed: Annotated[int, "The least that would bound it."]


PartRecord = TypedDict(
    "PartRecord",
    {
        "from": Annotated[float | str, "Least value of the parameter."],
        "to": Annotated[float | str, "Largest."],
        "quantile": Annotated[float, "Of the metric among the runs of the part, SI."],
        "runs": Annotated[int, "Of the part."],
    },
)


class InfluenceRecord(TypedDict):
    """What one parameter does to a metric."""

    parameter: Annotated[str, "Its path."]
    clear: Annotated[bool, "Whether its parts differ by more than chance."]
    goes_along_with: Annotated[list[str], "Parameters with more effect that it follows in these runs."]
    rank_correlation: Annotated[float | None, "Spearman's; null of one that is chosen by name."]
    parts: Annotated[list[PartRecord], "From its least values to its largest."]


class SobolRecord(TypedDict):
    """Sobol indices, path -> share of the variance."""

    groups: Annotated[int, "Of the Saltelli design."]
    first: Annotated[dict[str, intervals.IntervalEstimate], "Alone."]
    total: Annotated[dict[str, intervals.IntervalEstimate], "With interactions."]


class MetricFiguresRecord(TypedDict):
    """One metric of one controller."""

    bound: Annotated[float | None, "The study's limit, SI; null without."]
    kept: Annotated[ShareRecord | None, "Runs inside it."]
    quantiles: Annotated[list[QuantileRecord], "Over the runs, SI."]
    influence: Annotated[list[InfluenceRecord], "The largest first."]
    sobol: Annotated[SobolRecord | None, "Of a Saltelli design."]


class BreakRecord(TypedDict):
    """A parameter alone, moved from its nominal value to an end of its range."""

    parameter: Annotated[str, "Its path."]
    end: Annotated[float, "Where it goes."]
    share: Annotated[float | None, "Of the way at which a limit breaks; null where none does."]
    kept: Annotated[float | None, "Last value without a broken limit."]
    broken: Annotated[float | None, "First with one."]
    limit: Annotated[str | None, "That breaks."]


class FirstBreakRecord(TypedDict):
    """Which parameter breaks a limit first."""

    at_nominal: Annotated[list[str], "Limits that are broken as modelled."]
    lines: Annotated[list[BreakRecord], "The first to break in front."]


class ControllerFiguresRecord(TypedDict):
    """What the runs of one controller say."""

    runs: Annotated[int, "That are there."]
    all_limits_kept: Annotated[ShareRecord | None, "Null without limits."]
    events: Annotated[dict[str, ShareRecord], "Runs by simulate, with each flag, with a torque that was cut."]
    metrics: Annotated[dict[str, MetricFiguresRecord], "By name."]
    first_break: Annotated[FirstBreakRecord | None, "Null where it was not looked for."]


class WorstRecord(TypedDict):
    """One of the worst runs."""

    controller: Annotated[str, "As the study has it."]
    run: Annotated[int, "Its number in the study."]


def _recorded(summary: SweepSummary) -> Section:
    """The summary as JSON values, in SI units."""
    study, sample = summary.study, summary.is_sample
    controllers = {
        name: {
            "runs": one.runs.count, "all_limits_kept": _share(one.within, sample),
            "events": {event: _share(found, sample) for event, found in one.events.items()},
            "metrics": {metric: _metric(found, sample) for metric, found in one.metrics.items()},
            "first_break": None if (search := one.outwards) is None else {
                "at_nominal": list(search.at_nominal),
                "lines": [{"parameter": line.path, "end": line.end, "share": line.share, "kept": line.kept,
                           "broken": line.broken, "limit": line.metric} for line in search.lines],
            },
        }
        for name, one in summary.controllers.items()
    }  # fmt: skip
    worst = [{"controller": name, "run": run} for name, run in summary.worst()]
    return Section("", [
        Fact("name", study.name, "Of the study."), Fact("robot", study.robot, "Its name or file."),
        Fact("reading", study.reading, "Its reading."), Fact("task", study.task, "What the arm does."),
        Fact("method", study.method, "How runs are drawn."), Fact("seed", study.seed, "Of the drawing."),
        Fact("runs", study.runs, "Of each controller."),
        Fact("extra_runs", summary.extra_runs, "Made to see what breaks a limit first."),
        Fact("digest", study.digest, "Of all that changes a run."),
        Fact("limits", dict(study.limits), "Metric -> bound, SI.", kind=dict[str, float]),
        Fact("level", 0.95, "Of the intervals."), Fact("caveat", caveat(summary), "What the runs lack."),
        Fact("missing", summary.missing, "Controller -> runs that are not there.", kind=dict[str, int]),
        Fact("not_searched", dict(summary.not_searched), "Controller -> why its parameters were not moved alone.",
             kind=dict[str, str]),
        Fact("controllers", controllers, "As the study has them.", kind=dict[str, ControllerFiguresRecord]),
        Fact("worst", worst, "The worst runs of each, the worst first.", kind=list[WorstRecord]),
    ], "summary", "Figures in SI units, with intervals of 95 %; null without a run and with --no-report.",
        there=True)  # fmt: skip


def _share(found: intervals.ShareEstimate | None, is_sample: bool) -> dict[str, Any] | None:
    if found is None:
        return None
    ends = {"low": found.low, "high": found.high} if is_sample else {}
    return {"count": found.count, "runs": found.runs, "share": found.value, **ends}


def _metric(one: MetricFigures, is_sample: bool) -> dict[str, Any]:
    sign, indices = one.words.worse, one.indices
    quantiles = []
    for found in one.quantiles:
        low, high = sorted((sign * found.low, sign * found.high))
        interval = {"low": low, "high": high} if is_sample else {}
        value = {"share": found.share, "value": sign * found.value, **interval}
        quantiles.append({**value, "runs": found.runs, "runs_needed": found.needed})
    return {
        "bound": one.bound, "kept": _share(one.within, is_sample), "quantiles": quantiles,
        "influence": [
            {"parameter": each.path, "clear": each.is_clear, "goes_along_with": list(each.along),
             "rank_correlation": None if each.correlation is None else sign * each.correlation.value,
             "parts": [{"from": part.low, "to": part.high, "quantile": sign * part.estimate.value,
                        "runs": part.estimate.runs} for part in each.parts]}
            for each in one.influence
        ],
        "sobol": None if indices is None else {
            "groups": indices.groups,
            "first": {path: asdict(x) for path, x in indices.first.items()},
            "total": {path: asdict(x) for path, x in indices.total.items()},
        },
    }  # fmt: skip
