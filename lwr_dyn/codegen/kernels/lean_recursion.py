"""The recursions that kernels are generated from: inverse dynamics, and B by composite bodies, in the axes' own frames.

A body is its ten inertial parameters about the origin of its joint's frame (`parameters.PER_LINK`): no product with a
mass, no centre of mass. Scalars are those of `lwr_dyn.model.vectors`; a literal 0.0 forms no operation. The readable
recursion is `lwr_dyn.dynamics.recursion`, with which these agree.

References
----------
Featherstone, *Rigid Body Dynamics Algorithms* (2008), table 5.1 (recursive Newton-Euler), table 6.2 (composite rigid
body); Khalil, Dombre, *Modeling, Identification and Control of Robots* (2002), section 9.5 (first moments).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.axis_frames import AxisFrame
from lwr_dyn.dynamics.recursion import lever_acceleration
from lwr_dyn.model.vectors import ZERO, Matrix3, Scalar, Vector, Z, add, multiply, subtract

Body = Sequence[Scalar]
"""m, mx, my, mz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz."""


def inverse_dynamics(
    frames: Sequence[AxisFrame], bodies: Sequence[Body], gravity: Vector, q: Any, dq: Any, ddq: Any
) -> list[Scalar]:
    """Torques of the bodies alone, B ddq + C dq + g, one scalar a joint; a literal 0.0 drops its terms."""
    turns = _turns(frames, q)
    omega, domega, a = ZERO, ZERO, -gravity
    motions = []
    for i, frame in enumerate(frames):
        a = a + lever_acceleration(omega, domega, frame.shift)
        omega, domega, a = (frame.turn.T @ v for v in (omega, domega, a))
        if frame.is_turning:
            omega, domega, a = (turns[i].back(v) for v in (omega, domega, a))
            domega = domega + Z.times(ddq[i]) + Vector(omega.y, multiply(-1.0, omega.x), 0.0).times(dq[i])
            omega = omega + Z.times(dq[i])
        else:
            a = a + lever_acceleration(omega, domega, Z.times(q[i])) + Z.times(ddq[i])
            a = a + Vector(omega.y, multiply(-1.0, omega.x), 0.0).times(multiply(2.0, dq[i]))
        motions.append((omega, domega, a))
    return _backward(frames, bodies, turns, q, motions)


def _backward(frames: Sequence[AxisFrame], bodies: Any, turns: Any, q: Any, motions: Any) -> list[Scalar]:
    """Forces and moments about the frames' origins, from the last body inward."""
    force, moment = ZERO, ZERO
    tau: list[Scalar] = [0.0] * len(frames)
    for i in reversed(range(len(frames))):
        frame, (omega, domega, a), body = frames[i], motions[i], _Composite.of(bodies[i])
        force = force + _curl(omega, domega) @ body.first + a.times(body.mass)
        spin = body.tensor.times(omega)
        moment = moment + body.tensor.times(domega) + omega.cross(spin) + body.first.cross(a)
        tau[i] = moment.z if frame.is_turning else force.z
        if frame.is_turning:
            force, moment = turns[i].ahead(force), turns[i].ahead(moment)
        else:
            moment = moment + Z.times(q[i]).cross(force)
        force, moment = frame.turn @ force, frame.turn @ moment
        moment = moment + frame.shift.cross(force)
    return tau


def mass_matrix(frames: Sequence[AxisFrame], bodies: Sequence[Body], q: Any) -> list[list[Scalar]]:
    """B of the bodies: column i is the torque of the composite body behind joint i at a unit acceleration of it."""
    n = len(frames)
    B: list[list[Scalar]] = [[0.0] * n for _ in range(n)]
    turns, composite = _turns(frames, q), _Composite.of([0.0] * 10)
    for i in reversed(range(n)):
        composite = composite.with_body(_Composite.of(bodies[i]))
        force, moment = composite.pushed(frames[i].is_turning)
        B[i][i] = moment.z if frames[i].is_turning else force.z
        for j in reversed(range(i)):
            force, moment = _to_parent(frames[j + 1], turns[j + 1], q[j + 1], force, moment)
            B[i][j] = B[j][i] = moment.z if frames[j].is_turning else force.z
        if i:
            composite = composite.turned(turns[i]) if frames[i].is_turning else composite.shifted(Z.times(q[i]))
            composite = composite.in_parent(frames[i].turn).shifted(frames[i].shift)
    return B


def potential_energy(frames: Sequence[AxisFrame], bodies: Sequence[Body], gravity: Vector, q: Any) -> Scalar:
    """U = -g . (sum of m_i p_{C_i}): the first moment of all bodies about the base."""
    mass, first = 0.0, ZERO
    for i in reversed(range(len(frames))):
        frame, body = frames[i], _Composite.of(bodies[i])
        mass, first = add(mass, body.mass), first + body.first
        first = _Turn.of(q[i]).ahead(first) if frame.is_turning else first + Z.times(multiply(q[i], mass))
        first = frame.turn @ first + frame.shift.times(mass)
    return multiply(-1.0, gravity.dot(first))


def _to_parent(frame: AxisFrame, turn: "_Turn", q: Scalar, force: Vector, moment: Vector) -> tuple[Vector, Vector]:
    if frame.is_turning:
        force, moment = turn.ahead(force), turn.ahead(moment)
    else:
        moment = moment + Z.times(q).cross(force)
    force, moment = frame.turn @ force, frame.turn @ moment
    return force, moment + frame.shift.cross(force)


def _curl(omega: Vector, domega: Vector) -> Matrix3:
    """[domega]x + [omega]x [omega]x: the acceleration of a point of a body by its place."""
    xx, yy, zz = multiply(omega.x, omega.x), multiply(omega.y, omega.y), multiply(omega.z, omega.z)
    xy, xz, yz = multiply(omega.x, omega.y), multiply(omega.x, omega.z), multiply(omega.y, omega.z)
    return Matrix3(
        Vector(multiply(-1.0, add(yy, zz)), subtract(xy, domega.z), add(xz, domega.y)),
        Vector(add(xy, domega.z), multiply(-1.0, add(xx, zz)), subtract(yz, domega.x)),
        Vector(subtract(xz, domega.y), add(yz, domega.x), multiply(-1.0, add(xx, yy))),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Turn:
    """A turn about z by its cosine and sine."""

    c: Scalar
    s: Scalar

    @classmethod
    def of(cls, angle: Scalar) -> "_Turn":
        return cls(np.cos(angle), np.sin(angle))

    def ahead(self, v: Vector) -> Vector:
        """A vector of the moved frame in the frame before the motion."""
        x = subtract(multiply(self.c, v.x), multiply(self.s, v.y))
        return Vector(x, add(multiply(self.s, v.x), multiply(self.c, v.y)), v.z)

    def back(self, v: Vector) -> Vector:
        """The other way."""
        x = add(multiply(self.c, v.x), multiply(self.s, v.y))
        return Vector(x, subtract(multiply(self.c, v.y), multiply(self.s, v.x)), v.z)


def _turns(frames: Sequence[AxisFrame], q: Any) -> list[_Turn]:
    """The turn of each joint; of a sliding one none."""
    return [_Turn.of(x) if frame.is_turning else _Turn(1.0, 0.0) for frame, x in zip(frames, q, strict=True)]


@dataclass(frozen=True, slots=True, eq=False)
class _Symmetric:
    """A symmetric tensor by its six entries."""

    xx: Scalar
    xy: Scalar
    yy: Scalar
    xz: Scalar
    yz: Scalar
    zz: Scalar

    def matrix(self) -> Matrix3:
        return Matrix3(
            Vector(self.xx, self.xy, self.xz), Vector(self.xy, self.yy, self.yz), Vector(self.xz, self.yz, self.zz)
        )

    def times(self, v: Vector) -> Vector:
        return self.matrix() @ v

    def plus(self, other: "_Symmetric") -> "_Symmetric":
        names = self.__slots__
        return _Symmetric(*(add(getattr(self, name), getattr(other, name)) for name in names))


@dataclass(frozen=True, slots=True, eq=False)
class _Composite:
    """Mass, first moment and tensor about the origin of some bodies that move as one."""

    mass: Scalar
    first: Vector
    tensor: _Symmetric

    @classmethod
    def of(cls, body: Body) -> "_Composite":
        return cls(body[0], Vector(*body[1:4]), _Symmetric(*body[4:10]))

    def with_body(self, other: "_Composite") -> "_Composite":
        return _Composite(add(self.mass, other.mass), self.first + other.first, self.tensor.plus(other.tensor))

    def pushed(self, is_turning: bool) -> tuple[Vector, Vector]:
        """Force and moment of a unit acceleration about z, or along z."""
        h = self.first
        if is_turning:
            return Vector(multiply(-1.0, h.y), h.x, 0.0), Vector(self.tensor.xz, self.tensor.yz, self.tensor.zz)
        return Z.times(self.mass), Vector(h.y, multiply(-1.0, h.x), 0.0)

    def turned(self, by: _Turn) -> "_Composite":
        """Rz I Rz^T in few operations: xx and yy change by the same u."""
        I, c, s = self.tensor, by.c, by.s  # noqa: E741
        half = add(multiply(s, subtract(I.xx, I.yy)), multiply(c, I.xy))
        u = multiply(s, add(half, multiply(c, I.xy)))
        xy = subtract(multiply(c, half), multiply(s, multiply(s, I.xy)))
        across = by.ahead(Vector(I.xz, I.yz, 0.0))
        tensor = _Symmetric(subtract(I.xx, u), xy, add(I.yy, u), across.x, across.y, I.zz)
        return _Composite(self.mass, by.ahead(self.first), tensor)

    def in_parent(self, turn: Matrix3) -> "_Composite":
        """R I R^T."""
        half = Matrix3(*(self.tensor.matrix() @ row for row in (turn.x, turn.y, turn.z)))  # rows of R I
        x, y, z = turn.x, turn.y, turn.z
        tensor = _Symmetric(half.x.dot(x), half.x.dot(y), half.y.dot(y), half.x.dot(z), half.y.dot(z), half.z.dot(z))
        return _Composite(self.mass, turn @ self.first, tensor)

    def shifted(self, by: Vector) -> "_Composite":
        """About an origin from which this one stands at `by`."""
        h, I, m = self.first, self.tensor, self.mass  # noqa: E741
        moved = h + by.times(m)
        g = h + moved  # I += (g . p) E - (h p^T + p h^T) - m p p^T
        xx, yy, zz = multiply(g.x, by.x), multiply(g.y, by.y), multiply(g.z, by.z)
        tensor = _Symmetric(
            add(I.xx, add(yy, zz)), _less(I.xy, moved.x, by.y, h.y, by.x), add(I.yy, add(xx, zz)),
            _less(I.xz, moved.x, by.z, h.z, by.x), _less(I.yz, moved.y, by.z, h.z, by.y), add(I.zz, add(xx, yy)),
        )  # fmt: skip
        return _Composite(m, moved, tensor)


def _less(entry: Scalar, a: Scalar, b: Scalar, c: Scalar, d: Scalar) -> Scalar:
    """entry - a b - c d."""
    return subtract(subtract(entry, multiply(a, b)), multiply(c, d))
