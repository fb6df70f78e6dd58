"""Submit programs (.sub): each makes one pass of its loop when the robot program has moved or waited, and in its waits.

On a controller they run all the time, each statement in its turn; here a pass takes no time.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import PurePosixPath

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.project.project import Project
from lwr_dyn.krl.running.context import ExecutionContext, StackFrame
from lwr_dyn.krl.running.evaluate import truth_of

MOST_STEPS = 5000
"""Statements of one pass."""


@dataclass(slots=True, eq=False)
class Submit:
    """A submit program: its file, its calls, whether it has begun."""

    file: str
    stack: list[StackFrame] = field(default_factory=list)
    began: bool = False


def submit_file(project: Project, path: str) -> str:
    """The file of a project that a cell names; raises `OptionError` where there is none."""
    name = PurePosixPath(path.replace("\\", "/")).name.lower()
    found = [x.file.name for x in project.files if PurePosixPath(x.file.name).name.lower() == name]
    if not found:
        raise OptionError("submits of the cell", f"{name} is not among the files", "a .sub that --with brings")
    return found[0]


def run_submit(m: ExecutionContext, submit: Submit) -> None:
    """One pass: until it goes back to the head of its loop, or waits."""
    robot, position, advance = m.stack[:], m.log.position, m.motions.advance
    m.stack[:] = submit.stack
    if not submit.began:
        submit.began = True
        m.controller.assumptions.note(submit.file, "", "one pass, in no time, after each motion and wait and in waits")
        m.enter(m.data.program_of(submit.file).routines[0], None)
    for _ in range(MOST_STEPS):
        if not m.stack or _ends_pass(m):
            break
    submit.stack = m.stack[:]
    m.stack[:] = robot
    m.log.position, m.motions.advance = position, advance


def _ends_pass(m: ExecutionContext) -> bool:
    """Execute one statement of a submit program; whether it has ended a pass."""
    frame = m.stack[-1]
    at = frame.at
    x = frame.routine.file.lines[at].statement if at < frame.routine.last else None
    if isinstance(x, s.Move | s.SplineBlock):
        raise ExecutionError("submit-motion", "a submit program moves the robot", "motions belong into a .src")
    if isinstance(x, s.Wait):
        if x.kind == "SEC" or truth_of(m, x.value, "WAIT FOR"):
            frame.at += 1
        return True
    m.step()
    return isinstance(x, s.Plain | s.Jump) and frame.at <= at
