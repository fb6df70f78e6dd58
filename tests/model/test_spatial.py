"""Rotations, poses and tensors against their definitions; vectors of any scalar are NumPy's, zeros leave no term."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model import spatial
from lwr_dyn.model.spatial import (
    ZERO,
    Matrix3,
    Pose,
    Vector,
    Z,
    cos_sin,
    cross,
    from_rpy,
    pose_array,
    skew,
    steiner,
    to_rpy,
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
    for rotation, axis in ((spatial.rot_x, 0), (spatial.rot_y, 1), (spatial.rot_z, 2)):
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
    R = spatial.axis_to_z(axis)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=ROUNDING)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=ROUNDING)
    np.testing.assert_allclose(R[:, 2] * np.linalg.norm(axis), axis, rtol=ROUNDING)


@given(seeds)
def test_vector_products_are_numpys_in_any_batch(rng):
    """`cross` to the bit; the tensor of a point mass is minus the square of `skew`."""
    a, b = rng.normal(size=(2, 4, 5, 3))
    np.testing.assert_allclose((skew(a) @ b[..., None])[..., 0], np.cross(a, b), atol=ROUNDING)
    a, b = rng.uniform(-9, 9, (4, 1, 3)), rng.uniform(-9, 9, (5, 3))
    for one, other in ((a, b), (b, a), (a[0, 0], b[0]), (b[::2], a[2])):
        assert cross(one, other).tobytes() == np.cross(one, other).tobytes()
    mass, offset = rng.uniform(0.1, 3.0), rng.normal(size=3)
    np.testing.assert_allclose(steiner(mass, offset), -mass * skew(offset) @ skew(offset), atol=10 * ROUNDING)


pairs = st.integers(0, 10**6).map(lambda seed: np.random.default_rng(seed).normal(size=(4, 3, 7)))


def numbers(v):
    return np.array([v.x, v.y, v.z])


@given(pairs)
def test_vectors_and_matrices_of_any_scalar_are_numpys(data):
    a, b = Vector(*data[0]), Vector(*data[1])
    np.testing.assert_allclose(numbers(a + b - -a), data[0] + data[1] + data[0], atol=ROUNDING)
    np.testing.assert_allclose(numbers(a.cross(b)), np.cross(data[0].T, data[1].T).T, atol=10 * ROUNDING)
    np.testing.assert_allclose(a.dot(b), (data[0] * data[1]).sum(0), atol=10 * ROUNDING)
    np.testing.assert_array_equal(numbers(a.times(2.0)), 2.0 * data[0])
    left, right = data[0][:, :3], data[1][:, :3]
    M, N, v = Matrix3.of(left), Matrix3.of(right), Vector.of(data[2][:, 0])
    np.testing.assert_allclose(numbers(M @ v), left @ numbers(v), atol=10 * ROUNDING)
    for matrix, wanted in ((M.T, left.T), (M.compose(N), left @ right)):
        np.testing.assert_allclose([numbers(row) for row in (matrix.x, matrix.y, matrix.z)], wanted, atol=1e-13)


@given(seeds)
def test_turns_about_an_axis_are_the_exponentials_of_its_skew_matrix(rng):
    axis, angles = rng.normal(size=3), rng.uniform(-4, 4, 3)
    axis /= np.linalg.norm(axis)
    np.testing.assert_allclose(spatial.turn_about(axis, angles), [expm(x * skew(axis)) for x in angles], atol=1e-13)
    R = from_rpy(rng.uniform(-3, 3, 3))
    np.testing.assert_allclose(R, Rotation.from_matrix(R).as_matrix(), atol=ROUNDING)
    angles = rng.uniform(-1.5, 1.5, 3)
    np.testing.assert_allclose(from_rpy(angles), Rotation.from_euler("xyz", angles).as_matrix(), atol=ROUNDING)
    np.testing.assert_allclose(to_rpy(from_rpy(angles)), angles, atol=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_at_a_pitch_of_a_right_angle_roll_is_0(side):
    pitch = side * np.pi / 2
    roll, found, yaw = to_rpy(from_rpy((0.4, pitch, 0.1)))
    assert (roll, found) == (0.0, pytest.approx(pitch))
    assert yaw == pytest.approx(0.1 - side * 0.4)
    assert [to_rpy(from_rpy((0.4, pitch - off, 0.1)))[0] == 0.0 for off in (0.9e-14, 1.1e-14)] == [True, False]


@pytest.mark.parametrize("quarter", [0, 1, -3, 40])
def test_an_angle_snaps_to_a_right_angle_within_a_rounding_of_it(quarter):
    exact, snap = quarter * np.pi / 2, 1e-15 * max(1, abs(quarter))
    inside, outside = exact + 0.9 * snap, exact + 1.5 * snap + 8 * np.spacing(abs(exact))
    assert cos_sin(inside) == cos_sin(exact)
    assert cos_sin(outside) == (np.cos(outside), np.sin(outside)) != cos_sin(exact)


def test_tensors_and_poses():
    tensor = np.array([[1.0, 2.0, 0.0], [4.0, 1.0, 6.0], [2.0, 0.0, 5.0]])
    assert spatial.symmetric_part(tensor).tolist() == [[1.0, 3.0, 1.0], [3.0, 1.0, 3.0], [1.0, 3.0, 5.0]]
    R = from_rpy((0.3, -0.2, 1.0))
    np.testing.assert_allclose(
        spatial.principal_moments(R @ np.diag([3.0, 1.0, 2.0]) @ R.T), [1.0, 2.0, 3.0], atol=ROUNDING
    )
    for pose in (Pose(spatial.rot_x(1e-9), np.zeros(3)), Pose(np.eye(3), np.array([0.0, 1e-300, 0.0]))):
        assert not pose.is_identity()
    assert (spatial.constant(2), spatial.constant("a"), type(spatial.constant(np.float64(2.0)))) == (2.0, "a", float)
    assert spatial.subtract(0.0, 3) == -3


def test_a_pose_is_made_exact_or_refused():
    T = np.tile(np.eye(4), (2, 1, 1))
    T[0, :3, :3], T[1, :3, 3] = from_rpy((0.3, -0.2, 1.0)), [1.0, 2.0, 3.0]
    rough = T.copy()
    rough[:, :3, :3] += 1e-7 * np.random.default_rng(1).uniform(-1.0, 1.0, (2, 3, 3))
    made = pose_array("T", rough)
    assert np.abs(np.swapaxes(made[:, :3, :3], 1, 2) @ made[:, :3, :3] - np.eye(3)).max() < 1e-15
    for one, other in zip(made, rough, strict=True):
        u, _, v = np.linalg.svd(other[:3, :3])
        np.testing.assert_allclose(one[:3, :3], u @ v, atol=ROUNDING)
    assert np.array_equal(made[:, :3, 3], T[:, :3, 3])
    grown = np.diag([1.0 + 0.49e-6, 1.0, 1.0, 1.0])
    assert pose_array("T", grown)[0, 0] == pytest.approx(1.0, abs=1e-15)
    for bad, error, words in (
        (np.diag([1.0 + 0.51e-6, 1.0, 1.0, 1.0]), OptionError, r"T: R\^T R differs from 1 by 1.02e-06; allowed: a"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), OptionError, r"T: a mirror image \(det R = -1\); allowed: a rotation"),
        (np.diag([1.0, 1.0, 1.0, 1.0 + 1e-15]), OptionError, "T: last row is not 0 0 0 1; allowed: a homogen"),
        (np.eye(3), ShapeError, r"T: shape \(3, 3\); allowed: \(..., 4, 4\)"),
        (np.ones(4), ShapeError, r"T: shape \(4,\)"),
        (np.full((4, 4), np.nan), ShapeError, "T"),
    ):  # fmt: skip
        with pytest.raises(error, match=words):
            pose_array("T", bad)


def test_literal_zeros_and_ones_form_no_term():
    x = np.array([1.0, 2.0])
    assert spatial.multiply(0.0, x) == 0.0
    assert spatial.multiply(1.0, x) is x
    assert spatial.add(0.0, x) is x
    assert spatial.subtract(x, 0.0) is x
    product = Vector(x, 0.0, 0.0).cross(Z)
    assert (product.x, product.z) == (0.0, 0.0)
    assert product.y.tolist() == [-1.0, -2.0]
    assert Vector(x, x, x).dot(ZERO) == 0.0
    zero = np.zeros(2)  # of an array: numbers like others
    assert spatial.multiply(zero, x).tolist() == [0.0, 0.0]
    assert spatial.add(zero, x) is not x
    assert [type(v) for v in numbers(Vector.of(np.zeros(3)))] == [np.float64] * 3
    assert all(type(v) is float for v in (Vector.of(np.zeros(3)).x, Vector.of([0, 1, 2]).y))
