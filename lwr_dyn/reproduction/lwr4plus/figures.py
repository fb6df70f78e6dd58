"""Figures 4, 6, 7, 9 and 10 of the LWR 4+ paper, from the runs of both controllers on IST."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.plotting.run_figures import (
    error_figure,
    path_figure,
    tip_error_figure,
    torque_figure,
)
from lwr_dyn.pages.replay.figures import Figure
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs
from lwr_dyn.reproduction.lwr4plus.runs import ControllerRun, ranking_table
from lwr_dyn.reproduction.paper_study import Pictures
from lwr_dyn.reproduction.report.content import Section, Still

PD, INVERSE, DROOP = 0, 1, 2
"""Places of the runs that are shown: both controllers on the arm as modelled, and what Table VIII seems to be of."""
REPLAYED = ("pd-gravity", "inverse-dynamics")
ASSUMED = "timing, tool orientation and arm angle are not printed: assumed here"


def pictures(arm: Arm, simulated: Sequence[ControllerRun], table_viii: Run) -> Pictures:
    """Figures 4, 6, 7, 9 and 10, torques, Figure 2 as a still; both controllers on the arm as modelled are replayed."""
    replayed = [run for run in simulated if run.plant == "as modelled" and run.controller in REPLAYED]
    shown = replayed_runs([*(run.run for run in replayed), table_viii], arm)
    return Pictures(
        simulated=tuple((run.name, run.file, run.run) for run in simulated),
        shown=shown,
        figures={file: [figure] for file, figure in _figures(shown).items()},
        stills=(Still("Fig. 2: frames, arm stretched up", arm, np.zeros(arm.n), "q = 0, DH frames of every link"),),
        sections=(Section("controllers", "Wrong models", "", (ranking_table(simulated),)),),
        title="KUKA LWR 4+ draws IST",
        replayed=len(replayed),
    )


def _figures(runs: Sequence[ReplayedRun]) -> dict[str, Figure]:
    """File -> figure."""

    def like(figure: Figure, name: str, title: str, where: str, note: str = "") -> Figure:
        return replace(figure, id=name, title=title, where=where, note=note)

    position, velocity = (error_figure(runs, (DROOP, INVERSE), q) for q in ("position error", "velocity error"))
    both = [error_figure(runs, (PD, INVERSE), q) for q in ("position error", "velocity error")]
    paths = {
        "figure_04_path": like(path_figure(runs, (PD, INVERSE)), "figure-4", "Trajectory to be implemented", "Fig. 4"),
        "figure_07_path_pd": like(path_figure(runs, (PD,)), "figure-7", "Trajectory obtained, decentralised", "Fig. 7"),
        "figure_10_path_inverse_dynamics": like(
            path_figure(runs, (INVERSE, DROOP)), "figure-10", "Trajectory obtained, centralised", "Fig. 10"
        ),
    }
    return paths | {
        "tip_error": tip_error_figure(runs),
        "torque": torque_figure(runs, (PD, INVERSE)),
        "figure_06_position_error_pd": like(
            error_figure(runs, (PD,)), "figure-6", "Position error, decentral", "Fig. 6", ASSUMED
        ),
        "figure_09_position_error_inverse_dynamics": like(
            position, "figure-9a", "Position error, central", "Fig. 9", ASSUMED
        ),
        "figure_09_velocity_error_inverse_dynamics": like(velocity, "figure-9b", "Velocity error, central", "Fig. 9"),
        "position_error": replace(both[0], id=""),
        "velocity_error": replace(both[1], id=""),
    }
