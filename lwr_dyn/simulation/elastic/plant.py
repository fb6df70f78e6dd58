"""The plant with elastic joints: 2n coordinates, friction on the motors' side, position stops on the links' side.

The reduced model: links and rotors, joined by springs and dampers.

    M(q) ddq + C(q, dq) dq + g(q) = s,   B ddtheta + s + tau_friction(dtheta) = tau,
    s = K (theta - q) + D (dtheta - dq)

M is the mass matrix of the links with the motors' masses, without the rotors' inertia B = k_r^2 I_m, which is seen at
the joints. Its one assumption is that the rotors' kinetic energy is that of their own spin. The full model is without
it: rotor i sits on link i - 1 and spins with k_i dtheta_i about the axis z_i, so its kinetic energy has the product

    I_i k_i dtheta_i (z_i . omega_{i-1}) = dq^T S(q) dtheta,   S_ki = I_i k_i z_k . z_i  for k < i,

    M ddq + S ddtheta + h + C dq + g = s,      h_k = c_kji dq_j dtheta_i - c_jki dq_j dtheta_i
    B ddtheta + S^T ddq + m + s = tau,         m_i = c_kji dq_k dq_j,
    c_kji = dS_ki / dq_j = I_i k_i z_k . (z_j x z_i)  for k < j < i, else 0

With theta = q both sides together are the recursion with rotors "full". A rotor that is only known by its inertia at
the joint has no products, nor has a sliding joint that moves one.

References
----------
M. W. Spong, "Modeling and control of elastic joint robots", J. Dyn. Syst. Meas. Control 109 (1987).
A. De Luca, W. Book, "Robots with flexible elements", *Springer Handbook of Robotics*, 2nd ed. (2016), section 11.1.2.
"""

import warnings
from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np

from lwr_dyn.dynamics.engines import ENGINES, dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics, mechanical_energy, ungated
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import MissingDataError, OptionError, RatingWarning
from lwr_dyn.kinematics.forward import joint_axes
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.transmission import JointElasticity
from lwr_dyn.simulation.arm_friction import FORMS, ArmFriction
from lwr_dyn.simulation.plant import Plant
from lwr_dyn.simulation.setup import Setup


def arm_without_rotors(arm: Arm) -> Arm:
    """The arm whose rotors have no inertia: its links."""
    links = tuple(replace(link, rotor=None) for link in arm.chain.links)
    return arm.with_chain(replace(arm.chain, links=links))


class ElasticDynamics:
    """The reduced model as an engine of 2n coordinates x = (q, theta), ungated; tau is (0, motors' torques)."""

    rotors = "reduced"

    def __init__(self, arm: Arm, elasticity: JointElasticity, engine: str = "pinocchio") -> None:
        self.links: Dynamics = dynamics_of(arm_without_rotors(arm), engine)
        self.joints, self.name = arm.n, engine
        self.rotor = arm.armature
        self.stiffness, self.damping = elasticity.stiffness, elasticity.damping
        self._links: Any = ungated(self.links)

    @property
    def n(self) -> int:
        """Number of coordinates, twice that of the joints."""
        return 2 * self.joints

    def gear_torque(self, x: Array, dx: Array) -> Array:
        """s (..., n), what the gears exert on the links [N m]."""
        n = self.joints
        turn, speed = x[..., n:] - x[..., :n], dx[..., n:] - dx[..., :n]
        return np.asarray(self.stiffness * turn + self.damping * speed)

    def damper_power(self, dx: Array) -> Array:
        """-D (dtheta - dq)^2 of all joints, (...) [W]."""
        n = self.joints
        speed = dx[..., n:] - dx[..., :n]
        return np.asarray(-(speed * speed) @ self.damping)

    def forward_dynamics(self, x: Array, dx: Array, tau: Array) -> Array:
        """(ddq, ddtheta), (2n,)."""
        n, gear = self.joints, self.gear_torque(x, dx)
        out = np.empty(2 * n)
        out[:n] = self._links.forward_dynamics(x[:n], dx[:n], tau[:n] + gear)
        out[n:] = (tau[n:] - gear) / self.rotor
        return out

    def mass_matrix(self, x: Array) -> Array:
        """diag(M, B), (..., 2n, 2n)."""
        n, links = self.joints, self._links if x.ndim == 1 else self.links
        B = np.zeros((*x.shape, 2 * n))
        B[..., :n, :n] = links.mass_matrix(x[..., :n])
        B[..., np.arange(n, 2 * n), np.arange(n, 2 * n)] = self.rotor
        return B

    def bias_torque(self, x: Array, dx: Array) -> Array:
        """(C dq + g - s, s), (..., 2n)."""
        n, links, gear = self.joints, self._links if x.ndim == 1 else self.links, self.gear_torque(x, dx)
        return np.concatenate([links.bias_torque(x[..., :n], dx[..., :n]) - gear, gear], axis=-1)

    def link_rows(self, x: Array, dx: Array, tau: Array, out: Array, external: Array | None = None) -> None:
        """Writes the slopes of ddq over (q, theta, dq, dtheta) into `out` (n, 4n).

        `external` (n, 4n) are the slopes of an external torque, which is a part of tau.
        """
        n = self.joints
        over_q, over_dq, M_inv = self._link_slopes(x[:n], dx[:n], tau[:n] + self.gear_torque(x, dx))
        spring, damper = out[:, n : 2 * n], out[:, 3 * n :]
        np.multiply(M_inv, self.stiffness, out=spring)
        np.multiply(M_inv, self.damping, out=damper)
        np.subtract(over_q, spring, out=out[:, :n])
        np.subtract(over_dq, damper, out=out[:, 2 * n : 3 * n])
        if external is not None:
            out += M_inv @ external

    def motor_slopes(self) -> Array:
        """Slopes of ddtheta_i over q_i, theta_i, dq_i and dtheta_i, (4, n): the same in all states."""
        K, D = self.stiffness / self.rotor, self.damping / self.rotor
        return np.array([K, -K, D, -D])

    def _link_slopes(self, q: Array, dq: Array, net: Array) -> tuple[Array, Array, Array]:
        own = getattr(self._links, "acceleration_slopes", None)
        if own is not None:
            slopes: tuple[Array, Array, Array] = own(q, dq, net)
            return slopes
        forward, n, M_inv = self._links.forward_dynamics, self.joints, np.linalg.inv(self._links.mass_matrix(q))
        step = SLOPE_STEP * np.eye(n)
        over_q = np.array([forward(q + e, dq, net) - forward(q - e, dq, net) for e in step]).T
        over_dq = np.array([forward(q, dq + e, net) - forward(q, dq - e, net) for e in step]).T
        return over_q / (2 * SLOPE_STEP), over_dq / (2 * SLOPE_STEP), M_inv

    def energies(self, x: Array, dx: Array) -> Array:
        """Energy of links, rotors and springs, (k,) [J], of k states (k, 2n)."""
        n = self.joints
        links = mechanical_energy(self.links, np.ascontiguousarray(x[:, :n]), np.ascontiguousarray(dx[:, :n]))
        turn = x[:, n:] - x[:, :n]
        return np.asarray(links + ((dx[:, n:] ** 2) @ self.rotor + (turn * turn) @ self.stiffness) / 2)


SLOPE_STEP = 1e-5
"""[rad, rad/s] of the central differences for engines without slopes of their own; they err by 1e-9."""


class FullElasticDynamics(ElasticDynamics):
    """As `ElasticDynamics`, with the rotors' spin coupled to the links' motion."""

    rotors = "full"

    def __init__(self, arm: Arm, elasticity: JointElasticity, engine: str = "pinocchio") -> None:
        ElasticDynamics.__init__(self, arm, elasticity, engine)
        rotors = [link.rotor for link in arm.chain.links]
        known = [r is not None and not r.reflected for r in rotors]
        size = [r.inertia * r.gear_ratio if r and k else 0.0 for r, k in zip(rotors, known, strict=True)]
        n, self._chain = arm.n, arm.chain
        first, second = np.triu(np.ones((n, n)), 1), np.triu(np.ones((n, n)), 1)
        self._pairs = first * size
        self._triples = np.einsum("kj,ji->kji", first, second) * size

    def products(self, q: Array) -> tuple[Array, Array]:
        """S (..., n, n) and its slopes c (..., n, n, n) [kg m^2] at q (..., n)."""
        axes = joint_axes(self._chain, q)
        z = axes.z * np.array(axes.revolute)[:, None]
        of_rotors = axes.z
        S = np.einsum("...ka,...ia->...ki", z, of_rotors) * self._pairs
        crossed = np.cross(z[..., :, None, :], of_rotors[..., None, :, :])  # (..., j, i, 3)
        return S, np.einsum("...ka,...jia->...kji", z, crossed) * self._triples

    def coupling(self, q: Array, dq: Array, dtheta: Array) -> tuple[Array, Array, Array]:
        """S (..., n, n), h and m (..., n)."""
        S, c = self.products(q)
        h = np.einsum("...kji,...j,...i->...k", c - np.swapaxes(c, -3, -2), dq, dtheta)
        return S, h, np.einsum("...kji,...k,...j->...i", c, dq, dq)

    def forward_dynamics(self, x: Array, dx: Array, tau: Array) -> Array:
        """(ddq, ddtheta), (2n,)."""
        n, gear = self.joints, self.gear_torque(x, dx)
        q, dq = x[:n], dx[:n]
        S, h, m = self.coupling(q, dq, dx[n:])
        motors = (tau[n:] - gear - m) / self.rotor
        links = tau[:n] + gear - h - self._links.bias_torque(q, dq) - S @ motors
        ddq = np.linalg.solve(self._links.mass_matrix(q) - (S / self.rotor) @ S.T, links)
        return np.concatenate([ddq, motors - (S.T @ ddq) / self.rotor])

    def mass_matrix(self, x: Array) -> Array:
        """[[M, S], [S^T, B]], (..., 2n, 2n)."""
        n, B = self.joints, ElasticDynamics.mass_matrix(self, x)
        S = self.products(x[..., :n])[0]
        B[..., :n, n:], B[..., n:, :n] = S, np.swapaxes(S, -1, -2)
        return B

    def bias_torque(self, x: Array, dx: Array) -> Array:
        """(C dq + g + h - s, m + s), (..., 2n)."""
        n = self.joints
        _, h, m = self.coupling(x[..., :n], dx[..., :n], dx[..., n:])
        return np.asarray(ElasticDynamics.bias_torque(self, x, dx) + np.concatenate([h, m], axis=-1))

    def couple(self, x: Array, slopes: Array) -> None:
        """Turns slopes (2n, m) of the reduced model's accelerations into those with products, without h, m and dS."""
        uncoupled = ElasticDynamics.mass_matrix(self, x)
        slopes[:] = np.linalg.solve(self.mass_matrix(x), uncoupled @ slopes)

    def energies(self, x: Array, dx: Array) -> Array:
        """With dq^T S dtheta, (k,) [J], of k states (k, 2n)."""
        n = self.joints
        S = self.products(x[:, :n])[0]
        coupled = np.einsum("ka,kab,kb->k", dx[:, :n], S, dx[:, n:])
        return np.asarray(ElasticDynamics.energies(self, x, dx) + coupled)


SLOWEST = 5.0
"""[rad/s] A rotor so light that a sampled law on the motors' side cannot even be this fast is refused."""


@dataclass(frozen=True, slots=True, eq=False)
class ElasticPlant(Plant):
    """As `Plant`, of 2n coordinates (q, theta)."""

    model: ElasticDynamics

    @property
    def n(self) -> int:
        """Number of coordinates, twice that of the joints."""
        return 2 * self.arm.n


def elastic_plant(setup: Setup) -> ElasticPlant:
    """The plant of a setup with `elasticity`: of the full model where the engine has rotors "full", else reduced.

    Raises `MissingDataError`: a joint without a rotor; `OptionError`: a rotor too light to be driven by a sampled law
    on its own side, an engine of no registered name.
    """
    plant, elasticity = setup.plant, setup.elasticity
    assert elasticity is not None
    if setup.loop.engine_name not in ENGINES.names:
        raise OptionError("engine", f"{setup.loop.engine_name} with elastic joints", ", ".join(ENGINES.names))
    full = getattr(plant.ungated, "rotors", "armature") == "full"
    links = "pinocchio" if full else setup.loop.engine_name  # the recursion is written to be read, not to be fast
    model = (FullElasticDynamics if full else ElasticDynamics)(plant.arm, elasticity, links)
    _check_rotors(setup, model)
    free = np.full(plant.arm.n, np.inf)
    return ElasticPlant(
        plant.arm, model, motor_friction(plant.friction, plant.arm.n),  # type: ignore[arg-type] # it has what loops use
        np.concatenate([plant.lower, -free]), np.concatenate([plant.upper, free]),
        np.concatenate([free, plant.effort]), model,
    )  # fmt: skip


def fastest_on_motors(rate: float, rotor: Array, B: Array) -> Array:
    """B_m / (B_ii T) (..., n) [rad/s] at `rate` = 1/T [Hz], for rotors (n,) [kg m^2] and mass matrices B (..., n, n).

    A law on the motors' side that is tuned to more shakes the rotor; less than `SLOWEST` is refused.
    """
    return np.asarray(rate * rotor / np.diagonal(B, axis1=-2, axis2=-1))


def _check_rotors(setup: Setup, model: ElasticDynamics) -> None:
    """A law on the motors' side, tuned to omega_n on the rigid inertia B_ii, damps the rotor alone with 2 omega_n B_ii.

    Held for T it lets the rotor swing up where T 2 omega_n B_ii > 2 B_m: faster than B_m / (B_ii T) nothing works.
    """
    arm, rate = setup.plant.arm, setup.loop.rate
    bare = np.flatnonzero(model.rotor <= 0.0)
    if bare.size:
        raise MissingDataError(arm.name, f"rotor inertia of {arm.joint_names[bare[0]]}", "elastic joints")
    B = setup.plant.ungated.mass_matrix(setup.start[0])
    rigid, fastest = np.diagonal(B), fastest_on_motors(rate, model.rotor, B)
    j = int(np.argmin(fastest))
    if fastest[j] >= SLOWEST or setup.loop.allow_unphysical:
        return
    fault = (
        f"rotor of {model.rotor[j]:.2g} kg m^2 before {rigid[j]:.3g} kg m^2, too light for elastic joints: held for "
        f"{1 / rate:.2g} s, damping on the motors' side shakes it from {fastest[j]:.2g} rad/s on"
    )
    need = ceil(SLOWEST * rigid[j] / model.rotor[j])
    if setup.loop.encoders == "link":
        warnings.warn(f"{arm.joint_names[j]}: {fault}", RatingWarning, stacklevel=2)
        return
    allowed = f"a reading with heavier rotors, a rate from {need} Hz on (steps of {1 / need:.2g} s), or "
    raise OptionError(f"{arm.joint_names[j]} ({arm.reading})", fault, f"{allowed}allow_unphysical")


def motor_friction(friction: ArmFriction, n: int) -> ArmFriction:
    """The friction of n joints on the motors' side of 2n coordinates."""
    if friction.form == "none":
        return ArmFriction.function("none", 2 * n, None)
    slope = np.concatenate([np.zeros(n), friction.slope])
    smooth = friction.smooth
    if smooth is not None:
        still = np.zeros(n)
        return ArmFriction.function(
            friction.form, 2 * n, lambda dx: np.concatenate([still, smooth(dx[n:])]), read_only(slope)
        )
    assert friction.form == FORMS[0]
    names = ("coulomb", "viscous", "stribeck_drop", "sharpness", "offset", "lowest", "highest", "lowest_slip")
    wide: dict[str, Any] = {name: _on_motors(getattr(friction, name)) for name in (*names, "highest_slip", "slope")}
    return replace(friction, **wide)


def _on_motors(table: Array) -> Array:
    return read_only(np.concatenate([np.zeros_like(table), table], axis=-1))
