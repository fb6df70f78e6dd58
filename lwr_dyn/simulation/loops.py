"""The loops of a run: one for sampled controllers, with a fast path for the usual step, and one for continuous ones.

Both fill a `Log`, from which the `Run` is built, and raise `Diverged` where the state can no longer be followed.
"""

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from lwr_dyn.control.protocol import (
    Controller,
    JointReadings,
    WithJointSensors,
    WithMemory,
    joint_torque,
    saturate,
    saturating,
)
from lwr_dyn.dynamics.protocol import mechanical_energy
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import DivergenceError, ShapeError
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Event, Motion, Reference, Run
from lwr_dyn.simulation.audit import audit
from lwr_dyn.simulation.contact import ACTIVE_FRICTION, TURN, followable
from lwr_dyn.simulation.flow import NO_WORK, Drive, FastStep, Flow
from lwr_dyn.simulation.setup import Setup


@dataclass(slots=True, eq=False)
class Log:
    """Samples 0..k of a run: states (k + 1, 2, n), torques (k + 1, n) [N m], work of each step (k + 1,) [J]."""

    reference: Motion
    states: Array
    command: Array
    applied: Array
    friction: Array | None  # tau_friction (k + 1, n) [N m]; None without friction
    stop_work: Array
    works: Array  # of motors, friction and, where they act, external torques, (k + 1, 2 or 3)
    continuous: bool
    done: int = 0  # samples of which state and torque are written
    signals: dict[str, Array] = field(default_factory=dict)  # (k + 1, m) each

    @classmethod
    def blank(cls, setup: Setup) -> Self:
        """A log for the times of a setup, with the first state in it."""
        reference = setup.motion
        samples, n = reference.t.size, setup.plant.n
        states = np.zeros((samples, 2, n))
        states[0] = setup.start
        command, applied = np.zeros((2, samples, n))
        stop, works = np.zeros(samples), np.zeros((samples, 2 if setup.loop.external is None else 3))
        friction = None if setup.plant.friction.form == "none" else np.zeros((samples, n))
        return cls(reference, states, command, applied, friction, stop, works, setup.loop.continuous)

    @property
    def t(self) -> Array:
        """Times of the samples [s]."""
        return self.reference.t

    def work(self) -> dict[str, Array]:
        """Work of each channel since t = 0, (done,) [J] each: actuator, friction, stop, external."""
        done = self.done
        steps, friction, *external = self.works[:done].T
        if not self.continuous:  # under hold it is exactly
            travel = np.diff(self.states[:done, 0], axis=0)
            steps = np.concatenate([[0.0], np.einsum("ki,ki->k", self.applied[: done - 1], travel)])
        channels = {"actuator": steps, "friction": friction, "stop": self.stop_work[:done]}
        channels |= dict(zip(("external",), external, strict=False))
        return {name: np.cumsum(each) for name, each in channels.items()}

    def signal_writer(self, controller: Controller) -> Callable[[int], None]:
        """What keeps the controller's `signals`, if any, of sample k; it raises `ShapeError`."""
        if not hasattr(controller, "signals"):
            return lambda k: None

        def write(k: int) -> None:
            for name, value in controller.signals.items():
                if name not in self.signals:
                    self.signals[name] = np.full((len(self.t), np.size(value)), np.nan)
                try:
                    self.signals[name][k] = value
                except (TypeError, ValueError):
                    allowed = f"{self.signals[name].shape[1]} numbers, as at the first sample"
                    raise ShapeError(f"signal {name} at sample {k}", f"shape {np.shape(value)}", allowed) from None

        return write


def run_of(setup: Setup, log: Log, flow: Flow, meta: Mapping[str, Any]) -> Run:
    """The run as far as it was computed; its meta is `meta`, the record of the setup, with the audit."""
    q, dq = log.states[: log.done, 0], log.states[: log.done, 1]
    run = unaudited_run(setup, log, flow, meta, mechanical_energy(setup.plant.dynamics, q, dq), {}, {})
    return run.with_meta({**run.meta, "audit": audit(run).to_json()})


def unaudited_run(
    setup: Setup,
    log: Log,
    flow: Flow,
    meta: Mapping[str, Any],
    energy: Array,
    signals: Mapping[str, Array],
    work: Mapping[str, Array],
) -> Run:
    """As `run_of`, with further signals and channels of work; of a log of both sides of elastic joints q is the links'.

    Torques and friction are those of the last n columns, the motors.
    """
    n, done, reference = setup.plant.n, slice(0, log.done), log.reference
    t, q, dq = log.t[done], log.states[done, 0, :n], log.states[done, 1, :n]
    friction = np.zeros_like(dq) if log.friction is None else log.friction[done, -n:]
    events = [
        replace(event, joint=None if event.joint is None else event.joint % n)
        for event in flow.events
        if event.t <= t[-1]
    ]
    events += [] if log.friction is None else active_friction(t, log.states[done, 1, -n:], friction)
    own = {**{name: each[done] for name, each in log.signals.items()}, **signals}
    if setup.loop.external is not None:
        rows = zip(t.tolist(), q, dq, strict=True)
        own["tau_external"] = np.array([setup.loop.external(*row) for row in rows], dtype=np.float64)
    counted = {"evaluations": flow.evaluations, "at_stop_s": flow.stop_seconds[:n].round(9).tolist()}
    return Run(
        t=t, q=q, dq=dq, q_ref=reference.q[done], dq_ref=reference.dq[done],
        tau_command=log.command[done, -n:], tau_applied=log.applied[done, -n:], tau_friction=friction,
        energy=energy, work={**log.work(), **work}, events=tuple(sorted(events, key=lambda event: event.t)),
        meta={**meta, **counted}, setup=setup, signals=own,
    )  # fmt: skip


def active_friction(t: Array, dq: Array, tau_friction: Array) -> list[Event]:
    """For each joint and direction the first sample at which friction fed energy in, with the speed there.

    Friction does so where tau_friction dq < 0: a negative viscous coefficient beyond some speed. Nothing is clamped;
    the event only warns.
    """
    out = []
    for joint, (speeds, torques) in enumerate(zip(dq.T, tau_friction.T, strict=True)):
        feeding = speeds * torques < 0.0
        for side in (1.0, -1.0):
            rows = np.flatnonzero(feeding & (side * speeds > 0.0))
            if rows.size:
                out.append(Event(float(t[rows[0]]), ACTIVE_FRICTION, joint, float(speeds[rows[0]])))
    return out


class Diverged(Exception):  # noqa: N818 (always turned into a DivergenceError)
    """The state after sample `k` cannot be followed; `command` is the controller's torque at that sample."""

    def __init__(self, k: int, command: Array) -> None:
        self.k, self.command = k, command


def divergence(
    end: Diverged, setup: Setup, log: Log, meta: Mapping[str, Any], run: Callable[[Mapping[str, Any]], Run]
) -> DivergenceError:
    """The error of a run that cannot go on: when, which joint (on either side of its gear), and the `run` of a meta."""
    k, command, arm = end.k, end.command, setup.plant.arm
    speed, broken = np.abs(log.states[k, 1]), np.flatnonzero(~np.isfinite(command))
    cap = TURN * setup.loop.rate
    fastest = int(broken[0] if broken.size else np.argmax(speed))
    joint = fastest % arm.n
    if broken.size:
        fault, allowed = f"torque command {command[fastest]}", "finite torques"
    else:
        unit = "rad/s" if arm.chain.links[joint].kind is JointKind.REVOLUTE else "m/s"
        fault = f"{speed[fastest]:.3g} {unit} at the last sample that can be followed, beyond reach at the next"
        allowed = f"less than a turn a sample ({cap:.4g} rad/s), finite numbers; try a higher rate or lower gains"
    t, name = float(log.t[k]), arm.joint_names[joint]
    diverged = {"t": t, "joint": name, "found": fault}
    return DivergenceError(t, name, fault, allowed, run({**meta, "diverged": diverged}))


Progress = Callable[[float], None]
"""Called with the share that is done, about a hundred times."""

REPORTS = 100

_EMPTY = np.zeros(0)


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
    plant, loop = setup.plant, setup.loop
    controller = delayed(sensed(setup.controller, log), loop.delay)
    n, h, cut = plant.n, 1 / loop.rate, saturating(plant.effort)
    fast = fast_step(flow, h, loop.substeps)
    friction, signals = log.friction, log.signal_writer(setup.controller)
    work = log.works
    measure, shape, reference = setup.sensor(), (n,), log.reference
    always_events = loop.method != "rk4" or plant.friction.smooth is not None
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
            cut(tau, applied)
            log.done = k + 1
            if not with_events and fast.take(t, now, applied, after):
                if fast.work is not NO_WORK:
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
    unlimited, memory_size = continuous_controller(setup.controller, _at_moments(setup.reference))

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


At = Callable[[float], tuple[Array, Array, Array]]
"""t -> q_ref, dq_ref, ddq_ref (n,) each."""


def _at_moments(reference: Reference) -> At:
    """The reference as a function of time, sampled once for stages of the same moment."""
    moment, sample = np.full(1, np.nan), reference.sample(np.zeros(1))

    def at(t: float) -> tuple[Array, Array, Array]:
        nonlocal sample
        if moment[0] != t:
            moment[0] = t
            sample = reference.sample(moment.copy())
        return sample.q[0], sample.dq[0], sample.ddq[0]

    return at


def continuous_controller(controller: Controller, at: At) -> tuple[Drive, int]:
    """The controller as a function of time and state, and the size of its memory."""
    if isinstance(controller, WithMemory):
        with_memory = controller
        return lambda t, q, dq, memory: with_memory.torque_and_rate(memory, q, dq, *at(t)), controller.memory_size
    return lambda t, q, dq, memory: (controller(t, q, dq, *at(t)), _EMPTY), 0
