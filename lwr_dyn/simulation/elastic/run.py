"""`run_elastic`: a sampled run of an arm with elastic joints, with its record and its audit."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from lwr_dyn.control.protocol import reset
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import DivergenceError, OptionError
from lwr_dyn.model.run import Event, Run
from lwr_dyn.simulation.audit import Audit
from lwr_dyn.simulation.elastic.loop import ElasticFlow, ElasticStep, OneSide
from lwr_dyn.simulation.elastic.plant import ElasticPlant, elastic_plant
from lwr_dyn.simulation.elastic.radau import radau
from lwr_dyn.simulation.elastic.second_road import second_road
from lwr_dyn.simulation.events import TURN
from lwr_dyn.simulation.external import ExternalTorque, checked_external
from lwr_dyn.simulation.loops import Diverged, Progress, run_sampled
from lwr_dyn.simulation.record import Log, active_friction
from lwr_dyn.simulation.setup import Setup

TOLERANCE = 1e-7
"""[J] of the energy audit for a run of 14 s at 1 kHz: springs of 1e4 N m/rad turn the method's error, 1e-12 rad a step,
into 1e-9 to 1e-8 J in all; dry friction and stops leave a little more. Substeps leave less."""
METHODS = {"rk4": "exponential", "radau": "radau"}
"""Option `method` of a run -> what moves elastic joints."""


def run_elastic(setup: Setup, progress: Progress | None = None) -> Run:
    """As `lwr_dyn.simulation.simulate.run_setup`, of elastic joints: q and dq of the run are the links'.

    Signals of the run are "theta" [rad], "dtheta" [rad/s] (the motors, seen at the joints) and "torque_sensor" [N m]
    (what goes through the gears); its channel "damper" is the work of the gears' dampers.

    Raises
    ------
    MissingDataError, OptionError
        As `elastic_plant`; a continuous run, a method for rigid joints.
    DivergenceError
        As `run_setup`.
    """
    options = setup.options
    if options.continuous:
        raise OptionError("continuous", "with elastic joints", "a sampled run")
    if options.method not in METHODS:
        raise OptionError("method", f"{options.method} with elastic joints", "rk4 (an exponential step), radau")
    plant = elastic_plant(setup)
    log, wide = _wide(setup, plant)
    flow = ElasticFlow(plant, radau(4 * plant.arm.n, options.substeps), wide.external)
    meta = setup.record()
    meta["options"] = {**meta["options"], "method": METHODS[options.method]}
    reset(setup.controller)
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            run_sampled(wide, flow, log, progress, ElasticStep)
    except Diverged as end:
        raise _divergence(end, setup, plant, log, flow, meta) from None
    return _run_of(setup, plant, log, flow, meta)


def _wide(setup: Setup, plant: ElasticPlant) -> tuple[Log, Setup]:
    """The setup for 2n coordinates, with its log; in its first state the springs carry the arm."""
    model, (q, dq) = plant.model, setup.start
    theta = q + model.links.bias_torque(q, dq) / model.stiffness
    external = None if setup.external is None else _on_links(setup.external, plant.arm.n)
    wide = replace(setup, plant=plant, start=read_only([[*q, *theta], [*dq, *dq]]), external=external)
    log = Log.blank(wide)
    return log, replace(wide, controller=OneSide(setup.controller, model, setup.encoders, log))


def _on_links(external: ExternalTorque, n: int) -> ExternalTorque:
    checked, still = checked_external(external, n), np.zeros(n)
    return lambda t, x, dx: np.concatenate([checked(t, x[:n], dx[:n]), still])


def _run_of(setup: Setup, plant: ElasticPlant, log: Log, flow: ElasticFlow, meta: Mapping[str, Any]) -> Run:
    """The run as far as it was computed."""
    n, done, model = plant.arm.n, log.done, plant.model
    x, dx = log.states[:done, 0], log.states[:done, 1]
    q, theta, dq, dtheta = x[:, :n], x[:, n:], dx[:, :n], dx[:, n:]
    friction = np.zeros((done, n)) if log.friction is None else log.friction[:done, n:]
    damped = np.cumsum([0.0, *flow.damped])[:done]
    signals = {name: each[:done] for name, each in log.signals.items()}
    signals |= {"theta": theta, "dtheta": dtheta, "torque_sensor": model.gear_torque(x, dx)}
    if setup.external is not None:
        rows = zip(log.t[:done].tolist(), q, dq, strict=True)
        signals["tau_external"] = np.array([setup.external(*row) for row in rows], dtype=np.float64)
    reference = log.reference
    run = Run(
        t=log.t[:done], q=q, dq=dq, q_ref=reference.q[:done], dq_ref=reference.dq[:done],
        tau_command=log.command[:done, n:], tau_applied=log.applied[:done, n:], tau_friction=friction,
        energy=model.energies(x, dx), work=log.work() | {"damper": damped},
        events=_events(flow, log, dtheta, friction, n), meta=meta, setup=setup, signals=signals,
    )  # fmt: skip
    cut = (run.tau_command != run.tau_applied).mean(axis=0)
    counted = {
        "evaluations": flow.evaluations, "at_stop_s": flow.stop_seconds[:n].round(9).tolist(),
        "cut_share": cut.round(6).tolist(),
    }  # fmt: skip
    return replace(run, meta={**meta, **counted, "audit": elastic_audit(run, plant).to_json()})


def _events(flow: ElasticFlow, log: Log, dtheta: Array, friction: Array, n: int) -> tuple[Event, ...]:
    """What happened until the last sample, by joints: stops of links, sticking and slipping of motors."""
    end = log.t[log.done - 1]
    events = [
        replace(event, joint=None if event.joint is None else event.joint % n)
        for event in flow.events
        if event.t <= end
    ]
    events += active_friction(log.t[: log.done], dtheta, friction)
    return tuple(sorted(events, key=lambda event: event.t))


def elastic_audit(run: Run, plant: ElasticPlant) -> Audit:
    """The audit of a run of this plant: as `lwr_dyn.simulation.audit.audit`, with springs, dampers and rotors."""
    change = run.energy - run.energy[0]
    return Audit(
        residual=float(np.abs(change - sum(run.work.values())).max()),
        energy_change=float(change[-1]),
        channels={name: float(each[-1]) for name, each in run.work.items()},
        actuator_gap=None,
        energy_gap=None,
        other_road=second_road(run, plant),
        tolerance=TOLERANCE,
    )


def _divergence(
    end: Diverged, setup: Setup, plant: ElasticPlant, log: Log, flow: ElasticFlow, meta: Mapping[str, Any]
) -> DivergenceError:
    """As of rigid joints; the joint that is named may be fast on either side of its gear."""
    n, speeds = plant.arm.n, np.abs(log.states[end.k, 1])
    broken = np.flatnonzero(~np.isfinite(end.command))
    joint = int(broken[0] if broken.size else np.argmax(speeds)) % n
    fault = f"torque command {end.command[broken[0]]}" if broken.size else f"{speeds.max():.3g} rad/s"
    t, name = float(log.t[end.k]), plant.arm.joint_names[joint]
    run = _run_of(setup, plant, log, flow, {**meta, "diverged": {"t": t, "joint": name, "found": fault}})
    allowed = f"finite torques, less than a turn a sample ({TURN * setup.options.rate:.4g} rad/s)"
    return DivergenceError(t, name, fault, allowed, run)
