"""The tables of the WAM report as text: cruise errors, where friction drives, Figure 7's axes, the runs."""

from __future__ import annotations

from collections.abc import Sequence

from lwr_dyn.identification.passive_refit import passive_refit
from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.printed import printed_tables
from lwr_dyn.reproduction.wam7.runs import AGREES, GRAVITIES, CruiseError, Experiment, sides_of
from lwr_dyn.tables import aligned

SIGN = {1: "+", -1: "-"}


def cruises_text(found: Sequence[CruiseError]) -> str:
    """Every joint, direction and gravity: predicted and simulated cruise error."""
    rows = [
        (
            f"J{c.joint + 1} {SIGN[c.side]}", c.gravity, f"{c.net_damping:.4g}", f"{1e3 * c.predicted:.4f}",
            f"{1e3 * c.mean:.4f}", f"{c.miss:+.2%}", f"{1e3 * c.least:.4f} to {1e3 * c.most:.4f}", verdict(c),
        )
        for c in found
    ]  # fmt: skip
    head = ("joint", "gravity", "kd + sigma", "(F_c + sigma v)/kp", "simulated", "miss", "range", "verdict")
    lines = [f"Steady cruise error q_ref - q [mrad] at 0.5/6 rad/s; agreement within {AGREES:.1%}", aligned(rows, head)]
    return "\n".join(lines)


def verdict(c: CruiseError) -> str:
    """Of one cruise, computed."""
    if c.stable:
        return "agrees" if c.holds else "DIFFERS"
    swing = f"{1e3 * c.least:.2f} to {1e3 * c.most:.2f} mrad, {c.slowest:.3f} to {c.fastest:.3f} rad/s"
    return f"no steady cruise (net damping {c.net_damping:.2f}): {swing}, {c.sticks} stops"


def figure_7_text(found: Sequence[CruiseError]) -> str:
    """Simulated cruise errors against the axes of Figure 7, where the text lets them be read."""
    axes, rows = printed_tables("wam7")["figure_7"], []
    for c in (c for c in found if c.side > 0 and c.gravity == GRAVITIES[0]):
        printed = axes.get(f"joint_{c.joint + 1}")
        inside = printed is not None and float(printed[0]) <= c.mean <= float(printed[1])
        words = "not readable in the text" if printed is None else "inside" if inside else "OUTSIDE"
        limits = "-" if printed is None else f"{1e3 * float(printed[0]):g} to {1e3 * float(printed[1]):g}"
        rows.append((f"J{c.joint + 1}", limits, f"{1e3 * c.mean:.2f}", words))
    return f"Figure 7, axes [mrad] (the gains are not the paper's)\n{aligned(rows, ('joint', 'axis', 'simulated', ''))}"


def figure_7_holds(found: Sequence[CruiseError]) -> bool:
    """No readable axis of Figure 7 is left by a cruise error."""
    return "OUTSIDE" not in figure_7_text(found)


def passivity_text(arm: Arm) -> str:
    """Where Table 1's friction feeds energy in, what it leaves of the damping, and what a passive refit would cost."""
    changes = {(c.joint, 1 if c.side == "positive" else -1): c for c in passive_refit(arm.friction_models()).changes}
    rows = []
    for (joint, side), found in sides_of(arm).items():
        change = changes.get((joint, side))
        refit = "" if change is None else f"{change.after.coulomb:.4f}, {change.after.viscous:.4f}"
        cost = "" if change is None else f"{change.rms:.3f}"
        start = "never" if found.from_speed is None else f"{found.from_speed:.3f}"
        damping = "-" if arm.gains is None else f"{found.net_damping(float(arm.gains.Kd[joint])):.4f}"
        rows.append((f"J{joint + 1} {SIGN[side]}", start, damping, refit, cost))
    head = ("joint", "feeds energy in from [rad/s]", "kd + sigma", "passive F_c, sigma", "RMS cost [N m]")
    return f"Passivity of Table 1's friction (measured up to 0.4 rad/s)\n{aligned(rows, head)}"


def runs_text(made: Sequence[Experiment]) -> str:
    """The runs: largest errors, events, evaluations, energy audit."""
    rows = []
    for e in made:
        error, audit = 1e3 * abs(e.run.q_ref - e.run.q).max(), e.run.meta["audit"]
        figures = (f"{error:.3f}", str(len(e.run.events)), str(e.run.meta["evaluations"]), f"{audit['residual']:.1e}")
        rows.append((e.name, *figures, f"{audit['channels']['friction']:.4f}"))
    head = ("run", "largest error [mrad]", "events", "evaluations", "audit [J]", "work of friction [J]")
    return f"The runs\n{aligned(rows, head)}"
