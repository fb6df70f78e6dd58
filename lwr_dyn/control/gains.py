"""Gains of a second-order loop, the damping of an impedance, and a controller near rest as matrices.

The damping gives every mode of (inertia, stiffness) the ratio xi. With B = L L^T and X = L^-1 J^T K^(1/2) (J is 1 in
joint space), the singular values of X are the natural frequencies of the modes. X = A S U^T gives the factorisation of
the effective inertia and of the stiffness that the design asks for, Lambda = (J B^-1 J^T)^-1 = Q Q^T and K = Q S^2 Q^T
with Q = K^(1/2) U S^-1, hence D = 2 xi Q S Q^T; and in the joints

    J^T D = 2 xi L A U^T K^(1/2),   J^T D J = 2 xi L A S A^T L^T,   1 - J^T Jbar^T = L (1 - A A^T) L^-1

without an inverse of J, of Lambda or of S: nothing grows near a singular pose. J^T D J is positive semidefinite
whatever inertia the model has.

References
----------
Albu-Schaeffer, Ott, Frese, Hirzinger, "Cartesian impedance control of redundant robots", ICRA 2003 (double
diagonalisation); Khatib, IEEE J. Robotics and Automation 3 (1987), for Lambda and Jbar = B^-1 J^T Lambda.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg.lapack import dgesdd, dpotrf, dtrtrs

from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, freeze_arrays, real_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm

OMEGA_N, XI = 50.0, 1.0
"""Natural frequency [rad/s] and damping ratio of the LWR 4+ paper."""

NaturalFrequency = Annotated[float, Option(float, "Natural frequency, rad/s.", unless="own_gains")]

DampingRatio = Annotated[float, Option(float, "Damping ratio.", unless="own_gains")]

LARGEST = 1e9
"""[rad/s] No joint moves faster; beyond it gains overflow."""


@dataclass(frozen=True, slots=True, eq=False)
class Gains:
    """Diagonal gains: Kp (n,) [N m/rad], Kd (n,) [N m s/rad], and the loop they belong to."""

    Kp: Array
    Kd: Array
    omega_n: float
    xi: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "Kp", "Kd")


def second_order_gains(inertia: ArrayLike, omega_n: float = OMEGA_N, xi: float = XI) -> Gains:
    """Kp = omega_n^2 b, Kd = 2 xi omega_n b (LWR 4+ paper, before Table VI; Siciliano eq. 8.22).

    Parameters
    ----------
    inertia : (n,) array_like
        Inertia b of each joint [kg m^2]; ones for inverse dynamics, which sees unit masses.
    omega_n : float
        Natural frequency [rad/s].
    xi : float
        Damping ratio.

    Raises
    ------
    ShapeError
        Inertias that are not finite numbers.
    OptionError
        A value that is not positive.

    >>> second_order_gains([2.0], omega_n=10.0).Kp
    array([200.])
    """
    b = real_array("inertia", inertia)
    for name, value in (("omega_n", omega_n), ("xi", xi), ("inertia", float(b.min(initial=1.0)))):
        if not (np.isfinite(value) and value > 0.0):
            raise OptionError(name, value, "a number above 0")
    if max(omega_n, xi) > LARGEST:
        raise OptionError("omega_n, xi", max(omega_n, xi), f"at most {LARGEST:g}")
    return Gains(omega_n**2 * b, 2 * xi * omega_n * b, float(omega_n), float(xi))


def worst_case_gains(arm: Arm, omega_n: float = OMEGA_N, xi: float = XI, inertia: ArrayLike | None = None) -> Gains:
    """`second_order_gains` of the largest inertia that each joint can have over its box (Table IV of the LWR 4+ paper).

    `inertia` (n,) [kg m^2] takes its place. Raises as `second_order_gains` and `worst_case_inertia`.
    """
    second_order_gains([1.0], omega_n, xi)  # refuse bad options before the search
    b = [w.value for w in worst_case_inertias(arm)] if inertia is None else inertia
    return second_order_gains(b, omega_n, xi)


class Modes(NamedTuple):
    """L (n, n), lower; A (n, m), S (m,) [rad/s] from large to small, U^T (m, m), with m = min(n, rows of J).

    A named tuple, since it is made at every sample.
    """

    root: Array
    joint: Array
    frequency: Array
    task: Array


def modes(B: Array, weighted: Array) -> Modes | None:
    """The modes of a mass matrix B (n, n) and `weighted` = J^T K^(1/2) (n, m); None if B is not positive definite."""
    root, fault = dpotrf(B, lower=1, clean=1)
    if fault:
        return None
    reduced = dtrtrs(root, weighted, lower=1)[0]
    joint, frequency, task, fault = dgesdd(reduced, full_matrices=0)
    return None if fault else Modes(root, joint, frequency, task)


def no_torque_known(n: int) -> Array:
    """NaN (n,): the torque where the model has no positive definite B; a run ends there with its `DivergenceError`."""
    return np.full(n, np.nan)


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
