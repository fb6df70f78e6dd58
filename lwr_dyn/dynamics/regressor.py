"""Regressor of an arm: joint torques are linear in the ten inertial parameters of every link.

    tau = Y(q, dq, ddq) pi,   pi_i = (m, m cx, m cy, m cz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz) about the origin of frame i

A column is the torque of the Newton-Euler recursion for a chain with one parameter of 1 and all others 0: the force and
moment of that unit, carried inward. All columns go together. Friction and rotors add columns for their own joint. A
source may leave a parameter open where no torque depends on it, its column being zero at all states: of a link on a
vertical first axis only Izz moves anything.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.dynamics.recursion import (
    LinkKinematics,
    lever_acceleration,
    link_constants,
    link_kinematics,
)
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import Body, Chain
from lwr_dyn.model.spatial import ZERO, Matrix3, Vector

INERTIAL = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
"""Mass [kg], first moment [kg m], tensor about the origin of the frame [kg m^2]."""
JOINT = ("armature", "coulomb+", "viscous+", "coulomb-", "viscous-")
"""Rotor inertia at the joint [kg m^2], friction per direction [N m, N m s/rad]."""
ROW_BY_ROW = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Entries of the tensor in the order of `INERTIAL`."""


def body_parameters(body: Body, entries: Sequence[tuple[int, int]] = ROW_BY_ROW) -> Array:
    """The ten inertial parameters of a body in its frame, (10,), the entries of the tensor in the given order.

    >>> body_parameters(Body(2.0, np.array([0.0, 0.0, 1.0]), np.zeros((3, 3)))).tolist()
    [2.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0]
    """
    tensor = body.inertia_origin()
    return np.array([body.mass, *(body.mass * body.com), *(tensor[i, j] for i, j in entries)])


def parameter_names(n: int) -> tuple[str, ...]:
    """Names of all columns: those of link 1, link 2 ..., then those of joint 1, joint 2 ..."""
    links = [f"{name}_{i}" for i in range(1, n + 1) for name in INERTIAL]
    return (*links, *(f"{name}_{i}" for i in range(1, n + 1) for name in JOINT))


def chain_parameters(chain: Chain) -> Array:
    """The parameters of a chain without friction, (15 n,): the model's own values for the columns."""
    links = [body_parameters(link.body or Body.massless()) for link in chain.links]
    joints = [[armature, 0.0, 0.0, 0.0, 0.0] for armature in chain.armature]
    return np.concatenate([*links, *joints])


@dataclass(frozen=True, slots=True, eq=False)
class Regressor:
    """Y(q, dq, ddq) of one chain's geometry; independent of its masses."""

    chain: Chain

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return parameter_names(self.chain.n)

    def __call__(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Y (k, n, 15 n) for states (k, n) [rad, rad/s, rad/s^2]: torque of joint j in row k per unit of a parameter.

        References
        ----------
        Siciliano et al., *Robotics*, section 7.2.2, eq. 7.52 (linearity in the dynamic parameters); Atkeson, An,
        Hollerbach, "Estimation of Inertial Parameters of Manipulator Loads and Links", 1986 (wrenches of a link by its
        parameters, carried inward).
        """
        k, n = q.shape
        out = np.zeros((k, n, (len(INERTIAL) + len(JOINT)) * n))
        links = [replace(link, com=ZERO) for link in link_constants(self.chain)]
        q_i, dq_i, ddq_i = ([x[:, i] for i in range(n)] for x in (q, dq, ddq))
        motions = link_kinematics(links, Vector.of(self.chain.gravity), q_i, dq_i, ddq_i)
        f = mu = _stacked([], k)  # of the parameters of link i and of those outside it, in the order of the columns
        for i in reversed(range(n)):
            link, m = links[i], motions[i]
            own_f, own_mu = _unit_wrenches(m)
            f, mu = _joined(_stacked(own_f, k), f), _joined(_stacked(own_mu, k), mu)
            mu = mu - f.cross(m.r)
            f, mu = m.R @ f, m.R @ mu  # into the joint frame
            out[:, i, len(INERTIAL) * i : len(INERTIAL) * n] = (mu.z if link.revolute else f.z).T
            if not link.before_is_identity:  # to frame i-1, about its origin
                f, mu = link.turn_before @ f, link.turn_before @ mu
                mu = mu + link.shift_before.cross(f)
        first = len(INERTIAL) * n
        for i in range(n):
            columns = slice(first + len(JOINT) * i, first + len(JOINT) * (i + 1))
            out[:, i, columns] = friction_columns(dq[:, i], ddq[:, i])
        return out


def friction_columns(dq: Array, ddq: Array) -> Array:
    """Rotor and friction of one joint, (k, 5): ddq, then 1 and dq while it moves up, -1 and dq while it moves down."""
    up, down = (dq > 0.0).astype(np.float64), (dq < 0.0).astype(np.float64)
    return np.column_stack([ddq, up, up * dq, -down, down * dq])


def _unit_wrenches(m: LinkKinematics) -> tuple[list[Vector], list[Vector]]:
    """Forces and moments of a moving link for one unit of each parameter, about the origin of its frame, there.

    The acceleration of that origin is `m.ddp_com`.
    """
    axes = [Vector.of(axis) for axis in np.eye(3)]
    forces = [m.ddp_com, *(lever_acceleration(m.omega, m.domega, axis) for axis in axes), *(ZERO for _ in UNIT_TENSORS)]
    tensors = [unit @ m.domega + m.omega.cross(unit @ m.omega) for unit in UNIT_TENSORS]
    return forces, [ZERO, *(axis.cross(m.ddp_com) for axis in axes), *tensors]


def _unit_tensor(a: int, b: int) -> Matrix3:
    tensor = np.zeros((3, 3))
    tensor[a, b] = tensor[b, a] = 1.0
    return Matrix3.of(tensor)


UNIT_TENSORS = tuple(_unit_tensor(a, b) for a, b in ROW_BY_ROW)
"""With one element of 1, and its mirror."""


def _stacked(vectors: Sequence[Vector], k: int) -> Vector:
    """Vectors of k states, or the same at all, as one whose components are (number of vectors, k)."""
    out = np.zeros((3, len(vectors), k))
    for p, v in enumerate(vectors):
        out[0, p], out[1, p], out[2, p] = v.x, v.y, v.z
    return Vector(*out)


def _joined(first: Vector, second: Vector) -> Vector:
    return Vector(*(np.concatenate([getattr(first, c), getattr(second, c)]) for c in "xyz"))


STATES = 20
ROUNDING = 1e-12
"""Of the largest entry of Y: what a column of zeros may be off."""
_UNITS = ("kg", *("kg m",) * 3, *("kg m^2",) * 6)


def chain_with_dynamics(arm: Any) -> Chain:
    """The chain of an arm whose torques its source determines.

    Raises `MissingDataError` for links without inertia, or an unknown parameter on which a torque depends.
    """
    chain: Chain = arm.require_dynamics()
    if any(link.body.unknown for link in chain.links if link.body is not None):
        _refuse_what_matters(arm.name, chain)
    return chain


def _refuse_what_matters(name: str, chain: Chain) -> None:
    rng = np.random.default_rng(0)
    Y = np.abs(Regressor(chain)(*rng.uniform(-np.pi, np.pi, (3, STATES, chain.n)))).max(axis=0)  # (n, 15 n)
    largest = float(Y[:, : len(INERTIAL) * chain.n].max())
    for i, link in enumerate(chain.links):
        for p in () if link.body is None else link.body.unknown:
            column = Y[:, len(INERTIAL) * i + p]
            joint = int(np.argmax(column))
            if column[joint] > ROUNDING * largest:
                share = f"the torque of {chain.links[joint].joint}: up to {column[joint]:.3g} N m per {_UNITS[p]}"
                raise MissingDataError(name, f"{INERTIAL[p]} of {link.link} about its frame's origin is", share)
