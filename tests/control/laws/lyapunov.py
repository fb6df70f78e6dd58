"""Lyapunov functions of the adaptive and the robust law, from the true B, C and g of road B."""

from dataclasses import dataclass

import numpy as np

import lwr_dyn
from lwr_dyn.control.laws.adaptive import SlotineLiRegressor
from lwr_dyn.model.arm import arm_with_payload

ARM = lwr_dyn.load("lwr4plus", reading="physical")
LOAD = arm_with_payload(ARM, 3.0, [0.02, -0.03, 0.05], np.diag([0.02, 0.03, 0.025]))
"""What the laws do not know."""
RNG = np.random.default_rng(11)
STATES = np.concatenate([RNG.uniform(-1.5, 1.5, (12, 1, 7)), RNG.uniform(-0.5, 0.5, (12, 4, 7))], axis=1)
STATES[:, 2] = STATES[:, 0] + 0.01 * STATES[:, 2]  # q_ref near q


def missing_load(arm=ARM, loaded=LOAD):
    """The parameters (10,) that the law would have to find."""
    return (SlotineLiRegressor(loaded).parameters - SlotineLiRegressor(arm).parameters)[-10:]


@dataclass(frozen=True, slots=True, eq=False)
class Instant:
    """A state with its reference as the laws combine them, and the true dynamics there."""

    s: np.ndarray
    dq_r: np.ndarray
    damping: float
    surplus: np.ndarray  # B ddq_r + C dq_r + g, what a perfect law would give without damping

    @classmethod
    def of(cls, dynamics, omega_n, q, dq, q_ref, dq_ref, ddq_ref):
        """At a state (n,) with its reference."""
        dq_r = dq_ref + omega_n * (q_ref - q)
        ddq_r, s = ddq_ref + omega_n * (dq_ref - dq), dq - dq_r
        B, C, g = dynamics.mass_matrix(q), dynamics.coriolis_matrix(q, dq), dynamics.gravity_vector(q)
        return cls(s, dq_r, omega_n * s @ B @ s, B @ ddq_r + C @ dq_r + g)

    def power(self, tau):
        """d/dt (s^T B s / 2) under the torque tau (n,): dB/dt - 2 C is skew, so that only this is left."""
        return self.s @ (tau - self.surplus)
