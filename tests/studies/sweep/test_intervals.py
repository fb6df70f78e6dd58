"""Intervals of quantiles and shares: their coverage by trial, and what too few runs leave open."""

import numpy as np
import pytest
from scipy.stats import binom, binomtest

from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.studies.sweep.intervals import quantile_of, runs_needed, share_of


def coverage(found) -> float:
    """The exact coverage of an interval from values that are their own ranks."""
    low = found.low if np.isfinite(found.low) else 0
    high = found.high if np.isfinite(found.high) else found.runs + 1
    return float(binom.cdf(high - 1, found.runs, found.share) - binom.cdf(low - 1, found.runs, found.share))


@pytest.mark.parametrize("runs", [6, 17, 100, 368, 1000, 100_000])
@pytest.mark.parametrize("share", [0.5, 0.05, 0.95, 0.99, 0.999])
def test_the_interval_covers_and_is_not_wider_than_it_must_be(runs, share):
    found = quantile_of(np.arange(1.0, runs + 1), share)
    assert coverage(found) >= 0.95
    for name, step in (("low", 1), ("high", -1)):
        inner = getattr(found, name) + step
        if np.isfinite(inner):
            beyond = binom.cdf(inner - 1, runs, share) if name == "low" else binom.sf(inner - 1, runs, share)
            assert beyond > 0.025  # a step further in, and one side misses more than it may


@pytest.mark.parametrize(("share", "runs"), [(0.5, 40), (0.9, 200), (0.99, 1000)])
def test_by_trial_it_covers_the_quantile_of_a_heavy_tail(share, runs):
    rng, truth = np.random.default_rng(3), (1.0 - share) ** -0.5  # Pareto, of infinite variance
    trials = [quantile_of((1.0 - rng.random(runs)) ** -0.5, share) for _ in range(1000)]
    held = np.mean([one.low <= truth <= one.high for one in trials])
    assert 0.94 <= held <= 1.0  # at least 0.95, less three standard errors
    assert 0.0 < np.mean([one.high < truth for one in trials]) < 0.04


def test_the_value_is_an_order_statistic():
    values = np.random.default_rng(0).permutation(np.arange(1.0, 1001.0))
    assert [quantile_of(values, p).value for p in (0.5, 0.95, 0.999)] == [500.0, 950.0, 999.0]
    assert quantile_of(values, 0.95).beyond == 50


def test_too_few_runs_leave_the_interval_open_and_say_how_many_are_needed():
    for share in (0.99, 0.999):
        needed = runs_needed(share)
        few, enough = (quantile_of(np.arange(float(n)), share) for n in (needed - 1, needed))
        assert (few.high, few.is_bounded) == (np.inf, False)
        assert (enough.high, enough.is_bounded) == (needed - 1.0, True)
        assert few.needed == enough.needed == needed


def test_runs_that_diverged_are_the_largest_of_all():
    values = np.append(np.arange(98.0), [np.inf, np.inf])
    assert quantile_of(values, 0.5).high == 60.0
    assert quantile_of(values, 0.99).value == np.inf


@pytest.mark.parametrize("values", [[], [1.0, np.nan], [[1.0, 2.0]]])
def test_values_that_are_no_column_of_numbers_are_refused(values):
    with pytest.raises(ShapeError, match="none of them NaN"):
        quantile_of(values, 0.5)


@pytest.mark.parametrize(("share", "level"), [(0.0, 0.95), (1.0, 0.95), (0.5, 1.0), (np.nan, 0.95)])
def test_a_share_that_is_none_is_refused(share, level):
    with pytest.raises(OptionError, match="between 0 and 1"):
        quantile_of([1.0, 2.0], share, level)


@pytest.mark.parametrize(("count", "runs"), [(0, 10), (3, 10), (10, 10), (1, 100_000), (0, 0)])
def test_a_share_has_the_interval_of_clopper_and_pearson(count, runs):
    found = share_of(count, runs)
    if runs:
        exact = binomtest(count, runs).proportion_ci(method="exact")
        assert (found.low, found.high) == pytest.approx((exact.low, exact.high), rel=1e-9)
        assert found.low <= found.value <= found.high
    else:
        assert (found.low, found.high) == (0.0, 1.0)
        assert np.isnan(found.value)


def test_the_interval_of_a_share_covers():
    for p in (0.001, 0.1, 0.5):
        counts = np.arange(101)
        inside = [found.low <= p <= found.high for found in (share_of(int(k), 100) for k in counts)]
        assert binom.pmf(counts, 100, p)[inside].sum() >= 0.95


@pytest.mark.parametrize("count", [-1, 11])
def test_a_count_beyond_the_runs_is_refused(count):
    with pytest.raises(OptionError, match="from 0 to the number of runs, 10"):
        share_of(count, 10)
