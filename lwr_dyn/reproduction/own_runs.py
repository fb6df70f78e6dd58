"""Closed loops of a user's own paper, `[run.NAME]`, whose errors, torques and speeds are printed results.

    [run.move]
    controller = "pd-gravity:omega-n=20"    # as the controllers of a study; none from a Python file
    rate = 500                              # samples a second, 1000 if not given
    payload = 1.5                           # kg at the flange, which the controller does not know; 0 if not given
    [run.move.task]                         # as `[task]` of a study
    name = "point-to-point"
    from-deg = [0, 0]
    to-deg = [60, -30]
    duration = 2

Friction is that of the file, if it gives any.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.schema import RUN, Paper
from lwr_dyn.control.controllers import ControllerSpec, controller_spec
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.fields import Fields
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.case import PaperCase
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.studies.sweep.read_study import TaskFields, missing_option, read_task
from lwr_dyn.trajectory.references.references import reference

NAME, NAMES = re.compile(r"[A-Za-z]\w*", re.ASCII), "a letter, then letters, digits and _, such as b22"
"""Ids of results and names of runs, which are names of files too."""


@dataclass(frozen=True, slots=True)
class OwnRun:
    """One `[run.NAME]`: a controller on a task."""

    controller: ControllerSpec
    task: TaskFields
    rate: float
    payload: float


@dataclass(frozen=True, slots=True, eq=False)
class OwnRuns:
    """All runs of a file by name; each is simulated once under one set of errata."""

    rows: Mapping[str, OwnRun]
    done: dict[tuple[str, frozenset[str]], Run] = field(default_factory=dict)

    def run(self, name: str, case: PaperCase) -> Run:
        """The run on the arm of a case; raises as `lwr_dyn.simulate` and the factories of task and controller."""
        key = name, case.applied
        if key not in self.done:
            row = self.rows[name]
            motion = reference(row.task.name, case.arm, **row.task.options)
            law = row.controller.make(case.arm, dynamics_of(case.arm))
            self.done[key] = simulate(case.arm, law, motion, rate=row.rate, payload=row.payload)
        return self.done[key]

    def metrics(self, name: str, case: PaperCase) -> Metrics:
        """The figures of a run; raises as `run`."""
        return metrics(self.run(name, case), case.arm)


def read_runs(tables: Mapping[str, Any], paper: Paper, folder: Path) -> OwnRuns:
    """The runs of a file's tables; files that a task names are looked for in `folder`. Raises `PaperError`."""
    top = Fields({RUN: tables.get(RUN, {})}, paper.file)
    runs = top.table(RUN)
    for name in (name for name in runs.unread() if not NAME.fullmatch(name)):
        raise runs.refuse("", repr(name), NAMES)
    return OwnRuns({name: _run(runs.table(name), paper, folder) for name in runs.unread()})


def _run(fields: Fields, paper: Paper, folder: Path) -> OwnRun:
    text = fields.text("controller")
    try:
        controller = controller_spec(text)
    except LwrDynError as fault:
        raise fields.refuse("controller", repr(text), f"a controller of the package ({fault})") from None
    if controller.is_file:
        raise fields.refuse("controller", f"{text!r}, Python that would run", "a controller by name")
    rate = fields.number("rate", default=1000.0, least=1.0, most=1e5)
    payload = fields.number("payload", default=0.0, least=0.0)
    given = fields.table("task")
    fields.refuse_unknown()
    task = read_task(given, folder, arm_from_paper(paper))
    if (lacking := missing_option(task, set())) is not None:
        raise given.refuse(lacking, "missing", f"a value, which the task {task.name} needs")
    return OwnRun(controller, task, rate, payload)
