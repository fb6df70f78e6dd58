"""The `Log` that a loop fills, the `Run` built from it, and the error of a run that diverged."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.protocol import mechanical_energy
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import DivergenceError, ShapeError
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.run import Event, Motion, Run
from lwr_dyn.simulation.audit import audit
from lwr_dyn.simulation.events import ACTIVE_FRICTION, TURN
from lwr_dyn.simulation.flow import Flow
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
        stop, works = np.zeros(samples), np.zeros((samples, 2 if setup.external is None else 3))
        friction = None if setup.plant.friction.form == "none" else np.zeros((samples, n))
        return cls(reference, states, command, applied, friction, stop, works, setup.options.continuous)

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
    done = slice(0, log.done)
    q, dq = log.states[done, 0], log.states[done, 1]
    reference = log.reference
    tau_friction = np.zeros_like(dq) if log.friction is None else log.friction[done]
    events = [event for event in flow.events if event.t <= log.t[log.done - 1]]
    events += active_friction(log.t[done], dq, tau_friction)
    signals = {name: each[done] for name, each in log.signals.items()}
    if setup.external is not None:
        rows = zip(log.t[done].tolist(), q, dq, strict=True)
        signals["tau_external"] = np.array([setup.external(*row) for row in rows], dtype=np.float64)
    run = Run(
        t=log.t[done], q=q, dq=dq, q_ref=reference.q[done], dq_ref=reference.dq[done],
        tau_command=log.command[done], tau_applied=log.applied[done], tau_friction=tau_friction,
        energy=mechanical_energy(setup.plant.dynamics, q, dq), work=log.work(),
        events=tuple(sorted(events, key=lambda event: event.t)), meta=meta, setup=setup, signals=signals,
    )  # fmt: skip
    counted = {"evaluations": flow.evaluations, "at_stop_s": flow.stop_seconds.round(9).tolist()}
    return replace(run, meta={**meta, **counted, "audit": audit(run).to_json()})


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


def divergence(k: int, command: Array, setup: Setup, log: Log, flow: Flow, meta: Mapping[str, Any]) -> DivergenceError:
    """The error of a run that cannot go on after sample k: when, which joint, and the run until then."""
    speed, arm = np.abs(log.states[k, 1]), setup.plant.arm
    cap = TURN * setup.options.rate
    broken = np.flatnonzero(~np.isfinite(command))
    if broken.size:
        joint, fault, allowed = int(broken[0]), f"torque command {command[broken[0]]}", "finite torques"
    else:
        joint = int(np.argmax(speed))
        unit = "rad/s" if arm.chain.links[joint].kind is JointKind.REVOLUTE else "m/s"
        fault = f"{speed[joint]:.3g} {unit} at the last sample that can be followed, beyond reach at the next"
        allowed = f"less than a turn a sample ({cap:.4g} rad/s), finite numbers; try a higher rate or lower gains"
    t, name = float(log.t[k]), arm.joint_names[joint]
    diverged = {"t": t, "joint": name, "found": fault}
    return DivergenceError(t, name, fault, allowed, run_of(setup, log, flow, {**meta, "diverged": diverged}))
