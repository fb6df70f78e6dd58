"""Closed-loop runs: a controller whose model is one reading of a robot, a plant that is another; every pair."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from lwr_dyn.checks.sensitivity.simulated_task import SimulatedTask, controller_of
from lwr_dyn.checks.sensitivity.statics import Statics
from lwr_dyn.control.linear_feedback import Linearised
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.design.sampled_loop import Sampling
from lwr_dyn.design.sampled_stability import stability_along
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.model.arm import Arm
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.simulation.simulate import simulate

Progress = Callable[[float], None]
PLACES = 50
"""Places along the reference at which the sampled loop is judged."""
SAFE = 1.6
"""Times the least rate that holds: the rate that is chosen where the usual one would not hold."""


@dataclass(frozen=True, slots=True, eq=False)
class ClosedLoopResult:
    """One closed-loop run: the controller's label, its model, the simulated plant, and the result."""

    controller: str
    model: str
    plant: str
    metrics: Metrics | None
    """None when the simulation failed."""
    fault: str = ""
    rate: float = 0.0
    """Samples a second [Hz]: more than wanted where a torque held that long would make the loop chatter."""

    @property
    def tip_rms_mm(self) -> float:
        """RMS error of the tip [mm], NaN when the simulation failed."""
        return np.nan if self.metrics is None else self.metrics.tip_rms_mm

    @property
    def worst_mrad(self) -> float:
        """Largest error of a joint [mrad; mm for a sliding one]."""
        if self.metrics is None:
            return np.nan
        errors = self.metrics.position_mrad
        return float(np.maximum(errors.max, -errors.min).max())


def closed_loops(
    arms: Mapping[str, Arm],
    study: SimulatedTask,
    statics: Mapping[str, Statics],
    rate: float,
    progress: Progress | None = None,
) -> Iterator[ClosedLoopResult]:
    """A run for every controller, model and plant."""
    choices = study.task.controllers
    total, done = len(choices) * len(arms) ** 2, 0
    for choice in choices:
        for model in arms:
            controller = controller_of(arms[model], choice, statics[model].b)
            for plant in arms:
                yield _run(arms, study, label_of(controller), controller, model, plant, rate)
                done += 1
                if progress is not None:
                    progress(done / total)


def _run(
    arms: Mapping[str, Arm],
    study: SimulatedTask,
    name: str,
    controller: Controller,
    model: str,
    plant: str,
    rate: float,
) -> ClosedLoopResult:
    used = _rate_that_holds(arms[plant], controller, study, rate)
    substeps = study.task.substeps
    try:
        run = simulate(arms[model], controller, study.reference, plant=arms[plant], rate=used, substeps=substeps)
    except LwrDynError as fault:
        return ClosedLoopResult(name, model, plant, None, str(fault), used)
    return ClosedLoopResult(name, model, plant, metrics(run, arms[plant]), rate=used)


def _rate_that_holds(plant: Arm, controller: Controller, study: SimulatedTask, rate: float) -> float:
    """The wanted rate [Hz], or a multiple of it `SAFE` above the least that holds along the reference, if any does."""
    reference = study.reference
    q = reference.sample(np.linspace(0.0, reference.duration, PLACES)).q
    found = stability_along(dynamics_of(plant), cast(Linearised, controller), Sampling(rate), q)
    return rate if found.holds or found.least_rate is None else rate * math.ceil(SAFE * found.least_rate / rate)
