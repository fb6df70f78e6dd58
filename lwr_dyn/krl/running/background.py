"""What goes on beside a running program: triggers, interrupts, the answers of the cell, submit programs.

Submit programs (.sub): each makes one pass of its loop when the robot program has moved or waited, and in its waits.

On a controller they run all the time, each statement in its turn; here a pass takes no time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError, ResumedError, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.project.project import Project
from lwr_dyn.krl.running.cell import Reply
from lwr_dyn.krl.running.evaluate import number_of, truth_of
from lwr_dyn.krl.running.execute import ExecutionContext, StackFrame
from lwr_dyn.krl.running.outside_values import give_value
from lwr_dyn.krl.running.triggers import TICK, PathTrigger, PlannedTrigger, ProgramClock, StoppedMotion, Triggers

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


MOST_AT_ONCE = 100
"""Interrupts and answers that may follow one another at one time."""

LONGEST_TAIL = 10.0
"""[s] After the end of a program, what still happens: delays of triggers, answers of the cell."""


@dataclass(slots=True, eq=False)
class Watch:
    """A condition that is looked at; what follows when it becomes true."""

    condition: e.Expression
    follow: Callable[[], object]
    last: bool = False
    enabled: bool = True
    frame: StackFrame | None = None
    """The routine that has declared an interrupt: it holds there and in what that calls."""


@dataclass(slots=True, eq=False)
class Background:
    """The clock of a program, and what depends on it."""

    m: ExecutionContext
    clock: ProgramClock
    triggers: Triggers
    interrupts: dict[int, Watch] = field(default_factory=dict)
    replies: list[Watch] = field(default_factory=list)
    priority: int = 1000
    """Of the interrupt that is executed now; only a lower number may come between."""
    returns_to: StackFrame | None = None
    """The routine that has declared the interrupt that is executed now."""
    stopped: tuple[StoppedMotion, list[PlannedTrigger]] | None = None
    """The motion that BRAKE has stopped in it, and triggers at places that it has not reached."""
    submits: list[Submit] = field(default_factory=list)
    submitting: bool = False
    """Whether one of them is executed now."""

    def start(self) -> None:
        """The cell's answers are watched, and its submit programs run, from the start."""
        project = self.m.program.project
        self.submits = [Submit(submit_file(project, path)) for path in self.m.controller.cell.submits]
        self.run_submits()
        for i, reply in enumerate(self.m.controller.cell.replies):
            if reply.when is None:
                self.clock.add(reply.after, self._giving(i, reply))
            else:
                self.replies.append(Watch(reply.when, self._later(i, reply)))
        for watch in self.replies:
            watch.last = self._is_true(watch.condition)
            if watch.last:
                watch.follow()

    def after_statement(self, x: s.Statement, position: SourcePosition, before: int) -> None:
        """Look at what the statement has changed; `before` is the number of motions executed before it."""
        if len(self.m.motions.executed) > before:
            self.clock.at = None
            self.run_submits()
        if isinstance(x, s.Move) and self.triggers.waiting:
            self.triggers.bind(position, before)
        if self.triggers.bound:
            self.triggers.plan(final=False)
        self.settle()

    def next_time(self) -> float | None:
        """[s] At which something beside the program happens next; None where nothing ever does."""
        times = [self.clock.next_time()] if self.clock.next_time() is not None else []
        if any(x.stack for x in self.submits):
            times.append(self.clock.now + TICK)
        return min((t for t in times if t is not None), default=None)

    def run_submits(self) -> None:
        """One pass of each submit program."""
        if not self.submitting:
            self.submitting = True
            for x in self.submits:
                run_submit(self.m, x)
            self.submitting = False

    def submit_frames(self) -> list[StackFrame]:
        """The calls of all submit programs."""
        return [frame for x in self.submits for frame in x.stack]

    def end(self) -> None:
        """The program has ended: what was planned for later still happens."""
        self.triggers.plan(final=True)
        while (time := self.clock.pending[0][0] if self.clock.pending else None) is not None:
            if time > self.m.motions.now + LONGEST_TAIL:
                return
            self.clock.run_due(self._look, time)

    def settle(self) -> None:
        """Let all happen that is due, and all that follows from it."""
        if not (self.clock.pending or self.replies or self.interrupts):
            return
        for _ in range(MOST_AT_ONCE):
            happened = self.clock.run_due(self._look)
            if not self._look() and not happened:
                return
        raise ExecutionError("endless", "interrupts or answers of the cell follow one another without end", "")

    def _look(self) -> bool:
        """Look at the conditions; whether one has become true."""
        followed = False
        for priority, watch in self.interrupts.items():
            if priority >= self.priority and watch.last and not self._is_true(watch.condition):
                watch.last = False  # it may rise again when the interrupt that is executed now has ended
        live = [w for p, w in sorted(self.interrupts.items()) if p < self.priority and w.enabled]
        for watch in (*self.replies, *live):
            if watch.frame is not None and watch.frame not in self.m.stack:
                watch.enabled = False
                continue
            now = self._is_true(watch.condition)
            rises, watch.last = now and not watch.last, now
            if rises:
                followed = True
                watch.follow()
        return followed

    def _is_true(self, condition: e.Expression) -> bool:
        """Whether it is true now; looking does not stop the advance run. FALSE where a value is missing."""
        motions = self.m.motions
        advance = motions.advance
        try:
            return truth_of(self.m, condition, "a condition")
        except ExecutionError as fault:
            self.m.controller.assumptions.note(expression_text(condition), "FALSE", str(fault))
            return False
        finally:
            motions.advance = advance

    # --- the answers of the cell
    def _giving(self, i: int, reply: Reply) -> Callable[[], None]:
        def give() -> None:
            for name, value in reply.values.items():
                try:
                    text = give_value(self.m, self.m.controller, name, value)
                except ExecutionError as fault:
                    raise OptionError(
                        f"reply[{i}].set.{name}", str(fault), "a variable and a value of its type"
                    ) from None
                self.clock.record(self.m.log.position, "reply", text)

        return give

    def _later(self, i: int, reply: Reply) -> Callable[[], object]:
        give = self._giving(i, reply)
        return lambda: self.clock.add(self.clock.now + reply.after, give)

    # --- interrupts
    def declare(self, x: s.InterruptDeclaration, frame: StackFrame, position: SourcePosition) -> None:
        """INTERRUPT DECL: it is off until it is switched on; raises `ExecutionError`."""
        priority = int(number_of(self.m, x.priority, "the priority of INTERRUPT"))
        old = self.interrupts.get(priority)
        enabled = old is not None and old.enabled

        def follow() -> None:
            self.clock.record(position, "interrupt", f"interrupt {priority}: {expression_text(x.condition)}")
            before = self.priority, self.returns_to, self.stopped
            self.priority, self.returns_to, self.stopped = priority, frame, None
            try:
                if x.with_brake:
                    self.brake()
                self.m.execute_beside(x.action, position)
                if self.stopped is not None:
                    self.triggers.go_on(*self.stopped)
            finally:
                self.priority, self.returns_to, self.stopped = before

        self.interrupts[priority] = Watch(x.condition, follow, enabled=enabled, frame=frame)

    def switch(self, x: s.InterruptSwitch) -> None:
        """INTERRUPT ON, OFF, ENABLE or DISABLE: one priority, or all."""
        on = x.mode in ("ON", "ENABLE")
        only = None if x.priority is None else int(number_of(self.m, x.priority, "the priority of INTERRUPT"))
        for priority, watch in self.interrupts.items():
            if only in (None, priority):
                watch.enabled = on
                # only an edge after this counts
                watch.last = on and self._is_true(watch.condition)

    def brake(self) -> None:
        """BRAKE: the arm stops on its path; raises `ExecutionError` outside an interrupt."""
        if self.returns_to is None:
            raise ExecutionError("brake", "BRAKE outside an interrupt", "in a subprogram that INTERRUPT DECL calls")
        motions = self.m.motions
        self.stopped = self.triggers.stop(self.clock.now - motions.idle, self.m.log.position) or self.stopped
        self.clock.at = None

    def resume(self) -> None:
        """RESUME: back to the routine that has declared the interrupt; raises `ResumedError`, `ExecutionError`."""
        stack = self.m.stack
        if self.returns_to is None or self.returns_to not in stack:
            raise ExecutionError("resume", "RESUME outside an interrupt", "in a subprogram that INTERRUPT DECL calls")
        del stack[stack.index(self.returns_to) + 1 :]
        self.m.motions.stop_advance()
        raise ResumedError

    # --- triggers
    def trigger(self, x: s.Trigger, position: SourcePosition) -> None:
        """TRIGGER: its action waits for the next motion; raises `ExecutionError`."""
        value = number_of(self.m, x.value, x.place)
        delay = number_of(self.m, x.delay, "DELAY") / 1e3

        def act() -> None:
            self.clock.record(position, "trigger", f"TRIGGER {x.place} = {value:g}, {1e3 * delay:g} ms")
            self.m.execute_beside(x.action, position)

        self.triggers.add(PathTrigger(x, value, delay, self.m.controller.tool, act))
