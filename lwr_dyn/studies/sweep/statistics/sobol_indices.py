"""Sobol indices of a metric from the runs of a Saltelli design, with intervals by the bootstrap.

The values are those of `scipy.stats.sobol_indices`, which takes a power of 2 of groups; where groups with a run that
diverged are left out, the same estimator stands here. The bootstrap of scipy (BCa) needs n^2 d numbers, gigabytes for
thousands of runs; here resampling is a matrix product of counts, and the intervals are percentiles.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import sobol_indices

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.studies.sweep.statistics.intervals import LEVEL

RESAMPLES = 2000
LEAST = 8
"""Complete groups below which no index is given."""


@dataclass(frozen=True, slots=True)
class IndexEstimate:
    """A Sobol index with its interval; single estimates may lie outside 0 to 1."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class SobolIndices:
    """Of one metric: each parameter's own share of the variance (`first`), and with all its interactions (`total`).

    `groups` are the rows A, B with their d rows AB that the indices rest on; `left_out` were not complete, or had a run
    without a finite metric: the indices say nothing of those.
    """

    metric: str
    first: Mapping[str, IndexEstimate]
    total: Mapping[str, IndexEstimate]
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
    if complete.size < LEAST:
        return None
    f_a, f_b, f_ab = f_a[complete], f_b[complete], f_ab[:, complete]
    both = np.concatenate([f_a, f_b])
    if np.ptp(both) <= 1e-12 * np.abs(both).max():
        return None
    d, n, products = len(names), complete.size, _products(f_a, f_b, f_ab)
    whole = _by_scipy(f_a, f_b, f_ab) if n & (n - 1) == 0 else _estimates(products.mean(axis=0)[None])[0]
    spread = _resampled(products, np.random.default_rng(seed))
    low, high = np.quantile(spread, [0.5 * (1.0 - level), 0.5 * (1.0 + level)], axis=0)
    made = [IndexEstimate(float(v), float(a), float(b)) for v, a, b in zip(whole, low, high, strict=True)]
    first, total = dict(zip(names, made[:d], strict=True)), dict(zip(names, made[d:], strict=True))
    return SobolIndices(metric, first, total, n, -(-values.size // (d + 2)) - n, level)


def _by_scipy(f_a: Array, f_b: Array, f_ab: Array) -> Array:
    d = f_ab.shape[0]
    pages = f_ab if d > 1 else np.tile(f_ab, (2, 1))  # scipy fails on a single parameter
    func: Any = {"f_A": f_a[None], "f_B": f_b[None], "f_AB": pages[:, None]}
    found = sobol_indices(func=func, n=f_a.size)
    return np.concatenate([found.first_order[:d], found.total_order[:d]])


def _products(f_a: Array, f_b: Array, f_ab: Array) -> Array:
    """Of each group the numbers (n, 2 + 2 d) whose means the indices are made of."""
    middle = 0.5 * (f_a.mean() + f_b.mean())
    f_a, f_b, f_ab = f_a - middle, f_b - middle, f_ab - middle
    return np.column_stack([f_a + f_b, f_a**2 + f_b**2, *(f_b * (f_ab - f_a)), *(0.5 * (f_a - f_ab) ** 2)])


def _estimates(means: Array) -> Array:
    """First and total indices (m, 2 d) from means of products (m, 2 + 2 d)."""
    variance = 0.5 * means[:, 1] - (0.5 * means[:, 0]) ** 2
    return np.asarray(means[:, 2:] / np.where(variance > 0.0, variance, np.inf)[:, None])


def _resampled(products: Array, rng: np.random.Generator) -> Array:
    """Indices (RESAMPLES, 2 d) of groups drawn with replacement: counts times the products."""
    n = products.shape[0]
    means = [np.bincount(rng.integers(0, n, n), minlength=n) @ products / n for _ in range(RESAMPLES)]
    return _estimates(np.array(means))
