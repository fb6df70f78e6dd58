"""The runs of the study: every controller on IST, and their ranking when the model is wrong."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.changed_arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.simulation.metrics import RIGID, Metrics, metrics
from lwr_dyn.simulation.simulate import simulate

PLANTS = ("as modelled", "10 % heavier", "3 kg at the flange")
"""The simulated plants; the model of the controllers is always the arm as modelled."""


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
        return {
            "controller": self.controller,
            "label": self.label,
            "plant": self.plant,
            "audit": self.run.meta["audit"],
        } | self.metrics.to_json()


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
