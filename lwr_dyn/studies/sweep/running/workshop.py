"""A study in one process: its arm, references and controllers are built once, and its runs are made, in rows.

Runs of a controller without a kernel form: one by one, by `simulate`, with the parameters that rollouts take.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.codegen.rollouts.law_forms import NoKernelFormError, law_form
from lwr_dyn.codegen.rollouts.loop_setup import LoopSetup, check_smooth_friction, loop_setup
from lwr_dyn.codegen.rollouts.result import Rollouts, figures_of, quantile_name
from lwr_dyn.codegen.rollouts.rollouts import rollouts, simulated_run
from lwr_dyn.codegen.rollouts.run_parameters import arm_of_run, parameter_shapes, run_parameters
from lwr_dyn.control.controllers import faults_in
from lwr_dyn.control.protocol import Controller
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import DivergenceError, LwrDynError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.studies.sweep.rollout_arguments import controller_of_run, rollout_arguments
from lwr_dyn.studies.sweep.running.chunks import Chunk, encoded
from lwr_dyn.studies.sweep.running.cluster import WorkerVersionError, refuse_other_versions
from lwr_dyn.studies.sweep.running.sweep_folder import versions
from lwr_dyn.studies.sweep.sampling import Values
from lwr_dyn.studies.sweep.summary import ControllerRuns
from lwr_dyn.studies.sweep.sweep_study import (
    SweepStudy,
    arm_of_study,
    controller_of_study,
    references_of_study,
    refuse_changed,
    spec_of_study,
)
from lwr_dyn.studies.sweep.vocabulary import METRICS

DIVERGED = "diverged"
"""The flag of a run whose state grows beyond all bounds; its metrics are not known."""

_NOT_OF_LOOP = ("parameters", "tolerance", "quantiles", "record", "hand_over")


class RunFaultError(LwrDynError, RuntimeError):
    """A run of a study fails: its `number`, and why."""

    def __init__(self, number: int, why: str) -> None:
        super().__init__(f"run {number}: {why}")
        self.number = number


class SimulatedRows:
    """Rows of runs, as `rollouts` takes them, by `simulate`.

    Parameters
    ----------
    arm : Arm
        As the controllers know it.
    controllers : callable
        Row -> its controller.
    references : sequence of Reference
    arguments : mapping
        Keywords of `rollouts`.
    first_run : int
        Number of the first row.
    count : int
        Of rows.
    file : str
        Of the controllers; "" where they come from a package.

    Raises
    ------
    OptionError, ShapeError, UnknownNameError
        As `rollouts`.
    """

    def __init__(
        self,
        arm: Arm,
        controllers: Callable[[int], Controller],
        references: Sequence[Reference],
        arguments: Mapping[str, Any],
        first_run: int,
        count: int,
        file: str = "",
    ) -> None:
        self.loop = {name: value for name, value in arguments.items() if name not in _NOT_OF_LOOP}
        self.arm, self.controllers, self.references = arm, controllers, references
        self.first_run, self.count, self.file = first_run, count, file
        self.tolerance, self.quantiles = arguments.get("tolerance"), tuple(arguments.get("quantiles", ()))
        self._setup: LoopSetup | None = None
        shapes = parameter_shapes(arm.n)
        _, self.given = run_parameters(arguments.get("parameters") or {}, count, shapes, len(references))
        check_smooth_friction(self.setup(0), self.given)

    def setup(self, i: int) -> LoopSetup:
        """The loop of a row; rows with one controller share it."""
        controller = self.controllers(i)
        if self._setup is None or self._setup.controller is not controller:
            self._setup = loop_setup(self.arm, controller, self.references, **self.loop)
        return self._setup

    def row(self, i: int) -> dict[str, Array]:
        """The parameters of a row."""
        return {name: array[i] for name, array in self.given.items()}

    def run(self, i: int) -> Run:
        """A row by `simulate`; raises as that, above all `DivergenceError`, and `FileAccessError` as `faults_in`."""
        with faults_in(self.file):
            return simulated_run(self.setup(i), self.row(i), self.first_run + i)

    def figures(self) -> tuple[dict[str, Array], list[str]]:
        """Metrics of all rows, and their flags; raises `RunFaultError` for what `simulate` or a controller refuses."""
        rows: list[dict[str, Array] | None] = []
        for i in range(self.count):
            try:
                plant = arm_of_run(self.setup(i).plant, self.row(i))
                rows.append(figures_of(self.run(i), plant, self.tolerance, self.quantiles))
            except DivergenceError:
                rows.append(None)
            except LwrDynError as fault:
                raise RunFaultError(self.first_run + i, str(fault)) from fault
        return self._metrics(rows), ["" if row is not None else DIVERGED for row in rows]

    def _metrics(self, rows: Sequence[Mapping[str, Array] | None]) -> dict[str, Array]:
        """Columns of rows, NaN where there is none."""
        shapes: dict[str, tuple[int, ...]] = {name: (self.arm.n,) * row.per_joint for name, row in METRICS.items()}
        shapes |= {quantile_name(share): () for share in self.quantiles}
        return {
            name: np.stack([np.full(shape, np.nan) if row is None else row[name] for row in rows])
            for name, shape in shapes.items()
        }


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
