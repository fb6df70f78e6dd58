"""A run as a table for people and a record for programs: errors joint by joint, limits, energy audit."""

from __future__ import annotations

from typing import Any

import numpy as np

from lwr_dyn.cli.friction import friction_lines
from lwr_dyn.control.gains import UNSTABLE, damping_per_sample
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.tables import aligned


def run_record(run: Run, arm: Arm) -> dict[str, Any]:
    """Metrics, audit, events and what made the run."""
    events = [{"t": e.t, "kind": e.kind, "joint": e.joint, "value": e.value} for e in run.events]
    return {"metrics": metrics(run, arm).to_json(), "events": events, "meta": dict(run.meta)}


def run_text(run: Run, arm: Arm) -> str:
    """The same as text."""
    found, audit = metrics(run, arm), run.meta["audit"]
    controller = run.meta["controller"]["name"]
    lines = [f"{arm.name}, reading {arm.reading}: {controller}, {run.t[-1]:g} s, {run.t.size} samples"]
    lines.append(_errors(arm, found))
    lines.append(f"tip error: largest {found.tip_max_mm:.6g} mm, RMS {found.tip_rms_mm:.6g} mm")
    kept = "kept" if found.within_limits else "NOT kept"
    stopped = sorted({arm.joint_names[e.joint] for e in run.events if e.kind == "stop" and e.joint is not None})
    if stopped:
        kept += f", {', '.join(stopped)} only by its stop"
    lines.append(f"limits of position, speed and torque: {kept}; {len(run.events)} events")
    channels = ", ".join(f"{name} {value:.6g}" for name, value in audit["channels"].items())
    lines.append(
        f"energy: change {audit['energy_change']:.6g} J; work [J]: {channels}; residual {audit['residual']:.2g}"
    )
    return "\n".join([*lines, *_chatter(run, arm), *friction_lines(run, arm)])


def _chatter(run: Run, arm: Arm) -> list[str]:
    """A note where a torque damping is too strong for the sampling."""
    parameters, options = run.meta["controller"].get("parameters", {}), run.meta["options"]
    if run.meta["controller"]["name"] not in ("pd-gravity", "pid") or options["continuous"]:
        return []
    found = damping_per_sample(dynamics_of(arm), np.array(parameters["Kd"]), run.q, options["rate"])
    if found <= UNSTABLE:
        return []
    need = options["rate"] * found / UNSTABLE
    fault = f"Kd is too strong for {options['rate']:g} samples a second here, the loop chatters"
    return [f"note: {fault}; a --rate above {need:.0f} would hold it"]


def _errors(arm: Arm, found: Metrics) -> str:
    p, v = found.position_mrad, found.velocity_mrad_s
    rows = []
    for i, name in enumerate(arm.joint_names):
        errors = [f"{x[i]:.3g}" for x in (p.mean, p.mean_abs, p.max, p.min, p.rms, v.mean_abs, v.max, v.min)]
        uses = [f"{found.peak_torque[i]:.4g}", _share(found.torque_use[i]), _share(found.speed_use[i])]
        rows.append((name, _unit(arm, i), *errors, *uses, f"{found.saturated_s[i]:.3g}"))
    head = ("error of", "in", "mean", "mean|e|", "max", "min", "RMS", "mean|de|", "max", "min per s")
    return aligned(rows, (*head, "peak N m (N)", "of limit", "speed", "cut s"))


def _share(use: float) -> str:
    """A use of a limit; a question mark where the limit is not known."""
    return "?" if np.isnan(use) else f"{use:.0%}"


def _unit(arm: Arm, i: int) -> str:
    return "mrad" if arm.chain.links[i].kind is JointKind.REVOLUTE else "mm"
