"""Rotations, poses and tensors against their definitions; vectors of any scalar are NumPy's, zeros leave no term."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.model.spatial import (
    ZERO,
    Matrix3,
    Pose,
    Vector,
    Z,
    add,
    axis_to_z,
    cos_sin,
    from_rpy,
    multiply,
    rot_x,
    rot_y,
    rot_z,
    skew,
    steiner,
    subtract,
)

ROUNDING = 1e-14
"""A few products of numbers near one."""
seeds = st.integers(0, 10**6).map(np.random.default_rng)
quarters = st.integers(-1000, 1000)


@given(quarters)
def test_cosine_and_sine_are_exact_at_right_angles(quarter):
    assert cos_sin(quarter * np.pi / 2) == ((1, 0), (0, 1), (-1, 0), (0, -1))[quarter % 4]


@given(seeds)
def test_elementary_rotations_turn_their_plane_and_keep_their_axis(rng):
    angle = rng.uniform(-7, 7)
    for rotation, axis in ((rot_x, 0), (rot_y, 1), (rot_z, 2)):
        R, one, other = rotation(angle), (axis + 1) % 3, (axis + 2) % 3
        np.testing.assert_array_equal(R[axis], np.eye(3)[axis])
        np.testing.assert_array_equal(R[:, axis], np.eye(3)[axis])
        assert R[one, one] == R[other, other] == np.cos(angle)
        assert R[other, one] == -R[one, other] == np.sin(angle)


@given(seeds)
def test_poses_multiply_and_invert_as_their_matrices(rng):
    a, b = (Pose(from_rpy(rng.uniform(-3, 3, 3)), rng.normal(size=3)) for _ in range(2))
    np.testing.assert_allclose((a @ b).matrix(), a.matrix() @ b.matrix(), atol=ROUNDING)
    np.testing.assert_allclose((a @ a.inverse()).matrix(), np.eye(4), atol=ROUNDING)
    assert not a.is_identity()
    assert Pose.identity().is_identity()


@given(seeds)
def test_an_axis_becomes_the_third_column_of_a_rotation(rng):
    axis = rng.normal(size=3) * 10.0 ** rng.integers(-3, 4)
    R = axis_to_z(axis)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=ROUNDING)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=ROUNDING)
    np.testing.assert_allclose(R[:, 2] * np.linalg.norm(axis), axis, rtol=ROUNDING)


@given(seeds)
def test_skew_is_the_cross_product_in_any_batch(rng):
    a, b = rng.normal(size=(2, 4, 5, 3))
    np.testing.assert_allclose((skew(a) @ b[..., None])[..., 0], np.cross(a, b), atol=ROUNDING)


@given(seeds)
def test_steiner_is_minus_the_square_of_skew(rng):
    mass, offset = rng.uniform(0.1, 3.0), rng.normal(size=3)
    np.testing.assert_allclose(steiner(mass, offset), -mass * skew(offset) @ skew(offset), atol=10 * ROUNDING)


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
