"""The loops of a run: one for sampled controllers, with a fast path for the usual step, and one for continuous ones.

Both fill a `Log` and raise `Diverged` where the state can no longer be followed.
"""

from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from lwr_dyn.control.protocol import (
    Controller,
    JointReadings,
    WithJointSensors,
    WithMemory,
    joint_torque,
    saturate,
)
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.run import Reference
from lwr_dyn.simulation.events import followable
from lwr_dyn.simulation.fast_step import FastStep
from lwr_dyn.simulation.flow import Drive, Flow
from lwr_dyn.simulation.record import Log
from lwr_dyn.simulation.setup import Setup

Progress = Callable[[float], None]
"""Called with the share that is done, about a hundred times."""
REPORTS = 100
_EMPTY = np.zeros(0)


class Diverged(Exception):  # noqa: N818 (always turned into a DivergenceError)
    """The state after sample `k` cannot be followed; `command` is the controller's torque at that sample."""

    def __init__(self, k: int, command: Array) -> None:
        self.k, self.command = k, command


def delayed(controller: Controller, samples: int) -> Controller:
    """The controller with its commands late by `samples`; until the first arrives, it acts already."""
    if samples == 0:
        return controller
    on_their_way = deque[Any]()

    def late(t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Any:
        on_their_way.append(np.array(controller(t, q, dq, q_ref, dq_ref, ddq_ref)))
        return on_their_way.popleft() if len(on_their_way) > samples else on_their_way[0]

    return late


def sensed(controller: Controller, log: Log) -> Controller:
    """The controller, given the readings of rigid joints before each call if it has joint sensors."""
    if not isinstance(controller, WithJointSensors):
        return controller
    sense = controller.sense

    def informed(t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Any:
        sense(JointReadings(q, dq, q, dq, log.applied[log.done - 1]))  # at first the last row, which is still 0
        return controller(t, q, dq, q_ref, dq_ref, ddq_ref)

    return informed


def _spans(steps: int, progress: Progress | None) -> Iterator[tuple[int, int]]:
    """The steps in pieces, with a report after each."""
    size = steps if progress is None else max(1, steps // REPORTS)
    for first in range(0, steps, size):
        last = min(first + size, steps)
        yield first, last
        if progress is not None:
            progress(last / steps)


def run_sampled(
    setup: Setup, flow: Flow, log: Log, progress: Progress | None, fast_step: type[FastStep] = FastStep
) -> None:
    """Torques held from sample to sample.

    A step that the fast path, a `fast_step`, rejects is computed again by `Flow`.
    """
    plant, options = setup.plant, setup.options
    controller = delayed(sensed(setup.controller, log), options.delay)
    n, h, effort = plant.n, 1 / options.rate, plant.effort
    fast = fast_step(flow, h, options.substeps)
    friction, signals = log.friction, log.signal_writer(setup.controller)
    work = log.works
    measure, shape, reference = setup.sensor(), (n,), log.reference
    always_events = options.method != "rk4" or plant.friction.smooth is not None
    with_events = always_events or friction is not None or bool(plant.at_limit(log.states[0, 0]).any())
    if not with_events:
        flow.begin(_holding(np.zeros(n)), float(log.t[0]), _sampled_state(log, 0))
    for first, last in _spans(len(log.t) - 1, progress):
        part = slice(first, last)
        rows = zip(
            range(first, last), log.t[part].tolist(), log.states[part], log.states[first + 1 : last + 1],
            reference.q[part], reference.dq[part], reference.ddq[part], log.command[part], log.applied[part],
            strict=True,
        )  # fmt: skip
        for k, t, now, after, q_ref, dq_ref, ddq_ref, command, applied in rows:
            q, dq = measure(*now)
            tau = controller(t, q, dq, q_ref, dq_ref, ddq_ref)
            if tau.__class__ is not np.ndarray or tau.shape != shape:
                tau = joint_torque(f"torque of the controller at sample {k}", tau, n)
            command[:] = tau
            signals(k)
            saturate(tau, effort, applied)
            log.done = k + 1
            if not with_events and fast.take(t, now, applied, after):
                work[k + 1] = fast.work
                if friction is not None:
                    friction[k] = fast.friction
                continue
            _advance(flow, _holding(applied), log, k, h, _sampled_state(log, k))
            with_events = always_events
    q, dq = measure(*log.states[-1])
    tau = controller(float(log.t[-1]), q, dq, reference.q[-1], reference.dq[-1], reference.ddq[-1])
    signals(len(log.t) - 1)
    _finish(flow, log, tau, _holding(log.applied[-1]), _sampled_state(log, -1))


def _sampled_state(log: Log, k: int) -> Array:
    """State k for `Flow`, without memory."""
    return np.concatenate([log.states[k].ravel(), np.zeros(log.works.shape[1])])


def _finish(flow: Flow, log: Log, tau: object, drive: Drive, y: Array) -> None:
    """Torque and friction of the last sample, which move nothing any more."""
    k = len(log.t) - 1
    _write_torque(flow, log, k, tau)
    if log.friction is not None:
        flow.begin(drive, float(log.t[k]), y)
        log.friction[k] = flow.friction


def _holding(tau: Array) -> Drive:
    """A drive with a constant torque and no memory."""
    return lambda t, q, dq, memory: (tau, _EMPTY)


def _write_torque(flow: Flow, log: Log, k: int, tau: object) -> None:
    log.command[k] = joint_torque(f"torque of the controller at sample {k}", tau, flow.plant.n)
    saturate(log.command[k], flow.plant.effort, log.applied[k])
    log.done = k + 1
    if not np.isfinite(log.command[k]).all():
        raise Diverged(k, log.command[k])


def _advance(flow: Flow, drive: Drive, log: Log, k: int, h: float, y: Array) -> Array:
    """State k + 1 and the work of each channel until then; raises `Diverged` when it cannot be followed."""
    n, before = flow.plant.n, flow.stop_work
    if not np.isfinite(log.applied[k]).all():
        raise Diverged(k, log.command[k])
    y1 = flow.advance(drive, float(log.t[k]), y, h)
    if log.friction is not None:
        log.friction[k] = flow.friction
    if not followable(y1, n, h):
        raise Diverged(k, log.command[k])
    log.states[k + 1] = y1[: 2 * n].reshape(2, n)
    log.works[k + 1] = (y1 - y)[2 * n : 2 * n + flow.works]
    log.stop_work[k + 1] = flow.stop_work - before
    return y1


def run_continuous(setup: Setup, flow: Flow, log: Log, progress: Progress | None) -> None:
    """The controller called at every stage of the integrator; its memory and the works are integrated as states."""
    n, h = flow.plant.n, float(log.t[1] - log.t[0])
    unlimited, memory_size = _continuous_controller(setup.controller, setup.reference)

    def drive(t: float, q: Array, dq: Array, memory: Array) -> tuple[Array, Array]:
        tau, rate = unlimited(t, q, dq, memory)
        if not np.isfinite(tau).all() and np.isfinite(q + dq).all():
            raise Diverged(log.done - 1, tau)
        return saturate(tau, flow.plant.effort), rate

    def torque(k: int, y: Array) -> Array:
        return unlimited(float(log.t[k]), y[:n], y[n : 2 * n], y[2 * n + flow.works :])[0]

    y = np.concatenate([_sampled_state(log, 0), np.zeros(memory_size)])
    for first, last in _spans(len(log.t) - 1, progress):
        for k in range(first, last):
            _write_torque(flow, log, k, torque(k, y))
            y = _advance(flow, drive, log, k, h, y)
    _finish(flow, log, torque(-1, y), drive, y)


def _continuous_controller(controller: Controller, reference: Reference) -> tuple[Drive, int]:
    """The controller as a function of time and state; the reference is sampled once for stages of the same moment."""
    moment, sample = np.full(1, np.nan), reference.sample(np.zeros(1))

    def at(t: float) -> tuple[Array, Array, Array]:
        nonlocal sample
        if moment[0] != t:
            moment[0] = t
            sample = reference.sample(moment.copy())
        return sample.q[0], sample.dq[0], sample.ddq[0]

    if isinstance(controller, WithMemory):
        with_memory = controller
        return lambda t, q, dq, memory: with_memory.torque_and_rate(memory, q, dq, *at(t)), controller.memory_size
    return lambda t, q, dq, memory: (controller(t, q, dq, *at(t)), _EMPTY), 0
