"""A controller near rest as matrices, from which the stability of its sampled loop follows."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array

STEP = 1e-4
"""[rad or m] of the central differences of g: truncation and rounding both stay below 1e-8 of dg/dq."""


@dataclass(frozen=True, slots=True, eq=False)
class LinearFeedback:
    """tau = g(q) - position x - velocity v - torque tau_J + I, dI/dt = -integral x, near rest at k poses q_0.

    Small deviations are x = q - q_0, v = dq, and the torque tau_J that joint sensors read. `position` (k, n, n)
    [N m/rad], `velocity` (k, n, n) [N m s/rad]; `integral` (n,) or (k, n, n) [N m/(rad s)] and `torque` (k, n, n), None
    without; `gravity` is the model whose g(q) the controller adds, None where it adds a constant or nothing.
    With `motor`, x and v are read on the motor side of elastic joints, whatever the arm's encoders are.
    """

    position: Array
    velocity: Array
    integral: Array | None = None
    gravity: Dynamics | None = None
    torque: Array | None = None
    motor: bool = False


@runtime_checkable
class Linearised(Protocol):
    """A controller that gives its own linear form."""

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """The controller near rest at each of the poses q (k, n) [rad or m]."""


def gravity_stiffness(dynamics: Dynamics, q: Array) -> Array:
    """dg/dq (k, n, n) [N m/rad] at the poses q (k, n): column j is dg/dq_j, by central differences.

    >>> import lwr_dyn
    >>> dynamics = lwr_dyn.dynamics_of(lwr_dyn.load("lwr4plus"))
    >>> upright = gravity_stiffness(dynamics, np.zeros((1, 7)))[0]
    >>> bool(upright[1, 1] < 0)  # the upright arm falls
    True
    """
    step = STEP * np.eye(q.shape[-1])
    ahead, behind = (dynamics.gravity_vector(q[..., None, :] + side * step) for side in (1.0, -1.0))
    return np.asarray(np.swapaxes((ahead - behind) / (2 * STEP), -1, -2))


def diagonal(gains: Array, poses: int) -> Array:
    """Gains (n,) of single joints as matrices (k, n, n)."""
    return np.broadcast_to(np.diag(gains), (poses, gains.size, gains.size))
