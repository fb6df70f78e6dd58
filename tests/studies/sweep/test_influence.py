"""The numbers of a tornado, and Sobol indices, on metrics whose dependence is known."""

import numpy as np
import pytest
from scipy.stats import chi2_contingency, kruskal, qmc, sobol_indices, spearmanr

from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.studies.sweep.influence import columns, groups_of, indices_of, influences, parts_of, rank_correlation
from lwr_dyn.studies.sweep.intervals import IntervalEstimate

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
    line = np.arange(9.0)
    for x, y in ((np.zeros(9), line), (line, np.zeros(9)), (line, np.full(9, np.inf))):
        assert rank_correlation(x, y) == IntervalEstimate(0.0, 0.0, 0.0)
    whole = rank_correlation(line, np.exp(-line))
    assert (whole.value, whole.low, whole.high) == pytest.approx((-1.0, -1.0, -1.0))
    few = rank_correlation(np.arange(3.0), np.array([1.0, 3.0, 2.0]))
    assert (few.value, few.low, few.high) == (0.5, -1.0, 1.0)
    four = rank_correlation(np.arange(4.0), np.array([1.0, 3.0, 2.0, 4.0]))  # Bonett and Wright, 2000
    half = 1.959963984540054 * np.sqrt(1 + 0.5 * 0.8**2)
    assert (four.value, np.arctanh(four.low), np.arctanh(four.high)) == pytest.approx(
        (0.8, np.arctanh(0.8) - half, np.arctanh(0.8) + half)
    )


def test_chance_is_that_of_the_test_which_sees_more_times_all_that_was_tried():
    """Kruskal and Wallis on ranks, or chi-squared on the shares above the quantile; Bonferroni of two a parameter."""
    level, line = np.repeat([0.0, 1.0], 100), np.arange(200.0)
    line[90:110] = line[90:110][::-1]
    for metric, share in ((line, 0.5), (np.where(level == 1, 100 + np.arange(200.0) % 7, np.arange(200) % 100), 0.9)):
        found = {one.path: one for one in influences(metric, {"a": level, "b": np.tile([0.0, 1.0], 100)}, share)}
        above = [int((metric[level == k] > np.sort(metric)[int(share * 200) - 1]).sum()) for k in (0, 1)]
        ranks = kruskal(metric[level == 0], metric[level == 1]).pvalue
        shares = chi2_contingency([above, [100 - x for x in above]]).pvalue
        assert found["a"].chance == pytest.approx(2 * 2 * min(ranks, shares), rel=1e-9)
        assert found["b"].chance <= 1.0
    same = influences(np.append(np.zeros(199), 1.0), {"a": level}, 0.5)[0]
    assert same.swing == 0.0
    assert influences(np.zeros(200), {"a": level}, 0.5)[0].chance == 1.0


@pytest.mark.parametrize(
    ("count", "levels", "parts"),
    [(60, 6, [10] * 6), (59, 6, []), (70, 7, [10, 10, 20, 10, 20]), (50, 50, [10] * 5), (49, 49, [])],
)
def test_a_parameter_of_up_to_six_values_is_cut_by_value_and_others_in_fifths(count, levels, parts):
    column = np.arange(count, dtype=float) % levels
    found = influences(np.arange(count, dtype=float), {"a": column}, 0.5)
    assert [part.estimate.runs for one in found for part in one.parts] == parts
    for one in found:
        assert (one.extent, one.parts[0].low, one.parts[-1].high) == (levels - 1.0, 0.0, levels - 1.0)


def test_a_parameter_with_another_number_of_runs_is_refused():
    with pytest.raises(ShapeError, match="one value a run"):
        influences(X[:, 0], {"a": X[:5, 0]}, 0.5)


A, B = 7.0, 0.1


def ishigami(x):
    """The function of Ishigami and Homma (1990) of (..., 3) in [-pi, pi]."""
    return np.sin(x[..., 0]) + A * np.sin(x[..., 1]) ** 2 + B * x[..., 2] ** 4 * np.sin(x[..., 0])


def ishigami_indices():
    """Its indices in closed form: first order, total."""
    own = [0.5 * (1 + B * np.pi**4 / 5) ** 2, A**2 / 8, 0.0]
    both = B**2 * np.pi**8 * (1 / 18 - 1 / 50)
    variance = sum(own) + both
    return np.array(own) / variance, np.array([own[0] + both, own[1], both]) / variance


def design(groups, d, seed=0):
    """The rows (groups (d + 2), d) of a Saltelli design in the unit cube, in the order of a study."""
    points = qmc.Sobol(2 * d, seed=seed).random(groups)
    a, b = points[:, :d], points[:, d:]
    rows = [a, b]
    for i in range(d):
        mixed = a.copy()
        mixed[:, i] = b[:, i]
        rows.append(mixed)
    return np.stack(rows, axis=1).reshape(-1, d)


def values_of(groups, seed=0):
    """Ishigami's function on a design."""
    return ishigami(np.pi * (2.0 * design(groups, 3, seed) - 1.0))


def test_the_indices_of_ishigami_come_back():
    first, total = ishigami_indices()
    found = indices_of("tip_max", values_of(4096), ["a", "b", "c"])
    assert (found.groups, found.left_out) == (4096, 0)
    np.testing.assert_allclose([one.value for one in found.first.values()], first, atol=0.01)
    np.testing.assert_allclose([one.value for one in found.total.values()], total, atol=0.01)
    for one, truth in zip((*found.first.values(), *found.total.values()), (*first, *total), strict=True):
        assert one.low <= truth <= one.high
        assert 0.0 <= one.high - one.low < 0.15


def test_a_product_has_interactions_and_a_sum_has_none():
    rows = 2.0 * design(2048, 2) - 1.0
    product = indices_of("tip_max", rows[:, 0] * rows[:, 1], ["a", "b"])
    assert all(abs(one.value) < 0.02 for one in product.first.values())
    assert all(abs(one.value - 1.0) < 0.02 for one in product.total.values())
    both = indices_of("tip_max", rows[:, 0] + 2.0 * rows[:, 1], ["a", "b"])
    for kind in (both.first, both.total):
        assert [one.value for one in kind.values()] == pytest.approx([0.2, 0.8], abs=0.01)


def test_they_are_those_of_scipy():
    values = values_of(256)
    f_a, f_b, f_ab = groups_of(values, 3)
    theirs = sobol_indices(func={"f_A": f_a[None], "f_B": f_b[None], "f_AB": f_ab[:, None]}, n=256)
    ours = indices_of("tip_max", values, ["a", "b", "c"])
    np.testing.assert_allclose([one.value for one in ours.first.values()], theirs.first_order, atol=1e-12)
    np.testing.assert_allclose([one.value for one in ours.total.values()], theirs.total_order, atol=1e-12)


@pytest.mark.slow
def test_the_intervals_cover_with_independent_rows():
    """Rows drawn at random, as the bootstrap assumes; 60 designs."""
    first, total = ishigami_indices()
    rng, held = np.random.default_rng(1), []
    for seed in range(60):
        a, b = rng.random((2, 256, 3))
        mixed = [np.where(np.arange(3) == i, b, a) for i in range(3)]
        values = ishigami(np.pi * (2.0 * np.stack([a, b, *mixed], axis=1).reshape(-1, 3) - 1.0))
        found = indices_of("tip_max", values, ["a", "b", "c"], seed=seed)
        every = zip((*found.first.values(), *found.total.values()), (*first, *total), strict=True)
        held.append([one.low <= truth <= one.high for one, truth in every])
    share = np.mean(held, axis=0)
    assert share.min() > 0.85
    assert share.mean() > 0.91


def test_runs_without_a_number_take_their_group_along():
    values = values_of(64)
    values[7] = np.inf  # of the second group
    found = indices_of("tip_max", np.append(values, [0.0, 0.0]), ["a", "b", "c"])
    assert (found.groups, found.left_out) == (63, 2)  # and one group that has only begun
    assert found.first == indices_of("tip_max", np.r_[values[:5], values[10:]], ["a", "b", "c"]).first


def test_what_does_not_vary_and_what_is_too_little_has_no_indices():
    assert indices_of("tip_max", np.full(5 * 64, 3.0), ["a", "b", "c"]) is None
    assert indices_of("tip_max", values_of(64)[: 5 * 7], ["a", "b", "c"]) is None
    assert indices_of("tip_max", np.full(5 * 64, np.inf), ["a", "b", "c"]) is None


def test_eight_groups_are_enough_and_intervals_are_percentiles_of_resampled_groups():
    assert indices_of("tip_max", values_of(64)[: 5 * 8], ["a", "b", "c"]).groups == 8
    rows, rng = design(16, 1), np.random.default_rng(3)
    values, drawn = rows[:, 0] ** 2 + rows[:, 0], []
    a, b, ab = values.reshape(-1, 3).T
    centre = 0.5 * (a.mean() + b.mean())
    for _ in range(2000):
        x, y, z = (one[k] - centre for k in [rng.integers(0, 16, 16)] for one in (a, b, ab))
        variance = 0.5 * (x**2 + y**2).mean() - (0.5 * (x + y).mean()) ** 2
        drawn.append(((y * (z - x)).mean() / variance, 0.5 * ((x - z) ** 2).mean() / variance))
    found = indices_of("tip_max", values, ["a"], seed=3)
    wanted = np.quantile(drawn, [0.025, 0.975], axis=0).T
    for one, ends in zip((found.first["a"], found.total["a"]), wanted, strict=True):
        assert (one.low, one.high) == pytest.approx(tuple(ends))


def test_values_of_another_shape_are_refused():
    for values, names in ((np.zeros((5, 2)), ["a"]), (np.zeros(5), [])):
        with pytest.raises(ShapeError, match=r"\(runs,\)"):
            indices_of("tip_max", values, names)


def test_one_parameter_explains_all():
    rows = design(64, 1)
    found = indices_of("tip_max", rows[:, 0], ["a"])
    assert found.first["a"].value == pytest.approx(1.0, abs=0.05)
    assert found.total["a"].value == pytest.approx(1.0, abs=0.05)
