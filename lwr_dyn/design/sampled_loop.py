"""The sampled loop at rest as a linear map from one sample to the next, and the spectral radius of that map.

Near rest at q_0 the plant is B ddx + G dx = u with G = dg/dq, both at q_0; u is held over a sample T, so the step is
exact (zero-order hold). The controller is its `LinearFeedback`. The loop is stable where every eigenvalue of the map
lies within the unit circle. Speeds (C dq), friction, limits of torque and stops are left out: a moving arm is not at
rest, and dry friction hides a weak instability. With the damping alone, and g compensated exactly, the limit is
T lambda_max(B^-1 Kd) = 2.

References
----------
Astrom, Wittenmark, *Computer-Controlled Systems*, section 3.2 (zero-order hold, delay by more states).
"""

from dataclasses import dataclass, replace
from math import exp, isfinite, pi
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array
from lwr_dyn.control.linear_feedback import LinearFeedback, Linearised, gravity_stiffness
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.errors import OptionError
from lwr_dyn.simulation.options import MOST_DELAY

GROWS = 1.0 + 1e-6
"""A spectral radius above it counts as unstable; rounding moves a double eigenvalue at 1 by about 1e-8."""
TERMS = 9
"""Of the series below: for |Z| <= 1/2 the next one is under 1e-18."""


@dataclass(frozen=True, slots=True)
class Sampling:
    """How a controller is sampled: `rate` [Hz], `delay` in whole samples, cut-off of a velocity filter [Hz] if any.

    A torque computed from sample k acts from sample k + delay on.

    Raises
    ------
    OptionError
        A rate that is not positive, a delay that is not a whole number from 0 to `MOST_DELAY`.
    """

    rate: float = 1000.0
    delay: int = 0
    cutoff_hz: float | None = None

    def __post_init__(self) -> None:
        if not (isfinite(self.rate) and self.rate > 0.0):
            raise OptionError("rate", self.rate, "a number above 0")
        if not (isinstance(self.delay, int) and 0 <= self.delay <= MOST_DELAY):
            raise OptionError("delay", self.delay, f"a whole number of samples from 0 to {MOST_DELAY}")


def held_step(W: Array, T: float) -> tuple[Array, Array]:
    """The exact step over T [s] of ddx = W x + a with a held, for W (k, n, n): (x, v) -> A (x, v) + b a.

    With Z = W T^2: A = [[c, T s], [Z s / T, c]] and b = [T^2 e, T s], where c, s, e are the sums of Z^j / (2j)!,
    Z^j / (2j + 1)! and Z^j / (2j + 2)!. Where Z is large the step is made of halves.

    Returns
    -------
    A : (k, 2n, 2n) array
    b : (k, 2n, n) array

    >>> A, b = held_step(np.zeros((1, 1, 1)), 0.5)
    >>> A[0].tolist(), b[0].ravel().tolist()
    ([[1.0, 0.5], [0.0, 1.0]], [0.125, 0.5])
    """
    size = T * T * float(np.abs(W).sum(axis=-1).max(initial=0.0))
    halvings = max(0, int(np.ceil(np.log2(max(size, 0.5) / 0.5) / 2)))
    h = T / 2**halvings
    Z, one = W * (h * h), np.eye(W.shape[-1])
    c, s, e = one + 0 * Z, one + 0 * Z, one / 2 + 0 * Z
    power, factorial = np.broadcast_to(one, Z.shape), 1.0
    for j in range(1, TERMS):
        power, factorial = power @ Z, factorial * (2 * j - 1) * (2 * j)
        c, s, e = (
            c + power / factorial,
            s + power / (factorial * (2 * j + 1)),
            e + power / (factorial * (2 * j + 1) * (2 * j + 2)),
        )
    A = np.block([[c, h * s], [Z @ s / h, c]])
    b = np.concatenate([h * h * e, h * s], axis=-2)
    for _ in range(halvings):
        A, b = A @ A, A @ b + b
    return A, b


@dataclass(frozen=True, slots=True, eq=False)
class RestingLoop:
    """A plant and its controller near rest at k poses: B^-1 and B^-1 G (k, n, n), and the controller's matrices.

    In `feedback.position` the gravity that the controller compensates is taken off already.
    """

    inverse_inertia: Array
    stiffness: Array
    feedback: LinearFeedback

    @classmethod
    def of(cls, dynamics: Dynamics, controller: Linearised, q: Array) -> Self:
        """The loop at the poses q (k, n); `dynamics` are the plant's.

        Raises `OptionError` where the mass matrix of the plant is singular.
        """
        try:
            inverse = np.asarray(np.linalg.inv(dynamics.mass_matrix(q)), dtype=np.float64)
        except np.linalg.LinAlgError:
            raise OptionError("mass matrix", "singular", "an arm with inertia at every joint") from None
        law, stiffness = controller.linear_feedback(q), gravity_stiffness(dynamics, q)
        if law.gravity is not None:
            compensated = stiffness if law.gravity is dynamics else gravity_stiffness(law.gravity, q)
            law = replace(law, position=law.position - compensated, gravity=None)
        return cls(inverse, inverse @ stiffness, law)

    def at(self, rows: NDArray[np.signedinteger[Any]]) -> Self:
        """The loop at some of its poses."""
        law = self.feedback
        part = LinearFeedback(law.position[rows], law.velocity[rows], law.integral)
        return type(self)(self.inverse_inertia[rows], self.stiffness[rows], part)

    def damping_rates(self) -> Array:
        """The largest |lambda| of B^-1 `velocity` at each pose, (k,) [1/s]."""
        return np.asarray(np.abs(np.linalg.eigvals(self.inverse_inertia @ self.feedback.velocity)).max(axis=-1))

    def step_matrices(self, sampling: Sampling) -> Array:
        """The map from one sample to the next at each pose, (k, N, N).

        The state is x, v; then the integral I, where there is one; x and the filtered speed of the last sample, where
        speeds are filtered; and the commands that are on their way, newest first.
        """
        k, n, _ = self.stiffness.shape
        law, T = self.feedback, 1.0 / sampling.rate
        A, b = held_step(-self.stiffness, T)
        integral, filtered = law.integral is not None, sampling.cutoff_hz is not None
        first = n * (2 + integral + 2 * filtered)  # of the commands on their way
        size = first + n * sampling.delay
        X, V, I = slice(0, n), slice(n, 2 * n), slice(2 * n, 3 * n)  # noqa: E741
        step, one = np.zeros((k, size, size)), np.eye(n)
        speed = np.zeros((n, size))  # the measured speed, from the state
        if filtered:
            last_x, last_v = slice(first - 2 * n, first - n), slice(first - n, first)
            pole = exp(-2 * pi * float(sampling.cutoff_hz or 0.0) * T)
            speed[:, X], speed[:, last_x], speed[:, last_v] = (1 - pole) / T * one, (pole - 1) / T * one, pole * one
            step[:, last_x, X], step[:, last_v] = one, speed
        else:
            speed[:, V] = one
        command = -(law.velocity @ speed)
        command[:, :, X] -= law.position
        if law.integral is not None:
            command[:, :, I] = one
            step[:, I, I], step[:, I, X] = one, -T * np.diag(law.integral)
        arriving = command
        if sampling.delay:
            arriving = np.zeros((n, size))
            arriving[:, size - n :] = one
            step[:, first : first + n] = command
            step[:, first + n :, first : size - n] = np.eye(size - n - first)
        step[:, : 2 * n, : 2 * n] += A
        step[:, : 2 * n] += b @ (self.inverse_inertia @ arriving)
        return step

    def radius(self, sampling: Sampling) -> Array:
        """The spectral radius of each step, (k,): small deviations grow by it at each sample."""
        with np.errstate(over="ignore", invalid="ignore"):
            steps = self.step_matrices(sampling)
        finite = np.isfinite(steps).all(axis=(-1, -2))
        out = np.full(len(steps), np.inf)
        out[finite] = np.abs(np.linalg.eigvals(steps[finite])).max(axis=-1)
        return out
