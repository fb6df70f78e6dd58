"""How much a metric follows each varied parameter: the numbers of a tornado, and Sobol indices of a Saltelli design.

Of runs where all parameters vary there are two measures: a quantile of the metric among the runs of each fifth of a
parameter, lowest to highest (of each level where there are few), and Spearman's rank correlation. The first is in the
unit of the metric and sees what rises at both ends; the second says the direction. The largest of many quantiles differ
by chance too, so two tests say beside them whether the runs of the parts differ at all.

Sobol indices have the estimator of `scipy.stats.sobol_indices`, which takes a power of 2 of groups only; here groups
with a run that diverged are left out. The bootstrap of scipy (BCa) needs n^2 d numbers, gigabytes for thousands of
runs; here resampling is a matrix product of counts, and the intervals are percentiles.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import atanh, sqrt, tanh
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2_contingency, kruskal, norm, rankdata, spearmanr
from scipy.stats.contingency import crosstab

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.studies.sweep.intervals import LEVEL, IntervalEstimate, QuantileEstimate, quantile_of

PARTS = 5
MOST_LEVELS = 6
"""A parameter with at most so many different values is cut by value."""
LEAST = 10
"""Runs in a part below which a parameter is not cut."""
FEWEST = 5
"""Expected runs of a cell below which the test of chi-squared is not asked."""
FOLLOWS = 0.01
"""Probability below which two parameters count as going together."""
MOST_COMPARED = 20


@dataclass(frozen=True, slots=True)
class PartQuantile:
    """A quantile of the metric among runs whose parameter lies from `low` to `high`; both are a choice by name."""

    low: float | str
    high: float | str
    estimate: QuantileEstimate


@dataclass(frozen=True, slots=True)
class Influence:
    """Of one parameter on one metric; `parts` from the lowest values of the parameter to the highest.

    `chance` is the probability that parts without any effect differ so much somewhere among all parameters, in their
    ranks (Kruskal and Wallis) or in their shares above the quantile of all runs (chi-squared), by Bonferroni.
    """

    path: str
    parts: tuple[PartQuantile, ...]
    chance: float
    correlation: IntervalEstimate | None
    """Spearman's rho; None where the parameter is chosen by name."""
    along: tuple[str, ...] = ()
    """Parameters with more effect that it follows in these runs, and without whose help it shows no effect: few runs of
    many parameters can be drawn so that two of them go together, and then the effect may be the other's."""

    @property
    def best(self) -> PartQuantile:
        """The part with the smallest quantile."""
        return min(self.parts, key=lambda part: part.estimate.value)

    @property
    def worst(self) -> PartQuantile:
        """The part with the largest quantile."""
        return max(self.parts, key=lambda part: part.estimate.value)

    @property
    def extent(self) -> float:
        """From the least to the largest value of the parameter; 0 for a choice by name."""
        low, high = self.parts[0].low, self.parts[-1].high
        return 0.0 if isinstance(low, str) or isinstance(high, str) else high - low

    @property
    def swing(self) -> float:
        """Largest less smallest quantile; inf where runs diverged in some parts only."""
        low, high = self.best.estimate.value, self.worst.estimate.value
        return 0.0 if low == high else high - low

    @property
    def is_clear(self) -> bool:
        """Whether its parts differ by more than chance."""
        return self.chance < 1.0 - LEVEL


def influences(
    metric: Array, values: Mapping[str, NDArray[Any]], share: float, level: float = LEVEL
) -> tuple[Influence, ...]:
    """The influence of each parameter on the quantile `share` of a metric (runs,), the largest swing first.

    Parameters that do not vary, or whose parts have fewer than `LEAST` runs, are left out. A path with several draws
    (runs, m) gives m rows, `path[1]` to `path[m]`.

    Raises
    ------
    ShapeError
        A parameter with another number of runs.
    """
    found, drawn = [], columns(values)
    for path, column in drawn.items():
        if column.shape != metric.shape:
            raise ShapeError(path, f"shape {column.shape}", f"{metric.shape}, one value a run")
        cut = [rows for rows in parts_of(column) if rows.size]
        if len(cut) < 2 or min(rows.size for rows in cut) < LEAST:
            continue
        parts = tuple(
            PartQuantile(
                min(column[rows].tolist()), max(column[rows].tolist()), quantile_of(metric[rows], share, level)
            )
            for rows in cut
        )
        correlation = None if is_by_name(column) else rank_correlation(column, metric, level)
        found.append(Influence(path, parts, _chance([metric[rows] for rows in cut], share, len(drawn)), correlation))
    found.sort(key=lambda one: (-one.is_clear, -one.swing))
    clear = [one.path for one in found if one.is_clear][:MOST_COMPARED]
    places = {path: _places(drawn[path]) for path in clear}
    along = {
        path: tuple(a for a in clear[:k] if _may_explain(places[a], places[path], metric, share))
        for k, path in enumerate(clear)
    }
    return tuple(replace(one, along=along.get(one.path, ())) for one in found)


def _chance(parts: Sequence[Array], share: float, tried: int) -> float:
    """Of the test of Kruskal and Wallis, or of the shares above the whole's quantile, whichever sees more; times 2."""
    whole, sizes = np.concatenate(parts), np.array([part.size for part in parts])
    if whole.min() == whole.max():
        return 1.0
    ranks = np.split(rankdata(whole), np.cumsum(sizes)[:-1])  # a run that diverged has the last
    above = np.array([(rank > share * whole.size).sum() for rank in ranks])
    chances = [float(kruskal(*ranks).pvalue)]
    if min(above.sum(), (sizes - above).sum()) * sizes.min() >= FEWEST * whole.size:
        chances.append(float(chi2_contingency([above, sizes - above]).pvalue))
    return min(1.0, 2.0 * tried * min(chances))


def _places(column: NDArray[Any]) -> NDArray[np.int64]:
    """The number of the part of every run (runs,)."""
    place = np.zeros(column.size, dtype=np.int64)
    for k, rows in enumerate(parts_of(column)):
        place[rows] = k
    return place


def _may_explain(stronger: NDArray[np.int64], weaker: NDArray[np.int64], metric: Array, share: float) -> bool:
    """Whether one follows the other (chi-squared), and has no effect of its own among the runs of any part of it."""
    found = chi2_contingency(crosstab(weaker, stronger).count)
    if not (found.expected_freq.min() >= FEWEST and found.pvalue < FOLLOWS):
        return False
    strata = np.unique(stronger)
    for k in strata:
        parts = [metric[(stronger == k) & (weaker == part)] for part in np.unique(weaker)]
        parts = [part for part in parts if part.size >= FEWEST]
        if len(parts) > 1 and _chance(parts, share, strata.size) < 1.0 - LEVEL:
            return False
    return True


def is_by_name(column: NDArray[Any]) -> bool:
    """Whether a parameter is chosen by name, as a reading is."""
    return column.dtype.kind not in "biuf"


def columns(
    values: Mapping[str, NDArray[Any]], names: Mapping[str, Sequence[str]] | None = None
) -> dict[str, NDArray[Any]]:
    """One column (runs,) a draw; a path with several has `names` of its draws, or numbers from 1.

    >>> list(columns({"a": np.zeros(3), "arm.com": np.zeros((3, 2))}))
    ['a', 'arm.com[1]', 'arm.com[2]']
    """
    found: dict[str, NDArray[Any]] = {}
    for path, array in values.items():
        flat = array.reshape(array.shape[0], -1)
        numbered = [path] if flat.shape[1] == 1 else [f"{path}[{k + 1}]" for k in range(flat.shape[1])]
        own = (names or {}).get(path, numbered)
        found |= dict(zip(own, flat.T, strict=True))
    return found


def parts_of(column: NDArray[Any]) -> list[NDArray[np.int64]]:
    """The rows of each fifth of a parameter (runs,), or of each of its values where it has few."""
    different = np.unique(column)
    if different.size <= MOST_LEVELS or is_by_name(column):
        return [np.flatnonzero(column == value) for value in different]
    edges = np.quantile(column, np.linspace(0.0, 1.0, PARTS + 1)[1:-1])
    place = np.searchsorted(edges, column, side="right")
    return [np.flatnonzero(place == part) for part in range(PARTS)]


def rank_correlation(x: Array, y: Array, level: float = LEVEL) -> IntervalEstimate:
    """Spearman's rho of two columns (n,); 0 where one does not vary.

    The interval is tanh(atanh(rho) +- z sqrt((1 + rho^2 / 2) / (n - 3))), by Fisher's transformation (Bonett and Wright
    2000).
    """
    if np.ptp(x) == 0.0 or (y == y[0]).all():
        return IntervalEstimate(0.0, 0.0, 0.0)
    rho = float(spearmanr(x, y).statistic)
    if x.size < 4:
        return IntervalEstimate(rho, -1.0, 1.0)
    if abs(rho) > 1.0 - 1e-12:
        return IntervalEstimate(rho, rho, rho)
    half = float(norm.ppf(0.5 * (1.0 + level))) * sqrt((1.0 + 0.5 * rho * rho) / (x.size - 3))
    return IntervalEstimate(rho, tanh(atanh(rho) - half), tanh(atanh(rho) + half))


RESAMPLES = 2000
FEWEST_GROUPS = 8
"""Complete groups below which no index is given."""


@dataclass(frozen=True, slots=True)
class SobolIndices:
    """Of one metric: each parameter's own share of the variance (`first`), and with all its interactions (`total`).

    `groups` are the rows A, B with their d rows AB that the indices rest on; `left_out` were not complete, or had a run
    without a finite metric: the indices say nothing of those.
    """

    metric: str
    first: Mapping[str, IntervalEstimate]
    total: Mapping[str, IntervalEstimate]
    groups: int
    left_out: int
    level: float = LEVEL


def groups_of(values: Array, parameters: int) -> tuple[Array, Array, Array]:
    """The rows f_A (g,), f_B (g,) and f_AB (d, g) of a metric (runs,), run g (d + 2) + j being A, B, AB_1 ... AB_d.

    A group that is not complete at the end is left out.
    """
    width = parameters + 2
    rows = values[: values.size // width * width].reshape(-1, width).T
    return rows[0], rows[1], rows[2:]


def indices_of(
    metric: str, values: Array, names: Sequence[str], level: float = LEVEL, seed: int = 0
) -> SobolIndices | None:
    """The indices of a metric (runs,) of a Saltelli design; None where it does not vary or groups are too few.

    Raises
    ------
    ShapeError
        Values that are not (runs,).

    References
    ----------
    Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Commun. 181 (2010), table 2, b
    and f.
    """
    if values.ndim != 1 or not names:
        raise ShapeError("values", f"shape {values.shape}, {len(names)} parameters", "(runs,) and a parameter or more")
    f_a, f_b, f_ab = groups_of(values, len(names))
    finite = np.isfinite(f_a) & np.isfinite(f_b) & np.isfinite(f_ab).all(axis=0)
    complete = np.flatnonzero(finite)
    if complete.size < FEWEST_GROUPS:
        return None
    f_a, f_b, f_ab = f_a[complete], f_b[complete], f_ab[:, complete]
    both = np.concatenate([f_a, f_b])
    if np.ptp(both) <= 1e-12 * np.abs(both).max():
        return None
    d, n, products = len(names), complete.size, _products(f_a, f_b, f_ab)
    rng = np.random.default_rng(seed)
    drawn = [np.bincount(rng.integers(0, n, n), minlength=n) @ products / n for _ in range(RESAMPLES)]
    whole, spread = _estimates(products.mean(axis=0)[None])[0], _estimates(np.array(drawn))
    low, high = np.quantile(spread, [0.5 * (1.0 - level), 0.5 * (1.0 + level)], axis=0)
    made = [IntervalEstimate(float(v), float(a), float(b)) for v, a, b in zip(whole, low, high, strict=True)]
    first, total = dict(zip(names, made[:d], strict=True)), dict(zip(names, made[d:], strict=True))
    return SobolIndices(metric, first, total, n, -(-values.size // (d + 2)) - n, level)


def _products(f_a: Array, f_b: Array, f_ab: Array) -> Array:
    """Of each group the numbers (n, 2 + 2 d) whose means the indices are made of."""
    middle = 0.5 * (f_a.mean() + f_b.mean())
    f_a, f_b, f_ab = f_a - middle, f_b - middle, f_ab - middle
    return np.column_stack([f_a + f_b, f_a**2 + f_b**2, *(f_b * (f_ab - f_a)), *(0.5 * (f_a - f_ab) ** 2)])


def _estimates(means: Array) -> Array:
    """First and total indices (m, 2 d) from means of products (m, 2 + 2 d)."""
    variance = 0.5 * means[:, 1] - (0.5 * means[:, 0]) ** 2
    return np.asarray(means[:, 2:] / np.where(variance > 0.0, variance, np.inf)[:, None])
