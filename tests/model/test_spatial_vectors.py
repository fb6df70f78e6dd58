"""Vectors and matrices of any scalar are NumPy's, and literal zeros leave no term."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.model.spatial import ZERO, Matrix3, Vector, Z, add, multiply, subtract

ROUNDING = 1e-14
"""Sums of three products of numbers near one."""
pairs = st.integers(0, 10**6).map(lambda seed: np.random.default_rng(seed).normal(size=(4, 3, 7)))


def numbers(v):
    return np.array([v.x, v.y, v.z])


@given(pairs)
def test_operations_on_batches_are_numpys(data):
    a, b = Vector(*data[0]), Vector(*data[1])
    np.testing.assert_allclose(numbers(a + b - -a), data[0] + data[1] + data[0], atol=ROUNDING)
    np.testing.assert_allclose(numbers(a.cross(b)), np.cross(data[0].T, data[1].T).T, atol=10 * ROUNDING)
    np.testing.assert_allclose(a.dot(b), (data[0] * data[1]).sum(0), atol=10 * ROUNDING)
    np.testing.assert_array_equal(numbers(a.times(2.0)), 2.0 * data[0])


@given(pairs)
def test_matrices_are_numpys(data):
    left, right = data[0][:, :3], data[1][:, :3]
    M, N, v = Matrix3.of(left), Matrix3.of(right), Vector.of(data[2][:, 0])
    np.testing.assert_allclose(numbers(M @ v), left @ numbers(v), atol=10 * ROUNDING)
    np.testing.assert_allclose([numbers(row) for row in (M.T.x, M.T.y, M.T.z)], left.T)
    product = M.compose(N)
    np.testing.assert_allclose([numbers(row) for row in (product.x, product.y, product.z)], left @ right, atol=1e-13)


def test_literal_zeros_and_ones_form_no_term():
    x = np.array([1.0, 2.0])
    assert multiply(0.0, x) == 0.0
    assert multiply(1.0, x) is x
    assert add(0.0, x) is x
    assert subtract(x, 0.0) is x
    product = Vector(x, 0.0, 0.0).cross(Z)
    assert (product.x, product.z) == (0.0, 0.0)
    assert product.y.tolist() == [-1.0, -2.0]
    assert Vector(x, x, x).dot(ZERO) == 0.0


def test_zeros_of_an_array_are_numbers_like_others():
    x, zero = np.array([1.0, 2.0]), np.zeros(2)
    assert multiply(zero, x).tolist() == [0.0, 0.0]
    assert add(zero, x) is not x
    assert [type(v) for v in numbers(Vector.of(np.zeros(3)))] == [np.float64] * 3
    assert all(type(v) is float for v in (Vector.of(np.zeros(3)).x, Vector.of([0, 1, 2]).y))
