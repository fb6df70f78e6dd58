"""`tune`: gains for a stated aim, found on some runs of a study and judged on others.

What a search for gains has found, as text and as a record.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.progress import Report
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.studies.sweep.gain_search import (
    GainAim,
    GainVerdict,
    SearchedGain,
    SearchTrace,
    search,
    values_of,
    verdict,
)
from lwr_dyn.studies.sweep.intervals import QuantileEstimate
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

    controller: str
    gains: tuple[SearchedGain, ...]
    aim: GainAim
    bound: float
    size: SearchSize
    trace: SearchTrace
    best: int
    given: Array
    check: GainVerdict

    @property
    def values(self) -> Array:
        """The found gains (d,)."""
        return np.asarray(values_of(self.gains, self.trace.points[[self.best]])[0])

    @property
    def keeps_bound(self) -> bool:
        """Whether the found gains keep the bound on the runs of the search."""
        return bool(self.trace.use[self.best] <= self.bound and np.isfinite(self.trace.aim[self.best]))

    @property
    def holds(self) -> bool:
        """Whether the found gains keep it on the runs that the search has not seen."""
        return self.check.found_use.value <= self.bound

    @property
    def candidates(self) -> int:
        """How many were looked at."""
        return self.trace.aim.size


def tune(
    study: SweepStudy,
    controller: str,
    gains: Sequence[SearchedGain],
    evaluate: Evaluate,
    given: Mapping[str, float],
    *,
    aim: GainAim,
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
    gains : sequence of SearchedGain
    evaluate : callable
        Of the controller, see `Evaluate`.
    given : mapping
        Path -> value to compare with; a path without one has none.
    aim : GainAim
    bound : float
        On the same quantile of the torque use; inf for none.
    size : SearchSize

    Raises
    ------
    OptionError
        No gains, a gain twice, a bound that is not above 0.
    """
    _check(gains, bound)
    drawn = replace(study, method="random", runs=size.runs + size.check, seed=size.seed)
    seen, unseen = drawn.values(0, size.runs), drawn.values(size.runs, drawn.runs)
    paths = [gain.path for gain in gains]

    def judge(points: Array) -> tuple[Array, Array]:
        candidates = values_of(gains, points)
        rows = {path: np.repeat(column, size.runs, axis=0) for path, column in zip(paths, candidates.T, strict=True)}
        metric, use = _figures(evaluate, aim, tiled(seen, len(points)) | rows)
        each = (x.reshape(len(points), size.runs) for x in (metric, use))
        aims, uses = ([aim.of(one) for one in table] for table in each)
        return np.array(aims), np.array(uses)

    trace = SearchTrace.empty(judge, len(gains))
    start = _start(gains, given)
    searches = size.front + 1

    def search_under(limit: float, begin: Sequence[Array], k: int) -> int:
        return search(
            trace, begin, limit, population=size.population, generations=size.generations, seed=size.seed + k,
            report=lambda x: report(x if isinstance(x, str) else (k + x) / searches),
        )  # fmt: skip

    best = search_under(bound, start, 0)
    for k, tighter in enumerate(_tighter(trace, best, size.front)):
        search_under(tighter, [trace.points[trace.best(tighter)]], k + 1)
    best = trace.best(bound)
    found = dict(zip(paths, values_of(gains, trace.points[[best]])[0].tolist(), strict=True))
    pairs = [
        _figures(evaluate, aim, unseen | {path: np.full(size.check, x) for path, x in set_of.items()})
        for set_of in ({path: x for path, x in given.items() if path in paths}, found)
    ]
    check = verdict(pairs[0][0], pairs[1][0], pairs[0][1], pairs[1][1], aim.share, size.seed)
    known = np.array([given.get(path, np.nan) for path in paths])
    return TunedGains(controller, tuple(gains), aim, bound, size, trace, best, known, check)


def tiled(values: Mapping[str, Values], times: int) -> dict[str, Values]:
    """Values of runs (k, ...) by path, all runs again and again."""
    return {path: np.concatenate([x] * times) for path, x in values.items()}


def _figures(evaluate: Evaluate, aim: GainAim, values: Mapping[str, Values]) -> tuple[Array, Array]:
    """Metric and torque use (runs,), inf where a run has no number."""
    metrics = evaluate(values)
    use = metrics[USE]
    return aim.metric.badness(metrics[aim.metric.name]), np.where(np.isnan(use), np.inf, use)


def _check(gains: Sequence[SearchedGain], bound: float) -> None:
    paths = [gain.path for gain in gains]
    if not paths:
        raise OptionError("gains", "none", "one or more, as omega_n=5:200")
    for path in paths:
        if paths.count(path) > 1:
            raise OptionError("gains", f"{path} twice", "each once")
    if not bound > 0.0:
        raise OptionError("torque bound", bound, "a share of the torque limits above 0, or inf for none")


def _start(gains: Sequence[SearchedGain], given: Mapping[str, float]) -> list[Array]:
    """The given gains as a point of the search, where all of them are known; else none."""
    if any(gain.path not in given for gain in gains):
        return []
    return [np.array([gain.share(given[gain.path]) for gain in gains])]


def _tighter(trace: SearchTrace, best: int, count: int) -> Array:
    """Bounds on the use evenly between the least that was seen and that of the best candidate, without both."""
    front = trace.front
    if not front.size:
        return np.zeros(0)
    least, most = float(trace.use[front[0]]), float(min(trace.use[best], trace.use[front[-1]]))
    return np.linspace(least, most, count + 2)[1:-1] if most > least else np.zeros(0)


FRONT_ROWS = 8
"""Rows of the front that the text shows; the record has all."""


def tuned_text(found: TunedGains, title: str) -> str:
    """The search, its judgement on other runs, and the front."""
    n, size = found.candidates, found.size
    limit = (
        f"; the same quantile of the torque use at most {100 * found.bound:.3g} %" if np.isfinite(found.bound) else ""
    )
    lines = [
        f"{title}, {found.controller}: {', '.join(f'{g.name} {g.low:g} to {g.high:g}' for g in found.gains)}",
        f"aim: least {found.aim.words}{limit}",
        f"search: differential evolution, {n} candidates, each on the same {size.runs} runs, seed {size.seed}",
    ]
    if size.runs * (1.0 - found.aim.share) < 1.0:
        lines.append(f"of {size.runs} runs, the {100 * found.aim.share:g} % quantile is the worst")
    if not found.keeps_bound:
        lines.append("no candidate keeps the bound: the one that misses it by the least is shown")
    check = found.check
    return "\n".join(
        [
            *lines,
            "",
            _judged(found).text(),
            f"found / given: {check.ratio.value:.3g} ({check.ratio.low:.3g} to {check.ratio.high:.3g}); "
            f"less error in {100 * check.better.value:.3g} % of the runs: {check.words}",
            *([] if found.holds else ["on these runs the bound is NOT kept: more --runs find gains that keep it"]),
            "",
            _front(found).text(),
        ]
    )


def tuned_record(found: TunedGains) -> dict[str, Any]:
    """As JSON values, in SI units."""
    paths = [gain.path for gain in found.gains]
    front = found.trace.front
    table = values_of(found.gains, found.trace.points[front])
    check = found.check
    return {
        "controller": found.controller,
        "gains": {g.path: {"low": g.low, "high": g.high} for g in found.gains},
        "aim": {"metric": found.aim.metric.name, "share": found.aim.share},
        "torque_share": found.bound,
        "search": {
            "candidates": found.candidates,
            "runs": found.size.runs,
            "seed": found.size.seed,
            "aim": float(found.trace.aim[found.best]),
            "torque_use": float(found.trace.use[found.best]),
            "keeps_bound": found.keeps_bound,
        },
        "given": dict(zip(paths, found.given.tolist(), strict=True)),
        "found": dict(zip(paths, found.values.tolist(), strict=True)),
        "check": {
            "runs": check.given.runs,
            "level": check.given.level,
            "given": _estimates(check.given, check.given_use),
            "found": _estimates(check.found, check.found_use),
            "ratio": {"value": check.ratio.value, "low": check.ratio.low, "high": check.ratio.high},
            "better": {"value": check.better.value, "low": check.better.low, "high": check.better.high},
            "keeps_bound": found.holds,
            "verdict": check.words,
        },
        "front": [
            {"gains": dict(zip(paths, row.tolist(), strict=True)), "aim": aim, "torque_use": use}
            for row, aim, use in zip(
                table, found.trace.aim[front].tolist(), found.trace.use[front].tolist(), strict=True
            )
        ],
    }


def _estimates(aim: QuantileEstimate, use: QuantileEstimate) -> Mapping[str, Any]:
    pairs = {"aim": aim, "torque_use": use}
    return {name: {"value": x.value, "low": x.low, "high": x.high} for name, x in pairs.items()}


def _judged(found: TunedGains) -> Table:
    """The two sets of gains on the runs that the search has not seen."""
    metric, check = found.aim.metric, found.check
    rows = [
        (name, *(None if np.isnan(x) else x for x in gains), _interval(aim, metric.factor), _interval(use, 100.0))
        for name, gains, aim, use in (
            ("given", found.given, check.given, check.given_use),
            ("found", found.values, check.found, check.found_use),
        )
    ]
    headings = [
        Heading("gains"), *(Heading(gain.name, format=".4g") for gain in found.gains),
        Heading(f"{metric.title}, {100 * found.aim.share:g} %", metric.unit), Heading("torque use", "%"),
    ]  # fmt: skip
    level = f"{100 * check.given.level:g} %"
    return Table(f"on {check.given.runs} runs that the search has not seen, intervals of {level}", headings, rows)


def _interval(one: QuantileEstimate, factor: float) -> str:
    value, low, high = (factor * x for x in (one.value, one.low, one.high))
    return f"{value:.4g} ({'-' if np.isinf(low) else f'{low:.4g}'} to {'-' if np.isinf(high) else f'{high:.4g}'})"


def _front(found: TunedGains) -> Table:
    """Some candidates of the front, evenly along it; the found one is marked."""
    front, metric = found.trace.front, found.aim.metric
    chosen = front[np.unique(np.linspace(0, len(front) - 1, FRONT_ROWS).round().astype(int))] if front.size else front
    shown = np.unique(np.append(chosen, found.best) if found.best in front else chosen)
    shown = shown[np.argsort(found.trace.use[shown], kind="stable")]
    rows = [
        (
            *values_of(found.gains, found.trace.points[[i]])[0].tolist(), metric.factor * found.trace.aim[i],
            100.0 * found.trace.use[i], "found" if i == found.best else "",
        )
        for i in shown
    ]  # fmt: skip
    headings = [
        *(Heading(gain.name, format=".4g") for gain in found.gains),
        Heading(f"{metric.title}, {100 * found.aim.share:g} %", metric.unit, ".4g"),
        Heading("torque use", "%", ".4g"), Heading(""),
    ]  # fmt: skip
    title = f"Pareto front of the candidates, on the runs of the search: {len(rows)} of {len(front)}"
    return Table(title, headings, rows)
