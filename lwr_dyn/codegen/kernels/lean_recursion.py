"""The recursions that kernels are generated from: inverse dynamics, and B by composite bodies, in the axes' own frames.

A body is its ten inertial parameters about the origin of its joint's frame (`kernel_spec`): no product with a mass, no
centre of mass. Scalars are those of `lwr_dyn.model.spatial`; a literal 0.0 forms no operation. The readable recursion
is `lwr_dyn.dynamics.recursion`, with which these agree.

The frames have z on the joints' axes and are slid along them until few lengths remain between one and the next: joints
whose axes meet share an origin (the LWR's shoulder and wrist), so that a chain with seven joints keeps two shifts. The
motion and the torques are those of the source's frames. Parameters on which the torque depends only together are folded
into base parameters once, so that most masses and many moments are zero in the recursion.

References
----------
Featherstone, *Rigid Body Dynamics Algorithms* (2008), table 5.1 (recursive Newton-Euler), table 6.2 (composite rigid
body); Khalil, Dombre, *Modeling, Identification and Control of Robots* (2002), section 9.5 (first moments);
Gautier, Khalil, "Direct calculation of minimum set of inertial parameters of serial robots", IEEE T-RA 6 (1990).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from lwr_dyn.codegen.kernels.kernel_spec import to_parent
from lwr_dyn.dynamics.recursion import lever_acceleration
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Chain, JointKind
from lwr_dyn.model.spatial import ZERO, Matrix3, Pose, Scalar, Vector, Z, add, multiply, subtract

EXACT = 1e-12
"""[m, 1] Entries of constants nearer to 0 or +-1 than this are taken as such."""


@dataclass(frozen=True, slots=True, eq=False)
class AxisFrame:
    """The pose of a joint's frame, at q = 0, in the moved frame of the joint before; the link's frame in its own."""

    is_turning: bool
    turn: Matrix3
    shift: Vector
    link: Pose


def axis_frames(chain: Chain) -> tuple[AxisFrame, ...]:
    """The frames of a chain."""
    before = [link.before for link in chain.links]
    poses = [before[0], *(a.after @ b for a, b in zip(chain.links, before[1:], strict=False))]
    slides = _slides(poses)
    frames, last = [], 0.0
    for link, pose, slide in zip(chain.links, poses, slides, strict=True):
        shift = pose.position - last * np.array([0.0, 0.0, 1.0]) + slide * pose.rotation[:, 2]
        own = Pose(link.after.rotation, link.after.position - slide * np.array([0.0, 0.0, 1.0]))
        turn = Matrix3.of(_tidy(pose.rotation))
        frames.append(AxisFrame(link.kind is JointKind.REVOLUTE, turn, Vector.of(_tidy(shift)), own))
        last = slide
    return tuple(frames)


def parameter_map(frames: Sequence[AxisFrame]) -> Array:
    """The matrix (10 n, 10 n) from inertial parameters in the links' frames to those in `frames`."""
    out: Array = block_diag(*(to_parent(frame.link) for frame in frames))
    return out


def _slides(poses: Sequence[Pose]) -> list[float]:
    """How far each frame is slid along its axis [m]; the first by what makes the way to the second shortest."""
    out = [_to_the_next(poses[1]) if len(poses) > 1 else 0.0]
    for pose in poses[1:]:
        here = pose.position - np.array([0.0, 0.0, out[-1]])
        axis = pose.rotation[:, 2]
        candidates = [0.0, *(-here[k] / axis[k] for k in range(3) if abs(axis[k]) > EXACT)]
        out.append(min(candidates, key=lambda s: (np.count_nonzero(_tidy(here + s * axis)), abs(s))))
    return out


def _to_the_next(pose: Pose) -> float:
    """Along the first axis, the foot of the shortest way to the second; 0 where they are parallel."""
    axis = pose.rotation[:, 2]
    across = 1.0 - axis[2] ** 2
    return 0.0 if across < EXACT else float((pose.position[2] - axis[2] * (axis @ pose.position)) / across)


def _tidy(entries: Array) -> Array:
    """The entries, those that miss 0 or +-1 by rounding put right."""
    near = np.round(entries)
    return np.where((np.abs(entries - near) < EXACT) & (np.abs(near) <= 1.0), near, entries)


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
        tensor = body.tensor.matrix()
        moment = moment + tensor @ domega + omega.cross(tensor @ omega) + body.first.cross(a)
        tau[i] = moment.z if frame.is_turning else force.z
        force, moment = _to_parent(frame, turns[i], q[i], force, moment)
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
        first = Turn.of(q[i]).ahead(first) if frame.is_turning else first + Z.times(multiply(q[i], mass))
        first = frame.turn @ first + frame.shift.times(mass)
    return multiply(-1.0, gravity.dot(first))


def _to_parent(frame: AxisFrame, turn: "Turn", q: Scalar, force: Vector, moment: Vector) -> tuple[Vector, Vector]:
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
class Turn:
    """A turn about z by its cosine and sine."""

    c: Scalar
    s: Scalar

    @classmethod
    def of(cls, angle: Any) -> "Turn":
        """Of an angle; a turn stays as it is."""
        return angle if isinstance(angle, Turn) else cls(np.cos(angle), np.sin(angle))

    def ahead(self, v: Vector) -> Vector:
        """A vector of the moved frame in the frame before the motion."""
        x = subtract(multiply(self.c, v.x), multiply(self.s, v.y))
        return Vector(x, add(multiply(self.s, v.x), multiply(self.c, v.y)), v.z)

    def back(self, v: Vector) -> Vector:
        """The other way."""
        x = add(multiply(self.c, v.x), multiply(self.s, v.y))
        return Vector(x, subtract(multiply(self.c, v.y), multiply(self.s, v.x)), v.z)


def _turns(frames: Sequence[AxisFrame], q: Any) -> list[Turn]:
    """The turn of each joint; of a sliding one none."""
    return [Turn.of(x) if frame.is_turning else Turn(1.0, 0.0) for frame, x in zip(frames, q, strict=True)]


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

    def plus(self, other: "_Symmetric") -> "_Symmetric":
        return _Symmetric(*(add(getattr(self, name), getattr(other, name)) for name in self.__slots__))


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

    def turned(self, by: Turn) -> "_Composite":
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


ORDER = (9, 1, 2, 4, 5, 7, 8, 6, 3, 0)
"""Places in `PER_LINK` as they are tried: Izz, mx, my, Ixx, Ixy, Ixz, Iyz first; then Iyy, mz and m, which thus go."""

STATES = 12
"""Random states a joint, from which the dependence is found."""

SEED = 0

INDEPENDENT = 1e-8
"""Share of a column that must be left for it to be independent of those before; rounding leaves 1e-14."""

NO_TORQUE = 1e-9

NO_COEFFICIENT = 1e-10
"""Coefficients below this are zero: they are sums of products of lengths [m, m^2] and of 1."""


def base_matrix(frames: Sequence[AxisFrame], gravity: Array | None) -> Array:
    """K (10 n, 10 n): inertial parameters in `frames` -> those of the same torques, with zeros for all that can be.

    Parameters
    ----------
    gravity : (3,) array or None
        [m/s^2]; None for any gravity.
    """
    Y, n = _columns(frames, gravity), len(frames)
    kept: list[int] = []
    Q = np.zeros((len(Y), 0))
    for at in (10 * i + k for k in ORDER for i in range(n)):
        size, rest = float(np.linalg.norm(Y[:, at])), Y[:, at]
        for _ in range(2):  # twice is enough
            rest = rest - Q @ (Q.T @ rest)
        left = float(np.linalg.norm(rest))
        if size > NO_TORQUE and left > INDEPENDENT * size:
            kept.append(at)
            Q = np.column_stack([Q, rest / left])
    K = np.zeros((10 * n, 10 * n))
    folded = np.linalg.lstsq(Y[:, kept], Y, rcond=None)[0]
    K[kept] = np.where(np.abs(folded) < NO_COEFFICIENT, 0.0, folded)
    return K


def _columns(frames: Sequence[AxisFrame], gravity: Array | None) -> Array:
    """The torque of each parameter alone at random states, (rows, 10 n)."""
    n = len(frames)
    rng = np.random.default_rng(SEED)
    q, dq, ddq = rng.uniform(-np.pi, np.pi, (3, n, STATES * n))
    pull = Vector.of(gravity) if gravity is not None else Vector(*rng.normal(0.0, 10.0, (3, STATES * n)))
    units = np.eye(10 * n).reshape(10 * n, n, 10, 1)
    bodies = [[units[:, i, k] for k in range(10)] for i in range(n)]
    torque = inverse_dynamics(frames, bodies, pull, q, dq, ddq)  # (10 n, states) each
    return np.concatenate([np.broadcast_to(x, (10 * n, STATES * n)) for x in torque], axis=1).T
