"""Road B: the paper's Newton-Euler recursion, by hand, on the native chain.

Siciliano, Sciavicco, Oriolo, Villani, *Robotics*, section 7.5 (the recursion of the LWR 4+ paper, its errata
corrected): vectors of link i are in its own frame i, its joint acts along z0 of frame i-1, its rotor is on link i-1.

Two things are more general than the book: a constant pose `before` may precede the joint (modified DH, URDF), and
rotors enter completely ("full"), by their inertia at the joint ("armature", k_r^2 I_m ddq) or not at all ("none").
Scalars are those of `lwr_dyn.model.spatial`. This module must never import `urdf`, `Arm` or Pinocchio.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lwr_dyn.model.chain import Chain, JointKind
from lwr_dyn.model.spatial import ZERO, Matrix3, Scalar, Vector, Z, add, multiply

Rotors = Literal["armature", "full", "none"]


@dataclass(frozen=True, slots=True, eq=False)
class LinkConstants:
    """The constants of one link as scalars: numbers, or symbols when code is generated."""

    revolute: bool
    turn_before: Matrix3
    shift_before: Vector
    before_is_identity: bool
    """As in every standard DH table."""
    turn: Matrix3
    """Rotation of frame i in the moved joint frame."""
    shift: Vector
    """Origin of frame i in the moved joint frame."""
    mass: Scalar
    com: Vector
    inertia: Matrix3
    gear_ratio: Scalar
    rotor_inertia: Scalar
    reflected: bool
    """Only the rotor's inertia at the joint is known, so that "full" takes it as armature."""


def link_constants(chain: Chain) -> tuple[LinkConstants, ...]:
    """The constants of all links; a link without a body is massless, one without a rotor has no rotor inertia."""
    out = []
    for link in chain.links:
        body, rotor = link.body, link.rotor
        out.append(
            LinkConstants(
                revolute=link.kind is JointKind.REVOLUTE,
                turn_before=Matrix3.of(link.before.rotation),
                shift_before=Vector.of(link.before.position),
                before_is_identity=link.before.is_identity(),
                turn=Matrix3.of(link.after.rotation),
                shift=Vector.of(link.after.position),
                mass=0.0 if body is None else float(body.mass),
                com=ZERO if body is None else Vector.of(body.com),
                inertia=Matrix3(ZERO, ZERO, ZERO) if body is None else Matrix3.of(body.inertia_com),
                gear_ratio=0.0 if rotor is None else float(rotor.gear_ratio),
                rotor_inertia=0.0 if rotor is None else float(rotor.inertia),
                reflected=rotor is not None and rotor.reflected,
            )
        )
    return tuple(out)


@dataclass(frozen=True, slots=True, eq=False)
class LinkKinematics:
    """Motion of link i: results of the forward recursion for the backward one, in frame i."""

    R: Matrix3
    """R_i^{i-1}, frame i in the joint frame."""
    r: Vector
    """r_{i-1,i}, from the joint to the origin of frame i."""
    omega: Vector
    domega: Vector
    ddp_com: Vector
    omega_carrier: Vector
    """Angular velocity of link i-1, in the joint frame."""
    domega_carrier: Vector


def inverse_dynamics(
    links: Sequence[LinkConstants],
    gravity: Vector,
    q: Sequence[Scalar],
    dq: Sequence[Scalar],
    ddq: Sequence[Scalar],
    rotors: Rotors = "armature",
) -> list[Scalar]:
    """Joint torques tau = B ddq + C dq + g, one scalar per joint.

    Parameters
    ----------
    links : sequence of LinkConstants
    gravity : Vector
        In the base frame [m/s^2].
    q, dq, ddq : sequences of n scalars
        [rad or m], [rad/s or m/s], [rad/s^2 or m/s^2]; a literal 0.0 drops its terms.
    rotors : {"armature", "full", "none"}

    Returns
    -------
    list of n scalars
        [N m or N]

    References
    ----------
    Siciliano et al., eqs. 7.107 to 7.114; LWR 4+ paper, "Forward Recursion", "Backward Recursion".
    """
    return joint_torques(links, link_kinematics(links, gravity, q, dq, ddq), dq, ddq, rotors)


def link_kinematics(
    links: Sequence[LinkConstants], gravity: Vector, q: Sequence[Scalar], dq: Sequence[Scalar], ddq: Sequence[Scalar]
) -> list[LinkKinematics]:
    """Velocities and accelerations from the base outward (eqs. 7.107 to 7.111); of bodies it takes the centres only."""
    omega, domega, ddp = ZERO, ZERO, -gravity
    states = []
    for i, link in enumerate(links):
        if not link.before_is_identity:
            ddp = ddp + lever_acceleration(omega, domega, link.shift_before)
            omega, domega, ddp = (link.turn_before.T @ v for v in (omega, domega, ddp))
        carrier, dcarrier = omega, domega
        if link.revolute:
            R = turn_about_z(q[i]).compose(link.turn)
            r = link.turn.T @ link.shift
            omega = R.T @ (carrier + Z.times(dq[i]))
            domega = R.T @ (dcarrier + Z.times(ddq[i]) + carrier.times(dq[i]).cross(Z))
            ddp = R.T @ ddp
        else:
            R = link.turn
            r = R.T @ (link.shift + Z.times(q[i]))
            omega = R.T @ carrier
            domega = R.T @ dcarrier
            ddp = R.T @ (ddp + Z.times(ddq[i]) + carrier.times(multiply(2.0, dq[i])).cross(Z))
        ddp = ddp + lever_acceleration(omega, domega, r)
        ddp_com = ddp + lever_acceleration(omega, domega, link.com)
        states.append(LinkKinematics(R, r, omega, domega, ddp_com, carrier, dcarrier))
    return states


def joint_torques(
    links: Sequence[LinkConstants],
    states: Sequence[LinkKinematics],
    dq: Sequence[Scalar],
    ddq: Sequence[Scalar],
    rotors: Rotors,
) -> list[Scalar]:
    """Forces and moments from the flange inward (eqs. 7.112 to 7.114); behind the last of `links` is nothing."""
    f, mu = ZERO, ZERO  # force and moment of link i on link i+1, about the origin of frame i, in frame i
    tau: list[Scalar] = [0.0] * len(links)
    for i in reversed(range(len(links))):
        link, m = links[i], states[i]
        f_next, f = f, f + m.ddp_com.times(link.mass)
        mu = (
            mu
            - f.cross(m.r + link.com)
            + f_next.cross(link.com)
            + link.inertia @ m.domega
            + m.omega.cross(link.inertia @ m.omega)
        )
        f, mu = m.R @ f, m.R @ mu  # into the joint frame
        tau[i] = mu.z if link.revolute else f.z
        kr, Im = link.gear_ratio, link.rotor_inertia
        if rotors == "armature" or (rotors == "full" and link.reflected):
            tau[i] = add(tau[i], multiply(multiply(kr * kr, Im), ddq[i]))
        elif rotors == "full":
            spin, dspin = multiply(kr, dq[i]), multiply(kr, ddq[i])
            domega_m = m.domega_carrier + Z.times(dspin) + m.omega_carrier.times(spin).cross(Z)
            tau[i] = add(tau[i], multiply(kr * Im, domega_m.z))
            mu = mu + Z.times(multiply(dspin, Im)) + m.omega_carrier.cross(Z).times(multiply(spin, Im))
        if not link.before_is_identity:  # to frame i-1, about its origin
            f, mu = link.turn_before @ f, link.turn_before @ mu
            mu = mu + link.shift_before.cross(f)
    return tau


def turn_about_z(angle: Scalar) -> Matrix3:
    """Rz(angle) for any scalar."""
    c, s = np.cos(angle), np.sin(angle)
    return Matrix3(Vector(c, -s, 0.0), Vector(s, c, 0.0), Z)


def lever_acceleration(omega: Vector, domega: Vector, r: Vector) -> Vector:
    """Acceleration of a point at r on a turning body relative to the origin: domega x r + omega x (omega x r)."""
    return domega.cross(r) + omega.cross(omega.cross(r))


def potential_energy(links: Sequence[LinkConstants], gravity: Vector, q: Sequence[Scalar]) -> Scalar:
    """U = -sum m_i g . p_{C_i} [J], zero for masses at the base origin (Siciliano eq. 7.36)."""
    R, p, energy = Matrix3.of(np.eye(3)), ZERO, 0.0
    for i, link in enumerate(links):
        p = p + R @ link.shift_before
        R = R.compose(link.turn_before)
        if link.revolute:
            R = R.compose(turn_about_z(q[i]))
            p = p + R @ link.shift
        else:
            p = p + R @ (link.shift + Z.times(q[i]))
        R = R.compose(link.turn)
        energy = add(energy, multiply(-link.mass, gravity.dot(p + R @ link.com)))
    return energy
