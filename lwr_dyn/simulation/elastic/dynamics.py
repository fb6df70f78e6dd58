"""The reduced model of an arm with elastic joints: links and rotors, joined by springs and dampers.

    M(q) ddq + C(q, dq) dq + g(q) = s,   B ddtheta + s + tau_friction(dtheta) = tau,
    s = K (theta - q) + D (dtheta - dq)

M is the mass matrix of the links with the motors' masses, without the rotors' inertia B = k_r^2 I_m, which is seen at
the joints. The one assumption is that the rotors' kinetic energy is that of their own spin; `full_model` is without it.

References
----------
M. W. Spong, "Modeling and control of elastic joint robots", J. Dyn. Syst. Meas. Control 109 (1987).
"""

from dataclasses import replace
from typing import Any

import numpy as np

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics, mechanical_energy, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.elasticity import JointElasticity


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
