"""Least squares by hand: weights, outliers, singular equations, and what a fit knows of its errors."""

import numpy as np
import pytest
from scipy import stats

from lwr_dyn.identification.regression.least_squares import (
    HUBER,
    Spectrum,
    base_parameters,
    has_full_rank,
    huber,
    solved,
    student_factor,
    weighted,
)

X = np.column_stack([np.ones(12), np.linspace(0.0, 3.0, 12)])
WEIGHTS = np.linspace(1.0, 4.0, 12)


def test_weighted_squares_and_their_errors_are_those_of_the_normal_equations():
    y = X @ [2.0, -1.0] + np.random.default_rng(0).normal(0.0, 0.1, 12)
    found, W = weighted(X, y, WEIGHTS), np.diag(WEIGHTS)
    b = np.linalg.solve(X.T @ W @ X, X.T @ W @ y)
    left = y - X @ b
    assert found.values == pytest.approx(b)
    assert found.covariance == pytest.approx(left @ W @ left / 10 * np.linalg.inv(X.T @ W @ X))
    assert (found.dof, found.rms) == (10, pytest.approx(np.sqrt(np.mean(left**2))))
    assert found.half_widths == pytest.approx(found.standard_errors * student_factor(10))
    assert student_factor(10) == pytest.approx(-stats.t.ppf(stats.norm.sf(3.0), 10))
    assert np.isnan([student_factor(0), *weighted(X[:2], y[:2], WEIGHTS[:2]).standard_errors]).all()


def test_a_robust_fit_bounds_what_an_outlier_says():
    """At its end sum w psi x = 0, psi = r within 1.345 scales (of the median deviation) and 1.345 scales beyond."""
    y = X @ [2.0, -1.0] + np.random.default_rng(0).normal(0.0, 0.1, 12)
    y[3] += 5.0
    found, root = huber(X, y, WEIGHTS), np.sqrt(WEIGHTS)
    scaled = root * (y - X @ found.values)
    bound = HUBER * 1.4826 * np.median(np.abs(scaled)) * np.sqrt(12 / 10)
    psi = np.clip(scaled, -bound, bound)
    assert (root * psi) @ X == pytest.approx(0.0, abs=1e-8)
    assert np.abs(found.values - [2.0, -1.0]).max() < 0.2 < np.abs(weighted(X, y, WEIGHTS).values - [2.0, -1.0]).max()
    share = np.mean(np.abs(scaled) < bound)
    factor = (1 + 2 / 12 * (1 - share) / share) ** 2 * (psi @ psi) / 10 / share**2
    assert found.covariance == pytest.approx(factor * np.linalg.inv(X.T @ np.diag(WEIGHTS) @ X))
    exact = huber(X, X @ [2.0, -1.0], WEIGHTS)
    assert exact.values == pytest.approx([2.0, -1.0])
    assert np.isnan(huber(X[:2], y[:2], WEIGHTS[:2]).covariance).all()


def test_columns_determine_parameters_or_do_not():
    twice = np.column_stack([X, 2.0 * X[:, 1]])
    wide = (X, X[:2], X * [1.0, 1e-14], twice, X[:1], X * [1.0, 0.0])
    assert [has_full_rank(A) for A in wide] == [True] * 3 + [False] * 3
    whole, pi = np.column_stack([twice, np.zeros(12)]), np.array([1.0, -2.0, 0.5, 9.0])
    base = base_parameters(whole, "abcd")
    assert whole[:, base.kept] @ base.of(pi) == pytest.approx(whole @ pi)
    assert base.statements() in (("a", "b + 2 c"), ("a", "c + 0.5 b"))
    spectrum, M = Spectrum.of(twice.T @ twice), X.T @ X
    assert (spectrum.rank, spectrum.condition, spectrum.determined.tolist()) == (2, np.inf, [True, False, False])
    full, size = Spectrum.of(M), np.linalg.norm(X, axis=0)
    assert full.condition == pytest.approx(np.linalg.cond(X / size))
    assert full.inverse() == pytest.approx(np.linalg.inv(M))
    assert full.factor() == pytest.approx(np.linalg.cholesky(M).T)
    least = spectrum.inverse() @ twice.T @ (X @ [2.0, -1.0])
    assert least == pytest.approx([2.0, -0.5, -0.25])  # of least length in scaled columns
    assert Spectrum.of(np.zeros((3, 3))).rank == 0


def test_a_step_of_refinement_mends_an_inverse_that_is_nearly_singular():
    errors = []
    for seed in range(40):  # of one matrix the ratio is rounding, another on each processor
        rng = np.random.default_rng(seed)
        U = np.linalg.qr(rng.normal(size=(30, 30)))[0]
        matrix, truth = U * np.geomspace(1.0, 1e-9, 30) @ U.T, rng.normal(size=30)
        side, inverse = matrix @ truth, Spectrum.of(matrix).inverse()
        errors.append((np.abs(solved(matrix, side, inverse) - truth).max(), np.abs(inverse @ side - truth).max()))
    refined, plain = np.median(errors, axis=0)
    assert refined < 0.7 * plain
    assert Spectrum.of(matrix).rank == 30
