"""Everything the WAM paper simulates: tables, runs, Figures 4 to 8 redrawn, a replay."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.document import Note
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import FRICTIONLESS
from lwr_dyn.model.passivity import passive_refit
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.figure import Curve, Figure, Level, Panel
from lwr_dyn.pages.figures.run_figures import register_figure
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.paper_study import Pictures, Progress, Reproduction, paper_study, study_document
from lwr_dyn.reproduction.papers import printed_tables
from lwr_dyn.reproduction.report.content import Still
from lwr_dyn.reproduction.wam7 import runs as wam
from lwr_dyn.reproduction.wam7.formulas import caption_motion
from lwr_dyn.reproduction.wam7.runs import GRAVITIES, CruiseError, Experiment, cruise_errors, experiments, sides_of

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
    return Table(f"Steady cruise error q_ref - q [mrad] at 0.5/6 rad/s; agreement within {wam.AGREES:.1%}", heads, rows)


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


EVERY = 10
"""Of the samples at 1 kHz one in ten is drawn where curves are given as numbers."""

GAINS = "the gains are the manufacturer's, not the paper's"

FRICTION = {"with friction": True, "without": False}

REGISTER = 2
"""Place of the run of Figure 5 among those that are shown."""

RunsOfJoints = Mapping[str, Sequence[Run]]
"""With friction and without: a run per joint."""


def runs_of_joints(arm: Arm, simulated: Sequence[Experiment], alone: bool) -> RunsOfJoints:
    """The runs that Figure 7 (each joint alone) or Figure 8 (all together) shows of each joint."""
    chosen = {(e.joint, e.friction): e.run for e in simulated if e.side > 0 and e.gravity == GRAVITIES[0]}
    return {label: [chosen[j if alone else None, on] for j in range(arm.n)] for label, on in FRICTION.items()}


def pictures(arm: Arm, simulated: Sequence[Experiment]) -> Pictures:
    """Figures 4 to 8, Figure 1 as a still; all joints with friction and without are replayed."""
    alone, together = (runs_of_joints(arm, simulated, alone) for alone in (True, False))
    labels = [*(f"all joints, {name}" for name in together), "joint 1 alone, with friction"]
    runs = [*(runs[0] for runs in together.values()), alone["with friction"][0]]
    shown = replayed_runs(runs, arm, labels)
    colours = dict(zip(FRICTION, (one.place for one in shown), strict=False))
    register = replace(
        register_figure(REGISTER, 0), id="figure-5", title="Register of joint 1 turned by 0.5 rad", where="Figure 5",
        note=GAINS,
    )  # fmt: skip
    return Pictures(
        simulated=tuple((e.name, e.file, e.run) for e in simulated),
        shown=shown,
        figures={
            "figure_4_lspb": [_lspb()],
            "figure_5_register": [register],
            "figure_6_friction_maps": [_friction_maps(arm)],
            "figure_7_errors_one_at_a_time": [_errors("7", "one joint at a time", arm, alone, colours)],
            "figure_8_errors_all_together": [_errors("8", "all joints together", arm, together, colours)],
        },
        stills=(Still("Figure 1: Denavit-Hartenberg frames, q = 0", arm, np.zeros(arm.n)),),
        title="Barrett WAM, all joints, 0.5 rad in 7 s",
        replayed=len(together),
    )


def _lspb() -> Figure:
    """With the signs of the erratum, under which the motion lies within the figure's axes."""
    case = paper_study("wam7").data.case("figure4-acceleration")
    t, motion = caption_motion(case)
    panels = []
    for (name, values), unit in zip(motion.items(), ("rad", "rad/s", "rad/s^2"), strict=True):
        low, high = case.numbers("figure_4", name)
        levels = (Level("axis in print", low), Level("axis in print", high))
        note = f"axis in print from {low:g} to {high:g}"
        panels.append(Panel(name, name, unit, (Curve("LSPB", values, t),), levels, note))
    q = motion["position"]
    title = f"LSPB from {q[0]:.2f} to {q[-1]:.2f} rad"
    return Figure("figure-4", title, "Figure 4", "time", "s", tuple(panels), over_time=True)


def _friction_maps(arm: Arm) -> Figure:
    v = np.linspace(0.0, max(model.covered or 0.0 for model in arm.friction_models() if model), 81)[1:]
    speeds = np.concatenate([-v[::-1], [0.0], v])
    panels = []
    for model, joint in zip(arm.friction_models(), arm.joint_names, strict=True):
        friction = model or FRICTIONLESS
        torque = friction.torque(speeds)
        torque[v.size] = np.nan
        rest = Curve("at rest, anything between", np.array(friction.breakaway), np.zeros(2))
        panels.append(Panel(joint, "friction", "N m", (Curve("Table 1", torque, speeds), rest)))
    title = "Friction-velocity maps of Table 1"
    return Figure("figure-6", title, "Figure 6", "velocity", "rad/s", tuple(panels), columns=2)


def _errors(number: str, which: str, arm: Arm, series: RunsOfJoints, colours: Mapping[str, int]) -> Figure:
    panels = []
    for j, joint in enumerate(arm.joint_names):
        shown = {label: runs[j] for label, runs in series.items()}
        curves = [
            Curve(label, 1e3 * (run.q_ref - run.q)[::EVERY, j], run.t[::EVERY], colour=colours[label])
            for label, run in shown.items()
        ]
        panels.append(Panel(joint, "position error", "mrad", tuple(curves)))
    title, name = f"Position error, {which}", f"Figure {number}"
    return Figure(f"figure-{number}", title, name, "time", "s", tuple(panels), over_time=True, columns=2, note=GAINS)


def run(_: Path, arm: Arm, progress: Progress) -> Reproduction:
    """Recompute the paper's simulations.

    It holds when every cruise of a loop with damping settles on (F_c + sigma v)/kp, and no readable axis of Figure 7
    is left. The loop without damping is a finding, stated as such.
    """
    simulated = experiments(arm, progress)
    cruises = cruise_errors(arm, simulated)
    settled = [1e3 * c.mean for c in cruises if c.side > 0 and c.gravity == GRAVITIES[0] and c.stable]
    progress("plots and replay")
    return Reproduction(
        holds=all(c.holds for c in cruises) and figure_7_holds(cruises),
        document=study_document(
            cruise_table(cruises), Note(findings(cruises)), figure_7_table(cruises), passivity_table(arm),
            run_table(simulated),
            cruises=[c.record() for c in cruises], runs=[e.record() for e in simulated],
        ),
        known={"settled": {"error": settled}},
        pictures=pictures(arm, simulated),
    )  # fmt: skip
