"""The sampled loop at rest as a linear map from one sample to the next, and the spectral radius of that map.

Near rest the plant is dz/dt = A z + B u (`RestingPlant`); u is held over a sample T, so the step is exact (zero-order
hold). The controller is its `LinearFeedback`. The loop is stable where every eigenvalue of the map lies within the unit
circle. Speeds (C dq), friction, limits of torque and stops are left out: a moving arm is not at rest, and dry friction
hides a weak instability. With the damping alone, and g compensated exactly, the limit of a rigid arm is
T lambda_max(B^-1 Kd) = 2.

References
----------
Astrom, Wittenmark, *Computer-Controlled Systems*, section 3.2 (zero-order hold, delays that are no whole samples).
"""

from dataclasses import dataclass, replace
from math import exp, isfinite, pi
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.control.linear_feedback import LinearFeedback, Linearised, gravity_stiffness
from lwr_dyn.design.resting_plant import RestingPlant, rigid_plant
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.simulation.options import MOST_DELAY

GROWS = 1.0 + 1e-6
"""A spectral radius above it counts as unstable; rounding moves a double eigenvalue at 1 by about 1e-8."""


BLOCK = 4_000_000
"""Entries of the step matrices that are held at once; with what they are built from about 200 MB."""


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

    @property
    def filter_pole(self) -> float:
        """Of the velocity filter, exp(-2 pi f_c T); 0 where speeds are not filtered."""
        return 0.0 if self.cutoff_hz is None else exp(-2 * pi * self.cutoff_hz / self.rate)


@dataclass(frozen=True, slots=True, eq=False)
class RestingLoop:
    """A plant and its controller near rest at k poses.

    In `feedback.position` the gravity that the controller compensates is taken off already.
    """

    plant: RestingPlant
    feedback: LinearFeedback

    @classmethod
    def of(cls, dynamics: Dynamics, controller: Linearised, q: Array) -> Self:
        """The loop of a rigid arm at the poses q (k, n); `dynamics` are the plant's.

        Raises `OptionError` where the mass matrix of the plant is singular.
        """
        return cls.of_plant(rigid_plant(dynamics, q), controller.linear_feedback(q), q)

    @classmethod
    def of_plant(cls, plant: RestingPlant, law: LinearFeedback, q: Array) -> Self:
        """The loop of any plant at the poses q (k, n), and of `law` there.

        A law of the motor side takes the torque of a rigid joint for that of its sensor.
        """
        if law.gravity is not None:
            law = replace(law, position=law.position - gravity_stiffness(law.gravity, q), gravity=None)
        if law.torque is not None and law.motor and plant.torque is None:  # tau_J = u: solved for u
            solve = np.linalg.inv(np.eye(plant.n) + law.torque)
            law = replace(law, position=solve @ law.position, velocity=solve @ law.velocity, torque=None)
        return cls(plant, law)

    def at(self, rows: NDArray[np.signedinteger[Any]]) -> Self:
        """The loop at some of its poses."""
        law = self.feedback
        torque = None if law.torque is None else law.torque[rows]
        integral = law.integral if law.integral is None or law.integral.ndim == 1 else law.integral[rows]
        part = LinearFeedback(law.position[rows], law.velocity[rows], integral, law.gravity, torque, law.motor)
        return type(self)(self.plant.at(rows), part)

    def damping_rates(self) -> Array:
        """The largest |lambda| at each pose, (k,) [1/s], of what the damping does to the speeds: B^-1 `velocity`."""
        speeds = self.plant.velocity @ self.plant.B @ self.feedback.velocity
        return np.asarray(np.abs(np.linalg.eigvals(speeds)).max(axis=-1))

    def step_matrices(self, sampling: Sampling, late: float = 0.0, scale: Array | float = 1.0) -> Array:
        """The map from one sample to the next at each pose, (k, N', N'), on the state of `open_loop`.

        Parameters
        ----------
        sampling : Sampling
        late : float
            [s] A delay beside that of `sampling`, at least 0 and below a sample.
        scale : float, (n,) or (k, n) array
            Factor on the torque of each joint, 1 for the loop as it is.
        """
        step, entry, command = self.open_loop(sampling, late)
        k, n = command.shape[:2]
        return step + entry @ (np.broadcast_to(scale, (k, n))[:, :, None] * command)

    def open_loop(self, sampling: Sampling, late: float = 0.0) -> tuple[Array, Array, Array]:
        """The loop cut where the controller's torques u (n,) leave it: s -> A s + B u, and u = C s closes it.

        The state s is that of the plant; then the integral I, where there is one; position and filtered speed of the
        last sample, where speeds are filtered; and the commands that are on their way, newest first.

        Returns
        -------
        A, B, C : (k, N', N'), (k, N', n) and (k, n, N') arrays
        """
        k, N, n = self.plant.B.shape
        law, T, plant = self.feedback, 1.0 / sampling.rate, self.plant
        integral, filtered = law.integral is not None, sampling.cutoff_hz is not None
        applied = law.torque is not None and plant.torque is None  # the sensor reads the torque applied last
        kept = sampling.delay + (late > 0.0 or applied)
        first = N + n * (integral + 2 * filtered)  # of the commands on their way
        size, one = first + n * kept, np.eye(n)
        Z, I = slice(0, N), slice(N, N + n)  # noqa: E741
        step, entry, speed = np.zeros((k, size, size)), np.zeros((k, size, n)), np.zeros((n, size))
        if filtered:
            last_x, last_v = slice(first - 2 * n, first - n), slice(first - n, first)
            pole = sampling.filter_pole
            speed[:, Z], speed[:, last_x] = (1 - pole) / T * plant.position, (pole - 1) / T * one
            speed[:, last_v] = pole * one
            step[:, last_x, Z], step[:, last_v] = plant.position, speed
        else:
            speed[:, Z] = plant.velocity
        sent = [np.eye(n, size, first + n * i) for i in range(kept)]
        command = -(law.velocity @ speed)
        command[:, :, Z] -= law.position @ plant.position
        if law.torque is not None:
            read = sent[-1] if plant.torque is None else np.pad(plant.torque, ((0, 0), (0, 0), (0, size - N)))
            command -= law.torque @ read
        if law.integral is not None:
            integral_matrix = np.diag(law.integral) if law.integral.ndim == 1 else law.integral
            command[:, :, I] += one
            step[:, I, I], step[:, I, Z] = one, -T * integral_matrix @ plant.position
        if kept:
            entry[:, first : first + n] = one
            step[:, first + n :, first : size - n] = np.eye(size - n - first)
        A, b = plant.held(T - late)
        if sampling.delay:
            step[:, Z] += b @ sent[sampling.delay - 1]
        else:
            entry[:, Z] = b
        if late > 0.0:  # u[k - d - 1] acts for `late`, then u[k - d]
            A_late, b_late = plant.held(late)
            step[:, Z] += A @ b_late @ sent[-1]
            A = A @ A_late
        step[:, Z, Z] += A
        return step, entry, command

    def radius(self, sampling: Sampling, late: float = 0.0, scale: Array | float = 1.0) -> Array:
        """The spectral radius of each step, (k,): small deviations grow by it at each sample; inf past all numbers."""
        k, n = self.plant.B.shape[0], self.plant.n
        states = self.plant.B.shape[1] + n * (sampling.delay + 4)  # at most
        scales = np.broadcast_to(scale, (k, n))
        out = np.full(k, np.inf)
        count = max(1, BLOCK // states**2)
        for rows in (np.arange(i, min(i + count, k)) for i in range(0, k, count)):
            with np.errstate(over="ignore", invalid="ignore"):
                steps = self.at(rows).step_matrices(sampling, late, scales[rows])
            finite = np.isfinite(steps).all(axis=(-1, -2))
            out[rows[finite]] = np.abs(np.linalg.eigvals(steps[finite])).max(axis=-1)
        return out
