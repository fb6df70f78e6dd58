"""Runs of a controller without a kernel form: one by one, by `simulate`, with the parameters that rollouts take."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from lwr_dyn.codegen.rollouts.bodies_of_runs import arm_of_run
from lwr_dyn.codegen.rollouts.figures import figures_of, quantile_name
from lwr_dyn.codegen.rollouts.loop_setup import LoopSetup, check_smooth_friction, loop_setup
from lwr_dyn.codegen.rollouts.replay import simulated_run
from lwr_dyn.codegen.rollouts.run_parameters import parameter_shapes, run_parameters
from lwr_dyn.control.controller_file import faults_in
from lwr_dyn.control.protocol import Controller
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import DivergenceError, LwrDynError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.studies.sweep.study.metric_table import METRICS

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
