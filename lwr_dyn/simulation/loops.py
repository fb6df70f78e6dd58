"""The loops themselves: one for sampled controllers, with a fast way for the usual step, and one for continuous ones.

Both fill a `Log` and raise `Blowup` where the state leaves what can be followed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.control.protocol import Controller, WithMemory
from lwr_dyn.errors import ShapeError
from lwr_dyn.model.run import Reference
from lwr_dyn.simulation.events import followable
from lwr_dyn.simulation.flow import Drive, Flow
from lwr_dyn.simulation.log import Log
from lwr_dyn.simulation.quick import quick_step
from lwr_dyn.simulation.sensors import Sensor
from lwr_dyn.simulation.stick_flow import StickFlow

Progress = Callable[[float], None]
"""Called with the share that is done, about a hundred times."""
Advancing = Flow | StickFlow
"""What takes a state over an interval, events included."""
REPORTS = 100
_EMPTY = np.zeros(0)


class Blowup(Exception):  # noqa: N818 (caught at once and told as DivergenceError)
    """The state after sample `k` cannot be followed; `command` is the torque asked for then."""

    def __init__(self, k: int, command: Array) -> None:
        self.k, self.command = k, command


@dataclass(frozen=True, slots=True, eq=False)
class Sampling:
    """How the controller is asked: every `step` [s], through a sensor or with the true state.

    `fast` says that a step which meets nothing may go the fast way: RK4, no friction.
    """

    step: float
    substeps: int
    fast: bool
    sensor: Sensor | None
    progress: Progress | None


def joint_torque(tau: object, n: int, k: int) -> Array:
    """What a controller gave at sample k as a float64 array (n,); raises `ShapeError` for text or another shape."""
    name, allowed = f"torque of the controller at sample {k}", f"{n} numbers, one a joint"
    try:
        array = np.asarray(tau, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(name, "not an array of numbers", allowed) from None
    if array.shape != (n,):
        raise ShapeError(name, f"shape {array.shape}", allowed)
    return array


def _spans(steps: int, progress: Progress | None) -> Iterator[tuple[int, int]]:
    """The steps in pieces, with a report after each."""
    size = steps if progress is None else max(1, steps // REPORTS)
    for first in range(0, steps, size):
        last = min(first + size, steps)
        yield first, last
        if progress is not None:
            progress(last / steps)


def run_sampled(flow: Advancing, controller: Controller, log: Log, sampling: Sampling) -> None:
    """Torques held from sample to sample.

    A step that the fast way does not vouch for is thrown away and goes through `flow`.
    """
    plant, n, h = flow.plant, flow.plant.n, sampling.step
    quick = quick_step(flow, log, sampling.step, sampling.substeps)
    effort, negative = plant.effort, -plant.effort
    minimum, maximum = np.minimum, np.maximum
    sensor, shape, reference = sampling.sensor, (n,), log.reference
    careful = not sampling.fast or isinstance(flow, StickFlow) or bool(plant.at_limit(log.states[0, 0]).any())
    for first, last in _spans(len(log.t) - 1, sampling.progress):
        part = slice(first, last)
        rows = zip(
            range(first, last), log.t[part].tolist(), log.states[part], log.states[first + 1 : last + 1],
            reference.q[part], reference.dq[part], reference.ddq[part], log.command[part], log.applied[part],
            strict=True,
        )  # fmt: skip
        for k, t, now, after, q_ref, dq_ref, ddq_ref, command, applied in rows:
            q, dq = now
            if sensor is not None:
                q, dq = sensor(q, dq)
            tau = controller(t, q, dq, q_ref, dq_ref, ddq_ref)
            if tau.__class__ is not np.ndarray or tau.shape != shape:
                tau = joint_torque(tau, n, k)
            command[:] = tau
            minimum(tau, effort, out=applied)
            maximum(applied, negative, out=applied)
            log.done = k + 1
            if not careful and quick(k, now, applied, after):
                continue
            careful = _careful_step(flow, log, k, h) or not sampling.fast
    _last_sample(flow, controller, log, sensor)


def _last_sample(flow: Advancing, controller: Controller, log: Log, sensor: Sensor | None) -> None:
    """The torque at the end of the run, which moves nothing any more."""
    k = len(log.t) - 1
    q, dq = log.states[k]
    if sensor is not None:
        q, dq = sensor(q, dq)
    asked = log.reference
    tau = controller(float(asked.t[k]), q, dq, asked.q[k], asked.dq[k], asked.ddq[k])
    _write_torque(flow, log, k, tau)
    _last_friction(flow, log, _holding(log.applied[k]), np.concatenate([log.states[k].ravel(), (0.0, 0.0)]))


def _last_friction(flow: Advancing, log: Log, drive: Drive, y: Array) -> None:
    """The friction at the end of the run, for those at rest under the torque asked for there."""
    if isinstance(flow, StickFlow) and log.friction is not None:
        k = len(log.t) - 1
        flow.begin(drive, float(log.t[k]), y)
        log.friction[k] = flow.friction


def _holding(tau: Array) -> Drive:
    """A torque that stays as it is."""
    return lambda t, q, dq, memory: (tau, _EMPTY)


def _write_torque(flow: Advancing, log: Log, k: int, tau: object) -> None:
    log.command[k] = joint_torque(tau, flow.plant.n, k)
    log.applied[k] = flow.plant.cut(log.command[k])
    log.done = k + 1
    if not np.isfinite(log.command[k]).all():
        raise Blowup(k, log.command[k])


def _careful_step(flow: Advancing, log: Log, k: int, h: float) -> bool:
    """Step k with its events; says whether a joint stands at a limit after it, where `quick` does not know of that."""
    n = flow.plant.n
    _advance(flow, _holding(log.applied[k]), log, k, h, np.concatenate([log.states[k].ravel(), (0.0, 0.0)]))
    return not isinstance(flow, StickFlow) and bool(flow.plant.at_limit(log.states[k + 1].reshape(2, n)[0]).any())


def _advance(flow: Advancing, drive: Drive, log: Log, k: int, h: float, y: Array) -> Array:
    """State k + 1 and what the channels did meanwhile; raises `Blowup` when it cannot be followed."""
    n, before = flow.plant.n, flow.stop_work
    if not np.isfinite(log.applied[k]).all():
        raise Blowup(k, log.command[k])
    y1 = flow.advance(drive, float(log.t[k]), y, h)
    if isinstance(flow, StickFlow) and log.friction is not None:
        log.friction[k] = flow.friction
    if not followable(y1, n, h):
        raise Blowup(k, log.command[k])
    log.states[k + 1] = y1[: 2 * n].reshape(2, n)
    log.friction_work[k + 1] = y1[2 * n + 1] - y[2 * n + 1]
    log.stop_work[k + 1] = flow.stop_work - before
    return y1


def run_continuous(
    flow: Advancing, controller: Controller, reference: Reference, log: Log, progress: Progress | None
) -> None:
    """The controller asked at every moment the integrator looks at; its memory and the works ride along as states."""
    n, h = flow.plant.n, float(log.t[1] - log.t[0])
    raw, memory_size = _continuous_law(controller, reference, n)

    def drive(t: float, q: Array, dq: Array, memory: Array) -> tuple[Array, Array]:
        tau, rate = raw(t, q, dq, memory)
        if not np.isfinite(tau).all() and np.isfinite(q + dq).all():
            raise Blowup(log.done - 1, tau)
        return flow.plant.cut(tau), rate

    def ask(k: int, y: Array) -> Array:
        return raw(float(log.t[k]), y[:n], y[n : 2 * n], y[2 * n + 2 :])[0]

    y = np.concatenate([log.states[0].ravel(), (0.0, 0.0), np.zeros(memory_size)])
    for first, last in _spans(len(log.t) - 1, progress):
        for k in range(first, last):
            _write_torque(flow, log, k, ask(k, y))
            after = _advance(flow, drive, log, k, h, y)
            log.actuator_work[k + 1] = after[2 * n] - y[2 * n]
            y = after
    _write_torque(flow, log, len(log.t) - 1, ask(len(log.t) - 1, y))
    _last_friction(flow, log, drive, y)


def _continuous_law(controller: Controller, reference: Reference, n: int) -> tuple[Drive, int]:
    """The controller as a function of time and state; the reference is asked once for stages of the same moment."""
    moment, asked = np.full(1, np.nan), reference.sample(np.zeros(1))

    def at(t: float) -> tuple[Array, Array, Array]:
        nonlocal asked
        if moment[0] != t:
            moment[0] = t
            asked = reference.sample(moment.copy())
        return asked.q[0], asked.dq[0], asked.ddq[0]

    if isinstance(controller, WithMemory):
        remembering = controller
        return lambda t, q, dq, memory: remembering.torque_and_rate(memory, q, dq, *at(t)), controller.memory_size
    return lambda t, q, dq, memory: (controller(t, q, dq, *at(t)), _EMPTY), 0
