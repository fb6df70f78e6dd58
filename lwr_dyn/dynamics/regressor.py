"""Regressor of an arm: joint torques are linear in the ten inertial parameters of every link.

    tau = Y(q, dq, ddq) pi,   pi_i = (m, m cx, m cy, m cz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz) about the origin of frame i

A column is the torque of the Newton-Euler recursion for a chain with one parameter of 1 and all others 0. Friction and
rotors add columns for their own joint. A source may leave a parameter open where no torque depends on it, its column
being zero at all states: of a link on a vertical first axis only Izz moves anything.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.dynamics.recursion import (
    LinkConstants,
    LinkKinematics,
    joint_torques,
    lever_acceleration,
    link_constants,
    link_kinematics,
)
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import Body, Chain
from lwr_dyn.model.spatial import ZERO, Matrix3, Vector, steiner

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
        Siciliano et al., *Robotics*, section 7.2.2, eq. 7.52 (linearity in the dynamic parameters).
        """
        k, n = q.shape
        out = np.zeros((k, n, (len(INERTIAL) + len(JOINT)) * n))
        gravity = Vector.of(self.chain.gravity)
        q_i, dq_i, ddq_i = ([x[:, i] for i in range(n)] for x in (q, dq, ddq))
        bare = [_bare(link) for link in link_constants(self.chain)]
        motions = link_kinematics(bare, gravity, q_i, dq_i, ddq_i)
        for i in range(n):
            for p, unit in enumerate(_unit_bodies(bare[i])):
                moved = [*motions[:i], _with_centre(motions[i], unit.com)]
                torque = joint_torques([*bare[:i], unit], moved, dq_i, ddq_i, rotors="none")
                for j, values in enumerate(torque):
                    out[:, j, len(INERTIAL) * i + p] = values
            mass = out[:, :, len(INERTIAL) * i, None]
            out[:, :, len(INERTIAL) * i + 1 : len(INERTIAL) * i + 4] -= mass  # that body had a mass of 1 too
        first = len(INERTIAL) * n
        for i in range(n):
            columns = slice(first + len(JOINT) * i, first + len(JOINT) * (i + 1))
            out[:, i, columns] = friction_columns(dq[:, i], ddq[:, i])
        return out


def friction_columns(dq: Array, ddq: Array) -> Array:
    """Rotor and friction of one joint, (k, 5): ddq, then 1 and dq while it moves up, -1 and dq while it moves down."""
    up, down = (dq > 0.0).astype(np.float64), (dq < 0.0).astype(np.float64)
    return np.column_stack([ddq, up, up * dq, -down, down * dq])


def _bare(link: LinkConstants) -> LinkConstants:
    return replace(link, mass=0.0, com=ZERO, inertia=Matrix3(ZERO, ZERO, ZERO), gear_ratio=0.0, rotor_inertia=0.0)


def _with_centre(origin: LinkKinematics, com: Vector) -> LinkKinematics:
    """The motion of a link whose centre of mass is at `com`, from that of one with its centre at the frame's origin."""
    return replace(origin, ddp_com=origin.ddp_com + lever_acceleration(origin.omega, origin.domega, com))


def _unit_bodies(bare: LinkConstants) -> Sequence[LinkConstants]:
    """The link with a mass of 1; with that mass at one unit along each axis; with each element of the tensor 1.

    The middle three have no inertia about the origin: their tensor about the centre of mass is negative.
    """
    bodies = [replace(bare, mass=1.0)]
    for axis in np.eye(3):
        bodies.append(replace(bare, mass=1.0, com=Vector.of(axis), inertia=Matrix3.of(-steiner(1.0, axis))))
    for a, b in ROW_BY_ROW:
        tensor = np.zeros((3, 3))
        tensor[a, b] = tensor[b, a] = 1.0
        bodies.append(replace(bare, inertia=Matrix3.of(tensor)))
    return bodies


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
