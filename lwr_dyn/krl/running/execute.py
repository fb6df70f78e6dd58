"""Executes one statement of a running program: a function for each statement in one table.

A statement changes variables, moves the arm, or sets the next line of its routine. RETURN is in the interpreter.

What a statement sees and changes: the frame of its routine, and the running program around it.

WAIT, HALT: the program stands until a time has passed or until something beside it makes a condition true.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from lwr_dyn.krl.diagnostics import DiagnosticLog, ExecutionError, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import CodeBlock, Routine
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.running.controller import ControllerState, MachineData
from lwr_dyn.krl.running.evaluate import (
    Environment,
    aggregate_value,
    number_of,
    reference_to,
    root_name,
    truth_of,
    value_of,
)
from lwr_dyn.krl.running.functions import called_routine, value_of_call
from lwr_dyn.krl.running.inline_forms import WithSettings, bas
from lwr_dyn.krl.running.motions import Motions, OpenBlock, begin_block, collect, end_block
from lwr_dyn.krl.running.values import StructValue, Value, Variable, copied, value_text


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


MOST_LOOKS = 10_000
"""Times that a waiting program looks again while only timers or submit programs run."""


def wait(m: ExecutionContext, x: s.Wait) -> None:
    """WAIT SEC or WAIT FOR; raises `ExecutionError` where nothing can end it."""
    if x.kind == "SEC":
        m.motions.wait(number_of(m, x.value, "WAIT SEC"), m.log.position)
    else:
        _wait_for(m, x)


def _wait_for(m: ExecutionContext, x: s.Wait) -> None:
    looks = 0
    while not (met := truth_of(m, x.value, "WAIT FOR")) and looks < MOST_LOOKS:
        time = m.background.next_time()
        if time is None or m.motions.now > m.machine.seconds:
            break
        m.motions.wait(max(time - m.motions.now, 0.0), m.log.position, "WAIT FOR")
        m.background.run_submits()
        m.background.settle()
        looks += 1
    m.motions.stop_advance()
    if not met:
        _unmet(m, expression_text(x.value))


def _unmet(m: ExecutionContext, text: str) -> None:
    after = m.controller.cell.unmet_wait
    if after is None:
        message = "the condition is FALSE and nothing here can change it"
        raise ExecutionError(
            "waits-forever", message, "set its input: --set, or a reply or unmet_wait_s in a cell file"
        )
    m.controller.assumptions.note(f"WAIT FOR {text}", f"met after {after:g} s", "unmet_wait_s of the cell file")
    m.motions.wait(after, m.log.position, "WAIT FOR")


def halt(m: ExecutionContext) -> None:
    """HALT: the program is started again at once."""
    m.motions.stop_advance()
    m.background.clock.record(m.log.position, "halt", "HALT")
    m.controller.assumptions.note("HALT", "", "the program is started again at once")


def execute(m: ExecutionContext, x: s.Statement, frame: StackFrame, at: int) -> None:
    """Execute the statement in line `at` of a routine; raises `ExecutionError`."""
    function = _FUNCTIONS.get(type(x))
    if function is not None:
        function(m, x, frame, at)
    if not (isinstance(x, s.Plain) and x.keyword == "CONTINUE"):
        m.motions.kept = False


def assign(m: ExecutionContext, x: s.Assign) -> None:
    """Assign a value; to an output it stops the advance run; raises `ExecutionError`."""
    target = reference_to(m, x.target)
    value = aggregate_value(m, x.value, target.type.name) if isinstance(x.value, e.Aggregate) else value_of(m, x.value)
    before = target.read()
    if isinstance(x.value, e.Aggregate) and isinstance(before, StructValue) and isinstance(value, StructValue):
        # components that an aggregate does not name keep their values
        value = StructValue(value.type, {**{k: copied(v) for k, v in before.parts.items()}, **value.parts})
    target.write(value)
    m.controller.note_written(root_name(x.target))
    _note_output(m, x, value)


def _note_output(m: ExecutionContext, x: s.Assign, value: Value) -> None:
    """An output stops the advance run and is an event; timers count from here."""
    root, clock = m.io_name(x.target), m.background.clock
    if root in ("$OUT", "$ANOUT"):
        m.motions.stop_advance()
        clock.record(m.log.position, "output", f"{expression_text(x.target)} = {value_text(value)}")
    elif root in ("$TIMER", "$TIMER_STOP") and isinstance(x.target, e.Index) and x.target.indices:
        number = int(number_of(m, x.target.indices[0], root))
        if root == "$TIMER" and isinstance(value, int | float):
            clock.set_timer(number, float(value))
        elif root == "$TIMER_STOP":
            clock.stop_timer(number, value is True)


def invoke(m: ExecutionContext, x: s.Invoke) -> None:
    """A subprogram call; raises `ExecutionError`."""
    name = x.call.name.upper()
    routine = called_routine(m, name)
    if routine is not None:
        m.enter(routine, x.call)
    elif name in m.controller.cell.stubs:
        value_of_call(m, x.call)
    elif name == "BAS":
        _bas(m, x.call)
    elif value_of_call(m, x.call) is None:
        m.motions.note_unmodelled(name)


def _bas(m: ExecutionContext, x: e.FunctionCall) -> None:
    arguments = [a for a in x.arguments if a is not None]
    if not arguments or not isinstance(arguments[0], e.EnumLiteral):
        raise ExecutionError("type", "BAS without a command", "BAS(#INITMOV, 0)")
    value = number_of(m, arguments[1], "the value of BAS") if len(arguments) > 1 else 0.0
    bas(m, m.controller, arguments[0].name.upper(), value)


def _with(m: ExecutionContext, settings: tuple[s.Assign, ...]) -> WithSettings:
    return WithSettings(m.controller, m.motions.note_unmodelled, settings, lambda setting: assign(m, setting))


def _move(m: ExecutionContext, x: s.Move) -> None:
    with _with(m, x.settings):
        if m.motions.block is None:
            m.motions.move(m, x, m.log.position)
        else:
            collect(m.motions, m, x, m.log.position)


def _plain(m: ExecutionContext, x: s.Plain, frame: StackFrame, at: int) -> None:
    if x.keyword == "HALT":
        halt(m)
    elif x.keyword in ("RESUME", "BRAKE", "BRAKE F"):
        m.background.resume() if x.keyword == "RESUME" else m.background.brake()
    elif x.keyword == "CONTINUE":
        m.motions.keep_advance()
    else:
        _block_keyword(m, x.keyword, frame, at)


def _block_keyword(m: ExecutionContext, keyword: str, frame: StackFrame, at: int) -> None:
    """ELSE, CASE, DEFAULT and EXIT leave their block; ENDLOOP, ENDWHILE and ENDFOR return to its beginning."""
    block = frame.routine.blocks.get(at)
    if block is None:
        return
    if keyword in ("ELSE", "CASE", "DEFAULT", "EXIT"):
        frame.at = block.last + 1
        return
    # the block of this line is the outermost one that it closes
    back = {"ENDLOOP": block.first + 1, "ENDWHILE": block.first}
    if keyword in back:
        frame.at = back[keyword]
    elif keyword == "ENDFOR":
        _next_for(m, block, frame)


def _condition(m: ExecutionContext, x: s.Condition, frame: StackFrame, at: int) -> None:
    """IF, WHILE, UNTIL, SWITCH: into the block, to one of its parts, or past it."""
    block = frame.routine.blocks.get(at)
    if block is None:
        return
    if x.keyword == "SWITCH":
        _switch(m, x, block, frame)
    elif x.keyword == "UNTIL":
        if not truth_of(m, x.value, "UNTIL"):
            frame.at = block.first + 1
    elif not truth_of(m, x.value, x.keyword):
        frame.at = (block.parts[0] if block.parts else block.last) + 1


def _switch(m: ExecutionContext, x: s.Condition, block: CodeBlock, frame: StackFrame) -> None:
    value = value_of(m, x.value)
    for at in block.parts:
        case = frame.routine.file.lines[at].statement
        if not isinstance(case, s.CaseBranch) or any(value_of(m, v) == value for v in case.values):
            frame.at = at + 1
            return
    frame.at = block.last + 1


def _begin_for(m: ExecutionContext, x: s.For, frame: StackFrame, at: int) -> None:
    block = frame.routine.blocks.get(at)
    if block is None:
        return
    first, last = (round(number_of(m, v, "FOR")) for v in (x.first, x.last))
    step = 1 if x.step is None else round(number_of(m, x.step, "STEP"))
    if step == 0:
        raise ExecutionError("endless", "STEP 0 never ends", "a step that is not 0")
    reference_to(m, x.variable).write(first)
    frame.loops[at] = (last, step)
    if (first - last) * step > 0:
        frame.at = block.last + 1


def _next_for(m: ExecutionContext, block: CodeBlock, frame: StackFrame) -> None:
    x = frame.routine.file.lines[block.first].statement
    if not isinstance(x, s.For) or block.first not in frame.loops:
        return
    last, step = frame.loops[block.first]
    variable = reference_to(m, x.variable)
    value = variable.read()
    if not isinstance(value, int):
        raise ExecutionError("no-value", "the variable of FOR has lost its value", "do not assign it in the loop")
    if (value + step - last) * step <= 0:
        variable.write(value + step)
        frame.at = block.first + 1


def _goto(x: s.Jump, frame: StackFrame) -> None:
    if x.label.upper() not in frame.routine.labels:
        raise ExecutionError("undeclared", f"there is no label {x.label}")
    frame.at = frame.routine.labels[x.label.upper()]


def _spline(m: ExecutionContext, x: s.SplineBlock, frame: StackFrame, at: int) -> None:
    settings = _with(m, x.settings)
    settings.__enter__()
    begin_block(m.motions, OpenBlock(x.kind, m.log.position, settings))


def _end_spline(m: ExecutionContext, x: s.EndSpline) -> None:
    block = m.motions.block
    try:
        end_block(m.motions, x.blends)
    finally:
        if block is not None:
            block.settings.__exit__(None, None, None)


_FUNCTIONS: dict[type, Callable[[ExecutionContext, Any, StackFrame, int], None]] = {
    s.Assign: lambda m, x, frame, at: assign(m, x),
    s.Invoke: lambda m, x, frame, at: invoke(m, x),
    s.Move: lambda m, x, frame, at: _move(m, x),
    s.Wait: lambda m, x, frame, at: wait(m, x),
    s.Plain: _plain,
    s.Condition: _condition,
    s.CaseBranch: lambda m, x, frame, at: _block_keyword(m, "CASE", frame, at),
    s.For: _begin_for,
    s.Jump: lambda m, x, frame, at: _goto(x, frame),
    s.Trigger: lambda m, x, frame, at: m.background.trigger(x, m.log.position),
    s.InterruptDeclaration: lambda m, x, frame, at: m.background.declare(x, frame, m.log.position),
    s.InterruptSwitch: lambda m, x, frame, at: m.background.switch(x),
    s.SplineBlock: _spline,
    s.EndSpline: lambda m, x, frame, at: _end_spline(m, x),
}
