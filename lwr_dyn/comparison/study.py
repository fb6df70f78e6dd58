"""Controllers x plants: every controller on every plant, on one reference."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lwr_dyn.comparison.comparison import RunComparison, comparison_of
from lwr_dyn.comparison.plants import PlantCase
from lwr_dyn.control.controller_file import faults_in
from lwr_dyn.control.controllers import make_controller, split_name
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.errors import DivergenceError, OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.progress import Report
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.viewer.replayed_runs import PLAIN


@dataclass(frozen=True, slots=True, eq=False)
class ControllerStudy:
    """What is simulated: controllers by name or file, in the order of the table, on each plant."""

    arm: Arm
    reference: Reference
    controllers: Sequence[str]
    plants: Sequence[PlantCase]
    task: str = ""
    options: tuple[tuple[str, Any], ...] = ()
    """Of `simulate`, for all runs."""

    def run(self, report: Report = lambda _: None) -> tuple[RunComparison, tuple[Run, ...]]:
        """The comparison and its runs, plant by plant; a run that diverges is a line of `failures`.

        Raises as `make_controller`, `simulate` and `comparison_of`; `DivergenceError` where every run diverges.
        """
        built = self._built()
        runs, failures, fault = [], [], None
        count = len(built) * len(self.plants)
        for i, (case, (file, controller)) in enumerate((case, pair) for case in self.plants for pair in built):
            report(i / count)
            try:
                runs.append(self._simulated(case, file, controller))
            except DivergenceError as diverged:
                fault = diverged
                failures.append(f"{label_of(controller)}, {', '.join(case.words) or PLAIN}: {diverged}")
        if fault is not None and not runs:
            raise fault
        names = [f"run {i}" for i in range(1, len(runs) + 1)]
        return comparison_of(runs, names, failures=failures), tuple(runs)

    def _built(self) -> list[tuple[str, Controller]]:
        """Each controller with the name or file it came from."""
        for kind, chosen in (("controllers", self.controllers), ("plants", self.plants)):
            if not chosen:
                raise OptionError(kind, "none", "one or more")
        dynamics = dynamics_of(self.arm)
        return [(split_name(name)[0], make_controller(name, self.arm, dynamics)) for name in self.controllers]

    def _simulated(self, case: PlantCase, file: str, controller: Controller) -> Run:
        note = {"task": self.task} | ({"plant": ", ".join(case.words)} if case.words else {})
        with faults_in(file):
            return simulate(self.arm, controller, self.reference, **dict(self.options), **case.options, meta=note)
