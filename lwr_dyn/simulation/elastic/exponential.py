"""One step of an arm with elastic joints under a held torque: the exponential of the linearised motion.

Exponential Rosenbrock-Euler: with J the slopes of f at the start of the step,

    y(h) = y + h phi_1(h J) f(y),   phi_1(z) = (e^z - 1) / z,

which is exact where the motion is linear: springs and dampers of any stiffness cost and err no more than soft ones.
phi_1 comes out of the exponential of [[J, f], [0, 0]] for an eighth of the step, which is then applied eight times.
What is left, f(y) - f(y_0) - J (y - y_0) on that path, grows with t^2; its effect is added by trapezoids between the
eight nodes, which makes the method one of order 3 for the links' motion. The exponential itself is Taylor's series of
degree 16 and repeated squaring, a third of SciPy's time: terms in blocks of four take six products (Paterson and
Stockmeyer), exact to rounding for norms up to `REACH`; larger matrices are halved until they are there.

`ElasticStep`, `ElasticFlow` and `OneSide` fit it to the loop of rigid joints, which then moves 2n coordinates (q,
theta) under torques (0, tau).

References
----------
M. Hochbruck, A. Ostermann, "Exponential integrators", Acta Numerica 19 (2010), section 2.4.
A. H. Al-Mohy, N. J. Higham, "Computing the action of the matrix exponential", SIAM J. Sci. Comput. 33 (2011), sec. 3.
"""

from dataclasses import dataclass, field
from math import ceil, factorial, log2
from typing import Any

import numpy as np

from lwr_dyn.control.protocol import Controller, JointReadings, WithJointSensors, joint_torque
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.arm_friction import FrictionTorque
from lwr_dyn.simulation.contact import ContactMode
from lwr_dyn.simulation.elastic.plant import ElasticDynamics
from lwr_dyn.simulation.flow import Drive, FastStep, Flow
from lwr_dyn.simulation.loops import Log
from lwr_dyn.simulation.plant import ExternalTorque

REACH = 0.64
"""1-norm up to which 15 terms have a backward error below rounding."""

TERMS = np.array([[1.0 / factorial(4 * block + i) for i in range(4)] for block in range(4)])

LAST = 1.0 / factorial(16)


class MatrixExponential:
    """The exponential of (m, m) matrices; its result is overwritten by the next."""

    def __init__(self, m: int) -> None:
        self._powers = np.zeros((4, m, m))
        self._powers[0] = np.eye(m)
        self._flat = self._powers.reshape(4, m * m)
        self._blocks = np.zeros((4, m, m))
        self._flat_blocks = self._blocks.reshape(4, m * m)
        self._fourth, self._one, self._other = np.zeros((3, m, m))

    def of(self, A: Array) -> Array:
        """e^A; not finite where A is not.

        >>> np.allclose(MatrixExponential(2).of(np.array([[0.0, 3.0], [-3.0, 0.0]]))[0], [np.cos(3), np.sin(3)])
        True
        """
        size = float(np.abs(A).sum(axis=0).max())
        if not size < np.inf:
            return np.full_like(A, np.nan)
        halvings = max(0, ceil(log2(size / REACH))) if size > 0.0 else 0
        powers, fourth, sum_, other, dot = self._powers, self._fourth, self._one, self._other, np.dot
        np.multiply(A, 0.5**halvings, out=powers[1])
        dot(powers[1], powers[1], out=powers[2])
        dot(powers[1], powers[2], out=powers[3])
        dot(powers[2], powers[2], out=fourth)
        dot(TERMS, self._flat, out=self._flat_blocks)
        blocks = self._blocks
        np.multiply(fourth, LAST, out=sum_)
        sum_ += blocks[3]
        for block in (blocks[2], blocks[1], blocks[0]):
            dot(sum_, fourth, out=other)
            other += block
            sum_, other = other, sum_
        for _ in range(halvings):
            dot(sum_, sum_, out=other)
            sum_, other = other, sum_
        return sum_


NODES = 8
"""Parts of a step at whose ends the power of dampers and friction is taken, and turning joints are looked for."""

WEIGHTS = np.array([989, 5888, -928, 10496, -4540, 10496, -928, 5888, 989]) / 28350
"""Newton-Cotes weights of nine nodes, for a step of length 1: they integrate polynomials of degree 9."""

GROWTH = (np.arange(NODES + 1.0)[:, None] / NODES) ** np.array([1.0, 2.0])[:, None, None]
"""Time since the start of a step, as its share, at the nodes, and its square, (2, NODES + 1, 1)."""

EXTERNAL_STEP = 1e-7
"""[rad, rad/s] of the differences for the slopes of an external torque."""

SPEED_STEP = 1e-6
"""[rad/s] of the central difference for the slope of friction over the speed."""


class HeldExponential:
    """Steps of h [s] in a contact mode in which no link rests; motors may.

    Positions count in units of 1 / `w`, the fastest frequency, so that the matrix has few halvings to its exponential.
    `damped` [J] is the work of the dampers in the last step.
    """

    def __init__(
        self,
        model: ElasticDynamics,
        mode: ContactMode,
        h: float,
        substeps: int = 1,
        external: ExternalTorque | None = None,
    ) -> None:
        n2, n = model.n, model.joints
        self._model, self._friction, self._sides = model, mode.friction, mode.sides
        self._couple = getattr(model, "couple", None)  # the slopes of what it leaves out are not in J
        self._h, self._external = h / substeps, external
        self._part = self._h / NODES
        self._exponential = MatrixExponential(2 * n2 + 2)
        self._w, self._A = 0.0, np.zeros((2 * n2 + 2, 2 * n2 + 2))
        self._moving = (~mode.at_rest[n:]).astype(np.float64)
        self._motors = np.zeros((n, 4, n))
        i, rows = np.arange(n), model.motor_slopes() * self._moving
        self._motors[i, :, i] = rows.T
        self._path = np.zeros((NODES + 1, 2 * n2 + 2))
        self._path[0, -1] = 1.0
        self._A[-2, -1] = float(external is not None)  # the entry before the last is time, in parts of the step
        self._moved, self._rates = np.zeros((2, 2 * n2 + 2))
        self._pull = np.zeros_like(self._path)
        self._speeds = np.zeros((substeps, NODES + 1, n2))
        self.damped = 0.0

    def step(self, t: float, now: Array, tau: Array, after: Array) -> tuple[float, ...]:
        """Writes the state `after` (2, 2n) that follows `now` at t under tau (2n,); works as of `HeldStep`."""
        friction_work = external_work = self.damped = 0.0
        state, n2, external = now, self._model.n, self._external
        for i, speeds in enumerate(self._speeds):
            start = t + i * self._h
            self._follow(start, state, tau, speeds)
            self.damped += self._h * float(WEIGHTS @ self._model.damper_power(speeds))
            if self._friction is not None:
                friction_work -= self._h * float(WEIGHTS @ [self._friction(v) @ v for v in speeds])
            if external is not None:
                rows = zip(start + self._part * np.arange(NODES + 1), self._path, speeds, strict=True)
                power = [external(s, state[0] + z[:n2] / self._w, v) @ v for s, z, v in rows]
                external_work += self._h * float(WEIGHTS @ power)
            end = self._path[-1]
            np.add(state[0], end[:n2] / self._w, out=after[0])
            np.add(state[1], end[n2 : 2 * n2], out=after[1])
            state = after
        return (0.0, friction_work) if external is None else (0.0, friction_work, external_work)

    def slowest(self) -> Array:
        """The speed of each coordinate (2n,), at a node of the last step, that is furthest back from its own side."""
        return np.asarray((self._sides * self._speeds).min(axis=(0, 1)) * self._sides)

    def _follow(self, t: float, state: Array, tau: Array, speeds: Array) -> None:
        """The path of a step from `state`, as differences from it, and the speeds (NODES + 1, 2n) along it."""
        model, A, path, d = self._model, self._A, self._path, self._part
        n, n2, (x, dx) = model.joints, model.n, state
        net, slope = self._net(t, x, dx, tau), _slope(self._friction, dx)
        link = A[n2 : n2 + n, : 2 * n2]
        model.link_rows(x, dx, net, link, self._external_slopes(t, x, dx))
        if self._w == 0.0:
            self._choose_unit(link)
        link[:, :n2] *= d / self._w
        link[:, n2:] *= d
        if self._couple is not None:
            self._write_motors()
        if slope is not None:
            i = np.arange(n)
            A[n2 + n + i, n2 + n + i] = d * (self._motors[i, 3, i] - self._moving * slope[n:] / model.rotor)
        A[:n2, -1] = (d * self._w) * dx
        A[n2 : 2 * n2, -1] = d * model.forward_dynamics(x, dx, net)
        if self._couple is not None:
            self._couple(x, A[n2 : 2 * n2, : 2 * n2])
        if self._external is not None:
            later = d * model.forward_dynamics(x, dx, self._net(t + d, x, dx, tau))
            A[n2 : 2 * n2, -2] = later - A[n2 : 2 * n2, -1]
        A[n2 + n : 2 * n2, -2:] *= self._moving[:, None]
        part = self._exponential.of(A)
        for k in range(NODES):
            np.dot(part, path[k], out=path[k + 1])
        self._correct(t, state, tau, part)
        np.add(path[:, n2 : 2 * n2], dx, out=speeds)

    def _correct(self, t: float, state: Array, tau: Array, part: Array) -> None:
        """Adds what the linearised motion leaves out, as it is seen at the nodes of its own path.

        It grows with the square of time; where J has not all slopes, or an external torque has a kink, also with time.
        """
        pull, last = self._pull, self._left_out(t, state, tau, NODES)
        if self._external is None and self._couple is None:
            np.multiply(GROWTH[1], last, out=pull)
        else:
            half = self._left_out(t, state, tau, NODES // 2)
            np.add(GROWTH[0] * (4.0 * half - last), GROWTH[1] * (2.0 * last - 4.0 * half), out=pull)
        bend = pull.copy()
        for k in range(1, NODES):  # trapezoids between the nodes
            np.dot(part, pull[k], out=self._moved)
            pull[k + 1] += self._moved
        pull -= 0.5 * bend
        self._path += pull

    def _left_out(self, t: float, state: Array, tau: Array, node: int) -> Array:
        """The rates (4n + 2,) at a node of the path less those of the linearised motion, times a part of the step."""
        model, z, rates = self._model, self._path[node], self._rates
        n2 = model.n
        rows = slice(n2, 2 * n2)
        x, dx = state[0] + z[:n2] / self._w, state[1] + z[n2 : 2 * n2]
        rates[rows] = self._part * model.forward_dynamics(x, dx, self._net(t + node * self._part, x, dx, tau))
        rates[n2 + model.joints : 2 * n2] *= self._moving
        rates[rows] -= self._A[rows] @ z
        return rates.copy()

    def _external_slopes(self, t: float, x: Array, dx: Array) -> Array | None:
        """Of the external torque over (q, theta, dq, dtheta), (n, 4n), by differences; None where nothing acts."""
        external, n = self._external, self._model.joints
        here = None if external is None else external(t, x, dx)[:n]
        if external is None or here is None or not here.any():
            return None
        step, out = EXTERNAL_STEP * np.eye(2 * n), np.zeros((n, 4 * n))
        for j in range(n):
            out[:, j] = (external(t, x + step[j], dx)[:n] - here) / EXTERNAL_STEP
            out[:, 2 * n + j] = (external(t, x, dx + step[j])[:n] - here) / EXTERNAL_STEP
        return out

    def _net(self, t: float, x: Array, dx: Array, tau: Array) -> Array:
        net = tau if self._friction is None else tau - self._friction(dx)
        return net if self._external is None else net + self._external(t, x, dx)

    def _choose_unit(self, link: Array) -> None:
        """`w`, and with it what stays in the matrix: speeds over positions, and the rows of the motors."""
        n2, d = self._model.n, self._part
        fastest = max(np.abs(link[:, :n2]).max(), np.abs(self._motors[:, :2]).max())
        self._w = w = float(2.0 ** np.round(np.log2(np.sqrt(fastest))))
        self._A[:n2, n2 : 2 * n2] = d * w * np.eye(n2)
        self._write_motors()

    def _write_motors(self) -> None:
        n, n2, d, w = self._model.joints, self._model.n, self._part, self._w
        rows = self._A[n2 + n : 2 * n2, : 2 * n2].reshape(n, 4, n)
        rows[:, :2], rows[:, 2:] = d / w * self._motors[:, :2], d * self._motors[:, 2:]


def _slope(friction: FrictionTorque | None, dx: Array) -> Array | None:
    """The slope of friction over the speed, of each coordinate by its own (2n,); None without friction."""
    if friction is None:
        return None
    return np.asarray((friction(dx + SPEED_STEP) - friction(dx - SPEED_STEP)) / (2 * SPEED_STEP))


@dataclass(slots=True, eq=False)
class ElasticFlow(Flow):
    """A flow that also sums the work of the dampers, step by step [J]."""

    damped: list[float] = field(default_factory=list)

    def advance(self, drive: Drive, t: float, y: Array, h: float) -> Array:
        """y(t + h), with every event in between."""
        model: Any = self.plant.dynamics

        def with_dampers(t: float, x: Array, dx: Array, memory: Array) -> tuple[Array, Array]:
            return drive(t, x, dx, memory)[0], model.damper_power(dx)[None]

        after = Flow.advance(self, with_dampers, t, np.append(y, 0.0), h)
        self.damped.append(float(after[-1]))
        return after[:-1]


class ElasticStep(FastStep):
    """The usual step by the exponential of the linearised motion.

    Where a link rests, or a motor of the full model, `Flow` takes it.
    """

    def take(self, t: float, now: Array, tau: Array, after: Array) -> bool:
        """As `FastStep.take`; the work of the dampers goes to the flow."""
        flow: Any = self._flow
        n = flow.plant.arm.n
        resting = flow.mode.at_rest if flow.plant.model.rotors == "full" else flow.mode.at_rest[:n]
        if resting.any() or not FastStep.take(self, t, now, tau, after):
            return False
        flow.damped.append(self._held.damped)
        return True

    def _adopt(self, mode: ContactMode) -> None:
        FastStep._adopt(self, mode)
        model: Any = mode.plant.dynamics
        held = self._held = HeldExponential(model, mode, self._h, self._substeps, self._flow.external)
        self._own, self._step, self._tangent = None, held.step, held.slowest


class OneSide:
    """A controller of n joints on 2n coordinates: it is given one side's positions, and senses both."""

    def __init__(self, controller: Controller, model: ElasticDynamics, encoders: str, log: Log) -> None:
        n = model.joints
        self._controller, self._model, self._log = controller, model, log
        self._side = slice(n, None) if encoders == "motor" else slice(0, n)
        self._sense = controller.sense if isinstance(controller, WithJointSensors) else None

    def __call__(self, t: float, x: Array, dx: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """(0, tau), (2n,)."""
        n, k = self._model.joints, self._log.done
        name = f"torque of the controller at sample {k}"
        if self._sense is not None:
            torque = self._model.gear_torque(*self._log.states[k])
            self._sense(JointReadings(x[n:], dx[n:], x[:n], dx[:n], torque))
        out = np.zeros(2 * n)
        out[n:] = joint_torque(name, self._controller(t, x[self._side], dx[self._side], q_ref, dq_ref, ddq_ref), n)
        return out

    def __getattr__(self, name: str) -> Any:
        """The `signals` of the controller, if it has any; what else it has is not for the loop."""
        if name != "signals":
            raise AttributeError(name)
        return self._controller.signals  # type: ignore[attr-defined] # raises where there are none
