"""A plant near rest as matrices: dz/dt = A z + B u, and what its sensors read; its exact step with u held."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from lwr_dyn.control.linear_feedback import gravity_stiffness
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError


@dataclass(frozen=True, slots=True, eq=False)
class RestingPlant:
    """dz/dt = A z + B u near rest at k poses; z are deviations, u (n,) the deviation of the motors' torque [N m].

    A controller reads `position @ z` and `velocity @ z`, and `torque @ z` where a sensor stands in the joint. Without
    one (a rigid arm) the torque of a joint is the one that was applied last.

    Parameters
    ----------
    A : (k, N, N) array
    B : (k, N, n) array
    position, velocity : (n, N) array
        What the encoders read [rad, rad/s].
    torque : (k, n, N) array, optional
        What the torque sensors read [N m].
    """

    A: Array
    B: Array
    position: Array
    velocity: Array
    torque: Array | None = None

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.B.shape[-1])

    @property
    def size(self) -> int:
        """Length N of the state."""
        return int(self.A.shape[-1])

    def at(self, rows: NDArray[np.signedinteger[Any]]) -> Self:
        """The plant at some of its poses."""
        torque = None if self.torque is None else self.torque[rows]
        return type(self)(self.A[rows], self.B[rows], self.position, self.velocity, torque)

    def held(self, T: float) -> tuple[Array, Array]:
        """The exact step over T [s] with u held: z -> Ad z + Bd u, (k, N, N) and (k, N, n), by one exponential.

        >>> mass = RestingPlant(np.array([[[0.0, 1.0], [0.0, 0.0]]]), np.array([[[0.0], [1.0]]]), *np.eye(2)[:, None])
        >>> Ad, Bd = mass.held(0.5)
        >>> Ad[0].tolist(), Bd[0].ravel().tolist()
        ([[1.0, 0.5], [0.0, 1.0]], [0.125, 0.5])
        """
        k, N, n = self.B.shape
        whole = np.zeros((k, N + n, N + n))
        whole[:, :N, :N], whole[:, :N, N:] = self.A * T, self.B * T
        step = np.asarray(expm(whole), dtype=np.float64)
        return step[:, :N, :N], step[:, :N, N:]


def rigid_plant(dynamics: Dynamics, q: Array) -> RestingPlant:
    """The rigid arm near rest at the poses q (k, n), z = (x, v): B dv + G x = u with G = dg/dq.

    Raises `OptionError` where the mass matrix is singular.
    """
    try:
        inverse = np.asarray(np.linalg.inv(dynamics.mass_matrix(q)), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise OptionError("mass matrix", "singular", "an arm with inertia at every joint") from None
    k, n = q.shape
    A, B = np.zeros((k, 2 * n, 2 * n)), np.zeros((k, 2 * n, n))
    A[:, :n, n:], A[:, n:, :n], B[:, n:] = np.eye(n), -inverse @ gravity_stiffness(dynamics, q), inverse
    return RestingPlant(A, B, np.eye(n, 2 * n), np.eye(n, 2 * n, n))
