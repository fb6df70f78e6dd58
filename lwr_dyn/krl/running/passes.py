"""Endless loops: a run ends when the state of the whole program comes back at the head of a loop.

The model is deterministic, so a program whose variables, axes and pending events are as they were some passes before
repeats these passes for ever: their time is the cycle time. If no time has passed either, the loop only watches.
Timers that the program never asks for are no part of the state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lwr_dyn.krl.diagnostics import SourcePosition
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.running.execute import MOST_LOOKS, ExecutionContext, StackFrame
from lwr_dyn.krl.running.values import Value, Variable, copied

ALIKE = 3
"""Passes of an endless LOOP that take the same time between the same axes, after which the run may end."""
PATIENCE = 65
"""Passes before that: a loop that counts up to 32, such as the places of a pallet, comes back to its state first."""
SAME = 1e-6
"""[s]"""
ROUNDED = 9
"""Digits of axes [rad] and times [s] that count."""
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
            return (
                head + f"{self.cycle_time:.3f} s a pass, for ever" + (f" ({self.period} in turn)" * (self.period > 1))
            )
        least, most, n = min(self.seconds), max(self.seconds), len(self.seconds)
        spread = f"{self.cycle_time:.3f} s in the last of {n} passes, from {least:.3f} to {most:.3f} s"
        return head + spread + "; its variables do not come back, so later passes may differ"

    def to_json(self) -> dict[str, Any]:
        """As one JSON object."""
        return {
            "file": self.position.file, "line": self.position.line, "cycle_time": self.cycle_time,
            "seconds": list(self.seconds), "period": self.period,
        }  # fmt: skip


@dataclass(slots=True, eq=False)
class ProgramState:
    """A copy of all that decides how a program goes on."""

    head: tuple[Any, ...]
    tables: tuple[Mapping[str, Value | None], ...]

    def is_now(self, m: ExecutionContext) -> bool:
        """Whether the program is in this state again."""
        tables = _tables(m)
        if self.head != _head(m) or len(tables) != len(self.tables):
            return False
        for kept, now in zip(self.tables, tables, strict=True):
            if len(kept) != len(now) or any(name not in kept or kept[name] != x.value for name, x in now.items()):
                return False
        return True


def state_of(m: ExecutionContext) -> ProgramState:
    """The present state."""
    copies = ({name: _copy(x.value) for name, x in table.items()} for table in _tables(m))
    return ProgramState(_head(m), tuple(copies))


def _copy(value: Value | None) -> Value | None:
    return None if value is None else copied(value)


def _tables(m: ExecutionContext) -> list[Mapping[str, Variable]]:
    frames = [*m.stack, *m.background.submit_frames()]
    return [*(frame.variables for frame in reversed(frames)), *m.data.files.values(), m.controller.variables]


def _head(m: ExecutionContext) -> tuple[Any, ...]:
    """Axes, lines of the calls, blend, inputs, and when pending events come."""
    q, motions, background = m.controller.q, m.motions, m.background
    lines = tuple((id(frame.routine), frame.at, tuple(frame.loops.items())) for frame in m.stack)
    submits = tuple((id(frame.routine), frame.at) for frame in background.submit_frames())
    pending = tuple(sorted(round(time - motions.now, ROUNDED) for time, _, _ in background.clock.pending))
    watches = tuple((p, w.enabled, w.last) for p, w in background.interrupts.items())
    place = None if q is None else tuple((np.round(q, ROUNDED) + 0.0).tolist())
    inputs = tuple(sorted((k, repr(v)) for k, v in m.controller.inputs.items()))
    return place, lines, submits, pending, watches, inputs, motions.advance, repr(motions.blend)


@dataclass(slots=True, eq=False)
class LoopWatch:
    """The passes of one loop so far."""

    began: float
    """[s] The present pass."""
    kept: ProgramState
    kept_time: float
    kept_at: int = 0
    """The pass after which the state was kept, and its time [s]."""
    kept_timers: tuple[tuple[int, float], ...] = ()
    """Timers at that time; they go on while a loop only watches, so they are held apart."""
    count: int = 0
    looks: int = 0
    """Passes that only watched."""
    ticked: float = 0.0
    """[s] That passed in them since the state was kept."""
    seconds: list[float] = field(default_factory=list)
    places: list[Any] = field(default_factory=list)
    """The axes at the head of the loop."""

    def end_pass(self, m: ExecutionContext) -> None:
        """One more pass has ended."""
        self.count += 1
        if m.motions.now - self.began > SAME:
            self.seconds.append(m.motions.now - self.began)
            self.places.append(_head(m)[0])
        self.began = m.motions.now

    def has_come_back(self, m: ExecutionContext) -> bool:
        """Whether the state is the one that was kept."""
        return (self.count < EACH or self.count % 16 == 0) and self.kept.is_now(m)

    def keep(self, m: ExecutionContext) -> None:
        """Keep the state after passes 1, 2, 4, 8 ..."""
        if self.count & (self.count - 1) == 0:
            self.kept, self.kept_at, self.kept_time = state_of(m), self.count, m.motions.now
            self.kept_timers = m.background.clock.timers_now()
            self.ticked = 0.0

    def alike(self) -> bool:
        """Whether the last passes took the same time between the same axes."""
        last, places = self.seconds[-ALIKE:], self.places[-ALIKE:]
        return len(self.seconds) >= PATIENCE and max(last) - min(last) < SAME and len(set(places)) == 1


def look_at_loop(m: ExecutionContext, frame: StackFrame, at: int) -> None:
    """Line `at` has gone back to the head of its loop: end the run where all later passes are known."""
    watch = frame.watched.get(frame.at)
    if watch is None:
        frame.watched[frame.at] = LoopWatch(m.motions.now, state_of(m), m.motions.now)
        return
    watch.end_pass(m)
    if watch.has_come_back(m):
        if m.motions.now - watch.kept_time - watch.ticked <= SAME:
            _look_again(m, watch)
            return
        if watch.seconds and watch.kept_timers == m.background.clock.timers_now():
            _end(m, watch, max(min(watch.count - watch.kept_at, len(watch.seconds)), 1))
    watch.keep(m)
    if endless_by_form(frame.routine, at) and (watch.alike() or len(watch.seconds) >= m.machine.passes):
        _end(m, watch, 0)


def _end(m: ExecutionContext, watch: LoopWatch, period: int) -> None:
    m.passes = LoopPasses(m.log.position, tuple(watch.seconds), period)
    m.log.end_run("note", "endless", str(m.passes), "")


def _look_again(m: ExecutionContext, watch: LoopWatch) -> None:
    """The loop only watches: let time pass until something beside the program happens."""
    time = m.background.next_time()
    if time is None or watch.looks >= MOST_LOOKS:
        message = "the loop goes round without motion or wait, and nothing here can end it"
        m.log.end_run("warning", "endless", message, "a WAIT or an EXIT; inputs and answers: a cell file")
    watch.looks += 1
    seconds = max(time - m.motions.now, 0.0)
    watch.ticked += seconds
    m.motions.wait(seconds, m.log.position, "watching loop")
    m.background.settle()


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
