"""Executes a running program step by step, with bounds on steps and time, and its submit programs.

A statement changes variables, moves the arm, or sets the next line of its routine: a function for each in one table.
A submit program (.sub) makes one pass of its loop, until it goes back to the head or waits, when the robot program has
moved or waited, and in its waits. On a controller they run all the time; here a pass takes no time.
"""

from collections.abc import Callable
from pathlib import PurePosixPath
from typing import Any

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import CodeBlock
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.names.known_names import Type
from lwr_dyn.krl.running import background
from lwr_dyn.krl.running.conditions import follows_motion
from lwr_dyn.krl.running.evaluate import number_of, reference_to, truth_of, value_of
from lwr_dyn.krl.running.functions import called_routine, value_of_call
from lwr_dyn.krl.running.inline_forms import bas, with_settings
from lwr_dyn.krl.running.motions import OpenBlock, begin_block, collect, end_block
from lwr_dyn.krl.running.running_program import ActiveInterrupt, RunningProgram, StackFrame, Submit, Watch
from lwr_dyn.krl.running.triggers import PathTrigger
from lwr_dyn.krl.running.values import Value, converted

MOST_STEPS = 5000
"""Statements of one pass of a submit program."""


def step(m: RunningProgram, result: list[Value] | None = None) -> None:
    """Execute the next statement; RETURN adds its value to `result`."""
    frame = m.stack[-1]
    if frame.at >= frame.routine.last:
        m.stack.pop()
        return
    at = frame.at
    frame.at += 1
    statement = frame.routine.file.lines[at].statement
    if statement is None:
        return
    position = m.log.position = frame.routine.file.place(at)
    _count_step(m)
    before = len(m.motions.executed)
    try:
        if isinstance(statement, s.Return):
            _return(m, statement, result)
        else:
            _execute(m, statement, frame, at)
        _look_beside(m, statement, position, before)
        if frame.at <= at and m.stack and m.stack[-1] is frame and not m.submitting:
            background.look_at_loop(m, frame, at)
    except ExecutionError as fault:
        m.log.report_fault(fault)
        if isinstance(statement, s.Assign):
            m.log.unassigned.add(e.root_name(statement.target))


def _count_step(m: RunningProgram) -> None:
    m.steps += 1
    bounds = (
        (m.steps > m.machine.steps, f"{m.machine.steps} statements"),
        (m.motions.now > m.machine.seconds, f"{m.machine.seconds:g} s of simulated time"),
        (m.motions.count >= m.machine.motions, f"{m.machine.motions} motions"),
    )
    for reached, what in bounds:
        if reached:
            end_at_bound(m, what)


def end_at_bound(m: RunningProgram, what: str) -> None:
    """End the run: an endless loop is cut."""
    m.log.end_run("note", "bound", f"stopped here after {what}", "an endless loop is cut; the bound is an option")


def _return(m: RunningProgram, x: s.Return, result: list[Value] | None) -> None:
    value = None if x.value is None else value_of(m, x.value)
    kind = m.stack[-1].routine.head.returns
    if value is not None and kind is not None:
        value = converted(value, Type(kind.upper()))
    m.stack.pop()
    if result is not None and value is not None:
        result.append(value)


def _look_beside(m: RunningProgram, x: s.Statement, position: SourcePosition, before: int) -> None:
    """Look at what the statement has changed; `before` is the number of motions executed before it."""
    if len(m.motions.executed) > before:
        m.clock.at = None
        _run_submits(m)
    if isinstance(x, s.Move) and m.triggers.waiting:
        m.triggers.bind(position, before)
    if m.triggers.bound:
        m.triggers.plan(final=False)
    background.settle(m)


def _execute_beside(m: RunningProgram, action: s.Assign | s.Invoke, position: SourcePosition) -> None:
    """Execute an assignment or a whole subprogram now; without motion it does not stop the advance run."""
    motions, before = m.motions, m.log.position
    advance, count, depth = motions.advance, len(motions.executed), len(m.stack)
    m.log.position = position
    if isinstance(action, s.Assign):
        m.assign(action)
    else:
        _invoke(m, action)
        while len(m.stack) > depth:
            step(m)
    m.log.position = before
    if len(motions.executed) == count:
        motions.advance = advance


# --- submit programs
def start_submits(m: RunningProgram) -> None:
    """The submit programs of the cell, each with its first pass; raises `OptionError` where one is not there."""
    m.submits = [Submit(_submit_file(m, path)) for path in m.controller.cell.submits]
    _run_submits(m)


def _submit_file(m: RunningProgram, path: str) -> str:
    """The file of the project that a cell names; raises `OptionError` where there is none."""
    name = PurePosixPath(path.replace("\\", "/")).name.lower()
    found = (x.file.name for x in m.program.project.files if PurePosixPath(x.file.name).name.lower() == name)
    file = next(found, None)
    if file is None:
        raise OptionError("submits of the cell", f"{name} is not among the files", "a .sub that --with brings")
    return file


def _run_submits(m: RunningProgram) -> None:
    """One pass of each submit program."""
    if not m.submitting:
        m.submitting = True
        for x in m.submits:
            _run_submit(m, x)
        m.submitting = False


def _run_submit(m: RunningProgram, submit: Submit) -> None:
    robot, position, advance = m.stack[:], m.log.position, m.motions.advance
    m.stack[:] = submit.stack
    if not submit.began:
        submit.began = True
        m.controller.assume(submit.file, "", "one pass, in no time, after each motion and wait and in waits")
        m.enter(m.program_of(submit.file).routines[0])
    for _ in range(MOST_STEPS):
        if not m.stack or _ends_pass(m):
            break
    submit.stack = m.stack[:]
    m.stack[:] = robot
    m.log.position, m.motions.advance = position, advance


def _ends_pass(m: RunningProgram) -> bool:
    """Execute one statement of a submit program; whether it has ended a pass."""
    frame = m.stack[-1]
    at = frame.at
    x = frame.routine.file.lines[at].statement if at < frame.routine.last else None
    if isinstance(x, s.Move | s.SplineBlock | s.Wait):
        m.log.position = frame.routine.file.place(at)
    if isinstance(x, s.Move | s.SplineBlock):
        raise ExecutionError("submit-motion", "a submit program moves the robot", "motions belong into a .src")
    if isinstance(x, s.Wait):
        if x.kind == "SEC" or truth_of(m, x.value, "WAIT FOR"):
            frame.at += 1
        return True
    step(m)
    return isinstance(x, s.Plain | s.Jump) and frame.at <= at


# --- statements
def _execute(m: RunningProgram, x: s.Statement, frame: StackFrame, at: int) -> None:
    """Execute the statement in line `at` of a routine; raises `ExecutionError`."""
    function = _FUNCTIONS.get(type(x))
    if function is not None:
        function(m, x, frame, at)
    if not (isinstance(x, s.Plain) and x.keyword == "CONTINUE"):
        m.motions.kept = False


def _wait(m: RunningProgram, x: s.Wait) -> None:
    """WAIT SEC or WAIT FOR; raises `ExecutionError` where nothing can end it."""
    if x.kind == "SEC":
        m.motions.wait(number_of(m, x.value, "WAIT SEC"), m.log.position)
        return
    looks = 0
    while not (met := truth_of(m, x.value, "WAIT FOR")) and looks < background.MOST_LOOKS:
        time = background.next_time(m)
        if time is None or m.motions.now > m.machine.seconds:
            break
        m.motions.wait(max(time - m.motions.now, 0.0), m.log.position, "WAIT FOR")
        _run_submits(m)
        background.settle(m)
        looks += 1
    m.motions.stop_advance()
    if met:
        return
    after = m.controller.cell.unmet_wait
    if after is None:
        hint = "set its input: --set, or a reply or unmet_wait_s in a cell file"
        raise ExecutionError("waits-forever", "the condition is FALSE and nothing here can change it", hint)
    name = f"WAIT FOR {expression_text(x.value)}"
    m.controller.assume(name, f"met after {after:g} s", "unmet_wait_s of the cell file")
    m.motions.wait(after, m.log.position, "WAIT FOR")


def _invoke(m: RunningProgram, x: s.Invoke) -> None:
    """A subprogram call; raises `ExecutionError`."""
    name = x.call.name.upper()
    routine = called_routine(m, name)
    if routine is not None:
        m.enter(routine, x.call.arguments)
    elif name in m.controller.cell.stubs:
        value_of_call(m, x.call)
    elif name == "BAS":
        bas(m, x.call)
    elif value_of_call(m, x.call) is None:
        m.motions.note_unmodelled(name)


def _move(m: RunningProgram, x: s.Move) -> None:
    with with_settings(m, x.settings):
        if m.motions.block is None:
            m.motions.move(m, x, m.log.position)
        else:
            collect(m.motions, m, x, m.log.position)


def _plain(m: RunningProgram, x: s.Plain, frame: StackFrame, at: int) -> None:
    if x.keyword == "HALT":
        m.motions.stop_advance()
        m.clock.record(m.log.position, "halt", "HALT")
        m.controller.assume("HALT", "", "the program is started again at once")
    elif x.keyword in ("RESUME", "BRAKE", "BRAKE F"):
        background.resume(m) if x.keyword == "RESUME" else background.brake_arm(m)
    elif x.keyword == "CONTINUE":
        m.motions.kept = True
    else:
        _block_keyword(m, x.keyword, frame, at)


def _block_keyword(m: RunningProgram, keyword: str, frame: StackFrame, at: int) -> None:
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


def _branch(m: RunningProgram, x: s.Condition, frame: StackFrame, at: int) -> None:
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


def _switch(m: RunningProgram, x: s.Condition, block: CodeBlock, frame: StackFrame) -> None:
    value = value_of(m, x.value)
    for at in block.parts:
        case = frame.routine.file.lines[at].statement
        if not isinstance(case, s.CaseBranch) or any(value_of(m, v) == value for v in case.values):
            frame.at = at + 1
            return
    frame.at = block.last + 1


def _begin_for(m: RunningProgram, x: s.For, frame: StackFrame, at: int) -> None:
    """FOR: into the block, or past it; raises `ExecutionError`."""
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


def _next_for(m: RunningProgram, block: CodeBlock, frame: StackFrame) -> None:
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
    """GOTO; raises `ExecutionError` where there is no such label."""
    if x.label.upper() not in frame.routine.labels:
        raise ExecutionError("undeclared", f"there is no label {x.label}")
    frame.at = frame.routine.labels[x.label.upper()]


def _trigger(m: RunningProgram, x: s.Trigger) -> None:
    """TRIGGER: its action waits for the next motion; raises `ExecutionError`."""
    position = m.log.position
    value, delay = number_of(m, x.value, x.place), number_of(m, x.delay, "DELAY") / 1e3

    def act() -> None:
        m.clock.record(position, "trigger", f"TRIGGER {x.place} = {value:g}, {1e3 * delay:g} ms")
        _execute_beside(m, x.action, position)

    m.triggers.add(PathTrigger(x, value, delay, m.controller.tool, act))


def _declare_interrupt(m: RunningProgram, x: s.InterruptDeclaration, frame: StackFrame) -> None:
    """INTERRUPT DECL: it is off until it is switched on; raises `ExecutionError`."""
    position, priority = m.log.position, int(number_of(m, x.priority, "the priority of INTERRUPT"))
    old = m.interrupts.get(priority)

    def follow() -> None:
        m.clock.record(position, "interrupt", f"interrupt {priority}: {expression_text(x.condition)}")
        before, m.interrupt = m.interrupt, ActiveInterrupt(priority, frame)
        try:
            if x.with_brake:
                background.brake_arm(m)
            _execute_beside(m, x.action, position)
            if m.interrupt.stopped is not None:
                m.triggers.go_on(*m.interrupt.stopped)
        finally:
            m.interrupt = before

    moves, enabled = follows_motion(x.condition), old is not None and old.enabled
    m.interrupts[priority] = Watch(x.condition, follow, enabled=enabled, frame=frame, moves=moves, since=m.clock.now)


def _spline(m: RunningProgram, x: s.SplineBlock, frame: StackFrame, at: int) -> None:
    settings = with_settings(m, x.settings)
    settings.__enter__()
    begin_block(m.motions, OpenBlock(x.kind, m.log.position, settings))


def _not_carried_out(m: RunningProgram, name: str, effect: str) -> None:
    """A statement of spline blocks whose timing KUKA does not publish."""
    m.log.report("note", "not-modelled", f"{name} is not carried out: {effect}", "times may differ from the robot's")


def _end_spline(m: RunningProgram, x: s.EndSpline) -> None:
    block = m.motions.block
    try:
        end_block(m.motions, x.blends)
    finally:
        if block is not None:
            block.settings.__exit__(None, None, None)


_FUNCTIONS: dict[type, Callable[[RunningProgram, Any, StackFrame, int], None]] = {
    s.Assign: lambda m, x, frame, at: m.assign(x),
    s.Invoke: lambda m, x, frame, at: _invoke(m, x),
    s.Move: lambda m, x, frame, at: _move(m, x),
    s.Wait: lambda m, x, frame, at: _wait(m, x),
    s.Plain: _plain,
    s.Condition: _branch,
    s.CaseBranch: lambda m, x, frame, at: _block_keyword(m, "CASE", frame, at),
    s.For: _begin_for,
    s.Jump: lambda m, x, frame, at: _goto(x, frame),
    s.Trigger: lambda m, x, frame, at: _trigger(m, x),
    s.InterruptDeclaration: lambda m, x, frame, at: _declare_interrupt(m, x, frame),
    s.InterruptSwitch: lambda m, x, frame, at: background.switch_interrupts(m, x),
    s.ConstantSpeed: lambda m, x, frame, at: _not_carried_out(m, "CONST_VEL", "the speed may fall within its range"),
    s.TimeBlock: lambda m, x, frame, at: _not_carried_out(m, "TIME_BLOCK", "the spline is as fast as the arm allows"),
    s.ConditionalStop: lambda m, x, frame, at: _not_carried_out(m, "STOP WHEN", "the arm does not stop there"),
    s.SplineBlock: _spline,
    s.EndSpline: lambda m, x, frame, at: _end_spline(m, x),
}
