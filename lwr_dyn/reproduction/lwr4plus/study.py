"""Everything the LWR 4+ paper prints, recomputed; every controller on IST, also with a wrong model; the figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.foundation.document import Note
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm, arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.pages.figures.figure import Figure
from lwr_dyn.pages.figures.run_figures import error_figure, path_figure, tip_error_figure, torque_figure
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs
from lwr_dyn.reproduction.lwr4plus import TIMINGS, formulas, worst_cases
from lwr_dyn.reproduction.paper_study import Pictures, Progress, Reproduction, study_document
from lwr_dyn.reproduction.report.content import ReportSection, Still
from lwr_dyn.simulation.metrics import RIGID, Metrics, metrics
from lwr_dyn.simulation.simulate import simulate

PLANTS = ("as modelled", "10 % heavier", "3 kg at the flange")
"""The simulated plants; the model of the controllers is always the arm as modelled."""


def run(_: Path, arm: Arm, progress: Progress, timing: str = "smooth", fit_arm_angle: bool = False) -> Reproduction:
    """Recompute the paper: tables, runs, figures and the replay.

    Tables VII and VIII are computed under all timings; `timing` is that of the runs that are replayed. With
    `fit_arm_angle` they are also computed with the arm angle fitted to Table VIII, and named as fitted.
    """
    progress("Tables IV and VI")
    inertias, gains = worst_cases.inertia_rows(), worst_cases.gain_cells()
    shells = {name: worst_cases.shell_asymmetry(a) for name, a in worst_cases.arms().items()}
    progress("Tables VII and VIII")
    angles = [None, *([formulas.fitted_arm_angle(arm)] if fit_arm_angle else [])]
    errors = {
        name: [formulas.error_table(arm, name, t, angle) for angle in angles for t in TIMINGS]
        for name in ("table_vii", "table_viii")
    }
    velocity = formulas.velocity_rows(min(errors["table_viii"], key=lambda t: t.distance), arm)
    progress("controllers on three plants")
    runs = controller_runs(arm, formulas.shared_ist(arm, timing))
    progress("plots and replay")
    own = {name: [t for t in tables if t.arm_angle == formulas.LARGEST_MARGIN] for name, tables in errors.items()}
    nearest = {name: min(tables, key=lambda t: t.distance) for name, tables in own.items()}
    nearer = min(velocity, key=lambda name: velocity[name])
    spread = "Principal moments of the mirror-image links 1 to 4, largest spread over mean"
    return Reproduction(
        holds=all(r.reproduced("computed") for r in inertias) and all(g.reproduced or g.fits for g in gains),
        document=study_document(
            worst_cases.inertia_table(inertias),
            Note(f"{spread}: {_listed(shells, '.1%')}"),
            worst_cases.gain_table(gains),
            *(table for tables in errors.values() for table in formulas.condition_tables(tables)),
            Note(
                "Table VIII, velocity maxima and minima, RMS miss over row range: "
                f"{_listed(velocity, '.2f')}; nearer: {nearer}"
            ),
            ranking_table(runs),
            table_iv=[row.record() for row in inertias],
            errata_that_matter=list(worst_cases.errata_that_matter()),
            table_vi=[cell.record() for cell in gains],
            **{name: [table.record() for table in tables] for name, tables in errors.items()},
            controllers=[run.record() for run in runs],
            shell_spread=shells,
            velocity_rows=velocity,
        ),
        known={name: formulas.error_columns(one) for name, one in nearest.items()},
        pictures=pictures(arm, runs, nearest["table_viii"].run),
    )


@dataclass(frozen=True, slots=True, eq=False)
class ControllerRun:
    """One controller, by its name in the registry, on one plant."""

    controller: str
    plant: str
    run: Run
    metrics: Metrics

    @property
    def name(self) -> str:
        """For tables and pages."""
        return f"{self.label}, {self.plant}"

    @property
    def label(self) -> str:
        """The controller and its variant."""
        return str(self.run.meta["controller"]["label"])

    @property
    def file(self) -> str:
        """Name of the file that keeps the run."""
        return f"{self.controller}_{self.plant.replace(' ', '_').replace('%', 'percent')}.npz"

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        own = {"controller": self.controller, "label": self.label, "plant": self.plant}
        return own | {"audit": self.run.meta["audit"]} | self.metrics.to_json()


def plants(arm: Arm) -> dict[str, Arm]:
    """The plants by name."""
    return dict(zip(PLANTS, (arm, arm_with_scaled_inertia(arm, 1.1), arm_with_payload(arm, 3.0)), strict=True))


def controller_runs(arm: Arm, reference: Reference) -> tuple[ControllerRun, ...]:
    """Every controller on every plant: PD in the paper's form, PID, inverse dynamics with feed-forward."""
    searched = {"inertia": [w.value for w in worst_case_inertias(arm)]}
    controllers: dict[str, dict[str, Any]] = {"pd-gravity": searched, "pid": searched, "inverse-dynamics": {}}
    out = []
    for plant_name, plant in plants(arm).items():
        for name, options in controllers.items():
            controller = make_controller(name, arm, **options)
            run = simulate(arm, controller, reference, plant=plant, meta={"task": "ist", "plant": plant_name})
            out.append(ControllerRun(name, plant_name, run, metrics(run, arm)))
    return tuple(out)


def ranking(runs: Sequence[ControllerRun], plant: str) -> tuple[ControllerRun, ...]:
    """The runs on a plant, smallest RMS error of the tip first."""
    return tuple(sorted((run for run in runs if run.plant == plant), key=lambda run: run.metrics.tip_rms_mm))


def ranking_table(runs: Sequence[ControllerRun]) -> Table:
    """The controllers on each plant, best first."""
    rows = []
    for plant in PLANTS:
        for place, run in enumerate(ranking(runs, plant), start=1):
            m, audit = run.metrics, run.run.meta["audit"]
            use = max(m.torque_use), max(m.speed_use)
            rows.append((plant, place, run.label, m.tip_rms_mm, m.tip_max_mm, *use, m.limits, audit["residual"]))
    errors = [Heading(name, "mm", ".4g") for name in ("tip RMS", "tip max")]
    shares = [Heading(name, format=".0%") for name in ("torque", "speed")]
    title = f"Controllers on IST, ranked by RMS error of the tip ({RIGID}); their model is the arm as modelled"
    audits = Heading("audit", "J", ".1e")
    return Table(title, ("plant", "place", "controller", *errors, *shares, "limits", audits), rows)


PD, INVERSE, DROOP = 0, 1, 2
"""Places of the runs that are shown: both controllers on the arm as modelled, and what Table VIII seems to be of."""

ASSUMED = "timing, tool orientation and arm angle are not printed: assumed here"


def pictures(arm: Arm, simulated: Sequence[ControllerRun], table_viii: Run) -> Pictures:
    """Figures 4, 6, 7, 9 and 10, torques, Figure 2 as a still; both controllers on the arm as modelled are replayed."""
    replayed = [run for run in simulated if run.plant == "as modelled" and run.controller != "pid"]
    shown = replayed_runs([*(run.run for run in replayed), table_viii], arm)
    return Pictures(
        simulated=tuple((run.name, run.file, run.run) for run in simulated),
        shown=shown,
        figures={file: [figure] for file, figure in _figures(shown).items()},
        stills=(Still("Fig. 2: frames, arm stretched up", arm, np.zeros(arm.n), "q = 0, DH frames of every link"),),
        sections=(ReportSection("controllers", "Wrong models", "", (ranking_table(simulated),)),),
        title="KUKA LWR 4+ draws IST",
        replayed=len(replayed),
    )


def _figures(runs: Sequence[ReplayedRun]) -> dict[str, Figure]:
    """File -> figure."""

    def like(figure: Figure, number: str, title: str, note: str = "") -> Figure:
        return replace(figure, id=f"figure-{number}", title=title, where=f"Fig. {number.rstrip('ab')}", note=note)

    path, errors = partial(path_figure, runs), partial(error_figure, runs)
    return {
        "figure_04_path": like(path((PD, INVERSE)), "4", "Trajectory to be implemented"),
        "figure_07_path_pd": like(path((PD,)), "7", "Trajectory obtained, decentralised"),
        "figure_10_path_inverse_dynamics": like(path((INVERSE, DROOP)), "10", "Trajectory obtained, centralised"),
        "tip_error": tip_error_figure(runs),
        "torque": torque_figure(runs, (PD, INVERSE)),
        "figure_06_position_error_pd": like(errors((PD,)), "6", "Position error, decentral", ASSUMED),
        "figure_09_position_error_inverse_dynamics": like(
            errors((DROOP, INVERSE)), "9a", "Position error, central", ASSUMED
        ),
        "figure_09_velocity_error_inverse_dynamics": like(
            errors((DROOP, INVERSE), "velocity error"), "9b", "Velocity error, central"
        ),
        "position_error": replace(errors((PD, INVERSE)), id=""),
        "velocity_error": replace(errors((PD, INVERSE), "velocity error"), id=""),
    }


def _listed(values: Mapping[str, float], form: str) -> str:
    return ", ".join(f"{name} {x:{form}}" for name, x in values.items())
