"""A summary as sections of a document: what people read, and the record with the types of its values."""

from dataclasses import asdict
from typing import Annotated, Any, NotRequired, TypedDict

from lwr_dyn.foundation.document import Fact, Note, Section
from lwr_dyn.studies.sweep.intervals import IntervalEstimate, ShareEstimate
from lwr_dyn.studies.sweep.outwards import OutwardSearch
from lwr_dyn.studies.sweep.summary import MetricFigures, SweepSummary
from lwr_dyn.studies.sweep.summary_text import about_text, caveat, notes, summary_tables


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
    first: Annotated[dict[str, IntervalEstimate], "Alone."]
    total: Annotated[dict[str, IntervalEstimate], "With interactions."]


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
            "first_break": None if one.outwards is None else _outwards(one.outwards),
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
        Fact("digest", study.digest, "Of all that changes the results."),
        Fact("limits", dict(study.limits), "Metric -> bound, SI.", kind=dict[str, float]),
        Fact("level", 0.95, "Of the intervals."), Fact("caveat", caveat(summary), "What the runs lack."),
        Fact("missing", summary.missing, "Controller -> runs that are not there.", kind=dict[str, int]),
        Fact("not_searched", dict(summary.not_searched), "Controller -> why its parameters were not moved alone.",
             kind=dict[str, str]),
        Fact("controllers", controllers, "As the study has them.", kind=dict[str, ControllerFiguresRecord]),
        Fact("worst", worst, "The worst runs of each, the worst first.", kind=list[WorstRecord]),
    ], "summary", "Figures in SI units, with intervals of 95 %; null without a run and with --no-report.",
        there=True)  # fmt: skip


def _share(found: ShareEstimate | None, is_sample: bool) -> dict[str, Any] | None:
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


def _outwards(search: OutwardSearch) -> dict[str, Any]:
    lines = [
        {"parameter": line.path, "end": line.end, "share": line.share, "kept": line.kept, "broken": line.broken,
         "limit": line.metric} for line in search.lines
    ]  # fmt: skip
    return {"at_nominal": list(search.at_nominal), "lines": lines}
