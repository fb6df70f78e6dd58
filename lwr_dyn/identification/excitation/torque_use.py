"""Torques that a motion needs by the arm's own table and friction, as shares of what it may use."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.codegen.kernels.batch import BatchDynamics, batch_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.excitation.fourier import FourierBasis
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import friction_torque, smooth_friction

STEP, WIDTH = 1e-4, 0.05
"""[rad/s or m/s] Step of the differences of friction by speed, and the speed that smooths its sign in the search."""


@dataclass(frozen=True, slots=True, eq=False)
class TorqueUse:
    """Torques of an arm against `limit` (n,) [N m or N], infinite where it is unknown."""

    arm: Arm
    limit: Array
    dynamics: BatchDynamics

    @classmethod
    def of(cls, arm: Arm, limit: Array) -> "TorqueUse":
        """Raises `MissingDataError`, `MissingPackageError`."""
        arm.require_dynamics()
        return cls(arm, limit, batch_dynamics(arm))

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """(k, n) [N m or N], with the friction that the arm's file gives, none where it gives none."""
        return np.asarray(self.dynamics.inverse_dynamics(q, dq, ddq)) + friction_torque(self.arm.friction_models(), dq)

    def share(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Largest share of its limit that each joint uses, (n,); 0 where the limit is unknown."""
        return np.asarray(np.abs(self.torque(q, dq, ddq)).max(axis=0) / self.limit)

    def room(self, basis: FourierBasis, X: Array) -> Array:
        """1 - |tau| / limit at the instants of a motion, (2, k, j), of both signs and of the joints with a limit."""
        q, dq, ddq = basis.position @ X, basis.speed @ X, basis.acceleration @ X
        tau = self.dynamics.inverse_dynamics(q, dq, ddq) + smooth_friction(self.arm.friction_models(), WIDTH)(dq)
        share = (tau / self.limit)[:, np.isfinite(self.limit)]
        return np.stack([1.0 - share, 1.0 + share])

    def room_gradient(self, basis: FourierBasis, X: Array) -> Array:
        """Its derivative by the coordinates, (2 k j, b n)."""
        q, dq, ddq = basis.position @ X, basis.speed @ X, basis.acceleration @ X
        by = self.dynamics.inverse_dynamics_derivatives(q, dq, ddq)
        friction = smooth_friction(self.arm.friction_models(), WIDTH)
        slope = (friction(dq + STEP) - friction(dq - STEP)) / (2.0 * STEP)
        by_dq = np.asarray(by.by_dq) + slope[:, :, None] * np.eye(self.arm.n)
        known = np.isfinite(self.limit)
        parts = ((by.by_q, basis.position), (by_dq, basis.speed), (by.by_ddq, basis.acceleration))
        rows = sum(np.einsum("kij,kc->kicj", D / self.limit[:, None], P)[:, known] for D, P in parts)
        flat = np.asarray(rows).reshape(-1, X.size)
        return np.vstack([-flat, flat])
