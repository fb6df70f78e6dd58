"""Points of a study: whole ranges, and the same however they are cut."""

import numpy as np
import pytest
from scipy.stats import sobol_indices

from lwr_dyn.studies.sweep.sampling import METHODS, VariedParameter, points, saltelli_rows

SIZES = (1, 3, 1)
LEVELS = (4, 2, 3, 5, 20)
RUNS = 2400


def all_points(method, first=0, stop=RUNS, seed=3):
    return points(method, SIZES, LEVELS, seed, first, stop)


@pytest.mark.parametrize("method", METHODS)
def test_any_chunks_give_the_same_points(method):
    whole = all_points(method)
    assert whole.shape == (RUNS, 5)
    assert (whole >= 0.0).all()
    assert (whole < 1.0).all()
    for size in (1000, 37):
        parts = [all_points(method, k, min(k + size, RUNS)) for k in range(0, RUNS, size)]
        np.testing.assert_array_equal(np.concatenate(parts), whole)


@pytest.mark.parametrize("method", [m for m in METHODS if m != "grid"])
def test_the_seed_decides(method):
    np.testing.assert_array_equal(all_points(method), all_points(method))
    assert (all_points(method) != all_points(method, seed=4)).mean() > 0.9


@pytest.mark.parametrize("method", ["sobol", "random", "latin-hypercube", "grid"])
def test_no_point_comes_twice(method):
    assert len(np.unique(all_points(method), axis=0)) == RUNS


@pytest.mark.parametrize(("method", "error"), [("sobol", 2e-3), ("latin-hypercube", 5e-4), ("random", 4e-2)])
def test_means_are_those_of_the_cube(method, error):
    stop = 2048 if method == "latin-hypercube" else RUNS  # whose slices are all full there
    np.testing.assert_allclose(all_points(method, stop=stop).mean(axis=0), 0.5, atol=error)


@pytest.mark.parametrize(("first", "stop"), [(0, 1), (0, 64), (0, 2048), (64, 128), (1024, 2048)])
def test_a_hypercube_has_one_run_in_each_slice_and_so_has_what_doubles_it(first, stop):
    count = stop - first
    slices = np.sort((all_points("latin-hypercube")[first:stop] * count).astype(int), axis=0)
    np.testing.assert_array_equal(slices, np.arange(count)[:, None].repeat(5, axis=1))


def test_between_powers_of_two_a_slice_of_a_hypercube_has_one_run_or_two():
    slices = (all_points("latin-hypercube")[:1500] * 1024).astype(int)
    assert all(set(np.bincount(column, minlength=1024)) == {1, 2} for column in slices.T)


def test_a_hypercube_finds_a_sum_with_less_spread_than_independent_runs_and_without_bias():
    """Of a sum of d numbers a mean of n runs spreads by sqrt(d / 12) n^-1.5, not n^-0.5 (McKay et al., 1979)."""
    n, d = 64, 8
    means = np.array([points("latin-hypercube", (1,) * d, (), seed, 0, n).sum(axis=1).mean() for seed in range(200)])
    assert means.std() == pytest.approx(np.sqrt(d / 12) * n**-1.5, rel=0.2)
    assert abs(means.mean() - d / 2) < 4 * means.std() / np.sqrt(200)


@pytest.mark.parametrize("method", [m for m in METHODS if m != "grid"])
def test_the_first_runs_are_the_same_however_many_follow(method):
    np.testing.assert_array_equal(all_points(method, 0, 70), all_points(method)[:70])


def test_a_grid_has_each_combination_once():
    cells = (all_points("grid") * LEVELS).astype(int)
    assert len(np.unique(cells, axis=0)) == RUNS
    np.testing.assert_array_equal(cells.max(axis=0) + 1, LEVELS)
    np.testing.assert_array_equal(cells[:21, -1], [*range(20), 0])


def test_saltelli_takes_each_parameter_from_b_in_turn():
    rows = saltelli_rows(len(SIZES))
    sets = points("saltelli", SIZES, LEVELS, 3, 0, 4 * rows).reshape(4, rows, 5)
    A, B = sets[:, 0], sets[:, 1]
    for j, moved in enumerate(([0], [1, 2, 3], [4])):
        kept = [k for k in range(5) if k not in moved]
        np.testing.assert_array_equal(sets[:, 2 + j, moved], B[:, moved])
        np.testing.assert_array_equal(sets[:, 2 + j, kept], A[:, kept])
    assert not (A == B).any()


def test_saltelli_gives_the_indices_of_ishigami():
    """S_1 = 0.3139, S_2 = 0.4424, S_3 = 0; S_T3 = 0.2437 (Ishigami and Homma, 1990; a = 7, b = 0.1)."""
    n, rows = 1024, saltelli_rows(3)
    x = 2 * np.pi * points("saltelli", (1, 1, 1), (), 1, 0, n * rows) - np.pi
    f = (np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])).reshape(n, rows)
    found = sobol_indices(func={"f_A": f[:, :1].T, "f_B": f[:, 1:2].T, "f_AB": f[:, 2:].T[:, None, :]}, n=n)
    np.testing.assert_allclose(found.first_order, [0.3139, 0.4424, 0.0], atol=0.03)
    np.testing.assert_allclose(found.total_order, [0.5576, 0.4424, 0.2437], atol=0.03)


def test_without_parameters_there_are_no_numbers():
    assert points("sobol", (), (), 0, 1, 3).shape == (2, 0)


CUT = {"low": -0.01, "high": 0.02}


@pytest.mark.parametrize(
    ("distribution", "given", "words", "ends"),
    [
        ("uniform", CUT, "uniform from -0.01 to 0.02", (-0.01, 0.02)),
        ("fixed", {"values": (0.5,)}, "0.5", (0.5, 0.5)),
        ("normal", {"mean": 1.0, "deviation": 0.1}, "normal, mean 1, deviation 0.1", (0.7, 1.3)),
        ("normal", {"deviation": 1.0, **CUT}, "normal, mean 0, deviation 1 cut from -0.01 to 0.02", (-0.01, 0.02)),
        ("normal", {"deviation": 1.0, "low": -0.5}, "normal, mean 0, deviation 1 cut from -0.5", (-0.5, 3.0)),
        ("choice", {"values": (2.0, 0.0, 1.0)}, "one of 2, 0, 1", (0.0, 2.0)),
        ("choice", {"values": ("printed", "kuka")}, "one of printed, kuka", ("printed", "kuka")),
        ("levels", {"values": (1.0, 2.0)}, "levels 1, 2", (1.0, 2.0)),
    ],
)
def test_a_distribution_in_words_and_its_ends(distribution, given, words, ends):
    one = VariedParameter("a", distribution, ("a",), **given)
    assert one.distribution_words == words
    assert (one.lowest, one.highest) == (ends if one.is_text else pytest.approx(ends))
    assert (one.is_varied, one.is_text) == (distribution != "fixed", "kuka" in words)
    if one.values:
        count = len(one.values)
        assert one.values_of((np.arange(count) + 0.999) / count).tolist() == list(one.values)
        assert one.values_of(np.array([1.0])) == one.values[-1]
    elif distribution == "uniform":
        assert one.values_of(np.array([0.0, 0.25])) == pytest.approx([-0.01, -0.0025])
