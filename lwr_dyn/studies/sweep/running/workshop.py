"""A study in one process: arm, references and controllers are built once, its runs made by kernel or `simulate`."""

import threading
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from lwr_dyn.codegen.rollouts.law_forms import NoKernelFormError, law_form
from lwr_dyn.codegen.rollouts.loop_setup import (
    LoopSetup,
    arm_of_run,
    check_smooth_friction,
    loop_setup,
    parameter_shapes,
    run_parameters,
)
from lwr_dyn.codegen.rollouts.result import Rollouts, figures_of, quantile_name
from lwr_dyn.codegen.rollouts.rollouts import rollouts, simulated_run
from lwr_dyn.codegen.rollouts.substeps import RUNS, Steps, enough_steps, steps, stride_of
from lwr_dyn.control.controllers import faults_in
from lwr_dyn.control.protocol import Controller
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import DivergenceError, LwrDynError
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED
from lwr_dyn.simulation.setup import Loop
from lwr_dyn.studies.sweep import sweep_study
from lwr_dyn.studies.sweep.rollout_arguments import controller_of_run, rollout_arguments
from lwr_dyn.studies.sweep.running.chunk_file import encoded
from lwr_dyn.studies.sweep.running.cluster import WorkerVersionError, refuse_other_versions
from lwr_dyn.studies.sweep.running.schedulers import Chunk
from lwr_dyn.studies.sweep.running.sweep_folder import versions
from lwr_dyn.studies.sweep.sampling import Values
from lwr_dyn.studies.sweep.summary import ControllerRuns
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
from lwr_dyn.studies.sweep.vocabulary import METRICS

DIVERGED = "diverged"
"""The flag of a run whose state grows beyond all bounds; its metrics are not known."""
BY_SIMULATE = "simulate"
"""Stands for the digest of a kernel where there is none; the study's own has that of the controller's file."""
OF_LAW = ("controller.", "payload.known")
"""Paths that make a controller of its own for each run of `simulate`."""
_own = threading.local()
_NOT_OF_LOOP = ("parameters", "tolerance", "quantiles", "record", "hand_over")


class RunFaultError(LwrDynError, RuntimeError):
    """A run of a study fails: its `number`, and why."""

    def __init__(self, number: int, why: str) -> None:
        super().__init__(f"run {number}: {why}")
        self.number = number


class SweepWorkshop:
    """Makes runs of a study; of one thread, because a controller may remember what it has seen.

    The files of the study are looked at again when they have been read, and before runs are made. Raises as
    `arm_of_study`, `references_of_study` and `refuse_changed`.
    """

    def __init__(self, study: SweepStudy, threads: int = 1) -> None:
        self.study, self.threads = study, threads
        self.arm = sweep_study.arm_of_study(study)
        self.references = sweep_study.references_of_study(study)
        self._controllers: dict[str, Controller] = {}
        self._slow: dict[str, bool] = {}
        sweep_study.refuse_changed(study)

    def controller(self, text: str) -> Controller:
        """The controller of a text; raises as `make_controller` and `refuse_changed`."""
        if text not in self._controllers:
            made = sweep_study.controller_of_study(self.study, text)
            sweep_study.refuse_changed(self.study)
            self._controllers[text] = made
        return self._controllers[text]

    def is_slow(self, text: str) -> bool:
        """Whether a controller has no kernel form, so that `simulate` makes its runs, in processes."""
        if text not in self._slow:
            self._slow[text] = sweep_study.spec_of_study(self.study, text).is_file
            try:
                if not self._slow[text]:
                    law_form(self.controller(text), self.arm)
            except NoKernelFormError:
                self._slow[text] = True
        return self._slow[text]

    def runs(self, text: str, first: int, stop: int) -> tuple[ControllerRuns, str]:
        """Runs of the study from `first` to `stop` (without it), and the digest of what computed them.

        Raises as `rollouts`; `RunFaultError` for what a controller of a user's own does.
        """
        values = self.study.values(first, stop)
        digest, simulated = BY_SIMULATE, np.ones(stop - first, dtype=bool)
        if self.is_slow(text):
            metrics, flags = SimulatedRows(self, text, values, first, stop - first).figures()
        else:
            made = self.rollouts(text, values, first, stop - first)
            metrics, flags, simulated, digest = dict(made.metrics), list(made.flags), made.simulated, made.digest
        run = np.arange(first, stop, dtype=np.int64)
        return ControllerRuns(text, run, values, metrics, np.array(flags, dtype=str), simulated), digest

    def run(self, text: str, number: int) -> Run:
        """One run of the study again, whole, by `simulate`; raises as that, above all `DivergenceError`."""
        values = self.study.values(number, number + 1)
        if self.is_slow(text):
            return SimulatedRows(self, text, values, number, 1).run(0)
        return self.rollouts(text, values, number, 1, hand_over=False).run(0)

    def evaluate(self, text: str, values: Mapping[str, Values], hand_over: bool = False) -> Mapping[str, Array]:
        """Metrics of runs with other values than the study's, a row a run; NaN where a kernel cannot follow one.

        Raises `NoKernelFormError` for a controller without a kernel form, and as `rollouts`.
        """
        return self.rollouts(text, values, 0, len(next(iter(values.values()))), hand_over=hand_over).metrics

    def steps(self, text: str) -> Steps | None:
        """The study's substeps with their error, of up to 64 of its first runs; None without smooth friction.

        Runs have true readings. Raises as `rollouts`.
        """
        if self.study.loop["friction"] != "smooth":
            return None
        return steps(partial(self._positions, text), self.study.loop["substeps"])

    def enough_steps(self, text: str) -> Steps:
        """The fewest substeps from the study's on whose error is below 1e-6 rad, or the best that were found.

        Raises as `rollouts`.
        """
        return enough_steps(partial(self._positions, text), self.study.loop["substeps"])

    def _positions(self, text: str, substeps: int) -> Array:
        count = min(self.study.runs, RUNS)
        values = {path: x for path, x in self.study.values(0, count).items() if not path.startswith("sensor.")}
        loop, longest = self.study.loop, max(float(reference.duration) for reference in self.references)
        stride = stride_of(int(loop.get("duration", longest) * loop["rate"]))
        more = {"substeps": substeps, "encoder": None, "record": stride, "hand_over": False}
        q = self.rollouts(text, values, 0, count, **more).q
        assert q is not None  # a record was asked for
        return q

    def rollouts(self, text: str, values: Mapping[str, Values], first: int, count: int, **more: Any) -> Rollouts:
        """Runs by the kernel; `more` goes before what the study says. Raises as `rollouts` and `refuse_changed`."""
        sweep_study.refuse_changed(self.study)
        arguments = {**rollout_arguments(self.study, text, values), **more}
        options = {"runs": count, "threads": self.threads, "first_run": first, **arguments}
        return rollouts(self.arm, self.controller(text), self.references, **options)


class SimulatedRows:
    """Rows of runs of a controller without a kernel form: one by one, by `simulate`, with what rollouts would take.

    Where an option of the law or its payload varies, each row has a controller of its own. Raises as `rollouts` and
    `refuse_changed`.
    """

    def __init__(
        self, workshop: SweepWorkshop, text: str, values: Mapping[str, Values], first: int, count: int
    ) -> None:
        self.workshop, self.text, self.values, self.first, self.count = workshop, text, values, first, count
        sweep_study.refuse_changed(workshop.study)
        rest = {path: x for path, x in values.items() if not path.startswith(OF_LAW)}
        arguments = rollout_arguments(workshop.study, text, rest)
        given = {name: value for name, value in arguments.items() if name not in _NOT_OF_LOOP}
        self.friction_width = given.pop("friction_width", SMOOTH_SPEED)
        self.loop = Loop(**{"friction": "none", **given})
        self.file, self.by_row = sweep_study.spec_of_study(workshop.study, text).base, len(rest) < len(values)
        self._setup: tuple[int, LoopSetup] | None = None
        shapes = parameter_shapes(workshop.arm.n)
        _, self.given = run_parameters(arguments["parameters"], count, shapes, len(workshop.references))
        check_smooth_friction(self.setup(0), self.given)

    def setup(self, i: int) -> LoopSetup:
        """The loop of a row; rows come one after the other, and share it if they have one controller."""
        place, at = i if self.by_row else 0, self.workshop
        if self._setup is None or self._setup[0] != place:
            if self.by_row:
                controller = controller_of_run(at.study, self.text, self.values, i)
                sweep_study.refuse_changed(at.study)
            else:
                controller = at.controller(self.text)
            self._setup = place, loop_setup(at.arm, controller, at.references, self.loop, self.friction_width)
        return self._setup[1]

    def row(self, i: int) -> dict[str, Array]:
        """The parameters of a row."""
        return {name: array[i] for name, array in self.given.items()}

    def run(self, i: int) -> Run:
        """A row by `simulate`; raises as that, above all `DivergenceError`, and `FileAccessError` as `faults_in`."""
        with faults_in(self.file):
            return simulated_run(self.setup(i), self.row(i), self.first + i)

    def figures(self) -> tuple[dict[str, Array], list[str]]:
        """Metrics of all rows, NaN where one diverged, and their flags; raises `RunFaultError` for what is refused."""
        n, study = self.workshop.arm.n, self.workshop.study
        shapes: dict[str, tuple[int, ...]] = {name: (n,) * metric.per_joint for name, metric in METRICS.items()}
        shapes |= {quantile_name(share): () for share in study.quantiles}
        rows, flags = [], []
        for i in range(self.count):
            try:
                plant = arm_of_run(self.setup(i).plant, self.row(i))
                rows.append(figures_of(self.run(i), plant, study.tolerance, study.quantiles))
                flags.append("")
            except DivergenceError:
                rows.append({name: np.full(shape, np.nan) for name, shape in shapes.items()})
                flags.append(DIVERGED)
            except LwrDynError as fault:
                raise RunFaultError(self.first + i, str(fault)) from fault
        return {name: np.stack([row[name] for row in rows]) for name in shapes}, flags


def workshop_of(study: SweepStudy) -> SweepWorkshop:
    """The workshop of this thread, built when it is first needed; raises as `SweepWorkshop`."""
    key = study.digest, study.runs, dict(study.places)
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
