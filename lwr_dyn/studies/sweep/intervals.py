"""Confidence intervals that assume nothing of a distribution: of a quantile by order statistics, of a share; in words.

Both hold for runs drawn independently. Runs of a Sobol sequence or a Latin hypercube fill their box more evenly, and a
quantile of theirs varies less as a rule, so that the same interval is then a cautious one; a grid is no sample at all.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, inf, log
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import beta, binom

from lwr_dyn.foundation.errors import OptionError, ShapeError

LEVEL = 0.95
"""The confidence of every interval, unless another is asked for."""


@dataclass(frozen=True, slots=True)
class IntervalEstimate:
    """A number and its interval."""

    value: Annotated[float, "The number."]
    low: Annotated[float, "Lower end of its interval."]
    high: Annotated[float, "Upper end."]


@dataclass(frozen=True, slots=True)
class QuantileEstimate:
    """A quantile over runs; `low` is -inf and `high` inf where too few runs lie beyond it to bound it.

    `beyond` runs are larger than `value`; `needed` is the least number of runs that would bound the quantile from both
    sides.
    """

    share: float
    value: float
    low: float
    high: float
    runs: int
    beyond: int
    needed: int
    level: float = LEVEL

    @property
    def is_bounded(self) -> bool:
        """Whether the runs bound it from both sides."""
        return self.runs >= self.needed


@dataclass(frozen=True, slots=True)
class ShareEstimate:
    """`count` of `runs`, and the Clopper-Pearson interval of the probability."""

    count: int
    runs: int
    low: float
    high: float
    level: float = LEVEL

    @property
    def value(self) -> float:
        """The share itself; NaN of no runs."""
        return self.count / self.runs if self.runs else float("nan")


def quantile_of(values: ArrayLike, share: float, level: float = LEVEL) -> QuantileEstimate:
    r"""A quantile of independent runs with its interval.

    The value is the order statistic x_(k), k = ceil(n p). The interval is from x_(l) to x_(u) with the largest l and
    the smallest u for which P(Bin(n, p) < l) <= a / 2 and P(Bin(n, p) >= u) <= a / 2, a = 1 - level: its coverage is at
    least `level` whatever the distribution, also with ties.

    Parameters
    ----------
    values : (n,) array_like
        n >= 1; inf stands for a run that diverged. No NaN.
    share : float
        p, between 0 and 1.
    level : float
        Between 0 and 1.

    Raises
    ------
    ShapeError
        No values, or a NaN among them.
    OptionError
        A share or a level that is not between 0 and 1.

    References
    ----------
    David and Nagaraja, Order Statistics, 3rd ed., section 7.1.

    >>> found = quantile_of(np.arange(1.0, 101.0), 0.5)
    >>> found.value, found.low, found.high, found.needed
    (50.0, 40.0, 61.0, 6)
    >>> quantile_of(np.arange(100.0), 0.999).high, quantile_of(np.arange(100.0), 0.999).needed
    (inf, 3688)
    """
    ordered = np.sort(np.asarray(values, dtype=np.float64))
    if ordered.ndim != 1 or not ordered.size or np.isnan(ordered[-1]):
        raise ShapeError("values", f"shape {ordered.shape}", "(n,) numbers, n > 0, none of them NaN")
    for name, number in (("share", share), ("level", level)):
        if not 0.0 < number < 1.0:
            raise OptionError(name, number, "between 0 and 1")
    n = ordered.size
    lower, upper = interval_ranks(n, share, level)
    value = float(ordered[min(max(ceil(n * share * (1.0 - 1e-15)), 1), n) - 1])
    low = float(ordered[lower - 1]) if lower >= 1 else -inf
    high = float(ordered[upper - 1]) if upper <= n else inf
    beyond = int(n - np.searchsorted(ordered, value, side="right"))
    return QuantileEstimate(share, value, low, high, n, beyond, runs_needed(share, level), level)


@lru_cache(maxsize=1024)
def interval_ranks(n: int, share: float, level: float) -> tuple[int, int]:
    """The ranks l and u (from 1) of `quantile_of`; l = 0 and u = n + 1 are not among n runs."""
    half = 0.5 * (1.0 - level)
    lower = int(binom.ppf(half, n, share))  # the least k with P(X <= k) >= half, so that P(X < k) < half
    return lower, int(binom.ppf(1.0 - half, n, share)) + 1  # P(X >= upper) <= half


def runs_needed(share: float, level: float = LEVEL) -> int:
    """The least number of runs that bounds a quantile from both sides: max(p, 1 - p)^n <= (1 - level) / 2.

    >>> runs_needed(0.5), runs_needed(0.99), runs_needed(0.999)
    (6, 368, 3688)
    """
    return ceil(log(0.5 * (1.0 - level)) / log(max(share, 1.0 - share)))


def share_of(count: int, runs: int, level: float = LEVEL) -> ShareEstimate:
    """The share count / runs with the interval of Clopper and Pearson (1934).

    Raises
    ------
    OptionError
        A count below 0 or above the runs, or a level that is not between 0 and 1.

    >>> found = share_of(0, 100)
    >>> found.low, round(found.high, 4)
    (0.0, 0.0362)
    """
    if not 0 <= count <= runs:
        raise OptionError("count", count, f"from 0 to the number of runs, {runs}")
    if not 0.0 < level < 1.0:
        raise OptionError("level", level, "between 0 and 1")
    half = 0.5 * (1.0 - level)
    low = float(beta.ppf(half, count, runs - count + 1)) if count else 0.0
    high = float(beta.ppf(1.0 - half, count + 1, runs - count)) if count < runs else 1.0
    return ShareEstimate(count, runs, low, high, level)


OPEN = "?"
"""The end of an interval that the runs do not bound."""


def percent(share: float) -> str:
    """A share in percent, with as many digits as tell it from 0 and from 100 %.

    >>> percent(0.5), percent(0.99991), percent(0.00001234), percent(1.0)
    ('50', '99.991', '0.0012', '100')
    """
    rest = min(share, 1.0 - share)
    if rest <= 0.0:
        return f"{100 * share:.0f}"
    decimals = 1 if rest >= 0.01 else 2
    while decimals < 8 and round(100 * rest, decimals - 1) == 0.0:
        decimals += 1
    return f"{100 * share:.{decimals}f}".rstrip("0").rstrip(".")


def share_text(found: ShareEstimate | None, with_interval: bool = True) -> str:
    """A share in percent with its interval in brackets."""
    if found is None or not found.runs:
        return OPEN
    value = f"{percent(found.value)} %"
    return f"{value} [{percent(found.low)} to {percent(found.high)}]" if with_interval else value


def hundredths(value: float, sign: str = "") -> str:
    """A share or correlation in two decimals, never "-0.00"; with `sign` "+" a plus, too.

    >>> hundredths(-0.001), hundredths(-0.001, "+"), hundredths(-0.25)
    ('0.00', '+0.00', '-0.25')
    """
    return f"{round(value, 2) + 0.0:{sign}.2f}"


def index_text(one: IntervalEstimate) -> str:
    """An index with its interval in brackets."""
    return f"{hundredths(one.value)} [{hundredths(one.low)} to {hundredths(one.high)}]"
