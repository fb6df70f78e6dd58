"""What the report page of the WAM paper shows beside its numbers: motion with friction and without, Figures 4 to 8."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lwr_dyn.checks.verdict import Report
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction.models import FRICTIONLESS
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.outcome import PageExtras
from lwr_dyn.reproduction.pages import audit_of, checks_of
from lwr_dyn.reproduction.report.content import Replay, Still
from lwr_dyn.reproduction.wam7.runs import BLEND, DURATION, TRAVEL, Experiment
from lwr_dyn.trajectory.lspb import lspb
from lwr_dyn.viewer.figures import Curve, Figure, Level, Panel, Series

EVERY = 10
"""Of the samples at 1 kHz one in ten is drawn where curves are given as numbers."""
MAP_END = 0.4
GAINS = "the gains are the manufacturer's, not the paper's"


def shown(
    arm: Arm,
    made: Sequence[Experiment],
    alone: Mapping[str, Sequence[Run]],
    together: Mapping[str, Sequence[Run]],
    reports: Sequence[Report],
) -> PageExtras:
    """`alone` and `together`: label -> a run per joint, with friction and without."""
    both = [runs[0] for runs in together.values()]
    register = len(both)
    plots = (
        _figure_4(),
        _figure_5(register),
        _figure_6(arm),
        _errors("figure-7", "Position error, one joint at a time", "Figure 7", arm, alone),
        _errors("figure-8", "Position error, all joints together", "Figure 8", arm, together),
    )
    labels = (*(f"all joints, {name}" for name in together), "joint 1 alone, with friction")
    first = next(iter(alone.values()))[0]
    still = Still("Figure 1: Denavit-Hartenberg frames, q = 0", arm, np.zeros(arm.n))
    replay = Replay((*both, first), (arm,) * len(labels), labels, (still,))
    return PageExtras(plots, replay, checks_of(reports), audit_of((e.name, e.run) for e in made))


def _figure_4() -> Figure:
    t = np.linspace(0.0, DURATION, 281)
    way = lspb(TRAVEL, DURATION, BLEND).at(t)
    rows = (("position", way.s - 0.55, "rad", (-0.6, 0.0)), ("velocity", way.ds, "rad/s", (0.0, 0.1)),
            ("acceleration", way.dds, "rad/s^2", (-0.1, 0.1)))  # fmt: skip
    panels = tuple(
        Panel(name, name, unit, (Curve("LSPB", values, t),), tuple(Level("axis in print", x) for x in axis))
        for name, values, unit, axis in rows
    )
    return Figure("figure-4", "LSPB from -0.55 to -0.05 rad", "Figure 4", "time", "s", panels, over_time=True)


def _figure_5(run: int) -> Figure:
    panels = (
        Panel("position", "position", "rad", (Curve("q", Series(run, "q", 0)),)),
        Panel("velocity", "velocity", "rad/s", (Curve("dq", Series(run, "dq", 0)),)),
        Panel("torque", "torque", "N m",
              (Curve("motor", Series(run, "torque", 0)), Curve("friction", Series(run, "friction", 0)))),
    )  # fmt: skip
    return Figure("figure-5", "Register of joint 1 turned by 0.5 rad", "Figure 5", "time", "s", panels, over_time=True,
                note=GAINS)  # fmt: skip


def _figure_6(arm: Arm) -> Figure:
    v = np.linspace(0.0, MAP_END, 81)[1:]
    speeds = np.concatenate([-v[::-1], [0.0], v])
    panels = []
    for model, joint in zip(arm.friction_models(), arm.joint_names, strict=True):
        law = (model or FRICTIONLESS).torque(speeds)
        law[v.size] = np.nan  # at rest anything between both sides
        panels.append(Panel(joint, "friction", "N m", (Curve("Table 1", law, speeds),)))
    return Figure(
        "figure-6", "Friction-velocity maps of Table 1", "Figure 6", "velocity", "rad/s", tuple(panels), columns=2
    )


def _errors(name: str, title: str, figure: str, arm: Arm, series: Mapping[str, Sequence[Run]]) -> Figure:
    panels = []
    for j, joint in enumerate(arm.joint_names):
        curves = []
        for k, (label, runs) in enumerate(series.items()):
            run = runs[j]
            error = 1e3 * (run.q_ref - run.q)[::EVERY, j]
            curves.append(Curve(label, error, run.t[::EVERY], colour=k))
        panels.append(Panel(joint, "position error", "mrad", tuple(curves)))
    return Figure(name, title, figure, "time", "s", tuple(panels), over_time=True, columns=2, note=GAINS)
