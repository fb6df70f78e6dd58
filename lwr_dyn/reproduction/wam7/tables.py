"""The tables of the WAM study: cruise errors, Figure 7's axes, where friction feeds energy in, the runs."""

from collections.abc import Sequence

from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.passive_refit import passive_refit
from lwr_dyn.reproduction.results import printed_tables
from lwr_dyn.reproduction.wam7.runs import AGREES, GRAVITIES, CruiseError, Experiment, sides_of

SIGN = {1: "+", -1: "-"}
OUTSIDE = "OUTSIDE"


def cruise_table(cruises: Sequence[CruiseError]) -> Table:
    """Every joint, direction and gravity: predicted and simulated cruise error."""
    heads = (
        "joint", "gravity", Heading("kd + sigma", format=".4g"), Heading("(F_c + sigma v)/kp", format=".4f"),
        Heading("simulated", format=".4f"), Heading("miss", format="+.2%"), "range", "verdict",
    )  # fmt: skip
    rows = [
        (
            f"J{c.joint + 1} {SIGN[c.side]}", c.gravity, c.net_damping, 1e3 * c.predicted, 1e3 * c.mean, c.miss,
            f"{1e3 * c.least:.4f} to {1e3 * c.most:.4f}", verdict(c),
        )
        for c in cruises
    ]  # fmt: skip
    return Table(f"Steady cruise error q_ref - q [mrad] at 0.5/6 rad/s; agreement within {AGREES:.1%}", heads, rows)


def verdict(c: CruiseError) -> str:
    """Of one cruise, in words."""
    if c.stable:
        return "agrees" if c.holds else "DIFFERS"
    swing = f"{1e3 * c.least:.2f} to {1e3 * c.most:.2f} mrad, {c.slowest:.3f} to {c.fastest:.3f} rad/s"
    return f"no steady cruise (net damping {c.net_damping:.2f}): {swing}, at rest {c.sticks} times"


def findings(cruises: Sequence[CruiseError]) -> str:
    """Loops that cannot cruise steadily."""
    sides = {1: "positive", -1: "negative"}
    lines = [f"J{c.joint + 1} {sides[c.side]}, {c.gravity}: {verdict(c)}" for c in cruises if not c.stable]
    return "\n".join(["Findings: the friction takes more damping than kd gives, a limit cycle", *lines])


def figure_7_table(cruises: Sequence[CruiseError]) -> Table:
    """Simulated cruise errors against the axes of Figure 7, where the text lets them be read."""
    axes, rows = printed_tables("wam7")["figure_7"], []
    for c in (c for c in cruises if c.side > 0 and c.gravity == GRAVITIES[0]):
        axis, place = "-", "not readable in the text"
        if (printed := axes.get(f"joint_{c.joint + 1}")) is not None:
            low, high = map(float, printed)
            axis, place = f"{1e3 * low:g} to {1e3 * high:g}", "inside" if low <= c.mean <= high else OUTSIDE
        rows.append((f"J{c.joint + 1}", axis, 1e3 * c.mean, place))
    heads = ("joint", "axis", Heading("simulated", format=".2f"), "")
    return Table("Figure 7, axes [mrad] (the gains are not the paper's)", heads, rows)


def figure_7_holds(cruises: Sequence[CruiseError]) -> bool:
    """Every cruise error is inside the readable axes of Figure 7."""
    return all(row[-1] != OUTSIDE for row in figure_7_table(cruises).rows)


def passivity_table(arm: Arm) -> Table:
    """Where Table 1's friction feeds energy in, what it leaves of the damping, and what a passive refit would cost."""
    changes = {(c.joint, 1 if c.side == "positive" else -1): c for c in passive_refit(arm.friction_models()).changes}
    rows = []
    for (joint, side), passivity in sides_of(arm).items():
        change = changes.get((joint, side))
        start = "never" if passivity.from_speed is None else passivity.from_speed
        damping = "-" if arm.gains is None else passivity.net_damping(float(arm.gains.Kd[joint]))
        refit = None if change is None else f"{change.after.coulomb:.4f}, {change.after.viscous:.4f}"
        rows.append((f"J{joint + 1} {SIGN[side]}", start, damping, refit, None if change is None else change.rms))
    heads = (
        "joint", Heading("feeds energy in from", "rad/s", ".3f"), Heading("kd + sigma", format=".4f"),
        "passive F_c, sigma", Heading("RMS cost", "N m", ".3f"),
    )  # fmt: skip
    return Table("Passivity of Table 1's friction (measured up to 0.4 rad/s)", heads, rows)


def run_table(experiments: Sequence[Experiment]) -> Table:
    """The runs: largest errors, events, evaluations, energy audit."""
    rows = []
    for e in experiments:
        error, meta = 1e3 * abs(e.run.q_ref - e.run.q).max(), e.run.meta
        audit = meta["audit"]["residual"], meta["audit"]["channels"]["friction"]
        rows.append((e.name, error, len(e.run.events), meta["evaluations"], *audit))
    heads = (
        "run", Heading("largest error", "mrad", ".3f"), "events", "evaluations", Heading("audit", "J", ".1e"),
        Heading("work of friction", "J", ".4f"),
    )  # fmt: skip
    return Table("The runs", heads, rows)
