"""`tune`: gains for a stated aim, found on some runs of a study and judged on others; the result as a document."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, TypedDict

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.progress import Report
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.studies.sweep import gain_search
from lwr_dyn.studies.sweep.intervals import IntervalEstimate, QuantileEstimate, ShareEstimate
from lwr_dyn.studies.sweep.sampling import Values
from lwr_dyn.studies.sweep.sweep_study import SweepStudy

Evaluate = Callable[[Mapping[str, Values]], Mapping[str, Array]]
"""Values of runs by path -> metrics of the runs; "torque_use" (runs,) is the largest command over the torque limit."""
USE = "torque_use"
MOST = {"runs": 100_000, "population": 1000, "generations": 10_000, "check": 1_000_000, "front": 20}
LEAST = {"runs": 8, "population": 5, "generations": 1, "check": 8, "front": 0}


@dataclass(frozen=True, slots=True)
class SearchSize:
    """How large a search is: runs that each candidate meets, candidates, and runs for the judgement.

    Raises `OptionError` for a number outside its bounds.
    """

    runs: int = 64
    population: int = 16
    generations: int = 20
    check: int = 1000
    front: int = 3
    """Further searches, each under a tighter bound, for the Pareto front."""
    seed: int = 0

    def __post_init__(self) -> None:
        for name, most in MOST.items():
            value = getattr(self, name)
            if not LEAST[name] <= value <= most:
                raise OptionError(name, value, f"a whole number from {LEAST[name]} to {most}")
        if self.seed < 0:
            raise OptionError("seed", self.seed, "a whole number from 0 on")


@dataclass(frozen=True, slots=True, eq=False)
class TunedGains:
    """What a search has found: `values` (d,) of `gains`, `given` those it began with (NaN where there are none).

    `trace` has every candidate; `best` is the found one's number there, `first` that of the given gains (None where
    they lie outside the bounds of the search, or are not numbers). `keeps_bound` is of the runs of the search.
    """

    study: str
    controller: str
    gains: tuple[gain_search.SearchedGain, ...]
    aim: gain_search.GainAim
    bound: float
    size: SearchSize
    trace: gain_search.SearchTrace
    best: int
    given: Array
    check: gain_search.GainVerdict

    @property
    def values(self) -> Array:
        """The found gains (d,)."""
        return np.asarray(self.values_at(np.array([self.best]))[0])

    def values_at(self, candidates: NDArray[np.intp]) -> Array:
        """The gains (k, d) of candidates (k,) of the trace."""
        return gain_search.values_of(self.gains, self.trace.points[candidates])

    @property
    def keeps_bound(self) -> bool:
        """Whether the found gains keep the bound on the runs of the search."""
        return bool(self.trace.use[self.best] <= self.bound and np.isfinite(self.trace.aim[self.best]))

    @property
    def holds(self) -> bool:
        """Whether the found gains keep it on the runs that the search has not seen."""
        return self.check.found_use.value <= self.bound

    @property
    def document(self) -> Document:
        """The result for people and programs."""
        return _document(self)


def tune(
    study: SweepStudy,
    controller: str,
    gains: Sequence[gain_search.SearchedGain],
    evaluate: Evaluate,
    given: Mapping[str, float],
    *,
    aim: gain_search.GainAim,
    bound: float = 1.0,
    size: SearchSize = SearchSize(),
    report: Report = lambda _: None,
) -> TunedGains:
    """Gains with which a quantile of a metric over the runs of a study is smallest.

    The first `size.runs` runs of the study, drawn at random, are met by every candidate; the `size.check` runs after
    them judge the found gains beside the given ones. The same for a seed.

    Parameters
    ----------
    study : SweepStudy
        What is varied and how; its own method and number of runs are not used.
    controller : str
        One of a study's, as text.
    evaluate : callable
        Of the controller, see `Evaluate`.
    given : mapping
        Path -> value to compare with; a path without one has none.
    bound : float
        On the same quantile of the torque use; inf for none.

    Raises
    ------
    OptionError
        No gains, a gain twice, a bound that is not above 0.
    """
    paths = [gain.path for gain in gains]
    if not paths or len(set(paths)) < len(paths):
        twice = next((path for path in paths if paths.count(path) > 1), "")
        allowed = "each once" if twice else "one or more, as omega_n=5:200"
        raise OptionError("gains", f"{twice} twice" if twice else "none", allowed)
    if not bound > 0.0:
        raise OptionError("torque bound", bound, "a share of the torque limits above 0, or inf for none")
    drawn = replace(study, method="random", runs=size.runs + size.check, seed=size.seed)
    seen, unseen = drawn.values(0, size.runs), drawn.values(size.runs, drawn.runs)

    def judge(points: Array) -> tuple[Array, Array]:
        every = {path: np.concatenate([x] * len(points)) for path, x in seen.items()}
        columns = zip(paths, gain_search.values_of(gains, points).T, strict=True)
        rows = {path: np.repeat(x, size.runs) for path, x in columns}
        tables = (x.reshape(len(points), size.runs) for x in _figures(evaluate, aim, every | rows))
        aims, uses = (np.array([aim.of(one) for one in table]) for table in tables)
        return aims, uses

    trace, searches = gain_search.SearchTrace(judge, np.zeros((0, len(gains)))), size.front + 1
    is_known = all(path in given for path in paths)
    start = [np.array([gain.share(given[gain.path]) for gain in gains])] if is_known else []

    def search_under(limit: float, begin: Sequence[Array], k: int) -> int:
        return gain_search.search(
            trace, begin, limit, population=size.population, generations=size.generations, seed=size.seed + k,
            report=lambda x: report(x if isinstance(x, str) else (k + x) / searches),
        )  # fmt: skip

    best = search_under(bound, start, 0)
    for k, tighter in enumerate(_tighter(trace, best, size.front), 1):
        search_under(tighter, [trace.points[trace.best(tighter)]], k)
    best = trace.best(bound)
    found = dict(zip(paths, gain_search.values_of(gains, trace.points[[best]])[0].tolist(), strict=True))
    (before, use_before), (after, use_after) = (
        _figures(evaluate, aim, unseen | {path: np.full(size.check, x) for path, x in gains_.items()})
        for gains_ in ({path: x for path, x in given.items() if path in paths}, found)
    )
    check = gain_search.verdict(before, after, use_before, use_after, aim.share, size.seed)
    known = np.array([given.get(path, np.nan) for path in paths])
    return TunedGains(study.name, controller, tuple(gains), aim, bound, size, trace, best, known, check)


def _figures(evaluate: Evaluate, aim: gain_search.GainAim, values: Mapping[str, Values]) -> tuple[Array, Array]:
    """Metric and torque use (runs,), inf where a run has no number."""
    metrics = evaluate(values)
    use = metrics[USE]
    return aim.metric.badness(metrics[aim.metric.name]), np.where(np.isnan(use), np.inf, use)


def _tighter(trace: gain_search.SearchTrace, best: int, count: int) -> Array:
    """Bounds on the use evenly between the least that was seen and that of the best candidate, without both."""
    front = trace.front
    if not front.size:
        return np.zeros(0)
    least, most = float(trace.use[front[0]]), float(min(trace.use[best], trace.use[front[-1]]))
    return np.linspace(least, most, count + 2)[1:-1] if most > least else np.zeros(0)


FRONT_ROWS = 8
"""Rows of the front that the text shows; the record has all."""


class GainBounds(TypedDict):
    """What is searched of a gain."""

    low: Annotated[float, "Lowest."]
    high: Annotated[float, "Highest."]


class AimRecord(TypedDict):
    """`GainAim` in the record."""

    metric: Annotated[str, "Of one run."]
    share: Annotated[float, "Of the runs; the quantile that is to be small."]


class JudgedRecord(TypedDict):
    """What some gains make of the runs."""

    aim: Annotated[IntervalEstimate, "With its interval; null where it is not finite, or not bounded by the runs."]
    torque_use: Annotated[IntervalEstimate, "Likewise; share of the torque limit."]


class FrontRecord(TypedDict):
    """A candidate of the front."""

    gains: Annotated[dict[str, float], "Path -> value."]
    aim: Annotated[float, "Quantile of the metric."]
    torque_use: Annotated[float, "Share of the torque limit."]


def _document(found: TunedGains) -> Document:
    """The search, its judgement on other runs, and the front."""
    paths, trace, check, size = [gain.path for gain in found.gains], found.trace, found.check, found.size
    most = f"; the same quantile of the torque use at most {100 * found.bound:.3g} %"
    gains, bounds = {g.path: {"low": g.low, "high": g.high} for g in found.gains}, "Path -> bounds of the search."
    aim = {"metric": found.aim.metric.name, "share": found.aim.share}
    search = Section("", [
        Fact("study", found.study, "Its name."), Fact("controller", found.controller, "As the study has it."),
        Fact("gains", gains, bounds, kind=dict[str, GainBounds]),
        Fact("aim", aim, "What is to be least.", kind=AimRecord),
        Fact("torque_share", found.bound, "Bound of the same quantile of the torque use; null for none."),
        Note(f"aim: least {found.aim.words}{most if np.isfinite(found.bound) else ''}"),
        Note(f"search: differential evolution, {trace.aim.size} candidates, each on the same {size.runs} runs, "
             f"seed {size.seed}"),
        Note(f"of {size.runs} runs, the {100 * found.aim.share:g} % quantile is the worst",
             size.runs * (1.0 - found.aim.share) < 1.0),
        Note("no candidate keeps the bound: the one that misses it by the least is shown", not found.keeps_bound),
    ])  # fmt: skip
    best = Section("", [
        Fact("candidates", trace.aim.size, "Looked at."), Fact("runs", size.runs, "That each candidate met."),
        Fact("seed", size.seed, "Of the search and of the runs."),
        Fact("aim", float(trace.aim[found.best]), "Of what is found, on the runs of the search."),
        Fact("torque_use", float(trace.use[found.best]), "Likewise; share of the torque limit."),
        Fact("keeps_bound", found.keeps_bound, "Exit code 1 where false."),
    ], "search", "The search, and what it found on its own runs.")  # fmt: skip
    values = Section("", [
        Fact("given", dict(zip(paths, found.given.tolist(), strict=True)),
             "Path -> value that the study has; null where it has none.", kind=dict[str, float]),
        Fact("found", dict(zip(paths, found.values.tolist(), strict=True)), "Path -> value.", kind=dict[str, float]),
    ])  # fmt: skip
    ratio = f"{check.ratio.value:.3g} ({check.ratio.low:.3g} to {check.ratio.high:.3g})"
    better = f"less error in {100 * check.better.value:.3g} % of the runs: {check.words}"
    judged = Section("", [
        _judged(found), Note(f"found / given: {ratio}; {better}"),
        Note("on these runs the bound is NOT kept: more --runs find gains that keep it", not found.holds),
        Fact("runs", check.given.runs, "Not seen in the search."),
        Fact("level", check.given.level, "Of the intervals."),
        Fact("given", {"aim": _ends(check.given), "torque_use": _ends(check.given_use)}, "With the given gains.",
             kind=JudgedRecord),
        Fact("found", {"aim": _ends(check.found), "torque_use": _ends(check.found_use)}, "With the found ones.",
             kind=JudgedRecord),
        Fact("ratio", _ends(check.ratio), "Aim with the found gains over that with the given ones; bootstrap of pairs.",
             kind=IntervalEstimate),
        Fact("better", _ends(check.better), "Share of the runs with a smaller metric.", kind=IntervalEstimate),
        Fact("keeps_bound", found.holds, "On these runs."), Fact("verdict", check.words, "In words."),
    ], "check", "Given and found gains on runs that the search has not seen.", brief=True)  # fmt: skip
    columns = found.values_at(trace.front), trace.aim[trace.front], trace.use[trace.front]
    rows = zip(*(column.tolist() for column in columns), strict=True)
    records = [{"gains": dict(zip(paths, row, strict=True)), "aim": aim, "torque_use": use} for row, aim, use in rows]
    says = "Pareto front of the candidates on the runs of the search, by torque use."
    front = Section("", [_front(found), Fact("front", records, says, kind=list[FrontRecord])])
    searched = ", ".join(f"{g.name} {g.low:g} to {g.high:g}" for g in found.gains)
    title = f"{found.study}, {found.controller}: {searched}"
    return Document(title, "", [search, best, values, judged, front], "lwr-dyn tune", "search")


def _ends(x: IntervalEstimate | QuantileEstimate | ShareEstimate) -> dict[str, float]:
    return {"value": x.value, "low": x.low, "high": x.high}


def _headings(found: TunedGains, format: str = "") -> list[Heading]:
    gains = [Heading(gain.name, format=".4g") for gain in found.gains]
    metric = found.aim.metric
    aim = Heading(f"{metric.title}, {100 * found.aim.share:g} %", metric.unit, format)
    return [*gains, aim, Heading("torque use", "%", format)]


def _judged(found: TunedGains) -> Table:
    """The two sets of gains on the runs that the search has not seen."""
    factor, check = found.aim.metric.factor, found.check
    given = [None if np.isnan(x) else x for x in found.given]
    rows = [
        ("given", *given, _interval(check.given, factor), _interval(check.given_use, 100.0)),
        ("found", *found.values, _interval(check.found, factor), _interval(check.found_use, 100.0)),
    ]
    title = f"on {check.given.runs} runs that the search has not seen, intervals of {100 * check.given.level:g} %"
    return Table(title, [Heading("gains"), *_headings(found)], rows)


def _interval(one: QuantileEstimate, factor: float) -> str:
    low, high = ("-" if np.isinf(x) else f"{factor * x:.4g}" for x in (one.low, one.high))
    return f"{factor * one.value:.4g} ({low} to {high})"


def _front(found: TunedGains) -> Table:
    """Some candidates of the front, evenly along it; the found one is marked."""
    front, trace = found.trace.front, found.trace
    chosen = front[np.unique(np.linspace(0, len(front) - 1, FRONT_ROWS).round().astype(int))] if front.size else front
    shown = np.unique(np.append(chosen, found.best) if found.best in front else chosen)
    shown = shown[np.argsort(trace.use[shown], kind="stable")]
    rows = [
        (*gains, found.aim.metric.factor * trace.aim[i], 100.0 * trace.use[i], "found" if i == found.best else "")
        for i, gains in zip(shown, found.values_at(shown).tolist(), strict=True)
    ]
    title = f"Pareto front of the candidates, on the runs of the search: {len(rows)} of {len(front)}"
    return Table(title, [*_headings(found, ".4g"), Heading("")], rows)
