"""3-vectors and 3x3 matrices of any scalar: a float, a batch array, a complex step, a symbol.

A Python zero is a structural zero: its terms are never formed. So a 90 deg twist costs no multiplication in a batch and
leaves no 0*x in a traced expression, and the formulas that use these classes read as in the textbook.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Scalar = Any
"""A float, complex number, NumPy array, or symbol with + - * and NumPy's cos and sin."""


def _literal(x: Scalar, value: float) -> bool:
    return x.__class__ is float and bool(x == value)


def add(a: Scalar, b: Scalar) -> Scalar:
    """a + b; a literal 0.0 adds no term."""
    if _literal(a, 0.0):
        return b
    return a if _literal(b, 0.0) else a + b


def subtract(a: Scalar, b: Scalar) -> Scalar:
    """a - b; a literal 0.0 adds no term."""
    if _literal(b, 0.0):
        return a
    return -b if _literal(a, 0.0) else a - b


def multiply(a: Scalar, b: Scalar) -> Scalar:
    """a b; a literal 0.0 gives a literal 0.0, a literal +-1.0 forms no product.

    >>> multiply(0.0, "a symbol")
    0.0
    """
    for one, other in ((a, b), (b, a)):
        if one.__class__ is float:
            if one == 0.0:
                return 0.0
            if one in (1.0, -1.0):
                return other if one > 0 else -other
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
