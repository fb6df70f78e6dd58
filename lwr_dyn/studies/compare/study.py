"""Controllers x plants: every controller on every plant, on one reference, in one process or several.

Gains of one margin for all controllers of a study: the largest omega_n whose loop keeps it along the task.

The margin is the largest |S_ii| over the joints and frequencies at the worst of several plants: the arm as modelled
with a delay of 1 to 4 samples, and with its elastic gears where its file gives them and its rotors carry them. A law
is judged by its linear form at rest at poses of the task, which says nothing of large errors or of torque limits.

One run of a study: one controller on one plant, in this process or in one of a pool.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.control.controllers import CONTROLLERS, ControllerSpec, controller_spec, faults_in
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.design.defaults import law_fault, unstable_words
from lwr_dyn.design.gain_search import TunedFrequency, largest_omega_n
from lwr_dyn.design.loop_judgement import LoopCase
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation import errors
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.progress import Report
from lwr_dyn.foundation.registry import options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.caveats import ROTOR_OPTION
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.pages.replay.replayed_runs import PLAIN
from lwr_dyn.simulation.elastic.plant import SLOWEST, fastest_on_motors
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.studies.compare.compared_run import TorqueCuts, since, thinned, torque_cuts
from lwr_dyn.studies.compare.comparison import RunComparison, comparison_of
from lwr_dyn.studies.compare.plants import PlantCase

DELAYS = (1, 2, 3, 4)
"""[samples]"""
POSES = 21
"""Of the task, evenly in time, at which a loop is judged."""


def tuned_frequencies(
    arm: Arm,
    specs: Sequence[ControllerSpec],
    reference: Reference,
    peak: float,
    rate: float = 1000.0,
    report: Report = lambda _: None,
) -> Mapping[str, TunedFrequency]:
    """Controller as typed -> its largest omega_n [1/s] with |S_ii| at most `peak`, None where none keeps it.

    Files, and laws without an option omega_n, are left out.

    Raises
    ------
    OptionError
        A peak that is not above 1, a controller whose text gives omega_n already.
    """
    if not (np.isfinite(peak) and peak > 1.0):
        raise errors.OptionError("tuned", peak, "a peak of |S| above 1, as 1.7")
    poses = poses_of(reference)
    cases = cases_of(arm, rate, poses)
    dynamics = dynamics_of(arm)
    found = {}
    for spec in specs:
        if spec.is_file or "omega_n" not in options_of(CONTROLLERS.load(spec.base)):
            continue
        if "omega_n" in spec.options:
            raise errors.OptionError(f"controller {spec.text!r}", "omega-n given, which is to be tuned", "without it")
        report(f"tuning {spec.text}")
        found[spec.text] = largest_omega_n(arm, spec.name, cases, q=poses, peak=peak, dynamics=dynamics, **spec.options)
    return found


def poses_of(reference: Reference) -> Array:
    """Poses (k, n) of a reference, evenly in time."""
    return np.asarray(reference.sample(np.linspace(0.0, reference.duration, POSES)).q)


def cases_of(arm: Arm, rate: float, poses: Array) -> tuple[LoopCase, ...]:
    """The plants of the margin; elastic gears only where the arm can have them."""
    rigid = tuple(LoopCase(rate=rate, delay=delay) for delay in DELAYS)
    return (*rigid, LoopCase(rate=rate, elasticity="file")) if is_elastic(arm, rate, poses) else rigid


def is_elastic(arm: Arm, rate: float, poses: Array) -> bool:
    """Whether the arm gives the stiffness of its gears, and has rotors that a law on the motors' side can drive."""
    if arm.elasticity is None or not (arm.armature > 0.0).all():
        return False
    B = dynamics_of(arm).mass_matrix(poses)
    return bool((fastest_on_motors(rate, arm.armature, B) >= SLOWEST).all())


REFUSALS = (errors.DivergenceError, errors.OptionError, errors.MissingDataError, errors.NotPhysicalError)
"""What a plant or a controller may say of one pair; the other pairs go on."""


StudyRun = tuple[Run, tuple[Metrics, TorqueCuts]]
"""A run as a study keeps it, and its figures of merit, which are of all its samples."""


@dataclass(frozen=True, slots=True)
class StudyFault:
    """Why a pair has no run."""

    controller: str
    plant: str
    text: str
    cause: errors.LwrDynError | None = None
    """The error itself, where it was raised in this process."""
    stops: bool = False
    """Whether the study ends with it."""

    def error(self) -> errors.LwrDynError:
        """The error, to be raised."""
        return errors.LwrDynError(self.text) if self.cause is None else self.cause


@dataclass(frozen=True, slots=True, eq=False)
class ControllerStudy:
    """What is simulated: controllers by text (see `controller_spec`), in the order of the table, on each plant."""

    arm: Arm
    reference: Reference
    controllers: Sequence[str]
    plants: Sequence[PlantCase]
    task: str = ""
    options: tuple[tuple[str, Any], ...] = ()
    """Of `simulate`, for all runs."""
    since: float = 0.0
    """[s] Figures and pictures are of the run from here on."""
    peak: float | None = None
    """Of |S_ii|, to which omega_n of each controller is tuned (`studies.compare.study`); as typed if not given."""
    tuned: Mapping[str, Mapping[str, Any]] | None = None
    """Controller as typed -> further options of its factory; what `run` fills in for a `peak`."""
    lenient: bool = False
    """Whether a controller that cannot be made for the arm, or is unstable at its rate, is a line of `failures` too."""
    folder: Path | None = None
    """Where each run is saved whole, as run_1.npz and so on."""

    @property
    def specs(self) -> list[ControllerSpec]:
        """The controllers; raises as `controller_spec`."""
        return [controller_spec(text) for text in self.controllers]

    @property
    def rate(self) -> float | None:
        """Samples a second [Hz] that a run keeps once its figures are computed; None for all."""
        return RATE if len(self.controllers) * len(self.plants) >= MANY else None

    def run(self, report: Report = lambda _: None, processes: int = 1) -> tuple[RunComparison, tuple[Run, ...]]:
        """The comparison and its runs, plant by plant, the same for any number of processes.

        A run that diverges, or that its plant or its controller refuses, is a line of `failures`.

        Raises as `make_controller`, `simulate` and `comparison_of`; where no run succeeds, what stopped the first.
        """
        for kind, chosen in (("controllers", self.controllers), ("plants", self.plants)):
            if not chosen:
                raise errors.OptionError(kind, "none", "one or more")
        if not 1 <= processes <= MOST:
            raise errors.OptionError("processes", processes, f"from 1 to {MOST}")
        study, failures = self._makeable()
        frequencies = study.frequencies(report)
        failures += [
            f"{text}: no omega_n keeps |S_ii| <= {self.peak:g}, {one.case.words}, joint {one.joint + 1}"
            for text, one in frequencies.items()
            if one.omega_n is None
        ]
        study, frequencies = study._tuned(frequencies)
        done: list[StudyRun] = []
        faults: list[StudyFault] = []
        count = len(study.controllers) * len(self.plants)
        results = _in_pool(study, count, processes) if processes > 1 else map(Workshop(study).run, range(count))
        for i, result in enumerate(results):
            report((i + 1) / count)
            if isinstance(result, StudyFault):
                if result.stops:
                    raise result.error()
                faults.append(result)
            else:
                done.append(result)
        if faults and not done:
            raise faults[0].error()
        runs, figures = zip(*done, strict=True)
        names = [f"run {i}" for i in range(1, len(runs) + 1)]
        failures += [f"{one.controller}, {one.plant}: {one.text}" for one in faults]
        arms = [self.arm] * len(runs)
        compared = comparison_of(runs, names, failures=failures, figures=figures, arms=arms, least=1)
        return replace(compared, tuned=frequencies, remedy=ROTOR_OPTION), runs

    def _tuned(self, frequencies: Mapping[str, TunedFrequency]) -> tuple[ControllerStudy, Mapping[str, TunedFrequency]]:
        """The study with its omega_n, without the controllers that have none; and those that have one."""
        found = {text: one for text, one in frequencies.items() if one.omega_n is not None}
        kept = [text for text in self.controllers if text in found or text not in frequencies]
        if not kept:
            raise errors.OptionError("tuned", self.peak, "a higher peak: no controller keeps it at any omega_n")
        options = {text: {"omega_n": one.omega_n} for text, one in found.items()}
        return replace(self, controllers=tuple(kept), tuned=options or self.tuned), found

    def frequencies(self, report: Report = lambda _: None) -> Mapping[str, TunedFrequency]:
        """Controller as typed -> its tuned omega_n; empty without a `peak`. Raises as `tuned_frequencies`."""
        if self.peak is None:
            return {}
        rate = dict(self.options).get("rate", 1000.0)
        return tuned_frequencies(self.arm, self.specs, self.reference, self.peak, rate, report)

    def _makeable(self) -> tuple[ControllerStudy, list[str]]:
        """The study with the controllers that can be made, which is tried before anything is simulated."""
        workshop, kept, failures = Workshop(self), list[str](), list[str]()
        missing: errors.LwrDynError | None = None
        for spec in self.specs:
            try:
                workshop.controller(spec)
            except (errors.MissingDataError, errors.MissingPackageError) as fault:
                if not self.lenient:
                    raise
                missing = missing or fault
                failures.append(f"{spec.text}: {fault}")
            else:
                why = self._left_out(workshop.controller(spec), workshop.models[0]) if self.lenient else ""
                (failures if why else kept).append(f"{spec.text}: left out: {why}" if why else spec.text)
        if not kept:
            raise missing or errors.OptionError("controllers", "none holds here", f"--controllers NAME; {failures[0]}")
        return replace(self, controllers=tuple(kept)), failures

    def _left_out(self, controller: Controller, dynamics: Dynamics) -> str:
        """Why a controller is left out, by its sampled loop on the arm as modelled; empty where it is not."""
        if not getattr(controller, "follows_reference", True):
            return "it follows no reference"
        rate = dict(self.options).get("rate", 1000.0)
        found = law_fault(self.arm, dynamics, controller, self.reference, rate)
        return "" if found is None else f"at {rate:g} Hz it {unstable_words(found)}"


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
            load = [f"{case.options['payload']:g} kg"] if "payload" in case.options else []
            plant = ", ".join([*case.words, *load]) or PLAIN
            return StudyFault(label_of(controller), plant, str(fault), fault)
        figures = metrics(part, study.arm), torque_cuts(part, study.arm)
        return part if study.rate is None else replace(thinned(part, study.rate), setup=None), figures

    def _simulated(self, spec: ControllerSpec, controller: Controller, case: PlantCase) -> Run:
        study, words = self.study, option_words({**spec.options, **self.tuned(spec)})
        note = {"task": study.task, "plant": ", ".join(case.words), "controller_options": words, "typed": spec.text}
        said = {name: text for name, text in note.items() if text or name == "task"}
        with faults_in(spec.base):
            return simulate(study.arm, controller, study.reference, **dict(study.options), **case.options, meta=said)


def option_words(options: Mapping[str, Any]) -> str:
    """Numbers among the options of a controller in words; what a switch does is in the controller's label.

    >>> option_words({"omega_n": 23.84, "velocity_error": True})
    'omega_n 23.8'
    """
    numbers = [f"{k} {x:.3g}" for k, x in options.items() if isinstance(x, int | float) and not isinstance(x, bool)]
    return ", ".join([*numbers, *(f"{k} {x}" for k, x in options.items() if isinstance(x, str))])


MANY, RATE = 24, 100.0
"""From so many runs on, pages and pictures keep so many samples a second of each; its figures are of all samples."""
MOST = 64
"""Processes at most."""


def _in_pool(study: ControllerStudy, count: int, processes: int) -> Iterator[StudyRun | StudyFault]:
    """The results in their order; what a process warns of is said here, once each."""
    with ProcessPoolExecutor(processes, get_context("spawn"), begin, (study,)) as pool:
        try:
            for result, warned in pool.map(run_in_pool, range(count)):
                for words in warned:
                    warnings.warn(words, errors.RatingWarning, stacklevel=2)
                yield result
        finally:
            pool.shutdown(cancel_futures=True)


_OWN: list[Workshop] = []
"""The workshop of a process of a pool."""


def begin(study: ControllerStudy) -> None:
    """The first thing that a process of a pool does."""
    _OWN[:] = [Workshop(study)]


def run_in_pool(index: int) -> tuple[StudyRun | StudyFault, tuple[str, ...]]:
    """`Workshop.run` in a process of a pool, and what it warned of; all of it can be pickled."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", errors.RatingWarning)
        try:
            result = _OWN[0].run(index)
        except errors.LwrDynError as fault:
            result = StudyFault("", "", str(fault), stops=True)
    words = tuple(str(one.message) for one in said if issubclass(one.category, errors.RatingWarning))
    if isinstance(result, StudyFault):
        return replace(result, cause=None), words
    run, figures = result
    return (replace(run, setup=None), figures), words  # a setup holds an engine
