"""One run of a study: one controller on one plant, in this process or in one of a pool."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from lwr_dyn.control.controller_file import faults_in
from lwr_dyn.control.controller_specs import ControllerSpec
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.errors import (
    DivergenceError,
    LwrDynError,
    MissingDataError,
    NotPhysicalError,
    OptionError,
    RatingWarning,
)
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.replayed_runs import PLAIN
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.studies.compare.compared_run import TorqueCuts, torque_cuts
from lwr_dyn.studies.compare.part_of_run import since, thinned
from lwr_dyn.studies.compare.plants import PlantCase

if TYPE_CHECKING:
    from lwr_dyn.studies.compare.study import ControllerStudy

REFUSALS = (DivergenceError, OptionError, MissingDataError, NotPhysicalError)
"""What a plant or a controller may say of one pair; the other pairs go on."""


@dataclass(frozen=True, slots=True, eq=False)
class StudyRun:
    """A run as a study keeps it, and its figures of merit, which are of all its samples."""

    run: Run
    figures: tuple[Metrics, TorqueCuts]


@dataclass(frozen=True, slots=True)
class StudyFault:
    """Why a pair has no run."""

    controller: str
    plant: str
    text: str
    cause: LwrDynError | None = None
    """The error itself, where it was raised in this process."""
    stops: bool = False
    """Whether the study ends with it."""

    def error(self) -> LwrDynError:
        """The error, to be raised."""
        return LwrDynError(self.text) if self.cause is None else self.cause


@dataclass(frozen=True, slots=True, eq=False)
class Workshop:
    """A study in one process: each controller is made once."""

    study: ControllerStudy
    made: dict[str, Controller] = field(default_factory=dict)
    models: list[Dynamics] = field(default_factory=list)

    def controller(self, spec: ControllerSpec) -> Controller:
        """The controller; raises as `make_controller`."""
        if spec.text not in self.made:
            if not self.models:
                self.models.append(dynamics_of(self.study.arm))
            self.made[spec.text] = spec.make(self.study.arm, self.models[0], self.tuned(spec))
        return self.made[spec.text]

    def tuned(self, spec: ControllerSpec) -> Mapping[str, Any]:
        """Options that the study adds to those of the text."""
        return (self.study.tuned or {}).get(spec.text, {})

    def run(self, index: int) -> StudyRun | StudyFault:
        """Run number `index`, from 0, plant by plant; raises what is neither a divergence nor a refusal."""
        study = self.study
        spec = study.specs[index % len(study.controllers)]
        case = study.plants[index // len(study.controllers)]
        controller = self.controller(spec)
        try:
            run = self._simulated(spec, controller, case)
            if study.folder is not None:
                run.save(study.folder / f"run_{index + 1}.npz")
            part = since(run, study.since)
        except REFUSALS as fault:
            return StudyFault(label_of(controller), _plant_words(case), str(fault), fault)
        figures = metrics(part, study.arm), torque_cuts(part, study.arm)
        return StudyRun(part if study.rate is None else replace(thinned(part, study.rate), setup=None), figures)

    def _simulated(self, spec: ControllerSpec, controller: Controller, case: PlantCase) -> Run:
        study, words = self.study, option_words({**spec.options, **self.tuned(spec)})
        note = {"task": study.task, "plant": ", ".join(case.words), "controller_options": words, "typed": spec.text}
        said = {name: text for name, text in note.items() if text or name == "task"}
        with faults_in(spec.base):
            return simulate(study.arm, controller, study.reference, **dict(study.options), **case.options, meta=said)


def _plant_words(case: PlantCase) -> str:
    load = [f"{case.options['payload']:g} kg"] if "payload" in case.options else []
    return ", ".join([*case.words, *load]) or PLAIN


def option_words(options: Mapping[str, Any]) -> str:
    """Numbers among the options of a controller in words; what a switch does is in the controller's label.

    >>> option_words({"omega_n": 23.84, "velocity_error": True})
    'omega_n 23.8'
    """
    numbers = {name: x for name, x in options.items() if isinstance(x, int | float) and not isinstance(x, bool)}
    texts = {name: x for name, x in options.items() if isinstance(x, str)}
    return ", ".join([*(f"{name} {x:.3g}" for name, x in numbers.items()), *(f"{k} {x}" for k, x in texts.items())])


_OWN: list[Workshop] = []
"""The workshop of a process of a pool."""


def begin(study: ControllerStudy) -> None:
    """The first thing that a process of a pool does."""
    _OWN[:] = [Workshop(study)]


def run_in_pool(index: int) -> tuple[StudyRun | StudyFault, tuple[str, ...]]:
    """`Workshop.run` in a process of a pool, and what it warned of; all of it can be pickled."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", RatingWarning)
        try:
            result = _OWN[0].run(index)
        except LwrDynError as fault:
            result = StudyFault("", "", str(fault), stops=True)
    words = tuple(str(one.message) for one in said if issubclass(one.category, RatingWarning))
    if isinstance(result, StudyFault):
        return replace(result, cause=None), words
    return replace(result, run=replace(result.run, setup=None)), words  # a setup holds an engine
