"""From a loop's log to a `Run`: energies, channels, what made it, and the error that tells of a run that broke off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from lwr_dyn.arm import Arm
from lwr_dyn.arrays import Array
from lwr_dyn.dynamics.ungated import mechanical_energy
from lwr_dyn.errors import DivergenceError
from lwr_dyn.motion import Run
from lwr_dyn.simulation.audit import audit
from lwr_dyn.simulation.events import TURN
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.log import Log
from lwr_dyn.simulation.plant import Plant

PACKAGES = ("lwr_dyn", "numpy", "scipy", "pin")


def origin(arm: Arm) -> dict[str, Any]:
    """Which robot, as JSON values."""
    about = {"robot": arm.name, "reading": arm.reading, "digest": arm.digest, "errata": list(arm.errata)}
    return {**about, "file": arm.file or None, "loaded_with": dict(arm.loaded_with)}


def versions() -> dict[str, str]:
    """Versions of the packages that took part."""
    return {name: version(name) for name in PACKAGES}


def run_of(plant: Plant, log: Log, flow: Flow, meta: Mapping[str, Any]) -> Run:
    """The run as far as it was computed, with its energy audit in `meta`."""
    done = slice(0, log.done)
    q, dq = log.states[done, 0], log.states[done, 1]
    asked = log.reference
    tau_friction = np.zeros_like(q)
    if plant.friction is not None:
        tau_friction = np.array([plant.friction(speed) for speed in dq])
    run = Run(
        t=log.t[done], q=q, dq=dq, q_ref=asked.q[done], dq_ref=asked.dq[done],
        tau_command=log.command[done], tau_applied=log.applied[done], tau_friction=tau_friction,
        energy=mechanical_energy(plant.dynamics, q, dq), work=log.work(),
        events=tuple(event for event in flow.events if event.t <= log.t[log.done - 1]), meta=meta,
    )  # fmt: skip
    return replace(run, meta={**meta, "audit": audit(run).to_json()})


def divergence(k: int, command: Array, plant: Plant, log: Log, flow: Flow, meta: Mapping[str, Any]) -> DivergenceError:
    """The error of a run that cannot go on after sample k: when, which joint, and the run until then."""
    speed = np.abs(log.states[k, 1])
    cap = TURN / float(log.t[1] - log.t[0])
    broken = np.flatnonzero(~np.isfinite(command))
    if broken.size:
        joint, found, allowed = int(broken[0]), f"torque command {command[broken[0]]}", "finite torques"
    else:
        joint = int(np.argmax(speed))
        found = f"{speed[joint]:.3g} rad/s (m/s) at the last sample, and growing"
        allowed = f"less than a turn a sample ({cap:.4g} rad/s), finite numbers; try a higher rate or lower gains"
    t, name = float(log.t[k]), plant.arm.joint_names[joint]
    told = {**meta, "diverged": {"t": t, "joint": name, "found": found}}
    return DivergenceError(t, name, found, allowed, run_of(plant, log, flow, told))
