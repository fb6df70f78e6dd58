"""The interpreter: executes a program line by line on a robot's model, with bounds on steps, time and call depth."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import (
    Diagnostic,
    DiagnosticLog,
    ExecutionError,
    ResumedError,
    RunEndedError,
    SourcePosition,
)
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import Signal
from lwr_dyn.krl.names.types import UNKNOWN, Type
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.project.symbols import DeclaredName
from lwr_dyn.krl.running.background import Background
from lwr_dyn.krl.running.calls import called_routine, empty_value, value_of_call
from lwr_dyn.krl.running.cell import RobotCell
from lwr_dyn.krl.running.cell_values import give_arguments, give_cell, note_unread
from lwr_dyn.krl.running.clock import ProgramClock
from lwr_dyn.krl.running.context import StackFrame
from lwr_dyn.krl.running.controller import ControllerState, MachineData
from lwr_dyn.krl.running.evaluate import root_name, value_of
from lwr_dyn.krl.running.execute import assign, execute, invoke
from lwr_dyn.krl.running.module_data import ModuleData
from lwr_dyn.krl.running.motions import Motions
from lwr_dyn.krl.running.passes import LoopPasses, look_at_loop
from lwr_dyn.krl.running.signal_names import signal_reference
from lwr_dyn.krl.running.signals import element_value
from lwr_dyn.krl.running.triggers import Triggers
from lwr_dyn.krl.running.values import Value, Variable, VariableReference, converted
from lwr_dyn.model.arm import Arm

DEEPEST = 40
"""Most calls inside one another."""


class Interpreter:
    """One run of one program. With `tolerant` a faulty statement is skipped and the run goes on."""

    def __init__(
        self, program: Program, arm: Arm, machine: MachineData, cell: RobotCell | None = None, tolerant: bool = False
    ) -> None:
        self.program, self.machine = program, machine
        self.log = DiagnosticLog(SourcePosition(program.source.name, 1), tolerant)
        self.controller = ControllerState(arm, machine, cell or RobotCell())
        self.motions = Motions(self.controller, self.log.report)
        self.stack: list[StackFrame] = []
        self.data = ModuleData(program.project, self.log, self.stack)
        clock = ProgramClock(self.motions)
        self.background = Background(self, clock, Triggers(self.motions, clock))
        self.steps = 0
        self.passes: LoopPasses | None = None
        """Of an endless loop at which the run has ended."""

    # --- the methods of evaluate.Environment
    def variable(self, name: str) -> Variable:
        """A variable of the routine, else of its module or one that it sees, else of the controller."""
        key = name.upper()
        if self.stack and key in self.stack[-1].variables:
            return self.stack[-1].variables[key]
        declared = self.here.names.variables.get(key)
        if declared is not None and self._is_data(key, declared):
            return self.data.variables_of(self, declared.position.file)[key]
        variable = self.controller.variable(key)
        if variable is None:
            raise ExecutionError("undeclared", f"{name} is not declared", "declare it in the .dat or with DECL")
        return variable

    def _is_data(self, key: str, declared: DeclaredName) -> bool:
        """Whether a file holds the variable; the controller holds what it computes and what is given from outside."""
        held = key.startswith("$") and self.controller.holds(key)
        return not held and declared.position.file in self.program.project.homes

    def signal(self, name: str) -> Signal | None:
        """What a name declared with SIGNAL stands for; the controller's own states are no signals here."""
        key = name.upper()
        if key.startswith("$"):
            return None
        local = self.data.declared.get(id(self.stack[-1].routine), {}).get(key) if self.stack else None
        declared = local or self.here.names.variables.get(key)
        return None if declared is None else declared.signal

    def signal_reference(self, name: str) -> VariableReference | None:
        """The inputs or outputs of a SIGNAL name; None for another name."""
        signal = self.signal(name)
        return None if signal is None else signal_reference(self, signal)

    def io_name(self, x: e.Reference) -> str:
        """The name with which a reference begins; of a SIGNAL the input or output it stands for."""
        name = root_name(x)
        signal = self.signal(name)
        return root_name(signal.first) if signal is not None and not isinstance(signal.first, e.Bool) else name

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        """An element of an input; reading one stops the advance run, so no motion is blended across it."""
        if not name.startswith("$"):
            return None
        value = element_value(self.controller, self.background.clock, name, index)
        if value is not None and name.upper() in ("$IN", "$OUT", "$ANIN", "$ANOUT"):
            self.motions.stop_advance()
        return value

    def component_type(self, struct: str, name: str) -> Type:
        """The type of a component; unknown for an unknown structure or component."""
        components = self.here.names.structures.get(struct) or self.here.project.known.structures.get(struct) or {}
        return components.get(name, UNKNOWN)

    def routine(self, name: str) -> Routine | None:
        """A routine that the module of the current routine sees."""
        return self.here.routine(name)

    def call(self, x: e.FunctionCall) -> Value:
        """The value of a predefined function, or of one of the program, which is executed to its end."""
        routine = called_routine(self, x.name.upper())
        if routine is None:
            value = value_of_call(self, x)
            if value is None and (value := empty_value(self, x)) is None:
                hint = "define it in the program, or give it a stub in the cell file"
                raise ExecutionError("not-modelled", f"the function {x.name} is not modelled", hint)
            return value
        depth, position = len(self.stack), self.log.position
        self.enter(routine, x)
        result: list[Value] = []
        while len(self.stack) > depth:
            self._step(result)
        self.log.position = position  # the statement that calls goes on
        if not result:
            raise ExecutionError("no-value", f"{x.name} ended without RETURN", "RETURN a value on every way")
        return result[-1]

    def note_read(self, name: str) -> None:
        """A value that is assumed and read is listed."""
        self.controller.note_read(name)

    # --- the run
    def run(self) -> tuple[Diagnostic, ...]:
        """Execute the main routine to its end, or to the fault or bound that ends it."""
        try:
            self._run()
        except RunEndedError as end:
            if end.diagnostic is not None:
                self.log.diagnostics.append(end.diagnostic)
        except RecursionError:
            deep = ("recursion", "functions call one another without end", "use a loop")
            self.log.diagnostics.append(Diagnostic(self.log.position, "error", *deep))
        note_unread(self.controller)
        return tuple(self.log.diagnostics)

    def _run(self) -> None:
        for file in self.program.module.files:
            self.data.variables_of(self, file.file.name)
        give_cell(self, self.controller)
        self.background.start()
        if self.program.routines:
            self.enter(self.program.routines[0], None)
            give_arguments(self.stack[0], self.controller, self.log.report)
        while self.stack:
            try:
                self._step(None)
            except ResumedError:
                continue
        self.background.end()
        if self.motions.now > self.machine.seconds:
            self._end_at_bound(f"{self.machine.seconds:g} s of simulated time")

    def step(self) -> None:
        """Execute the next statement."""
        self._step(None)

    def _step(self, result: list[Value] | None) -> None:
        frame = self.stack[-1]
        if frame.at >= frame.routine.last:
            self.stack.pop()
            return
        at = frame.at
        frame.at += 1
        statement = frame.routine.file.lines[at].statement
        if statement is None:
            return
        position = self.log.position = frame.routine.file.position(at, getattr(statement, "column", 1))
        self._count_step()
        before = len(self.motions.executed)
        try:
            if isinstance(statement, s.Return):
                self._return(statement, result)
            else:
                execute(self, statement, frame, at)
            self.background.after_statement(statement, position, before)
            if frame.at <= at and self.stack and self.stack[-1] is frame and not self.background.submitting:
                look_at_loop(self, frame, at)
        except ExecutionError as fault:
            self.log.report_fault(fault)
            if isinstance(statement, s.Assign):
                self.log.unassigned.add(root_name(statement.target))

    def _return(self, x: s.Return, result: list[Value] | None) -> None:
        value = None if x.value is None else value_of(self, x.value)
        kind = self.stack[-1].routine.head.returns
        if value is not None and kind is not None:
            value = converted(value, Type(kind.upper()))
        self.stack.pop()
        if result is not None and value is not None:
            result.append(value)

    def execute_beside(self, action: s.Assign | s.Invoke, position: SourcePosition) -> None:
        """Execute an assignment or a whole subprogram now; without motion it does not stop the advance run."""
        motions, before = self.motions, self.log.position
        advance, count, depth = motions.advance, len(motions.executed), len(self.stack)
        self.log.position = position
        if isinstance(action, s.Assign):
            assign(self, action)
        else:
            invoke(self, action)
            while len(self.stack) > depth:
                self._step(None)
        self.log.position = before
        if len(motions.executed) == count:
            motions.advance = advance

    def _count_step(self) -> None:
        self.steps += 1
        bounds = (
            (self.steps > self.machine.steps, f"{self.machine.steps} statements"),
            (self.motions.now > self.machine.seconds, f"{self.machine.seconds:g} s of simulated time"),
            (self.motions.count >= self.machine.motions, f"{self.machine.motions} motions"),
        )
        for reached, what in bounds:
            if reached:
                self._end_at_bound(what)

    def _end_at_bound(self, what: str) -> None:
        hint = "an endless loop is cut; the bound is an option"
        self.log.end_run("note", "bound", f"stopped here after {what}", hint)

    def enter(self, routine: Routine, x: e.FunctionCall | None) -> None:
        """Begin a routine with the arguments of a call; OUT parameters are the caller's own variables."""
        if len(self.stack) >= DEEPEST:
            deep = f"{DEEPEST} calls inside one another, at {routine.head.name}"
            self.log.end_run("error", "recursion", deep, "use a loop")
        self.data.enter(self, routine, () if x is None else x.arguments)

    @property
    def here(self) -> Program:
        """The program of the module of the current routine."""
        return self.stack[-1].program if self.stack else self.program
