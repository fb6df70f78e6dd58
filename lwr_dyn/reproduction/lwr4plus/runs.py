"""The runs behind the report: both controllers on IST, and how the controllers rank when the model is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.worst_case_inertia import worst_case_inertias
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.simulation.plant import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.simulation.simulate import simulate

PLANTS = ("as modelled", "10 % heavier", "3 kg at the flange")
"""What is really moved; the controllers always believe in the arm as modelled."""


@dataclass(frozen=True, slots=True, eq=False)
class ControllerRun:
    """One controller on one plant."""

    controller: str
    plant: str
    run: Run
    metrics: Metrics


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


def ranking(found: Sequence[ControllerRun], plant: str) -> tuple[ControllerRun, ...]:
    """The controller_runs on a plant, smallest RMS error of the tip first."""
    return tuple(sorted((t for t in found if t.plant == plant), key=lambda t: t.metrics.tip_rms_mm))
