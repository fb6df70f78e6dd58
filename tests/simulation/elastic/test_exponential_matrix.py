"""Our exponential of a matrix against SciPy's."""

import numpy as np
import pytest
from scipy.linalg import expm

from lwr_dyn.simulation.elastic.exponential import MatrixExponential


@pytest.mark.parametrize("size", [1e-12, 0.1, 0.64, 0.65, 3.0, 30.0])
def test_any_size_as_scipy(size):
    for seed in range(10):
        A = np.random.default_rng(seed).normal(size=(9, 9))
        A *= size / np.abs(A).sum(axis=0).max()
        expected = expm(A)
        assert np.abs(MatrixExponential(9).of(A) - expected).max() <= 1e-13 * np.abs(expected).max()


def test_fast_decay_beside_slow_motion_keeps_its_digits():
    A = np.array([[0.0, 1.0], [-1e6, -1e4]])
    slow = -2e6 / (1e4 + np.sqrt(1e8 - 4e6))
    expected = np.exp(slow) * np.array([1.0, slow])  # from x = 1 on the slow mode
    assert MatrixExponential(2).of(A) @ [1.0, slow] == pytest.approx(expected, abs=1e-12)


def test_the_result_of_one_use_does_not_change_the_next():
    exponential, A = MatrixExponential(3), np.diag([1.0, -2.0, 5.0])
    first = exponential.of(A).copy()
    exponential.of(np.ones((3, 3)))
    assert np.array_equal(exponential.of(A), first)
    assert np.array_equal(exponential.of(np.zeros((3, 3))), np.eye(3))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_stays_so(value):
    assert np.isnan(MatrixExponential(2).of(np.array([[0.0, value], [0.0, 0.0]]))).all()
