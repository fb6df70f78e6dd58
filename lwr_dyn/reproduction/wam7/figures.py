"""Figures 4 to 8 of the WAM paper: its motion with friction and without."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import FRICTIONLESS
from lwr_dyn.model.run import Run
from lwr_dyn.pages.plotting.run_figures import register_figure
from lwr_dyn.pages.replay.figures import Curve, Figure, Level, Panel
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.paper_study import Pictures, paper_study
from lwr_dyn.reproduction.report.content import Still
from lwr_dyn.reproduction.wam7.formulas import caption_motion
from lwr_dyn.reproduction.wam7.runs import GRAVITIES, Experiment

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
