"""Rotations, poses and inertia tensors as NumPy arrays, and 3-vectors and 3x3 matrices of any scalar.

`T_ab` is the pose of frame b in frame a: ``T_ac = T_ab @ T_bc``.

A scalar is a float, a batch array, a complex step or a symbol. A Python zero is a structural zero: its terms are never
formed. So a 90 deg twist costs no multiplication in a batch and leaves no 0*x in a traced expression, and the formulas
that use these classes read as in the textbook.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, freeze_arrays, real_array
from lwr_dyn.foundation.errors import OptionError, ShapeError

Scalar = Any
"""A float, complex number, NumPy array, or symbol with + - * and NumPy's cos and sin."""


def add(a: Scalar, b: Scalar) -> Scalar:
    """a + b; a literal 0.0 adds no term."""
    if a.__class__ is float and a == 0.0:
        return b
    return a if b.__class__ is float and b == 0.0 else a + b


def subtract(a: Scalar, b: Scalar) -> Scalar:
    """a - b; a literal 0.0 adds no term."""
    if b.__class__ is float and b == 0.0:
        return a
    return -b if a.__class__ is float and a == 0.0 else a - b


def multiply(a: Scalar, b: Scalar) -> Scalar:
    """a b; a literal 0.0 gives a literal 0.0, a literal +-1.0 forms no product.

    >>> multiply(0.0, "a symbol")
    0.0
    """
    if a.__class__ is float and a in (0.0, 1.0, -1.0):
        return 0.0 if a == 0.0 else b if a > 0.0 else -b
    if b.__class__ is float and b in (0.0, 1.0, -1.0):
        return 0.0 if b == 0.0 else a if b > 0.0 else -a
    return a * b


@dataclass(frozen=True, slots=True, eq=False)
class Vector:
    """Three scalars."""

    x: Scalar
    y: Scalar
    z: Scalar

    @classmethod
    def of(cls, values: Any) -> Vector:
        """A vector of three numbers as Python floats, so that zeros are structural."""
        x, y, z = values
        return cls(constant(x), constant(y), constant(z))

    def __add__(self, other: Vector) -> Vector:
        return Vector(add(self.x, other.x), add(self.y, other.y), add(self.z, other.z))

    def __sub__(self, other: Vector) -> Vector:
        return Vector(subtract(self.x, other.x), subtract(self.y, other.y), subtract(self.z, other.z))

    def __neg__(self) -> Vector:
        return Vector(multiply(-1.0, self.x), multiply(-1.0, self.y), multiply(-1.0, self.z))

    def times(self, s: Scalar) -> Vector:
        """The vector multiplied by s."""
        return Vector(multiply(s, self.x), multiply(s, self.y), multiply(s, self.z))

    def dot(self, other: Vector) -> Scalar:
        """Scalar product."""
        return add(add(multiply(self.x, other.x), multiply(self.y, other.y)), multiply(self.z, other.z))

    def cross(self, other: Vector) -> Vector:
        """Vector product self x other.

        >>> Vector(0.0, 0.0, 1.0).cross(Vector(1.0, 0.0, 0.0))
        Vector(x=0.0, y=1.0, z=0.0)
        """
        a, b = self, other
        return Vector(
            subtract(multiply(a.y, b.z), multiply(a.z, b.y)),
            subtract(multiply(a.z, b.x), multiply(a.x, b.z)),
            subtract(multiply(a.x, b.y), multiply(a.y, b.x)),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Matrix3:
    """Three rows."""

    x: Vector
    y: Vector
    z: Vector

    @classmethod
    def of(cls, rows: Any) -> Matrix3:
        """A matrix of three rows of three numbers."""
        return cls(*(Vector.of(row) for row in rows))

    @property
    def T(self) -> Matrix3:
        """The transpose."""
        a, b, c = self.x, self.y, self.z
        return Matrix3(Vector(a.x, b.x, c.x), Vector(a.y, b.y, c.y), Vector(a.z, b.z, c.z))

    def __matmul__(self, v: Vector) -> Vector:
        return Vector(self.x.dot(v), self.y.dot(v), self.z.dot(v))

    def compose(self, other: Matrix3) -> Matrix3:
        """The product self other of two matrices."""
        columns = other.T
        return Matrix3(columns @ self.x, columns @ self.y, columns @ self.z)


def constant(x: Any) -> Scalar:
    """A number as a Python float; a symbol unchanged."""
    return x if getattr(x, "dtype", None) is None and not isinstance(x, int | float) else float(x)


ZERO = Vector(0.0, 0.0, 0.0)
Z = Vector(0.0, 0.0, 1.0)

SNAP = 1e-15
"""An angle within this [rad] of a multiple of 90 deg counts as that multiple: cos(pi/2) is 6e-17 only because pi is not
a float, and a recursion can drop terms with an exact zero."""

ORTHONORMAL = 1e-6
"""Entries of R^T R - 1 up to here are rounding of typed or printed numbers; the nearest rotation is taken."""
_GIMBAL = 1e-14
"""Below this cosine of the pitch, roll and yaw turn about one axis, and roll is set to 0."""


def cos_sin(angle: float) -> tuple[float, float]:
    """Cosine and sine of a constant angle [rad], exact at multiples of 90 deg.

    >>> cos_sin(math.pi / 2)
    (0.0, 1.0)
    """
    quarter = round(angle / (math.pi / 2))
    if abs(angle - quarter * (math.pi / 2)) <= SNAP * max(1, abs(quarter)):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[quarter % 4]
    return math.cos(angle), math.sin(angle)


def rot_x(angle: float) -> Array:
    """Rotation about x by `angle` [rad], (3, 3)."""
    c, s = cos_sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rot_y(angle: float) -> Array:
    """Rotation about y by `angle` [rad], (3, 3)."""
    c, s = cos_sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rot_z(angle: float) -> Array:
    """Rotation about z by `angle` [rad], (3, 3)."""
    c, s = cos_sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def from_rpy(rpy: Any) -> Array:
    """Rotation from URDF roll, pitch, yaw [rad]: R = Rz(yaw) Ry(pitch) Rx(roll).

    >>> from_rpy((0.0, 0.0, math.pi / 2))[:, 0]
    array([0., 1., 0.])
    """
    roll, pitch, yaw = (float(v) for v in rpy)
    return rot_z(yaw) @ rot_y(pitch) @ rot_x(roll)


def to_rpy(rotation: Array) -> tuple[float, float, float]:
    """Roll, pitch, yaw [rad] that reproduce the rotation to rounding at every pitch.

    Near a pitch of 90 deg only the combination of roll and yaw is well determined: yaw is computed first, then roll
    from Rz(yaw)^T R = Ry(pitch) Rx(roll).

    >>> near = from_rpy((0.3, 1.570796325, 0.1))
    >>> bool(abs(from_rpy(to_rpy(near)) - near).max() < 1e-15)
    True
    """
    r = rotation
    cos_pitch = math.hypot(r[0, 0], r[1, 0])
    pitch = math.atan2(-r[2, 0], cos_pitch)
    if cos_pitch < _GIMBAL:
        return 0.0, pitch, math.atan2(-r[0, 1], r[1, 1])
    yaw = math.atan2(r[1, 0], r[0, 0])
    c, s = cos_sin(yaw)
    return math.atan2(s * r[0, 2] - c * r[1, 2], c * r[1, 1] - s * r[0, 1]), pitch, yaw


def axis_to_z(axis: Array) -> Array:
    """A rotation whose third column is the unit vector `axis` (the identity for z itself).

    >>> axis_to_z(np.array([0.0, 0.0, 1.0])).tolist() == np.eye(3).tolist()
    True
    """
    z = axis / np.abs(axis).max()  # the square of a very long or short axis is not a float
    z = z / np.linalg.norm(z)
    start = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = start - z * (start @ z)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def skew(v: Array) -> Array:
    """The matrix of the cross product: ``skew(v) @ w == np.cross(v, w)``, shape (..., 3, 3).

    >>> skew(np.array([1.0, 2.0, 3.0])) @ np.array([0.0, 0.0, 1.0])
    array([ 2., -1.,  0.])
    """
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    o = np.zeros_like(x)
    rows = [[o, -z, y], [z, o, -x], [-y, x, o]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def cross(a: Array, b: Array) -> Array:
    """The vector product a x b of arrays (..., 3): the bits of `np.cross`, in half its time for many rows.

    >>> cross(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.array([0.0, 1.0, 0.0]))
    array([[0., 0., 1.],
           [0., 0., 0.]])
    """
    out = np.empty(np.broadcast_shapes(a.shape, b.shape), np.result_type(a, b))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        np.multiply(a[..., j], b[..., k], out=out[..., i])
        out[..., i] -= a[..., k] * b[..., j]
    return out


def turn_about(axis: Array, angle: Array) -> Array:
    """Rotations (k, 3, 3) about one unit axis by angles (k,) [rad] (Rodrigues)."""
    K, s, c = skew(axis), np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + s * K + (1.0 - c) * (K @ K))


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """A constant pose: `rotation` (3, 3) and `position` (3,) [m] of a frame in its parent."""

    rotation: Array
    position: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "rotation", "position")

    @classmethod
    def identity(cls) -> Pose:
        """The pose of a frame in itself."""
        return cls(np.eye(3), np.zeros(3))

    def __matmul__(self, other: Pose) -> Pose:
        """T_ac = T_ab @ T_bc."""
        return Pose(self.rotation @ other.rotation, self.rotation @ other.position + self.position)

    def inverse(self) -> Pose:
        """T_ba of T_ab."""
        return Pose(self.rotation.T, -self.rotation.T @ self.position)

    def matrix(self) -> Array:
        """The homogeneous (4, 4) matrix."""
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = self.rotation, self.position
        return out

    def is_identity(self) -> bool:
        """Whether it is exactly the identity, which a recursion may skip."""
        return bool((self.rotation == np.eye(3)).all() and (self.position == 0.0).all())


def steiner(mass: float, offset: Array) -> Array:
    """The tensor of a point mass at `offset` [m]: m (c.c E - c c^T), (3, 3) [kg m^2].

    >>> steiner(2.0, np.array([0.0, 0.0, 1.0])).diagonal()
    array([2., 2., 0.])
    """
    square = np.sum(offset * offset)  # not offset @ offset, whose last bit depends on the processor
    out: Array = mass * (square * np.eye(3) - np.outer(offset, offset))
    return out


def symmetric_part(tensor: Array) -> Array:
    """(T + T^T)/2: a turned tensor is symmetric only up to rounding.

    >>> symmetric_part(np.array([[1.0, 2.0], [4.0, 1.0]]))
    array([[1., 3.],
           [3., 1.]])
    """
    out: Array = (tensor + tensor.T) / 2
    return out


def principal_moments(tensor: Array) -> Array:
    """Principal moments of a symmetric tensor, ascending, (3,) [kg m^2].

    >>> principal_moments(np.diag([3.0, 1.0, 2.0]))
    array([1., 2., 3.])
    """
    return np.asarray(np.linalg.eigvalsh(tensor), dtype=np.float64)


def pose_array(name: str, value: ArrayLike) -> Array:
    """Poses (..., 4, 4) with rotations made exact; each with last row 0 0 0 1, lengths in metres.

    Raises `ShapeError` for another shape or a number that is not finite, `OptionError` for another last row or a
    rotation that is none (to `ORTHONORMAL`).

    >>> pose_array("T", np.eye(4)).shape
    (4, 4)
    """
    T = real_array(name, value)
    if T.ndim < 2 or T.shape[-2:] != (4, 4):
        raise ShapeError(name, f"shape {T.shape}", "(..., 4, 4), a homogeneous matrix")
    if not (T[..., 3, :] == np.array([0.0, 0.0, 0.0, 1.0])).all():
        raise OptionError(name, "last row is not 0 0 0 1", "a homogeneous matrix")
    R = T[..., :3, :3]
    error = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max(initial=0.0)
    if error > ORTHONORMAL:
        raise OptionError(name, f"R^T R differs from 1 by {error:.3g}", f"a rotation (to {ORTHONORMAL:g})")
    if (np.linalg.det(R) < 0.0).any():
        raise OptionError(name, "a mirror image (det R = -1)", "a rotation, det R = +1")
    for _ in range(2):  # Newton steps of the polar decomposition lead to the nearest rotation
        R = 1.5 * R - 0.5 * R @ np.swapaxes(R, -1, -2) @ R
    out = T.copy()
    out[..., :3, :3] = R
    return out
