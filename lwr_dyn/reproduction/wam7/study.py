"""Everything the WAM paper simulates: tables, runs, Figures 4 to 8 redrawn, a replay."""

from pathlib import Path

from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.paper_study import Progress, Reproduction
from lwr_dyn.reproduction.wam7.figures import pictures
from lwr_dyn.reproduction.wam7.runs import GRAVITIES, cruise_errors, experiments
from lwr_dyn.reproduction.wam7.tables import (
    cruise_table,
    figure_7_holds,
    figure_7_table,
    findings,
    passivity_table,
    run_table,
)


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
        tables=(
            cruise_table(cruises), findings(cruises), figure_7_table(cruises), passivity_table(arm),
            run_table(simulated),
        ),
        record={"cruises": [c.record() for c in cruises], "runs": [e.record() for e in simulated]},
        known={"settled": {"error": settled}},
        pictures=pictures(arm, simulated),
    )  # fmt: skip
