"""The numbers of a tornado on metrics whose dependence is known."""

import numpy as np
import pytest
from scipy.stats import spearmanr

from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.studies.sweep.influence import columns, influences, parts_of, rank_correlation

RNG = np.random.default_rng(5)
RUNS = 4000
X = RNG.random((RUNS, 4))


def test_the_largest_swing_is_first_and_conditional_medians_are_right():
    metric = 10.0 * X[:, 0] + X[:, 1]
    first, second, *none = influences(metric, dict(zip("abcd", X.T, strict=True)), 0.5)
    assert (first.path, second.path) == ("a", "b")
    middles = [part.estimate.value for part in first.parts]
    assert middles == pytest.approx([1.5, 3.5, 5.5, 7.5, 9.5], abs=0.15)
    assert [part.estimate.runs for part in first.parts] == [800] * 5
    assert first.swing == pytest.approx(8.0, abs=0.2)
    assert first.is_clear
    assert [one.is_clear for one in none] == [False, False]


def test_a_metric_that_rises_at_both_ends_is_seen_where_a_correlation_is_blind():
    metric = (X[:, 0] - 0.5) ** 2
    (one,) = influences(metric, {"a": X[:, 0]}, 0.9)
    assert abs(one.correlation.value) < 0.05
    assert one.is_clear
    assert (one.best.low, one.best.high) == pytest.approx((0.4, 0.6), abs=0.02)


def test_levels_and_names_are_cut_by_value():
    delay, reading = RNG.integers(0, 5, RUNS), RNG.choice(["computed", "printed"], RUNS)
    metric = delay + 3.0 * (reading == "printed")
    by_name, by_level = influences(metric, {"delay": delay.astype(float), "reading": reading}, 0.5)
    if by_name.path == "delay":
        by_name, by_level = by_level, by_name
    assert [(part.low, part.high) for part in by_level.parts] == [(float(k), float(k)) for k in range(5)]
    assert [part.low for part in by_name.parts] == ["computed", "printed"]
    assert by_name.correlation is None
    assert [part.estimate.value for part in by_name.parts] == [2.0, 5.0]


def test_runs_that_diverged_count_as_the_largest():
    metric = np.where(X[:, 0] > 0.8, np.inf, X[:, 1])
    first, *_ = influences(metric, {"a": X[:, 0], "b": X[:, 1]}, 0.9)
    assert (first.path, first.worst.estimate.value, first.swing) == ("a", np.inf, np.inf)


def test_a_path_with_several_draws_gives_a_row_each_and_too_few_runs_none():
    assert list(columns({"arm.com": X[:, :2], "b": X[:, 2:3]})) == ["arm.com[1]", "arm.com[2]", "b"]
    found = influences(X[:, 1], {"arm.com": X[:, :2]}, 0.5)
    assert found[0].path == "arm.com[2]"
    assert influences(X[:30, 1], {"a": X[:30, 0]}, 0.5) == ()
    assert influences(X[:, 1], {"a": np.zeros(RUNS)}, 0.5) == ()


@pytest.mark.slow
def test_what_has_no_effect_is_rarely_called_clear():
    """10 parameters without effect, 60 studies: 5 % of the studies may name one."""
    rng, named = np.random.default_rng(8), 0
    for _ in range(60):
        metric, values = rng.random(600), dict(zip("abcdefghij", rng.random((10, 600)), strict=True))
        named += any(one.is_clear for one in influences(metric, values, 0.9))
    assert named <= 7  # with p = 0.05, P(more than 7 of 60) = 0.7 %


def test_what_moves_only_the_largest_values_is_clear():
    metric = np.where((X[:, 0] > 0.8) & (X[:, 1] > 0.8), 5.0 + X[:, 2], X[:, 3])
    found = influences(metric, {"a": X[:, 0], "c": X[:, 2]}, 0.95)
    assert [(one.path, one.is_clear) for one in found] == [("a", True), ("c", False)]


def test_a_parameter_that_goes_along_with_a_stronger_one_is_named():
    follower = np.where(RNG.random(RUNS) < 0.8, X[:, 0], X[:, 1])
    levels = np.floor(4.0 * X[:, 0])
    first, second, third = influences(10.0 * levels + X[:, 2], {"a": levels, "b": follower, "c": X[:, 2]}, 0.5)
    assert (first.path, first.along) == ("a", ())
    assert (second.path, second.along) == ("b", ("a",))
    assert (third.path, third.along) == ("c", ())
    own = influences(10.0 * levels + X[:, 2] + 5.0 * follower, {"a": levels, "b": follower}, 0.5)
    assert {one.path: one.along for one in own} == {"a": (), "b": ()}  # an effect of its own beside it


def test_the_parts_hold_every_run_once():
    rows = parts_of(np.round(X[:, 0], 2))
    assert sorted(np.concatenate(rows)) == list(range(RUNS))
    assert all(650 < part.size < 950 for part in rows)


def test_the_rank_correlation_is_spearmans_and_its_interval_covers():
    rho = 0.6
    truth = 6.0 / np.pi * np.arcsin(rho / 2.0)  # of two normal numbers with correlation rho
    rng, held = np.random.default_rng(2), []
    for _ in range(400):
        x = rng.standard_normal(80)
        y = rho * x + np.sqrt(1 - rho**2) * rng.standard_normal(80)
        found = rank_correlation(x, y)
        held.append(found.low <= truth <= found.high)
        assert found.value == pytest.approx(spearmanr(x, y).statistic, abs=1e-12)
    assert 0.92 <= np.mean(held) <= 0.98


def test_a_correlation_of_what_does_not_vary_is_zero_and_of_order_alone_one():
    assert rank_correlation(np.zeros(9), np.arange(9.0)).value == 0.0
    whole = rank_correlation(np.arange(9.0), np.exp(np.arange(9.0)))
    assert (whole.value, whole.low, whole.high) == pytest.approx((1.0, 1.0, 1.0))
    few = rank_correlation(np.arange(3.0), np.array([1.0, 3.0, 2.0]))
    assert (few.low, few.high) == (-1.0, 1.0)


def test_a_parameter_with_another_number_of_runs_is_refused():
    with pytest.raises(ShapeError, match="one value a run"):
        influences(X[:, 0], {"a": X[:5, 0]}, 0.5)
