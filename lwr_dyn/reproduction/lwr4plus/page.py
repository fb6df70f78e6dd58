"""What the report page of the LWR 4+ paper shows beside its numbers: both controllers on IST, figures, frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lwr_dyn.checks.verdict import Report
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.curves import joints_plot, path_plot, torque_plot
from lwr_dyn.reproduction.lwr4plus.runs import ControllerRun
from lwr_dyn.reproduction.outcome import PageExtras
from lwr_dyn.reproduction.pages import audit_of, checks_of
from lwr_dyn.reproduction.report.content import PlainTable, Replay, Section, Still

AS_TABLE_VIII = "inverse dynamics, g and feed-forward left out"
ASSUMED = "timing, tool orientation and arm angle are not printed: assumed here"


def shown(
    arm: Arm, found: Sequence[ControllerRun], replayed: Sequence[str], reports: Sequence[Report], table_viii: Run
) -> PageExtras:
    """Figures 4, 6, 7, 9 and 10 of the paper from the runs on the arm as modelled; Figure 2 as a still.

    `table_viii` is the run that Table VIII seems to be of; Figure 9 shows it beside the law as printed.
    """
    mine = [t for t in found if t.plant == "as modelled" and t.controller in replayed]
    runs = [(t.controller, i) for i, t in enumerate(mine)]
    pd, inverse = runs
    droop = (AS_TABLE_VIII, len(runs))
    plots = (
        path_plot("figure-4", "Trajectory to be implemented", "Fig. 4", runs),
        joints_plot("figure-6", "Position error, decentral", "Fig. 6", [pd], arm, "position error", "mrad", ASSUMED),
        path_plot("figure-7", "Trajectory obtained, decentralised", "Fig. 7", [pd]),
        joints_plot("figure-9a", "Position error, central", "Fig. 9", [droop, inverse], arm, "position error", "mrad",
                    ASSUMED),
        joints_plot("figure-9b", "Velocity error, central", "Fig. 9", [droop, inverse], arm, "velocity error",
                    "mrad/s"),
        path_plot("figure-10", "Trajectory obtained, centralised", "Fig. 10", [inverse, droop]),
        torque_plot("torque", "Torques and their limits", runs, arm),
    )  # fmt: skip
    replay = Replay(
        (*(t.run for t in mine), table_viii),
        (arm,) * (len(mine) + 1),
        (*(t.controller for t in mine), AS_TABLE_VIII),
        (Still("Fig. 2: frames, arm stretched up", arm, np.zeros(arm.n), "q = 0, DH frames of every link"),),
    )
    return PageExtras(
        plots, replay, checks_of(reports), audit_of((f"{t.controller}, {t.plant}", t.run) for t in found),
        (_ranking(found),),
    )  # fmt: skip


def _ranking(found: Sequence[ControllerRun]) -> Section:
    """Every controller on every plant."""
    rows = [
        (t.plant, t.controller, f"{t.metrics.tip_rms_mm:.4g}", f"{t.metrics.tip_max_mm:.4g}",
         f"{max(t.metrics.torque_use):.0%}", f"{max(t.metrics.speed_use):.0%}")
        for t in sorted(found, key=lambda t: (t.plant, t.metrics.tip_rms_mm))
    ]  # fmt: skip
    head = ("plant", "controller", "tip RMS [mm]", "tip max [mm]", "torque", "speed")
    table = PlainTable("Controllers on IST; they believe in the arm as modelled", head, tuple(rows))
    return Section("controllers", "Wrong models", "", (table,))
