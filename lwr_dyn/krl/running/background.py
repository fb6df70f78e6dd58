"""What goes on beside a running program: the cell's values and answers, interrupts, BRAKE and RESUME, and loops.

A condition is looked at after each statement and at each time at which something is due; one on what moves also between
them (`conditions`). A loop is looked at when it
goes back to its head: the run ends where the state of the whole program has come back, so that all later passes are
known; where no time has passed, the loop only watches, and time passes until something beside the program happens.
"""

import re
from collections.abc import Mapping
from difflib import get_close_matches
from functools import partial
from typing import Any, NoReturn

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError, ResumedError
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.line_parser import statement_of
from lwr_dyn.krl.names.known_names import CONFIG, SYSTEM
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.running.cell import Reply
from lwr_dyn.krl.running.conditions import follows_motion, is_true, next_rise
from lwr_dyn.krl.running.controller import INPUTS, ControllerState
from lwr_dyn.krl.running.evaluate import number_of, reference_to
from lwr_dyn.krl.running.running_program import SAME, KeptState, LoopWatch, RunningProgram, StackFrame, Watch
from lwr_dyn.krl.running.triggers import TICK
from lwr_dyn.krl.running.values import Value, Variable, converted, copied, value_text

MOST_AT_ONCE = 1000
"""Interrupts and answers that may follow one another at one time."""
MOST_LOOKS = 10_000
"""Times that a waiting program looks again while only timers or submit programs run."""
LONGEST_TAIL = 10.0
"""[s] After the end of a program, what still happens: delays of triggers, answers of the cell."""
SPEEDS = ("$VEL", "$ACC", "$VEL_AXIS", "$ACC_AXIS", "$OV_PRO")
ROUNDED = 9
"""Digits of axes [rad] and times [s] that count in a state."""


def next_time(m: RunningProgram) -> float | None:
    """[s] At which something beside the program happens next; None where nothing ever does."""
    time = m.clock.next_time()
    times = [] if time is None else [time]
    if any(x.stack for x in m.submits):
        times.append(m.clock.now + TICK)
    return min(times, default=None)


def settle(m: RunningProgram) -> None:
    """Let all happen that is due, and all that follows from it."""
    if not (m.clock.pending or m.replies or m.interrupts):
        return
    for _ in range(MOST_AT_ONCE):
        happened = _pass_time(m)
        if not _look(m) and not happened:
            return
    _end_endless(m)


def _end_endless(m: RunningProgram) -> NoReturn:
    message = "interrupts or answers of the cell follow one another without end"
    m.log.end_run("error", "endless", message, "an answer that comes later")


def _run_next(m: RunningProgram) -> None:
    """Let the next of what is pending happen."""
    m.clock.run_next(lambda: _look(m))
    if m.clock.at_once > MOST_AT_ONCE:
        _end_endless(m)


def settle_rest(m: RunningProgram) -> None:
    """The program has ended: what was planned for later still happens."""
    m.triggers.plan(final=True)
    while m.clock.due(m.motions.now + LONGEST_TAIL) is not None:
        try:
            _run_next(m)
        except ExecutionError as fault:  # no statement is executed any more that would report it
            m.log.report_fault(fault)


def _pass_time(m: RunningProgram) -> bool:
    """Let all happen that is due now, in order of time; whether anything was."""
    happened = False
    while True:
        due = m.clock.due(m.motions.now)
        until = m.motions.fixed if due is None else min(due, m.motions.fixed)
        rise = next_rise(m, [x for x in _live(m) if x.moves], until)
        if rise is not None:
            time, watch = rise
            watch.last = True
            m.clock.run_at(time, watch.follow, lambda: _look(m))
        elif due is not None:
            _run_next(m)
        else:
            return happened
        happened = True


def _live(m: RunningProgram) -> list[Watch]:
    """The cell's answers, and the interrupts that may come now, in order of priority."""
    above = m.interrupt.priority
    for watch in m.interrupts.values():
        watch.enabled = watch.enabled and watch.frame in m.stack
    return [*m.replies, *(x for p, x in sorted(m.interrupts.items()) if p < above and x.enabled)]


def _look(m: RunningProgram) -> bool:
    """Look at the conditions on what stands still between statements; whether one has become true."""
    followed = False
    for priority, watch in m.interrupts.items():
        if priority >= m.interrupt.priority and watch.last and not watch.moves and not is_true(m, watch.condition):
            watch.last = False  # it may rise again when the interrupt that is executed now has ended
    for watch in _live(m):
        if watch.moves or (watch.frame is not None and watch.frame not in m.stack):
            continue
        now = is_true(m, watch.condition)
        rises, watch.last = now and not watch.last, now
        if rises:
            followed = True
            watch.follow()
    return followed


# --- what the cell gives, and its answers
def give_cell(m: RunningProgram) -> None:
    """Set the variables and states of the cell; raises `OptionError` for a wrong type, or a $ name that nothing has."""
    c = m.controller
    for root, values in c.given.items():
        if root.startswith("$") and not _is_known(m.program, root):
            near = get_close_matches(root, m.program.project.known.variables, n=1)
            meant = f" (did you mean {near[0]}?)" if near else ""
            wanted = f"a $ variable of KUKA's, or one that a file names{meant}"
            raise OptionError("the name given", next(iter(values)), wanted)
        for name, value in values.items():
            try:
                give_value(m, name, value)
                if root in SPEEDS:
                    c.speeds()
            except ExecutionError as fault:
                raise OptionError(f"the given {name}", value_text(value), fault.hint or str(fault)) from None
        c.unread[root] = "given"


def _is_known(program: Program, root: str) -> bool:
    """Whether a name is KUKA's, declared in a file that the program sees, or written in one of its files."""
    if root in program.project.known.variables or root in program.names.variables:
        return True
    word = re.compile(re.escape(root) + r"(?![A-Z0-9_$])", re.IGNORECASE)
    return any(word.search(line.text()) for x in program.module.files for line in x.file.lines)


def note_unread(c: ControllerState) -> None:
    """List the variables that are given and that the run neither reads nor sets."""
    for root, why in c.unread.items():
        if why == "given" and root not in SYSTEM and root not in CONFIG:
            c.assume(root, "", "given, but nothing reads it")


def give_arguments(m: RunningProgram) -> None:
    """Set the parameters of the routine that is run; those without a value are noted; raises `OptionError`."""
    c, frame, missing = m.controller, m.stack[0], []
    for p in frame.routine.head.parameters:
        key, variable = p.name.upper(), frame.variables[p.name.upper()]
        if key not in c.cell.arguments:
            missing.append(p.name)
            continue
        value = c.cell.arguments[key]
        try:
            variable.value = converted(value, variable.type)
        except ExecutionError as fault:
            raise OptionError(f"the cell's arguments.{key}", value_text(value), fault.hint or str(fault)) from None
        c.assume(f"the argument {p.name}", value_text(value), "given")
    if missing:
        name = frame.routine.head.name
        message = f"{name} is run without its argument{'s' * (len(missing) > 1)} {', '.join(missing)}"
        m.log.report("note", "arguments", message, "give them in a cell file under [arguments]")


def give_value(m: RunningProgram, name: str, value: Value) -> str:
    """Set an input, a state or a variable from outside; the text says what is set. Raises `ExecutionError`."""
    if name.partition("[")[0] in INPUTS:
        m.controller.inputs[name] = value
    else:
        statement = statement_of(f"{name}=0")
        assert isinstance(statement, s.Assign)
        reference_to(m, statement.target).write(value)
    return f"{name} = {value_text(value)}"


def watch_for_replies(m: RunningProgram) -> None:
    """The answers of the cell, from the start of the program."""
    for i, reply in enumerate(m.controller.cell.replies):
        give = partial(_give, m, i, reply)
        if reply.when is None:
            m.clock.add(reply.after, give)
        else:
            follow = partial(m.clock.add_later, reply.after, give)
            m.replies.append(Watch(reply.when, follow, moves=follows_motion(reply.when)))
    for watch in m.replies:
        watch.last = is_true(m, watch.condition)
        if watch.last:
            watch.follow()


def _give(m: RunningProgram, i: int, reply: Reply) -> None:
    for name, value in reply.values.items():
        try:
            text = give_value(m, name, value)
        except ExecutionError as fault:
            raise OptionError(f"reply[{i}].set.{name}", str(fault), "a variable and a value of its type") from None
        m.clock.record(m.log.position, "reply", text)


# --- interrupts
def switch_interrupts(m: RunningProgram, x: s.InterruptSwitch) -> None:
    """INTERRUPT ON, OFF, ENABLE or DISABLE: one priority, or all."""
    on = x.mode in ("ON", "ENABLE")
    only = None if x.priority is None else int(number_of(m, x.priority, "the priority of INTERRUPT"))
    for priority, watch in m.interrupts.items():
        if only in (None, priority):
            watch.enabled = on
            # only an edge after this counts
            watch.last, watch.since = on and is_true(m, watch.condition), m.clock.now


def brake_arm(m: RunningProgram) -> None:
    """BRAKE: the arm stops on its path; raises `ExecutionError` outside an interrupt."""
    if m.interrupt.frame is None:
        raise ExecutionError("brake", "BRAKE outside an interrupt", "in a subprogram that INTERRUPT DECL calls")
    stopped = m.triggers.stop(m.clock.now - m.motions.idle, m.log.position)
    m.interrupt.stopped = stopped or m.interrupt.stopped
    m.clock.at = None


def resume(m: RunningProgram) -> None:
    """RESUME: back to the routine that has declared the interrupt; raises `ResumedError`, `ExecutionError`."""
    frame = m.interrupt.frame
    if frame is None or frame not in m.stack:
        raise ExecutionError("resume", "RESUME outside an interrupt", "in a subprogram that INTERRUPT DECL calls")
    del m.stack[m.stack.index(frame) + 1 :]
    m.motions.stop_advance()
    raise ResumedError


# --- loops
def look_at_loop(m: RunningProgram, frame: StackFrame, at: int) -> None:
    """Line `at` has gone back to the head of its loop: end the run where all later passes are known."""
    watch, now = frame.watched.get(frame.at), m.motions.now
    if watch is None:
        frame.watched[frame.at] = LoopWatch(now, _kept_state(m))
        return
    watch.end_pass(now, _place(m) if now - watch.began > SAME else None)
    if watch.compares and watch.kept.is_same(_head(m), _tables(m)):
        if now - watch.kept.time - watch.ticked <= SAME:
            _look_again(m, watch)
            return
        if watch.seconds and watch.kept.timers == m.clock.timers_now():
            _end(m, watch, max(min(watch.count - watch.kept.after, len(watch.seconds)), 1))
    if watch.keeps:
        watch.kept, watch.ticked = _kept_state(m, watch.count, m.clock.timers_now()), 0.0
    if endless_by_form(frame.routine, at) and (watch.alike() or len(watch.seconds) >= m.machine.passes):
        _end(m, watch, 0)


def _end(m: RunningProgram, watch: LoopWatch, period: int) -> None:
    m.passes = watch.passes(m.log.position, period)
    m.log.end_run("note", "endless", str(m.passes), "")


def _look_again(m: RunningProgram, watch: LoopWatch) -> None:
    """The loop only watches: let time pass until something beside the program happens."""
    time = next_time(m)
    if time is None or watch.looks >= MOST_LOOKS:
        message = "the loop goes round without motion or wait, and nothing here can end it"
        m.log.end_run("warning", "endless", message, "a WAIT or an EXIT; inputs and answers: a cell file")
    watch.looks += 1
    seconds = max(time - m.motions.now, 0.0)
    watch.ticked += seconds
    m.motions.wait(seconds, m.log.position, "watching loop")
    settle(m)


def _kept_state(m: RunningProgram, after: int = 0, timers: tuple[tuple[int, float], ...] = ()) -> KeptState:
    copies = ({name: None if x.value is None else copied(x.value) for name, x in table.items()} for table in _tables(m))
    return KeptState(_head(m), tuple(copies), m.motions.now, after, timers)


def _tables(m: RunningProgram) -> list[Mapping[str, Variable]]:
    frames = [*m.stack, *(frame for x in m.submits for frame in x.stack)]
    return [*(frame.variables for frame in reversed(frames)), *m.files.values(), m.controller.variables]


def _place(m: RunningProgram) -> tuple[float, ...] | None:
    q = m.controller.q
    return None if q is None else tuple((np.round(q, ROUNDED) + 0.0).tolist())


def _head(m: RunningProgram) -> tuple[Any, ...]:
    """Axes, lines of the calls, blend, inputs, and when pending events come."""
    lines = tuple((id(frame.routine), frame.at, tuple(frame.loops.items())) for frame in m.stack)
    submits = tuple((id(frame.routine), frame.at) for x in m.submits for frame in x.stack)
    pending = tuple(sorted(round(time - m.motions.now, ROUNDED) for time, _, _ in m.clock.pending))
    watches = tuple((p, w.enabled, w.last) for p, w in m.interrupts.items())
    inputs = tuple(sorted((k, repr(v)) for k, v in m.controller.inputs.items()))
    return _place(m), lines, submits, pending, watches, inputs, m.motions.advance, repr(m.motions.blend)


def endless_by_form(routine: Routine, at: int) -> bool:
    """Whether the LOOP that ends in line `at` has no way out: no EXIT, no jump, no RETURN, no HALT inside."""
    block = routine.blocks.get(at)
    if block is None or block.kind != "LOOP":
        return False
    for i in range(block.first, at):
        x = routine.file.lines[i].statement
        leaves = isinstance(x, s.Plain) and x.keyword == "EXIT" and routine.blocks.get(i) is block
        if leaves or isinstance(x, s.Jump | s.Return):
            return False
    return True
