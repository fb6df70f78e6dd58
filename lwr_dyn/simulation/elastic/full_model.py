"""The full model of an arm with elastic joints: rotors also turn with the links that carry them.

Rotor i sits on link i - 1 and spins with k_i dtheta_i about the axis z_i, so its kinetic energy has the product

    I_i k_i dtheta_i (z_i . omega_{i-1}) = dq^T S(q) dtheta,   S_ki = I_i k_i z_k . z_i  for k < i,

which the reduced model leaves out:

    M ddq + S ddtheta + h + C dq + g = s,      h_k = c_kji dq_j dtheta_i - c_jki dq_j dtheta_i
    B ddtheta + S^T ddq + m + s = tau,         m_i = c_kji dq_k dq_j,
    c_kji = dS_ki / dq_j = I_i k_i z_k . (z_j x z_i)  for k < j < i, else 0

With theta = q both sides together are the recursion with rotors "full". A rotor that is only known by its inertia at
the joint has no products, nor has a sliding joint that moves one.

References
----------
A. De Luca, W. Book, "Robots with flexible elements", *Springer Handbook of Robotics*, 2nd ed. (2016), section 11.1.2.
"""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import joint_axes
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.elasticity import JointElasticity
from lwr_dyn.simulation.elastic.dynamics import ElasticDynamics


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
