"""`--friction` and `--passive-refit`: the friction of a simulated plant, and the lines about it in a report."""

from __future__ import annotations

from typing import Any

from lwr_dyn.errors import OptionError
from lwr_dyn.front import FUNCTIONS
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.friction import FORMS, FrictionOption
from lwr_dyn.simulation.record import ACTIVE_FRICTION


def friction_option(plant: Arm, form: str, refit: bool) -> tuple[FrictionOption, dict[str, Any]]:
    """The option `friction` of `simulate`, and a note of what a refit changed; raises as `passive_refit`."""
    if not refit:
        return form, {}
    if form != FORMS[0]:
        raise OptionError("--passive-refit", f"with --friction {form}", f"with --friction {FORMS[0]}")
    nearest = FUNCTIONS.load("passive_refit")(plant.friction_models())
    return nearest.models, {"passive_refit": [_change(plant, c) for c in nearest.changes]}


def _change(plant: Arm, c: Any) -> dict[str, Any]:
    before, after = ({"coulomb": d.coulomb, "viscous": d.viscous} for d in (c.before, c.after))
    name = plant.joint_names[c.joint]
    return {"joint": name, "side": c.side, "rms": c.rms, "speed": c.speed, "before": before, "after": after}


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
