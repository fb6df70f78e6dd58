"""A run as a table for people and a record for programs: errors joint by joint, limits, audit, friction."""

from typing import Any

import numpy as np

from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.replayed_runs import facts
from lwr_dyn.simulation.audit import audit_lines
from lwr_dyn.simulation.events import ACTIVE_FRICTION
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.simulation.responses.text import responses_said


def run_record(run: Run, arm: Arm) -> dict[str, Any]:
    """Metrics, audit, events and the record of the setup."""
    events = [{"t": e.t, "kind": e.kind, "joint": e.joint, "value": e.value} for e in run.events]
    found = {"metrics": metrics(run, arm).to_json(), "responses": responses_said(run, arm)[1]}
    return {**found, "events": events, "meta": dict(run.meta)}


def run_text(run: Run, arm: Arm, full: bool = False) -> str:
    """Errors, limits, audit and notes as text; with `full` all errors."""
    figures = metrics(run, arm)
    lines = [
        error_table(arm, figures, _title(run, arm), full).text(),
        f"tip error ({figures.caveat}): largest {figures.tip_max_mm:.6g} mm, RMS {figures.tip_rms_mm:.6g} mm",
        f"limits of position, speed and torque: {figures.limits}",
        *audit_lines(run.audit),
    ]
    return "\n".join([*lines, *friction_lines(run, arm), *responses_said(run, arm)[0]])


def _title(run: Run, arm: Arm) -> str:
    """The first line: what was simulated."""
    known = facts(run)
    parts = [f"{arm.name}, reading {arm.reading}: {known['controller']}"]
    parts += [f"{name} {known[name]}" for name in ("mount", "tool", "task", "payload", "plant") if name in known]
    return ", ".join([*parts, f"{run.t[-1]:g} s", f"{run.t.size} samples"])


def friction_lines(run: Run, arm: Arm) -> list[str]:
    """The friction of a run in words: its form, what a refit changed, and where it drove instead of braking."""
    form = run.meta["friction_law"]["form"]
    if form == "none":
        return []
    lines = [f"friction: {form}; accelerations computed {run.meta['evaluations']} times"]
    for c in run.meta["note"].get("passive_refit", ()):
        before, after = (f"F_c {x['coulomb']:.4f}, sigma {x['viscous']:.4f}" for x in (c["before"], c["after"]))
        cost = f"RMS {c['rms']:.3g} N m up to {c['speed']:g} rad/s"
        lines.append(f"passive refit of {c['joint']}, {c['side']}: {before} -> {after}; {cost}")
    for joint, name in enumerate(arm.joint_names):
        for e in (e for e in run.events if e.kind == ACTIVE_FRICTION and e.joint == joint):
            lines.append(f"warning: friction of {name} feeds energy in from {e.t:g} s on, at {e.value:.4g} rad/s (m/s)")
    return lines


def error_table(arm: Arm, figures: Metrics, title: str, full: bool = False) -> Table:
    """RMS and largest errors, or with `full` all of them, and uses of the limits, one row a joint."""
    p, v = figures.position_mrad, figures.velocity_mrad_s
    errors = {"RMS": p.rms, "max": np.maximum(p.max, -p.min) + 0.0}  # no -0
    if full:
        errors = {"mean": p.mean, "mean|e|": p.mean_abs, "max": p.max, "min": p.min, "RMS": p.rms}
        errors |= {"mean|de|": v.mean_abs, "max de": v.max, "min de": v.min}
    uses = (figures.peak_torque, figures.torque_use, figures.speed_use, figures.saturated_s)
    units = ["mrad" if link.kind is JointKind.REVOLUTE else "mm" for link in arm.chain.links]
    headings = [Heading("joint"), Heading("error in"), *(Heading(name, format=".3g") for name in errors), *USES]
    return Table(title, headings, list(zip(arm.joint_names, units, *errors.values(), *uses, strict=True)))


def _share(use: float) -> str:
    """A use of a limit; a question mark where the limit is not known."""
    return "?" if np.isnan(use) else f"{use:.0%}"


USES = (
    Heading("peak torque [N m]", format=".4g"), Heading("of limit", format=_share),
    Heading("speed of limit", format=_share), Heading("saturated [s]", format=".3g"),
)  # fmt: skip
"""Columns of how much of the limits was used; forces of sliding joints are in N."""
