"""The interpreter: executes a program line by line on a robot's model, with bounds on steps, time and call depth.

How variables begin: with the arguments of a call, and with the initial values of declarations.

The variables of each file while a program runs: made when one of them is first used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from lwr_dyn.krl.checks.type_check import shape_of
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
from lwr_dyn.krl.language.declarations import Declarator, Def, Parameter, Signal
from lwr_dyn.krl.names.known_names import UNKNOWN, Type
from lwr_dyn.krl.project.program import Program, program_in
from lwr_dyn.krl.project.project import Project
from lwr_dyn.krl.project.scope import scope_of
from lwr_dyn.krl.project.symbols import DeclaredName
from lwr_dyn.krl.running.background import Background
from lwr_dyn.krl.running.cell import RobotCell
from lwr_dyn.krl.running.controller import ControllerState, MachineData
from lwr_dyn.krl.running.evaluate import Environment, aggregate_value, number_of, root_name, signal_reference, value_of
from lwr_dyn.krl.running.execute import ExecutionContext, StackFrame, assign, execute, invoke
from lwr_dyn.krl.running.functions import called_routine, empty_value, value_of_call
from lwr_dyn.krl.running.motions import Motions
from lwr_dyn.krl.running.outside_values import element_value, give_arguments, give_cell, note_unread
from lwr_dyn.krl.running.passes import LoopPasses, look_at_loop
from lwr_dyn.krl.running.triggers import ProgramClock, Triggers
from lwr_dyn.krl.running.values import ArrayValue, Value, Variable, VariableReference, converted, text_array
from lwr_dyn.model.arm import Arm

LARGEST_ARRAY = 100_000
"""Most elements along one dimension of an array."""


def argument_variable(env: Environment, x: e.Expression | None, p: Parameter, kind: Type) -> Variable:
    """The variable of a parameter: the caller's own for OUT, where the argument is one; else a new one."""
    if x is None:
        return Variable(kind)
    if p.mode != "IN" and isinstance(x, e.Name):
        return env.variable(x.name)
    if p.mode != "IN" and isinstance(x, e.Index) and not x.indices and isinstance(x.of, e.Name):
        return env.variable(x.of.name)
    return Variable(kind, converted(value_of(env, x), kind))


def initialised(env: Environment, name: DeclaredName) -> Variable:
    """The variable as declared, with its initial value; raises `ExecutionError`."""
    d, kind = name.declarator, name.type
    if d is None:
        return Variable(kind)
    if d.sizes is not None:
        return Variable(kind, _initial_array(env, d, kind))
    if kind.name == "?" and isinstance(d.value, e.Aggregate):
        kind = shape_of(d.value)
    if d.value is None:
        return Variable(kind)
    if isinstance(d.value, e.Aggregate):
        return Variable(kind, aggregate_value(env, d.value, kind.name))
    return Variable(kind, converted(value_of(env, d.value), kind))


def _initial_array(env: Environment, d: Declarator, kind: Type) -> Value:
    sizes = tuple(int(number_of(env, x, "a size")) for x in d.sizes or ())
    if any(not 1 <= n <= LARGEST_ARRAY for n in sizes):
        message = f"{d.name} has the size {', '.join(map(str, sizes))}"
        raise ExecutionError("index-range", message, f"from 1 to {LARGEST_ARRAY}")
    return text_array(d.value.value, sizes) if isinstance(d.value, e.Text) else ArrayValue(kind.name, sizes)


@dataclass(slots=True, eq=False)
class ModuleData:
    """The data of the modules of a project."""

    project: Project
    log: DiagnosticLog
    stack: list[StackFrame]
    files: dict[str, dict[str, Variable]] = field(default_factory=dict)
    """The variables of each file, by its name."""
    programs: dict[str, Program] = field(default_factory=dict)
    declared: dict[int, Mapping[str, DeclaredName]] = field(default_factory=dict)

    def program_of(self, file: str) -> Program:
        """The program of the module of a file."""
        if file not in self.programs:
            self.programs[file] = program_in(self.project, self.project.homes[file])
        return self.programs[file]

    def declared_in(self, routine: Routine, home: Program) -> Mapping[str, DeclaredName]:
        """The names that a routine declares."""
        key = id(routine)
        if key not in self.declared:
            self.declared[key] = scope_of(home, routine, []).own.variables
        return self.declared[key]

    def enter(self, m: ExecutionContext, routine: Routine, arguments: Sequence[e.Expression | None]) -> None:
        """Put a call on the stack, with its arguments; OUT parameters are the caller's own variables."""
        variables: dict[str, Variable] = {}
        home = self.program_of(routine.file.name)
        declared = self.declared_in(routine, home)
        for i, p in enumerate(routine.head.parameters):
            key = p.name.upper()
            kind = declared[key].type if key in declared else UNKNOWN
            variables[key] = argument_variable(m, arguments[i] if i < len(arguments) else None, p, kind)
        self.stack.append(StackFrame(home, routine, routine.first, variables))
        for key, name in declared.items():
            if key not in variables:
                variables[key] = self.new_variable(m, name)

    def new_variable(self, m: ExecutionContext, name: DeclaredName) -> Variable:
        """The variable as declared; a fault in its declaration is reported, and it has no value."""
        try:
            return initialised(m, name)
        except ExecutionError as fault:
            self.log.position = name.position
            self.log.report_fault(fault)
            return Variable(name.type)

    def variables_of(self, m: ExecutionContext, file: str) -> dict[str, Variable]:
        """The variables of a file, with their initial values."""
        if file in self.files:
            return self.files[file]
        variables = self.files[file] = {}
        read, position = self.project.file(file), self.log.position
        # the statements of a .dat see the names of its module
        self.stack.append(StackFrame(self.program_of(file), Routine(read.file, Def(""), 0), 0, variables))
        for key, name in read.names.variables.items():
            variables[key] = self.new_variable(m, name)
        for i, x in read.outline.data:
            if isinstance(x, s.Assign):
                self.log.position = read.file.position(i, x.column)
                try:
                    assign(m, x)
                except ExecutionError as fault:
                    self.log.report_fault(fault)
        self.stack.pop()
        self.log.position = position
        return variables


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
