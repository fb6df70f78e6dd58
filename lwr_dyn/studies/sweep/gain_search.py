"""A search for gains: differential evolution of SciPy, a whole generation at once, under one bound.

Differential evolution is taken because it only compares candidates (a quantile over runs has kinks, a loop that turns
unstable is a cliff), because a generation is one call, which rollouts want, and because it is in SciPy: `cma` would be
one more package, and pays from some ten gains on. All candidates meet the same runs (common random numbers), so that a
difference between two of them is one of gains; the price is that the search fits its runs, so gains are judged on other
ones (`GainVerdict`).

The bound is kept by order, without a penalty to choose: of two candidates that keep it the one with the smaller aim is
better, one that keeps it is better than one that does not, and of two that do not the one that misses it by less
(K. Deb, Comput. Methods Appl. Mech. Eng. 186, 2000).

Beside it what a search aims at, a quantile over runs of one of their metrics, and what gains are worth on other runs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, differential_evolution
from scipy.stats import qmc

from lwr_dyn.foundation.arrays import Array, number_of
from lwr_dyn.foundation.errors import LwrDynError, OptionError
from lwr_dyn.foundation.progress import Report
from lwr_dyn.studies.sweep import intervals
from lwr_dyn.studies.sweep.vocabulary import MetricWords, metric_words

FORM = "PATH=LOW:HIGH, as controller.omega_n=5:200"


@dataclass(frozen=True, slots=True)
class SearchedGain:
    """A path between `low` and `high`; its logarithm is searched where both are above 0.

    Raises
    ------
    OptionError
        Bounds that are not finite, or not low < high.
    """

    path: str
    low: float
    high: float

    def __post_init__(self) -> None:
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            raise OptionError(f"bounds of {self.path}", f"{self.low:g} to {self.high:g}", "two numbers, low < high")

    @property
    def name(self) -> str:
        """The path without its group: controller.omega_n is omega_n."""
        return self.path.removeprefix("controller.")

    def value(self, share: Array) -> Array:
        """Values of shares (...) of the way from `low` to `high`.

        >>> SearchedGain("controller.omega_n", 1.0, 100.0).value(np.array([0.0, 0.5, 1.0])).round(9).tolist()
        [1.0, 10.0, 100.0]
        """
        if self.low <= 0.0:
            return np.asarray(self.low + (self.high - self.low) * share)
        return np.asarray(np.clip(self.low * (self.high / self.low) ** share, self.low, self.high))

    def share(self, value: float) -> float:
        """The share of a value, clipped to 0 ... 1."""
        inside = min(max(value, self.low), self.high)
        if self.low <= 0.0:
            return float((inside - self.low) / (self.high - self.low))
        return float(np.log(inside / self.low) / np.log(self.high / self.low))


def searched_gain(text: str) -> SearchedGain:
    """The gain of a text such as "controller.omega_n=5:200"; a name without a dot is an option of the controller.

    Raises
    ------
    OptionError
        Another form, or bounds that are no numbers, not finite or not low < high.

    >>> searched_gain("omega_n=5:200")
    SearchedGain(path='controller.omega_n', low=5.0, high=200.0)
    """
    path, _, bounds = (part.strip() for part in text.partition("="))
    low, colon, high = bounds.partition(":")
    if not (path and colon):
        raise OptionError("gain", repr(text), FORM)
    try:
        ends = number_of(low), number_of(high)
    except ValueError:
        raise OptionError(f"bounds of {path}", repr(bounds), FORM) from None
    name = path.replace("-", "_")
    return SearchedGain(name if "." in name else f"controller.{name}", *ends)


def values_of(gains: Sequence[SearchedGain], shares: Array) -> Array:
    """Values (k, d) of points (k, d) of the unit cube."""
    return np.stack([gain.value(shares[:, i]) for i, gain in enumerate(gains)], axis=-1)


MISSED = 1e12
"""Cost from which on candidates miss the bound; an aim is far below."""
MOST_MISSED = 1e6
"""By how much a candidate misses it at most."""
NO_NUMBER = 1e30
"""Cost of a candidate with runs that have no number."""
MUTATION, CROSSOVER = (0.5, 1.0), 0.9
"""Dithered scale of differences, and the share of numbers that a child takes from them: SciPy's default for the first;
high for the second, as gains act together."""

Judge = Callable[[Array], tuple[Array, Array]]
"""Points (k, d) of the unit cube -> aim (k,) and use (k,), inf where a candidate has none."""
Mask = NDArray[np.bool_]


@dataclass(slots=True, eq=False)
class SearchTrace:
    """All candidates that were looked at: points (k, d) of the unit cube, aim (k,), and use (k,), which is bounded."""

    judge: Judge
    points: Array
    aim: Array = field(default_factory=lambda: np.zeros(0))
    use: Array = field(default_factory=lambda: np.zeros(0))

    def look(self, points: Array) -> tuple[Array, Array]:
        """Aim and use of points (k, d), which are kept."""
        aim, use = self.judge(points)
        self.points = np.concatenate([self.points, points])
        self.aim, self.use = np.concatenate([self.aim, aim]), np.concatenate([self.use, use])
        return aim, use

    def best(self, bound: float) -> int:
        """The candidate that is best under a bound on use; the first of equals."""
        return int(np.argmin(costs(self.aim, self.use, bound)))

    @property
    def front(self) -> NDArray[np.int64]:
        """The Pareto front: the candidates than which none is better in one and no worse in the other; by use."""
        kept: list[int] = []
        for i in np.lexsort((self.aim, self.use)):
            if np.isfinite([self.aim[i], self.use[i]]).all() and (not kept or self.aim[i] < self.aim[kept[-1]]):
                kept.append(int(i))
        return np.array(kept, dtype=np.int64)


def costs(aim: Array, use: Array, bound: float) -> Array:
    """One number a candidate (k,), smaller for the better; candidates that miss the bound come behind all others.

    >>> order = np.argsort(costs(np.array([3.0, 1.0, 2.0, np.inf]), np.array([0.5, 0.9, 0.7, 0.1]), 0.8))
    >>> order.tolist()
    [2, 0, 1, 3]
    """
    inside = np.where(np.isfinite(aim), aim, NO_NUMBER)
    if not np.isfinite(bound):
        return inside
    missing = np.minimum(np.where(np.isnan(use), np.inf, use) - bound, MOST_MISSED)
    return np.where(missing > 0.0, MISSED * (1.0 + missing), inside)


def search(
    trace: SearchTrace,
    start: Sequence[Array],
    bound: float,
    *,
    population: int,
    generations: int,
    seed: int,
    report: Report = lambda _: None,
) -> int:
    """Differential evolution from `start` (points, each (d,)) and a Latin hypercube, under `bound` on the use.

    Every candidate goes into `trace`; the number of the best one there is returned, which an earlier search may have
    found. The same for a seed.

    Parameters
    ----------
    start : sequence of (d,) arrays
        Candidates of the first generation, at most `population`.
    bound : float
        inf for none.
    population, generations : int
        Candidates of a generation, and generations after the first; it ends before when all candidates agree to 1 %.

    Raises as the judge.
    """
    d = trace.points.shape[1]
    rng = np.random.default_rng(seed)
    cube = qmc.LatinHypercube(d, seed=rng).random(population)
    cube[: len(start)] = np.reshape(start, (len(start), d))
    done = 0

    def cost(x: Any, /) -> Any:  # the stubs know of one candidate at a time only
        nonlocal done
        aim, use = trace.look(np.ascontiguousarray(x.T))
        done += 1
        report(min(done / (generations + 1), 1.0))
        return costs(aim, use, bound)

    try:
        differential_evolution(
            cost, Bounds(np.zeros(d), np.ones(d)), init=cube, maxiter=generations, mutation=MUTATION,
            recombination=CROSSOVER, seed=rng, polish=False, updating="deferred", vectorized=True,
        )  # fmt: skip
    except RuntimeError as fault:  # SciPy makes one of every ValueError
        if isinstance(fault.__cause__, LwrDynError):
            raise fault.__cause__ from None
        raise
    return trace.best(bound)


@dataclass(frozen=True, slots=True)
class GainAim:
    """A quantile over runs of a metric of one run: of `share` of the runs it is to be small."""

    metric: MetricWords
    share: float

    def __post_init__(self) -> None:
        if not 0.0 < self.share < 1.0:
            raise OptionError("share of the aim", self.share, "between 0 and 1")

    @property
    def words(self) -> str:
        """As in "99 % quantile over runs: error of the tip, largest"."""
        return f"{100 * self.share:g} % quantile over runs: {self.metric.title}"

    def of(self, runs: Array) -> float:
        """The quantile of runs (k,); inf for one that reaches into runs without a number."""
        return intervals.quantile_of(runs, self.share).value


def gain_aim(text: str, quantiles: Sequence[float] = ()) -> GainAim:
    """The aim of a text such as "tip_max:0.99"; `quantiles` over time are those of the study.

    Raises
    ------
    OptionError
        Another form, a share that is not between 0 and 1, a metric of which more is better.
    UnknownNameError
        No metric of that name.

    >>> gain_aim("tip_max:0.99").words
    '99 % quantile over runs: error of the tip, largest'
    """
    name, _, share = text.partition(":")
    try:
        number = number_of(share)
    except ValueError:
        raise OptionError("aim", repr(text), "METRIC:SHARE, as tip_max:0.99") from None
    words = metric_words(name.strip(), quantiles)
    if words.worse < 0:
        raise OptionError("aim", repr(name), "a metric that is to be small, as tip_max")
    return GainAim(words, number)


RESAMPLES = 2000
"""Of the bootstrap."""
FEW = 10
"""Runs beyond a quantile below which the interval of the bootstrap is too narrow."""


@dataclass(frozen=True, slots=True, eq=False)
class GainVerdict:
    """Two sets of gains on the same runs: quantiles of the metric and of the torque use, and how they compare.

    `ratio` is found over given, below 1 where the found gains are better; `better` is the share of runs in which they
    err by less.
    """

    given: intervals.QuantileEstimate
    found: intervals.QuantileEstimate
    given_use: intervals.QuantileEstimate
    found_use: intervals.QuantileEstimate
    ratio: intervals.IntervalEstimate
    better: intervals.ShareEstimate

    @property
    def words(self) -> str:
        """What the interval of the ratio allows to say; and whether the quantile is bounded."""
        certain = self.found.high < self.given.low or self.given.high < self.found.low
        few = self.found.runs * (1.0 - self.found.share) < FEW and not certain
        said = " on these runs, too few to bound the quantile" if few else ""
        if self.ratio.high < 1.0 or self.found.high < self.given.low:
            return f"the found gains are better{said}"
        if self.ratio.low > 1.0 or self.given.high < self.found.low:
            return f"the given gains are better{said}"
        return "the runs do not tell them apart"


def verdict(given: Array, found: Array, given_use: Array, found_use: Array, share: float, seed: int) -> GainVerdict:
    """Of metric and use (runs,) each, with inf where a run has no number; `share` is that of the quantile.

    Raises as `quantile_of`.
    """
    return GainVerdict(
        given=intervals.quantile_of(given, share),
        found=intervals.quantile_of(found, share),
        given_use=intervals.quantile_of(given_use, share),
        found_use=intervals.quantile_of(found_use, share),
        ratio=paired_ratio(given, found, share, seed),
        better=intervals.share_of(int((found < given).sum()), given.size),
    )


def paired_ratio(given: Array, found: Array, share: float, seed: int) -> intervals.IntervalEstimate:
    """Quantile of `found` over that of `given`, (runs,) each; percentiles of a bootstrap that draws pairs.

    Two quantiles that are both inf have the ratio 1. For the quantile of runs that are few beyond it (1 - share times
    their number below `FEW`) the interval of a bootstrap is too narrow: the intervals of the quantiles themselves hold.

    References
    ----------
    Efron, Tibshirani, An Introduction to the Bootstrap, section 13.3.

    >>> rng = np.random.default_rng(0)
    >>> x = rng.random(400)
    >>> found = paired_ratio(x, 0.5 * x, 0.9, 0)
    >>> found.value, found.low, found.high
    (0.5, 0.5, 0.5)
    """
    rng, n = np.random.default_rng(seed), given.size
    place = min(max(int(np.ceil(n * share * (1.0 - 1e-15))), 1), n) - 1

    def ratio(rows: np.ndarray[tuple[int], np.dtype[np.int64]] | slice) -> float:
        below, above = (float(np.partition(x[rows], place)[place]) for x in (given, found))
        if np.isinf(below) or below == 0.0:
            return 1.0 if above == below else (0.0 if np.isinf(below) else np.inf)
        return above / below

    drawn = np.sort([ratio(rng.integers(0, n, n)) for _ in range(RESAMPLES)])
    cut = int(np.floor(0.5 * (1.0 - intervals.LEVEL) * RESAMPLES))
    return intervals.IntervalEstimate(ratio(slice(None)), float(drawn[cut]), float(drawn[-1 - cut]))
