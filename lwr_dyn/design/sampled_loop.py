"""The sampled loop at rest as a linear map from one sample to the next, and the spectral radius of that map.

Near rest the plant is dz/dt = A z + B u (`RestingPlant`); u is held over a sample T, so the step is exact (zero-order
hold). The controller is its `LinearFeedback`, or of one without memory the central differences of its torque. The loop
is stable where every eigenvalue of the map lies within the unit circle. Speeds (C dq), friction, limits of torque and
stops are left out: a moving arm is not at rest, and dry friction hides a weak instability. With the damping alone, and
g compensated exactly, the limit of a rigid arm is T lambda_max(B^-1 Kd) = 2.

References
----------
Astrom, Wittenmark, *Computer-Controlled Systems*, section 3.2 (zero-order hold, delays that are no whole samples).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import exp, isfinite, pi
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from lwr_dyn.control.gains import LinearFeedback, Linearised, gravity_stiffness
from lwr_dyn.control.protocol import Controller, WithMemory, label_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.simulation.setup import MOST_DELAY


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
    stiffness : Dynamics and (k, n, n) array, optional
        What dg/dq was computed with, and dg/dq [N m/rad], where the joints stand at the poses that a law reads.
    """

    A: Array
    B: Array
    position: Array
    velocity: Array
    torque: Array | None = None
    stiffness: tuple[Dynamics, Array] | None = None

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
        stiffness = None if self.stiffness is None else (self.stiffness[0], self.stiffness[1][rows])
        return type(self)(self.A[rows], self.B[rows], self.position, self.velocity, torque, stiffness)

    def stiffness_of(self, dynamics: Dynamics, q: Array) -> Array:
        """dg/dq (k, n, n) of a law's model at the poses q (k, n) that it reads: the plant's own where they are one."""
        if self.stiffness is not None and self.stiffness[0] is dynamics:
            return self.stiffness[1]
        return gravity_stiffness(dynamics, q)

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
    G = gravity_stiffness(dynamics, q)
    A[:, :n, n:], A[:, n:, :n], B[:, n:] = np.eye(n), -inverse @ G, inverse
    return RestingPlant(A, B, np.eye(n, 2 * n), np.eye(n, 2 * n, n), stiffness=(dynamics, G))


STEP = 1e-4
"""[rad, m; rad/s, m/s] of the differences."""

SAME = 1e-9
"""Of the largest torque: by less, two calls at one state agree."""

BENDS = 0.02
"""A slope that differs by more from one side to the other belongs to a law that is not smooth at rest."""


@dataclass(frozen=True, slots=True, eq=False)
class LawAtRest:
    """A controller near rest: its matrices, and where they come from.

    `bend` is by how much the slopes of the two sides differ, as a share of the largest slope; 0 for a law that gives
    its own linear form.
    """

    feedback: LinearFeedback
    by_differences: bool = False
    bend: float = 0.0

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of the linear form, in words; empty for a law that gives its own."""
        if not self.by_differences:
            return ()
        lines = ["the controller has no linear_feedback(q): linearised by central differences of its torque at rest"]
        if self.bend > BENDS:
            lines.append(
                f"its torque is not smooth at rest: slopes of the two sides differ by {100 * self.bend:.2g} %,"
                " and the linear results hold for none of them"
            )
        return tuple(lines)


def law_at_rest(controller: Controller, q: Array) -> LawAtRest:
    """The linear form of a controller at the poses q (k, n): its own, or by differences.

    The reference stands still at each pose; only what the torque makes of the measured position and speed counts.
    Raises `OptionError`: a controller that remembers between calls and has no linear form, or whose torques are not n
    finite numbers.
    """
    if isinstance(controller, Linearised):
        return LawAtRest(controller.linear_feedback(q))
    _refuse_memory(controller, q[0])
    k, n = q.shape
    slopes, bend, largest = np.zeros((k, n, 2 * n)), 0.0, 0.0
    for i, pose in enumerate(q):
        torque = _torque_near(controller, pose)
        middle = torque(np.zeros(2 * n))
        for j, offset in enumerate(STEP * np.eye(2 * n)):
            ahead, behind = torque(offset), torque(-offset)
            slopes[i, :, j] = (ahead - behind) / (2 * STEP)
            bend = max(bend, float(np.abs(ahead + behind - 2 * middle).max()) / STEP)
        largest = max(largest, float(np.abs(slopes[i]).max()))
    share = bend / largest if largest > 0.0 else 0.0
    return LawAtRest(LinearFeedback(-slopes[:, :, :n], -slopes[:, :, n:]), True, share)


def _torque_near(controller: Controller, pose: Array) -> Callable[[Array], Array]:
    """Torque (n,) at a small deviation (2n,) of position and speed from a pose; raises `OptionError`."""
    n, zero = pose.size, np.zeros(pose.size)

    def torque(z: Array) -> Array:
        answer: Any = controller(0.0, pose + z[:n], z[n:].copy(), pose.copy(), zero.copy(), zero.copy())
        tau = np.asarray(answer, dtype=np.float64)
        if tau.shape != (n,) or not np.isfinite(tau).all():
            found = f"shape {tau.shape}" if tau.shape != (n,) else "a number that is not finite"
            raise OptionError(f"torque of {label_of(controller)}", found, f"{n} finite numbers")
        return tau.copy()

    return torque


def _refuse_memory(controller: Controller, pose: Array) -> None:
    """Raise `OptionError` for a controller that says, or shows, that it remembers between calls."""
    said = isinstance(controller, WithMemory) or hasattr(controller, "reset")
    if not said:
        torque, away = _torque_near(controller, pose), np.full(2 * pose.size, 10 * STEP)
        first, _, again = torque(away), torque(-2 * away), torque(away)
        said = bool(np.abs(again - first).max() > SAME * max(1.0, float(np.abs(first).max())))
    if said:
        raise OptionError(
            f"controller {label_of(controller)}", "remembers between calls and has no linear_feedback(q)",
            "a controller without memory, or with linear_feedback(q)",
        )  # fmt: skip


GROWS = 1.0 + 1e-6
"""A spectral radius above it counts as unstable; rounding moves a double eigenvalue at 1 by about 1e-8."""

BLOCK = 4_000_000
"""Entries of the step matrices that are held at once; with what they are built from about 200 MB."""


@dataclass(frozen=True, slots=True)
class Sampling:
    """How a controller is sampled: `rate` [Hz], `delay` in whole samples, cut-off of a velocity filter [Hz] if any.

    A torque computed from sample k acts from sample k + delay on. Raises `OptionError`: a rate that is not positive, a
    delay that is not a whole number from 0 to `MOST_DELAY`.
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
            law = replace(law, position=law.position - plant.stiffness_of(law.gravity, q), gravity=None)
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
