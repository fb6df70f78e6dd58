"""Controllers x plants: every controller on every plant, on one reference, in one process or several."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from lwr_dyn.control.controller_specs import ControllerSpec, controller_spec
from lwr_dyn.design.gain_search import TunedFrequency
from lwr_dyn.foundation.errors import MissingDataError, MissingPackageError, OptionError, RatingWarning
from lwr_dyn.foundation.progress import Report
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.studies.compare.comparison import RunComparison, comparison_of
from lwr_dyn.studies.compare.plants import PlantCase
from lwr_dyn.studies.compare.study_run import StudyFault, StudyRun, Workshop, begin, run_in_pool

MANY = 24
"""From so many runs on, pages and pictures keep `RATE` samples a second of each; its figures are of all samples."""
RATE = 100.0
MOST = 64
"""Processes at most."""


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
    """Of |S_ii|, to which omega_n of each controller is tuned (`comparison.tuning`); as typed if not given."""
    tuned: Mapping[str, Mapping[str, Any]] | None = None
    """Controller as typed -> further options of its factory; what `run` fills in for a `peak`."""
    lenient: bool = False
    """Whether a controller that cannot be made for the arm is a line of `failures` too."""
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
                raise OptionError(kind, "none", "one or more")
        if not 1 <= processes <= MOST:
            raise OptionError("processes", processes, f"from 1 to {MOST}")
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
        runs, names = [one.run for one in done], [f"run {i}" for i in range(1, len(done) + 1)]
        failures += [f"{one.controller}, {one.plant}: {one.text}" for one in faults]
        compared = comparison_of(
            runs, names, failures=failures, figures=[one.figures for one in done], arms=[self.arm] * len(runs), least=1
        )
        return replace(compared, tuned=frequencies), tuple(runs)

    def _tuned(
        self, frequencies: Mapping[str, "TunedFrequency"]
    ) -> tuple["ControllerStudy", Mapping[str, "TunedFrequency"]]:
        """The study with its omega_n, without the controllers that have none; and those that have one."""
        found = {text: one for text, one in frequencies.items() if one.omega_n is not None}
        kept = [text for text in self.controllers if text in found or text not in frequencies]
        if not kept:
            raise OptionError("tuned", self.peak, "a higher peak: no controller keeps it at any omega_n")
        options = {text: {"omega_n": one.omega_n} for text, one in found.items()}
        return replace(self, controllers=tuple(kept), tuned=options or self.tuned), found

    def frequencies(self, report: Report = lambda _: None) -> Mapping[str, "TunedFrequency"]:
        """Controller as typed -> its tuned omega_n; empty without a `peak`. Raises as `tuned_frequencies`."""
        if self.peak is None:
            return {}
        from lwr_dyn.studies.compare.tuning import tuned_frequencies

        rate = dict(self.options).get("rate", 1000.0)
        return tuned_frequencies(self.arm, self.specs, self.reference, self.peak, rate, report)

    def _makeable(self) -> tuple["ControllerStudy", list[str]]:
        """The study with the controllers that can be made, which is tried before anything is simulated."""
        workshop, kept, failures = Workshop(self), [], []
        for spec in self.specs:
            try:
                workshop.controller(spec)
            except (MissingDataError, MissingPackageError) as fault:
                if not self.lenient:
                    raise
                failures.append(f"{spec.text}: {fault}")
            else:
                kept.append(spec.text)
        if not kept:
            raise OptionError("controllers", "none that can be made", failures[0])
        return replace(self, controllers=tuple(kept)), failures


def _in_pool(study: ControllerStudy, count: int, processes: int) -> Iterator[StudyRun | StudyFault]:
    """The results in their order; what a process warns of is said here, once each."""
    with ProcessPoolExecutor(processes, get_context("spawn"), begin, (study,)) as pool:
        try:
            for result, warned in pool.map(run_in_pool, range(count)):
                for words in warned:
                    warnings.warn(words, RatingWarning, stacklevel=2)
                yield result
        finally:
            pool.shutdown(cancel_futures=True)
