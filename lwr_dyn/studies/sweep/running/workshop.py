"""A study in one process: its arm, references and controllers are built once, and its runs are made, in rows."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.codegen.rollouts.laws.forms import law_form
from lwr_dyn.codegen.rollouts.laws.no_form import NoKernelFormError
from lwr_dyn.codegen.rollouts.result import Rollouts
from lwr_dyn.codegen.rollouts.rollouts import rollouts
from lwr_dyn.control.protocol import Controller
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.run import Run
from lwr_dyn.studies.sweep.running.chunk_file import encoded
from lwr_dyn.studies.sweep.running.cluster import WorkerVersionError, refuse_other_versions
from lwr_dyn.studies.sweep.running.manifest import versions
from lwr_dyn.studies.sweep.running.simulated_rows import SimulatedRows
from lwr_dyn.studies.sweep.running.tasks import Chunk
from lwr_dyn.studies.sweep.statistics.controller_runs import ControllerRuns
from lwr_dyn.studies.sweep.study.distributions import Values
from lwr_dyn.studies.sweep.study.rollout_arguments import controller_of_run, rollout_arguments
from lwr_dyn.studies.sweep.study.source_files import refuse_changed
from lwr_dyn.studies.sweep.study.study_file import SweepStudy
from lwr_dyn.studies.sweep.study.study_setup import (
    arm_of_study,
    controller_of_study,
    references_of_study,
    spec_of_study,
)

BY_SIMULATE = "simulate"
"""Stands for the digest of a kernel where there is none; the study's own has that of the controller's file."""
OF_LAW = ("controller.", "payload.known")
"""Paths that make a controller of its own for each run of `simulate`."""
_own = threading.local()


class SweepWorkshop:
    """Makes runs of a study; of one thread, because a controller may remember what it has seen.

    The files of the study are looked at again when they have been read, and before runs are made. Raises as
    `arm_of_study`, `references_of_study` and `refuse_changed`.
    """

    def __init__(self, study: SweepStudy, threads: int = 1) -> None:
        self.study, self.threads = study, threads
        self.arm = arm_of_study(study)
        self.references = references_of_study(study)
        self._controllers: dict[str, Controller] = {}
        self._slow: dict[str, bool] = {}
        refuse_changed(study)

    def controller(self, text: str) -> Controller:
        """The controller of a text; raises as `make_controller` and `refuse_changed`."""
        if text not in self._controllers:
            made = controller_of_study(self.study, text)
            refuse_changed(self.study)
            self._controllers[text] = made
        return self._controllers[text]

    def is_slow(self, text: str) -> bool:
        """Whether a controller has no kernel form, so that `simulate` makes its runs, in processes."""
        if text not in self._slow:
            self._slow[text] = spec_of_study(self.study, text).is_file or not self._has_form(text)
        return self._slow[text]

    def _has_form(self, text: str) -> bool:
        try:
            law_form(self.controller(text), self.arm)
        except NoKernelFormError:
            return False
        return True

    def runs(self, text: str, first: int, stop: int) -> tuple[ControllerRuns, str]:
        """Runs of the study from `first` to `stop` (without it), and the digest of what computed them.

        Raises as `rollouts`; `RunFaultError` for what a controller of a user's own does.
        """
        values = self.study.values(first, stop)
        digest, simulated = BY_SIMULATE, np.ones(stop - first, dtype=bool)
        if self.is_slow(text):
            metrics, flags = self.rows(text, values, first, stop - first).figures()
        else:
            made = self.rollouts(text, values, first, stop - first)
            metrics, flags, simulated, digest = dict(made.metrics), list(made.flags), made.simulated, made.digest
        run = np.arange(first, stop, dtype=np.int64)
        return ControllerRuns(text, run, values, metrics, np.array(flags, dtype=str), simulated), digest

    def run(self, text: str, number: int) -> Run:
        """One run of the study again, whole, by `simulate`; raises as that, above all `DivergenceError`."""
        values = self.study.values(number, number + 1)
        if self.is_slow(text):
            return self.rows(text, values, number, 1).run(0)
        return self.rollouts(text, values, number, 1, hand_over=False).run(0)

    def evaluate(self, text: str, values: Mapping[str, Values], hand_over: bool = False) -> Mapping[str, Array]:
        """Metrics of runs with other values than the study's, a row a run; NaN where a kernel cannot follow one.

        Raises `NoKernelFormError` for a controller without a kernel form, and as `rollouts`.
        """
        return self.rollouts(text, values, 0, len(next(iter(values.values()))), hand_over=hand_over).metrics

    def rollouts(self, text: str, values: Mapping[str, Values], first: int, count: int, **more: Any) -> Rollouts:
        """Runs by the kernel; `more` goes before what the study says. Raises as `rollouts` and `refuse_changed`."""
        refuse_changed(self.study)
        arguments = {**rollout_arguments(self.study, text, values), **more}
        options = {"runs": count, "threads": self.threads, "first_run": first, **arguments}
        return rollouts(self.arm, self.controller(text), self.references, **options)

    def rows(self, text: str, values: Mapping[str, Values], first: int, count: int) -> SimulatedRows:
        """Runs by `simulate`; raises as `SimulatedRows` and `refuse_changed`."""
        refuse_changed(self.study)
        of_law = [path for path in values if path.startswith(OF_LAW)]
        made: dict[int, Controller] = {}

        def controller(i: int) -> Controller:
            if not of_law:
                return self.controller(text)
            if i not in made:  # rows come one after the other
                made.clear()
                made[i] = controller_of_run(self.study, text, values, i)
                refuse_changed(self.study)
            return made[i]

        rest = {path: x for path, x in values.items() if path not in of_law}
        arguments = rollout_arguments(self.study, text, rest)
        base = spec_of_study(self.study, text).base
        return SimulatedRows(self.arm, controller, self.references, arguments, first, count, base)


def workshop_of(study: SweepStudy) -> SweepWorkshop:
    """The workshop of this thread, built when it is first needed; raises as `SweepWorkshop`."""
    key = study.digest, dict(study.places)
    if getattr(_own, "key", None) != key:
        _own.workshop, _own.key = SweepWorkshop(study), key
    found: SweepWorkshop = _own.workshop
    return found


@dataclass(frozen=True, slots=True)
class SweepJob:
    """What makes the file of any chunk of a study, here or in another process; `versions` are those it must have."""

    study: SweepStudy
    digests: tuple[str, ...]
    """Of each controller's chunks."""
    kernels: tuple[str, ...]
    versions: Mapping[str, str]

    def __call__(self, chunk: Chunk) -> bytes:
        """The file of a chunk.

        Raises `WorkerVersionError` in a process with other versions or another kernel, and as `SweepWorkshop.runs`.
        """
        refuse_other_versions({"of the chunk": versions()}, self.versions)
        text = self.study.controllers[chunk.controller]
        runs, kernel = workshop_of(self.study).runs(text, chunk.first, chunk.stop)
        if kernel != self.kernels[chunk.controller]:
            raise WorkerVersionError("of the chunk", "kernel", kernel[:8], self.kernels[chunk.controller][:8])
        names = {one.path: one.columns for one in self.study.parameters}
        return encoded(runs, self.digests[chunk.controller], names)
