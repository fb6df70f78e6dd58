"""From a loop's log to a `Run`: energies, channels, what made it, and the error that tells of a run that broke off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.dynamics.protocol import mechanical_energy
from lwr_dyn.errors import DivergenceError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.run import Event, Run
from lwr_dyn.simulation.audit import audit
from lwr_dyn.simulation.events import TURN
from lwr_dyn.simulation.log import Log
from lwr_dyn.simulation.loops import Advancing
from lwr_dyn.simulation.plant import Plant

PACKAGES = ("lwr_dyn", "numpy", "scipy", "pin")
FEEDS = "friction feeds energy in"
"""Kind of the event that warns of it."""


def origin(arm: Arm) -> dict[str, Any]:
    """Which robot, as JSON values."""
    about = {"robot": arm.name, "reading": arm.reading, "digest": arm.digest, "errata": list(arm.errata)}
    return {**about, "file": arm.file or None, "loaded_with": dict(arm.loaded_with)}


def versions() -> dict[str, str]:
    """Versions of the packages that took part."""
    return {name: version(name) for name in PACKAGES}


def run_of(plant: Plant, log: Log, flow: Advancing, meta: Mapping[str, Any]) -> Run:
    """The run as far as it was computed, with its energy audit in `meta`."""
    done = slice(0, log.done)
    q, dq = log.states[done, 0], log.states[done, 1]
    asked = log.reference
    tau_friction = _friction(plant, log, dq)
    happened = [event for event in flow.events if event.t <= log.t[log.done - 1]]
    happened += fed_by_friction(log.t[done], dq, tau_friction)
    run = Run(
        t=log.t[done], q=q, dq=dq, q_ref=asked.q[done], dq_ref=asked.dq[done],
        tau_command=log.command[done], tau_applied=log.applied[done], tau_friction=tau_friction,
        energy=mechanical_energy(plant.dynamics, q, dq), work=log.work(),
        events=tuple(sorted(happened, key=lambda event: event.t)), meta=meta,
    )  # fmt: skip
    return replace(run, meta={**meta, "evaluations": flow.evaluations, "audit": audit(run).to_json()})


def _friction(plant: Plant, log: Log, dq: Array) -> Array:
    if log.friction is not None:
        return log.friction[: log.done]
    if plant.friction is not None:
        return np.array([plant.friction(speed) for speed in dq])
    return np.zeros_like(dq)


def fed_by_friction(t: Array, dq: Array, tau_friction: Array) -> list[Event]:
    """For each joint and direction the first sample at which friction fed energy in, with the speed there.

    Friction does so where tau_friction dq < 0: a negative viscous coefficient beyond some speed. Nothing is clamped;
    this says that a run went where such a model was.
    """
    out = []
    for joint, (speeds, torques) in enumerate(zip(dq.T, tau_friction.T, strict=True)):
        feeding = speeds * torques < 0.0
        for side in (1.0, -1.0):
            rows = np.flatnonzero(feeding & (side * speeds > 0.0))
            if rows.size:
                out.append(Event(float(t[rows[0]]), FEEDS, joint, float(speeds[rows[0]])))
    return out


def divergence(
    k: int, command: Array, plant: Plant, log: Log, flow: Advancing, meta: Mapping[str, Any]
) -> DivergenceError:
    """The error of a run that cannot go on after sample k: when, which joint, and the run until then."""
    speed = np.abs(log.states[k, 1])
    cap = TURN / float(log.t[1] - log.t[0])
    broken = np.flatnonzero(~np.isfinite(command))
    if broken.size:
        joint, found, allowed = int(broken[0]), f"torque command {command[broken[0]]}", "finite torques"
    else:
        joint = int(np.argmax(speed))
        unit = "rad/s" if plant.arm.chain.links[joint].kind is JointKind.REVOLUTE else "m/s"
        found = f"{speed[joint]:.3g} {unit} at the last sample that can be followed, beyond reach at the next"
        allowed = f"less than a turn a sample ({cap:.4g} rad/s), finite numbers; try a higher rate or lower gains"
    t, name = float(log.t[k]), plant.arm.joint_names[joint]
    told = {**meta, "diverged": {"t": t, "joint": name, "found": found}}
    return DivergenceError(t, name, found, allowed, run_of(plant, log, flow, told))
