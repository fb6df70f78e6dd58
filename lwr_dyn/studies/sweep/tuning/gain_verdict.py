"""What gains are worth on runs that their search has not seen, beside the gains that were given."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.studies.sweep.statistics.intervals import LEVEL, QuantileEstimate, ShareEstimate, quantile_of, share_of

RESAMPLES = 2000
"""Of the bootstrap."""
FEW = 10
"""Runs beyond a quantile below which the interval of the bootstrap is too narrow."""


@dataclass(frozen=True, slots=True, eq=False)
class PairedRatio:
    """The quantile with one set of gains over that with another, on the same runs, with its interval."""

    value: float
    low: float
    high: float
    level: float = LEVEL


@dataclass(frozen=True, slots=True, eq=False)
class GainVerdict:
    """Two sets of gains on the same runs: quantiles of the metric and of the torque use, and how they compare.

    `ratio` is found over given, below 1 where the found gains are better; `better` is the share of runs in which they
    err by less.
    """

    given: QuantileEstimate
    found: QuantileEstimate
    given_use: QuantileEstimate
    found_use: QuantileEstimate
    ratio: PairedRatio
    better: ShareEstimate

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
        given=quantile_of(given, share),
        found=quantile_of(found, share),
        given_use=quantile_of(given_use, share),
        found_use=quantile_of(found_use, share),
        ratio=paired_ratio(given, found, share, seed),
        better=share_of(int((found < given).sum()), given.size),
    )


def paired_ratio(given: Array, found: Array, share: float, seed: int) -> PairedRatio:
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
    cut = int(np.floor(0.5 * (1.0 - LEVEL) * RESAMPLES))
    return PairedRatio(ratio(slice(None)), float(drawn[cut]), float(drawn[-1 - cut]))
