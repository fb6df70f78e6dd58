"""What a statement sees and changes: the frame of its routine, and the running program around it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

from lwr_dyn.krl.diagnostics import DiagnosticLog, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.running.controller import ControllerState, MachineData
from lwr_dyn.krl.running.evaluate import Environment
from lwr_dyn.krl.running.motions import Motions
from lwr_dyn.krl.running.values import Variable


@dataclass(slots=True, eq=False)
class StackFrame:
    """A call of a routine: the program of its module, its next line and its variables."""

    program: Program
    routine: Routine
    at: int
    variables: dict[str, Variable]
    loops: dict[int, tuple[int, int]] = field(default_factory=dict)
    """Line of a FOR -> its last value and step."""
    watched: dict[int, Any] = field(default_factory=dict)
    """Line to which the routine has gone back -> the passes of that loop."""


class ExecutionContext(Environment, Protocol):
    """The parts of a running program that statements change."""

    program: Program
    machine: MachineData
    controller: ControllerState
    motions: Motions
    data: Any
    background: Any
    log: DiagnosticLog
    stack: list[StackFrame]
    passes: Any

    @property
    def here(self) -> Program:
        """The program of the module of the current routine."""

    def routine(self, name: str) -> Routine | None:
        """A routine that the module of the current routine sees."""

    def enter(self, routine: Routine, x: e.FunctionCall | None) -> None:
        """Begin a routine with the arguments of a call."""

    def execute_beside(self, action: s.Assign | s.Invoke, position: SourcePosition) -> None:
        """Execute an assignment or a whole subprogram now, beside the program's own line."""

    def step(self) -> None:
        """Execute the next statement."""

    def io_name(self, x: e.Reference) -> str:
        """The name with which a reference begins, in capitals; of a SIGNAL the input or output it stands for."""
