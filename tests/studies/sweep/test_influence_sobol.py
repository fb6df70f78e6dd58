"""Sobol indices of functions with known ones, and what incomplete groups do."""

import numpy as np
import pytest
from scipy.stats import qmc, sobol_indices

from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.studies.sweep.influence import groups_of, indices_of

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


def test_the_estimator_is_that_of_scipy():
    values = values_of(64)
    found = indices_of("tip_max", values, ["a", "b", "c"])
    f_a, f_b, f_ab = groups_of(values, 3)
    theirs = sobol_indices(func={"f_A": f_a[None], "f_B": f_b[None], "f_AB": f_ab[:, None]}, n=f_a.size)
    np.testing.assert_allclose([one.value for one in found.first.values()], theirs.first_order, atol=1e-12)
    np.testing.assert_allclose([one.value for one in found.total.values()], theirs.total_order, atol=1e-12)


def test_what_does_not_vary_and_what_is_too_little_has_no_indices():
    assert indices_of("tip_max", np.full(5 * 64, 3.0), ["a", "b", "c"]) is None
    assert indices_of("tip_max", values_of(64)[: 5 * 7], ["a", "b", "c"]) is None
    assert indices_of("tip_max", np.full(5 * 64, np.inf), ["a", "b", "c"]) is None


def test_values_of_another_shape_are_refused():
    with pytest.raises(ShapeError, match=r"\(runs,\)"):
        indices_of("tip_max", np.zeros((5, 2)), ["a"])


def test_one_parameter_explains_all():
    rows = design(64, 1)
    found = indices_of("tip_max", rows[:, 0], ["a"])
    assert found.first["a"].value == pytest.approx(1.0, abs=0.05)
    assert found.total["a"].value == pytest.approx(1.0, abs=0.05)
