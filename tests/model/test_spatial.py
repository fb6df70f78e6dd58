"""Rotations, poses and tensors against their definitions; constant angles are exact at multiples of 90 deg."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.model.spatial import Pose, axis_to_z, cos_sin, from_rpy, rot_x, rot_y, rot_z, skew, steiner

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
