"""A running program: its calls and loops, variables, controller, motions and clock, and what a name means in it.

The variables of a file are made when one of them is first used. Statements are executed by `execute`; a function of
the program in an expression is executed too, so the state is given the function that evaluates calls.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lwr_dyn.krl.checks.type_check import shape_of
from lwr_dyn.krl.diagnostics import DiagnosticLog, ExecutionError, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import Declarator, Def, Parameter, Signal
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.names.known_names import SYSTEM, UNKNOWN, Type
from lwr_dyn.krl.project.program import Program, program_in, scope_of
from lwr_dyn.krl.project.project import DeclaredName
from lwr_dyn.krl.running import values as v
from lwr_dyn.krl.running.cell import RobotCell
from lwr_dyn.krl.running.controller import OF_MOTION, ControllerState, MachineData
from lwr_dyn.krl.running.evaluate import aggregate_value, number_of, reference_to, signal_reference, value_of
from lwr_dyn.krl.running.motions import Motions
from lwr_dyn.krl.running.triggers import PlannedTrigger, ProgramClock, StoppedMotion, Triggers
from lwr_dyn.krl.running.values import ArrayValue, StructValue, Value, Variable, VariableReference
from lwr_dyn.model.arm import Arm

LARGEST_ARRAY = 100_000
"""Most elements along one dimension of an array."""
DEEPEST = 40
"""Most calls inside one another."""
ALIKE = 3
"""Passes of an endless LOOP that take the same time between the same axes, after which the run may end."""
PATIENCE = 65
"""Passes before that: a loop that counts up to 32, such as the places of a pallet, comes back to its state first."""
SAME = 1e-6
"""[s] Passes, and ways of a loop, that differ by less are alike."""
EACH = 64
"""Passes after each of which the state is compared; later only after every 16th."""


@dataclass(frozen=True, slots=True)
class LoopPasses:
    """The passes of an endless loop: the position of its end, the duration of each after the first [s]."""

    position: SourcePosition
    seconds: tuple[float, ...]
    period: int
    """How many passes repeat for ever; 0 where the state did not come back."""

    @property
    def counted(self) -> int:
        """How many of the last passes give the time of one: those that repeat; the last one where none do."""
        return max(self.period, 1)

    @property
    def cycle_time(self) -> float:
        """[s] Of one pass, the mean of those that are counted."""
        return float(np.mean(self.seconds[-self.counted :]))

    def __str__(self) -> str:
        head = f"loop that ends in line {self.position.line} of {self.position.file}: "
        if self.period:
            in_turn = f" ({self.period} in turn)" * (self.period > 1)
            return f"{head}{self.cycle_time:.3f} s a pass, for ever{in_turn}"
        least, most, n = min(self.seconds), max(self.seconds), len(self.seconds)
        spread = f"{self.cycle_time:.3f} s in the last of {n} passes, from {least:.3f} to {most:.3f} s"
        return head + spread + "; its variables do not come back, so later passes may differ"


@dataclass(frozen=True, slots=True, eq=False)
class KeptState:
    """A copy of all that decides how a program goes on: calls, axes and events, and the variables of its tables."""

    head: tuple[Any, ...]
    tables: tuple[Mapping[str, Value | None], ...]
    time: float
    """[s] At which it was kept."""
    after: int = 0
    """The pass after which it was kept."""
    timers: tuple[tuple[int, float], ...] = ()
    """Those for which the program asks; they go on while a loop only watches, so they are held apart."""

    def is_same(self, head: tuple[Any, ...], tables: Sequence[Mapping[str, Variable]]) -> bool:
        """Whether a present state is this one."""
        if self.head != head or len(tables) != len(self.tables):
            return False
        pairs = zip(self.tables, tables, strict=True)
        return all(kept == {name: x.value for name, x in now.items()} for kept, now in pairs)


@dataclass(slots=True, eq=False)
class LoopWatch:
    """The passes of one loop so far."""

    began: float
    """[s] The present pass."""
    kept: KeptState
    count: int = 0
    looks: int = 0
    """Passes that only watched."""
    ticked: float = 0.0
    """[s] That passed in them since the state was kept."""
    seconds: list[float] = field(default_factory=list)
    places: list[Any] = field(default_factory=list)
    """The axes at the head of the loop."""

    def end_pass(self, now: float, place: Any) -> None:
        """One more pass has ended, at a time [s] with the axes at a place."""
        self.count += 1
        if now - self.began > SAME:
            self.seconds.append(now - self.began)
            self.places.append(place)
        self.began = now

    def passes(self, position: SourcePosition, period: int) -> LoopPasses:
        """All of them, of which so many repeat."""
        return LoopPasses(position, tuple(self.seconds), period)

    @property
    def compares(self) -> bool:
        """Whether the state is compared after this pass."""
        return self.count < EACH or self.count % 16 == 0

    @property
    def keeps(self) -> bool:
        """Whether the state is kept: after passes 1, 2, 4, 8 ..."""
        return self.count & (self.count - 1) == 0

    def alike(self) -> bool:
        """Whether the last passes took the same time between the same axes."""
        last, places = self.seconds[-ALIKE:], self.places[-ALIKE:]
        return len(self.seconds) >= PATIENCE and max(last) - min(last) < SAME and len(set(places)) == 1


@dataclass(slots=True, eq=False)
class StackFrame:
    """A call of a routine: the program of its module, its next line and its variables."""

    program: Program
    routine: Routine
    at: int
    variables: dict[str, Variable]
    loops: dict[int, tuple[int, int]] = field(default_factory=dict)
    """Line of a FOR -> its last value and step."""
    watched: dict[int, LoopWatch] = field(default_factory=dict)
    """Line to which the routine has gone back -> the passes of that loop."""


@dataclass(slots=True, eq=False)
class Watch:
    """A condition that is looked at; what follows when it becomes true."""

    condition: e.Expression
    follow: Callable[[], object]
    last: bool = False
    enabled: bool = True
    frame: StackFrame | None = None
    """The routine that has declared an interrupt: it holds there and in what that calls."""
    moves: bool = False  # the condition names what moves: it may become true between two statements
    since: float = 0.0  # [s] from when on it is looked at


@dataclass(slots=True, eq=False)
class ActiveInterrupt:
    """The interrupt that is executed now; only a lower number may come between."""

    priority: int = 1000
    frame: StackFrame | None = None
    """The routine that has declared it; None where no interrupt is executed."""
    stopped: tuple[StoppedMotion, list[PlannedTrigger]] | None = None
    """The motion that BRAKE has stopped in it, and triggers at places that it has not reached."""


@dataclass(slots=True, eq=False)
class Submit:
    """A submit program: its file, its calls, whether it has begun."""

    file: str
    stack: list[StackFrame] = field(default_factory=list)
    began: bool = False


class RunningProgram:
    """The state of one run of one program. With `tolerant` a faulty statement is skipped and the run goes on.

    Its names are those that the current routine sees; `value_of_call` gives the value of a call in an expression.
    """

    def __init__(
        self, program: Program, arm: Arm, machine: MachineData, cell: RobotCell | None, tolerant: bool,
        value_of_call: Callable[[RunningProgram, e.FunctionCall], Value],
    ) -> None:  # fmt: skip
        self.program, self.machine, self._value_of_call = program, machine, value_of_call
        self.log = DiagnosticLog(SourcePosition(program.source.name, 1), tolerant)
        self.controller = ControllerState(arm, machine, cell or RobotCell())
        self.motions = Motions(self.controller, self.log.report)
        self.clock = ProgramClock(self.motions)
        self.triggers = Triggers(self.motions, self.clock)
        self.stack: list[StackFrame] = []
        self.steps = 0
        self.passes: LoopPasses | None = None
        """Of an endless loop at which the run has ended."""
        self.interrupts: dict[int, Watch] = {}  # by priority
        self.interrupt = ActiveInterrupt()
        self.replies: list[Watch] = []
        self.submits: list[Submit] = []
        self.submitting = False
        """Whether a submit program is executed now."""
        self.files: dict[str, dict[str, Variable]] = {}
        """The variables of each file, by its name."""
        self._programs: dict[str, Program] = {}
        self._declared: dict[int, Mapping[str, DeclaredName]] = {}

    @property
    def here(self) -> Program:
        """The program of the module of the current routine."""
        return self.stack[-1].program if self.stack else self.program

    # --- what expressions ask for: the methods of evaluate.Environment
    def variable(self, name: str) -> Variable:
        """A variable of the routine, else of its module or one that it sees, else of the controller."""
        key = name.upper()
        if self.stack and key in self.stack[-1].variables:
            return self.stack[-1].variables[key]
        if key in OF_MOTION and self.clock.at is not None:  # an interrupt may come while the arm is on its way
            return Variable(SYSTEM[key], self.controller.position(key, self.motions.axes_at(self.clock.at)))
        declared = self.here.names.variables.get(key)
        file = "" if declared is None else declared.position.file
        # the controller holds what it computes and what is given from outside, also where a file declares it
        if file in self.program.project.homes and not (key.startswith("$") and self.controller.holds(key)):
            return self.variables_of(file)[key]
        variable = self.controller.variable(key)
        if variable is None:
            raise ExecutionError("undeclared", f"{name} is not declared", "declare it in the .dat or with DECL")
        return variable

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        """An element of an input; reading one stops the advance run, so no motion is blended across it."""
        if not name.startswith("$"):
            return None
        key = name.upper()
        if key in ("$TIMER", "$TIMER_FLAG") and len(index) == 1:
            value = self.clock.read_timer(index[0])
            return math.floor(value + 1e-6) if key == "$TIMER" else value > 0.0  # whole ms that have passed
        found = self.controller.element(key, index)
        if found is not None and key in ("$IN", "$OUT", "$ANIN", "$ANOUT"):
            self.motions.stop_advance()
        return found

    def call(self, x: e.FunctionCall) -> Value:
        """The value of a predefined function, or of one of the program, which is executed to its end."""
        return self._value_of_call(self, x)

    def signal_reference(self, name: str) -> VariableReference | None:
        """The inputs or outputs of a SIGNAL name; None for another name."""
        signal = self._signal(name.upper())
        return None if signal is None else signal_reference(self, signal)

    def _signal(self, key: str) -> Signal | None:
        """What a name declared with SIGNAL stands for; the controller's own states are no signals here."""
        if key.startswith("$"):
            return None
        local = self._declared.get(id(self.stack[-1].routine), {}).get(key) if self.stack else None
        declared = local or self.here.names.variables.get(key)
        return None if declared is None else declared.signal

    def note_read(self, name: str) -> None:
        """A value that is assumed and read is listed."""
        self.controller.note_read(name)

    def component_type(self, struct: str, name: str) -> Type:
        """The type of a component; unknown for an unknown structure or component."""
        components = self.here.names.structures.get(struct) or self.here.project.known.structures.get(struct) or {}
        return components.get(name, UNKNOWN)

    # --- calls and the variables of files
    def enter(self, routine: Routine, arguments: Sequence[e.Expression | None] = ()) -> None:
        """Put a call on the stack, with its arguments; OUT parameters are the caller's own variables."""
        if len(self.stack) >= DEEPEST:
            deep = f"{DEEPEST} calls inside one another, at {routine.head.name}"
            self.log.end_run("error", "recursion", deep, "use a loop")
        home = self.program_of(routine.file.name)
        if id(routine) not in self._declared:
            self._declared[id(routine)] = scope_of(home, routine, []).own.variables
        declared = self._declared[id(routine)]
        variables: dict[str, Variable] = {}
        for i, p in enumerate(routine.head.parameters):
            key = p.name.upper()
            kind = declared[key].type if key in declared else UNKNOWN
            variables[key] = _argument(self, arguments[i] if i < len(arguments) else None, p, kind)
        self.stack.append(StackFrame(home, routine, routine.first, variables))
        for key, name in declared.items():
            if key not in variables:
                variables[key] = self._new_variable(name)

    def program_of(self, file: str) -> Program:
        """The program of the module of a file."""
        if file not in self._programs:
            project = self.program.project
            self._programs[file] = program_in(project, project.homes[file])
        return self._programs[file]

    def variables_of(self, file: str) -> dict[str, Variable]:
        """The variables of a file, with their initial values."""
        if file in self.files:
            return self.files[file]
        variables = self.files[file] = {}
        read, position = self.program.project.file(file), self.log.position
        # the statements of a .dat see the names of its module
        self.stack.append(StackFrame(self.program_of(file), Routine(read.file, Def(""), 0), 0, variables))
        for key, name in read.names.variables.items():
            variables[key] = self._new_variable(name)
        for i, x in read.outline.data:
            if isinstance(x, s.Assign):
                self.log.position = read.file.position(i, x.column)
                try:
                    self.assign(x)
                except ExecutionError as fault:
                    self.log.report_fault(fault)
        self.stack.pop()
        self.log.position = position
        return variables

    def _new_variable(self, name: DeclaredName) -> Variable:
        """The variable as declared; a fault in its declaration is reported, and it has no value."""
        try:
            return _initialised(self, name)
        except ExecutionError as fault:
            self.log.position = name.position
            self.log.report_fault(fault)
            return Variable(name.type)

    def assign(self, x: s.Assign) -> None:
        """Assign a value; to an output it stops the advance run and is an event; raises `ExecutionError`."""
        target = reference_to(self, x.target)
        if isinstance(x.value, e.Aggregate):
            value: Value = (whole := aggregate_value(self, x.value, target.type.name))
            before = target.read()
            if isinstance(before, StructValue):
                # components that an aggregate does not name keep their values
                value = StructValue(whole.type, {**{k: v.copied(x) for k, x in before.parts.items()}, **whole.parts})
        else:
            value = value_of(self, x.value)
        target.write(value)
        self.controller.note_written(e.root_name(x.target))
        self._note_output(x, value)

    def _note_output(self, x: s.Assign, value: Value) -> None:
        root = e.root_name(x.target)
        signal = self._signal(root)
        if signal is not None and not isinstance(signal.first, e.Bool):
            root = e.root_name(signal.first)
        if root in ("$OUT", "$ANOUT"):
            self.motions.stop_advance()
            self.clock.record(self.log.position, "output", f"{expression_text(x.target)} = {v.value_text(value)}")
        elif root in ("$TIMER", "$TIMER_STOP") and isinstance(x.target, e.Index) and x.target.indices:
            number = int(number_of(self, x.target.indices[0], root))
            if root == "$TIMER" and isinstance(value, int | float):
                self.clock.set_timer(number, float(value))
            elif root == "$TIMER_STOP":
                self.clock.stop_timer(number, value is True)


def _argument(env: RunningProgram, x: e.Expression | None, p: Parameter, kind: Type) -> Variable:
    """The variable of a parameter: the caller's own for OUT, where the argument is one; else a new one."""
    if x is None:
        return Variable(kind)
    whole = x.of if isinstance(x, e.Index) and not x.indices else x
    if p.mode != "IN" and isinstance(whole, e.Name):
        return env.variable(whole.name)
    return Variable(kind, v.converted(value_of(env, x), kind))


def _initialised(env: RunningProgram, name: DeclaredName) -> Variable:
    """The variable as declared, with its initial value; raises `ExecutionError`."""
    d, kind = name.declarator, name.type
    if d is not None and d.sizes is not None:
        return Variable(kind, _initial_array(env, d, kind))
    if d is None or d.value is None:
        return Variable(kind)
    if isinstance(d.value, e.Aggregate):
        kind = shape_of(d.value) if kind.name == "?" else kind
        return Variable(kind, aggregate_value(env, d.value, kind.name))
    return Variable(kind, v.converted(value_of(env, d.value), kind))


def _initial_array(env: RunningProgram, d: Declarator, kind: Type) -> Value:
    sizes = tuple(int(number_of(env, x, "a size")) for x in d.sizes or ())
    if any(not 1 <= n <= LARGEST_ARRAY for n in sizes):
        message = f"{d.name} has the size {', '.join(map(str, sizes))}"
        raise ExecutionError("index-range", message, f"from 1 to {LARGEST_ARRAY}")
    return v.text_array(d.value.value, sizes) if isinstance(d.value, e.Text) else ArrayValue(kind.name, sizes)
