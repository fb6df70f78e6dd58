"""The interpreter: executes a program line by line on a robot's model, with bounds on steps, time and call depth."""

from __future__ import annotations

from collections.abc import Mapping

from lwr_dyn.krl.diagnostics import Diagnostic, DiagnosticLog, ExecutionError, RunEndedError, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import Def
from lwr_dyn.krl.names.types import UNKNOWN, Type
from lwr_dyn.krl.project.program import Program, program_in
from lwr_dyn.krl.project.symbols import DeclaredName, scope_of
from lwr_dyn.krl.running.calls import called_routine, value_of_call
from lwr_dyn.krl.running.cell import RobotCell
from lwr_dyn.krl.running.cell_values import give_cell
from lwr_dyn.krl.running.controller import ControllerState, MachineData
from lwr_dyn.krl.running.evaluate import root_name, value_of
from lwr_dyn.krl.running.execute import StackFrame, assign, execute
from lwr_dyn.krl.running.initial import argument_variable, initialised
from lwr_dyn.krl.running.motions import Motions
from lwr_dyn.krl.running.signals import element_value
from lwr_dyn.krl.running.values import Value, Variable, converted
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
        self.steps = 0
        self.data: dict[str, dict[str, Variable]] = {}
        """The variables of each file, by its name: those of a `.dat` are made when one of them is first used."""
        self._programs: dict[str, Program] = {}
        self._declared: dict[int, Mapping[str, DeclaredName]] = {}

    # --- the methods of evaluate.Environment
    def variable(self, name: str) -> Variable:
        """A variable of the routine, else of its module or one that it sees, else of the controller."""
        key = name.upper()
        if self.stack and key in self.stack[-1].variables:
            return self.stack[-1].variables[key]
        declared = self.here.names.variables.get(key)
        if declared is not None and self._is_data(key, declared):
            return self._variables_of(declared.position.file)[key]
        variable = self.controller.variable(key)
        if variable is None:
            raise ExecutionError("undeclared", f"{name} is not declared", "declare it in the .dat or with DECL")
        return variable

    def _is_data(self, key: str, declared: DeclaredName) -> bool:
        """Whether a file holds the variable; the controller holds what it computes and what is given from outside."""
        held = key.startswith("$") and self.controller.holds(key)
        return not held and declared.position.file in self.program.project.homes

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        """An element of an input; reading one stops the advance run, so no motion is blended across it."""
        if not name.startswith("$"):
            return None
        value = element_value(self.controller, name, index)
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
            if value is None:
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
            for file in self.program.module.files:
                self._variables_of(file.file.name)
            give_cell(self, self.controller)
            if self.program.routines:
                self.enter(self.program.routines[0], None)
            while self.stack:
                self._step(None)
            if self.motions.timeline.duration > self.machine.seconds:
                self._end_at_bound(f"{self.machine.seconds:g} s of simulated time")
        except RunEndedError as end:
            if end.diagnostic is not None:
                self.log.diagnostics.append(end.diagnostic)
        except RecursionError:
            deep = ("recursion", "functions call one another without end", "use a loop")
            self.log.diagnostics.append(Diagnostic(self.log.position, "error", *deep))
        return tuple(self.log.diagnostics)

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
        self.log.position = frame.routine.file.position(at, getattr(statement, "column", 1))
        self._count_step()
        try:
            if isinstance(statement, s.Return):
                self._return(statement, result)
            else:
                execute(self, statement, frame, at)
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

    def _count_step(self) -> None:
        self.steps += 1
        bounds = (
            (self.steps > self.machine.steps, f"{self.machine.steps} statements"),
            (self.motions.timeline.duration > self.machine.seconds, f"{self.machine.seconds:g} s of simulated time"),
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
        variables: dict[str, Variable] = {}
        home = self._program_of(routine.file.name)
        declared = self._declared_in(routine, home)
        arguments = () if x is None else x.arguments
        for i, p in enumerate(routine.head.parameters):
            key = p.name.upper()
            kind = declared[key].type if key in declared else UNKNOWN
            variables[key] = argument_variable(self, arguments[i] if i < len(arguments) else None, p, kind)
        self.stack.append(StackFrame(home, routine, routine.first, variables))
        for key, name in declared.items():
            if key not in variables:
                variables[key] = self._new_variable(name)

    @property
    def here(self) -> Program:
        """The program of the module of the current routine."""
        return self.stack[-1].program if self.stack else self.program

    def _program_of(self, file: str) -> Program:
        """The program of the module of a file."""
        if file not in self._programs:
            project = self.program.project
            self._programs[file] = program_in(project, project.homes[file])
        return self._programs[file]

    def _declared_in(self, routine: Routine, home: Program) -> Mapping[str, DeclaredName]:
        key = id(routine)
        if key not in self._declared:
            self._declared[key] = scope_of(home, routine, []).own.variables
        return self._declared[key]

    def _new_variable(self, name: DeclaredName) -> Variable:
        """The variable as declared; a fault in its declaration is reported, and it has no value."""
        try:
            return initialised(self, name)
        except ExecutionError as fault:
            self.log.position = name.position
            self.log.report_fault(fault)
            return Variable(name.type)

    def _variables_of(self, file: str) -> dict[str, Variable]:
        """The variables of a file, with their initial values."""
        if file in self.data:
            return self.data[file]
        variables = self.data[file] = {}
        read, position = self.program.project.file(file), self.log.position
        # the statements of a .dat see the names of its module
        frame = StackFrame(self._program_of(file), Routine(read.file, Def(""), 0), 0, variables)
        self.stack.append(frame)
        for key, name in read.names.variables.items():
            variables[key] = self._new_variable(name)
        for i, x in read.outline.data:
            if isinstance(x, s.Assign):
                self.log.position = read.file.position(i, x.column)
                try:
                    assign(self, x)
                except ExecutionError as fault:
                    self.log.report_fault(fault)
        self.stack.pop()
        self.log.position = position
        return variables
