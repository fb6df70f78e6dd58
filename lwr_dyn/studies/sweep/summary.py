"""What a study found: for each controller its quantiles, shares inside the limits, influences, and the worst runs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import ceil, floor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.studies.sweep.influence import Influence, SobolIndices, columns, indices_of, influences
from lwr_dyn.studies.sweep.intervals import QuantileEstimate, ShareEstimate, quantile_of, share_of
from lwr_dyn.studies.sweep.outwards import OutwardSearch, Span, outward_search
from lwr_dyn.studies.sweep.sampling import saltelli_rows
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
from lwr_dyn.studies.sweep.vocabulary import PATHS, MetricWords, metric_words

SHARES = (0.5, 0.95, 0.99, 0.999)
"""Of the runs: the quantiles that are given."""
TORNADO = 0.95
"""The quantile whose dependence on each parameter is shown."""
PLAIN_METRIC = "tip_max"
"""What is looked at where a study sets no limit on the tip."""
CUT = "torque cut"
"""The event of a torque beyond its limit."""
Evaluate = Callable[[str, Mapping[str, NDArray[Any]]], Mapping[str, Array]]
"""Controller, and values of all paths, a row a run -> metrics of these runs in SI units."""


@dataclass(frozen=True, slots=True, eq=False)
class ControllerRuns:
    """What a study keeps of k runs of one controller; a study that is not finished has fewer.

    `run` are their numbers in the study, ascending. `values` are what was varied: path -> (k,), (k, m) where a path has
    several draws, texts where it is chosen by name. `metrics` are in SI units: name -> (k,), or (k, n) for joints.
    `flags` say what a kernel could not follow, "" for nothing; `simulated` which metrics are those of `simulate`.

    Raises
    ------
    OptionError
        A column with another number of rows.
    """

    label: str
    run: NDArray[np.int64]
    values: Mapping[str, NDArray[Any]]
    metrics: Mapping[str, Array]
    flags: NDArray[np.str_]
    simulated: NDArray[np.bool_]

    def __post_init__(self) -> None:
        own: dict[str, NDArray[Any]] = {"flags": self.flags, "simulated": self.simulated}
        for name, column in (*self.values.items(), *self.metrics.items(), *own.items()):
            if column.shape[:1] != self.run.shape:
                raise OptionError(f"runs of {self.label}: {name}", f"{column.shape[0]} rows", f"{self.run.size}")

    @property
    def count(self) -> int:
        """How many runs."""
        return int(self.run.size)


@dataclass(frozen=True, slots=True, eq=False)
class MetricFigures:
    """One metric of one controller: `badness` of every run (k,), and what its `sample` (m,) says.

    The sample are the runs that are drawn independently; quantiles, shares and influences are theirs.
    """

    words: MetricWords
    badness: Array
    sample: Array
    quantiles: tuple[QuantileEstimate, ...]
    influence: tuple[Influence, ...]
    bound: float | None = None
    """Of the study's limits, SI."""
    within: ShareEstimate | None = None
    indices: SobolIndices | None = None
    """Of a Saltelli design."""


@dataclass(frozen=True, slots=True, eq=False)
class ControllerFigures:
    """What the runs of one controller say; `worst` are rows of `runs`, the worst first."""

    runs: ControllerRuns
    metrics: Mapping[str, MetricFigures]
    within: ShareEstimate | None
    """Runs that keep all limits."""
    events: Mapping[str, ShareEstimate]
    """Runs that were computed by `simulate`; that have each flag; whose torque was cut at a limit, of those of which
    that is known: not of runs that diverged."""
    worst: NDArray[np.int64]
    kept: NDArray[np.bool_]
    """Which runs (k,) keep all limits."""
    outwards: OutwardSearch | None = None


@dataclass(frozen=True, slots=True, eq=False)
class SweepSummary:
    """A study's result in figures.

    `is_sample` is False for a grid: its shares and quantiles are those of its points and have no interval.
    """

    study: SweepStudy
    controllers: Mapping[str, ControllerFigures]
    focus: tuple[MetricWords, ...]
    """The metrics that are looked at; the first orders the worst runs."""
    is_sample: bool
    extra_runs: int = 0
    """That were made to see what breaks a limit first."""
    failures: Mapping[str, Mapping[int, str]] = field(default_factory=dict)
    """Controller -> number of a chunk that failed -> why."""
    not_searched: Mapping[str, str] = field(default_factory=dict)
    """Controller -> why it was not looked for what breaks a limit first, where others were."""

    @property
    def missing(self) -> dict[str, int]:
        """Controller -> how many of the study's runs are not there, where there are such."""
        made = {text: one.runs.count for text, one in self.controllers.items()}
        lacking = {text: self.study.runs - made.get(text, 0) for text in self.study.controllers}
        return {text: count for text, count in lacking.items() if count}

    @property
    def title(self) -> str:
        """Name, robot and task."""
        robot = " ".join(filter(None, (Path(self.study.robot).stem, self.study.reading)))
        return f"{self.study.name}: {robot}, {self.study.task}"

    def worst(self, most: int | None = None) -> list[tuple[str, int]]:
        """(controller, number of the run) of the worst runs, as many of each controller as the study keeps."""
        keep = self.study.keep if most is None else most
        return [(name, int(one.runs.run[row])) for name, one in self.controllers.items() for row in one.worst[:keep]]


def summarise(
    study: SweepStudy,
    controllers: Mapping[str, ControllerRuns],
    evaluate: Evaluate | None = None,
    arm: Arm | None = None,
    not_searched: Mapping[str, str] | None = None,
    failures: Mapping[str, Mapping[int, str]] | None = None,
) -> SweepSummary:
    """The figures of a study from its runs.

    Parameters
    ----------
    controllers : mapping
        Controller as typed -> its runs; those that are not computed yet are missing.
    evaluate : callable, optional
        Makes further runs, to find which parameter breaks a limit first; without it that is not said.
    arm : Arm, optional
        Of the study: its joints decide the units of their metrics, its limits what is known.
    not_searched : mapping, optional
        Controller -> why `evaluate` makes no runs of it.
    failures : mapping, optional
        Controller -> number of a chunk that failed -> why.

    Raises
    ------
    OptionError
        A controller without any run.
    UnknownNameError
        A limit on a metric that is not there.
    """
    kinds = () if arm is None else [joint.kind for joint in arm.joints()]
    limits = {metric_words(name, study.quantiles, kinds): bound for name, bound in study.limits.items()}
    focus = tuple(limits)
    if not any(words.name.startswith("tip_") for words in focus):
        focus = (metric_words(PLAIN_METRIC, study.quantiles), *focus)
    made, left_out = {}, dict(not_searched or {}) if evaluate is not None and limits else {}
    for name, runs in controllers.items():
        if not runs.count:
            raise OptionError(f"results of {name}", "no run", "a run or more")
        found = _figures(study, runs, focus, limits, arm)
        if evaluate is not None and limits and name not in left_out:
            found = replace(found, outwards=outward_search(spans(study), limits, partial(evaluate, name)))
        made[name] = found
    extra = sum(one.outwards.runs for one in made.values() if one.outwards is not None)
    flags = [event for one in made.values() for event in one.events if event != CUT]
    for name, one in made.items():
        none = share_of(0, one.events["simulated"].runs)
        made[name] = replace(one, events={**dict.fromkeys(["simulated", *flags], none), **one.events})
    order = tuple(sorted(focus, key=_is_behind))
    return SweepSummary(study, made, order, study.method != "grid", extra, dict(failures or {}), left_out)


def _is_behind(words: MetricWords) -> bool:
    """Metrics of the tip come first."""
    return not words.name.startswith("tip_")


def sample_rows(study: SweepStudy, run: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which runs are drawn independently of each other: all, or of a Saltelli design the rows A and B."""
    if study.method != "saltelli":
        return np.ones(run.size, dtype=bool)
    return np.asarray(run % saltelli_rows(len(study.varied)) < 2)


def spans(study: SweepStudy) -> tuple[Span, ...]:
    """The ranges of a study's parameters; one whose nominal value is not known begins in the middle."""
    found = []
    for one in study.parameters:
        low, high = one.lowest, one.highest
        if isinstance(low, str) or isinstance(high, str):
            found.append(Span(one.path, str(low)))
            continue
        middle = float(one.values[len(one.values) // 2]) if one.values else 0.5 * (low + high)
        nominal = middle if one.nominal is None or not one.is_varied else one.nominal
        values = tuple(float(value) for value in one.values)
        if not values and one.path in PATHS and PATHS[one.path].whole:
            values = tuple(float(k) for k in range(ceil(low), floor(high) + 1))
        found.append(Span(one.path, nominal, low, high, len(one.columns), values))
    return tuple(found)


def draw_columns(study: SweepStudy, runs: ControllerRuns) -> dict[str, NDArray[Any]]:
    """What varies, a column (k,) a number of a run, by the study's names."""
    varied = {one.path: one.columns for one in study.varied}
    return columns({path: runs.values[path] for path in varied if path in runs.values}, varied)


def _figures(
    study: SweepStudy,
    runs: ControllerRuns,
    focus: tuple[MetricWords, ...],
    limits: Mapping[MetricWords, float],
    arm: Arm | None,
) -> ControllerFigures:
    chosen, drawn = sample_rows(study, runs.run), draw_columns(study, runs)
    inside = {words: words.is_within(runs.metrics[words.name], bound) for words, bound in limits.items()}
    kept = np.all(list(inside.values()), axis=0) if inside else np.ones(runs.count, dtype=bool)
    found = {}
    for words in focus:
        badness = words.badness(runs.metrics[words.name])
        sample = badness[chosen]
        quantiles = tuple(quantile_of(sample, share) for share in SHARES) if sample.size else ()
        rows = {name: column[chosen] for name, column in drawn.items()}
        moved = influences(sample, rows, TORNADO) if sample.size else ()
        within = _share(inside[words][chosen]) if words in limits else None
        indices = None
        if study.method == "saltelli":
            whole = np.full(study.runs, np.nan)
            whole[runs.run] = badness
            indices = indices_of(words.name, whole, [one.path for one in study.varied])
        found[words.name] = MetricFigures(words, badness, sample, quantiles, moved, limits.get(words), within, indices)
    first = found[min(focus, key=_is_behind).name]
    order = np.lexsort((runs.run, -first.badness))
    events = {"simulated": runs.simulated, **{flag: runs.flags == flag for flag in np.unique(runs.flags) if flag}}
    shares = {event: _share(np.asarray(rows)[chosen]) for event, rows in events.items()}
    if "saturated_s" in runs.metrics and (arm is None or np.isfinite(arm.effort).all()):  # else unknown
        cut = metric_words("saturated_s").badness(runs.metrics["saturated_s"])[chosen]
        shares[CUT] = _share(cut[np.isfinite(cut)] > 0.0)
    return ControllerFigures(runs, found, _share(kept[chosen]) if inside else None, shares, order, kept)


def _share(rows: NDArray[np.bool_]) -> ShareEstimate:
    return share_of(int(rows.sum()), rows.size)
