"""Everything the WAM paper simulates: tables, runs, Figures 4 to 8 redrawn, a replay."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lwr_dyn.files import make_folder
from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.paper_study import PageExtras, Progress, Reproduction
from lwr_dyn.reproduction.wam7.figures import drawn_runs, figures, page_extras, runs_of_joints
from lwr_dyn.reproduction.wam7.runs import GRAVITIES, Experiment, cruise_errors, experiments
from lwr_dyn.reproduction.wam7.tables import (
    cruise_table,
    figure_7_holds,
    figure_7_table,
    findings,
    passivity_table,
    run_table,
)
from lwr_dyn.viewer.plots import save_figure
from lwr_dyn.viewer.replay_page import write_replay


def run(place: Path, arm: Arm, progress: Progress) -> Reproduction:
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
        tables=(
            cruise_table(cruises), findings(cruises), figure_7_table(cruises), passivity_table(arm),
            run_table(simulated),
        ),
        record={"cruises": [c.record() for c in cruises], "runs": [e.record() for e in simulated]},
        known={"settled": {"error": settled}},
        extras=_pictures(place, arm, simulated),
    )  # fmt: skip


def _pictures(place: Path, arm: Arm, simulated: Sequence[Experiment]) -> PageExtras:
    """Write runs, figures and the replay; what the report page shows of them."""
    plots, folder = make_folder(place / "plots"), make_folder(place / "runs")
    for e in simulated:
        e.run.save(folder / e.file)
    alone, together = (runs_of_joints(arm, simulated, alone) for alone in (True, False))
    runs, drawn = drawn_runs(arm, alone, together), figures(arm, alone, together)
    for name, figure in drawn.items():
        save_figure(figure, plots / name, runs)
    title = "Barrett WAM, all joints, 0.5 rad in 7 s"
    write_replay(place / "replay.html", [one.run for one in runs[:2]], arm, labels=list(together), title=title)
    return page_extras(arm, simulated, runs, list(drawn.values()))
