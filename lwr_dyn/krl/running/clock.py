"""The time of a running program: what happens when, the events that did, and the timers of the controller."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Container
from dataclasses import dataclass, field
from typing import Any

from lwr_dyn.krl.diagnostics import SourcePosition
from lwr_dyn.krl.running.motions import Motions

TICK = 0.012
"""[s] How often a program that only watches looks again: the interpolation cycle."""
SAME = 1e-9
"""[s] Times nearer than this are one."""


@dataclass(frozen=True, slots=True)
class ProgramEvent:
    """Something that happened beside the motions: an output set, a trigger, an interrupt, an answer of the cell."""

    time: float
    """[s] Of the timeline."""
    position: SourcePosition
    kind: str
    """output, trigger, interrupt, reply, halt"""
    text: str

    def to_json(self) -> dict[str, Any]:
        """As one JSON object."""
        return {
            "time": self.time, "file": self.position.file, "line": self.position.line, "kind": self.kind,
            "text": self.text,
        }  # fmt: skip


@dataclass(slots=True, eq=False)
class ProgramClock:
    """The present time of the program is the end of the motions that are planned."""

    motions: Motions
    events: list[ProgramEvent] = field(default_factory=list)
    timers: dict[int, tuple[float, float, bool]] = field(default_factory=dict)
    """Number of a timer -> its value [ms] at a time [s], and whether it runs."""
    pending: list[tuple[float, int, Callable[[], None]]] = field(default_factory=list)
    """A heap: what happens at later times [s]."""
    timers_read: set[int] = field(default_factory=set)
    """Numbers of timers whose value the program has asked for."""
    at: float | None = None
    """[s] The time of what happens now, where it is not the present time."""
    added: int = 0

    @property
    def now(self) -> float:
        """[s] From the start, with what was waited before the arm stood anywhere."""
        return self.motions.now if self.at is None else self.at

    def add(self, time: float, action: Callable[[], None]) -> int:
        """Let something happen at a time [s]; its number."""
        self.added += 1
        heapq.heappush(self.pending, (time, self.added, action))
        return self.added

    def take_back(self, numbers: Container[int]) -> set[int]:
        """What has these numbers does not happen, as far as it has not happened yet; which they are."""
        gone = {number for _, number, _ in self.pending if number in numbers}
        self.pending = [x for x in self.pending if x[1] not in gone]
        heapq.heapify(self.pending)
        return gone

    def next_time(self) -> float | None:
        """[s] At which something happens next; a timer that runs is looked at every tick."""
        times = [self.pending[0][0]] if self.pending else []
        if any(running for _, _, running in self.timers.values()):
            times.append(self.now + TICK)
        return min(times, default=None)

    def run_due(self, then: Callable[[], object], until: float | None = None) -> bool:
        """Let everything happen that is due, in order of time, and `then` after each; whether anything was."""
        happened = False
        while self.pending and self.pending[0][0] <= (self.motions.now if until is None else until) + SAME:
            happened = True
            time, _, action = heapq.heappop(self.pending)
            self.at = time
            try:
                action()
                then()
            finally:
                self.at = None
        return happened

    def record(self, position: SourcePosition, kind: str, text: str) -> None:
        """Add an event at the present time."""
        self.events.append(ProgramEvent(max(self.now - self.motions.idle, 0.0), position, kind, text))

    # --- timers
    def set_timer(self, number: int, value: float) -> None:
        """`$TIMER[n] = value` [ms]."""
        self.timers[number] = (value, self.now, self.timers.get(number, (0.0, 0.0, False))[2])

    def stop_timer(self, number: int, stopped: bool) -> None:
        """`$TIMER_STOP[n]`."""
        self.timers[number] = (self.timer(number), self.now, not stopped)

    def timers_now(self) -> tuple[tuple[int, float], ...]:
        """Numbers and values [ms] of timers that the program asks for."""
        return tuple((number, round(self.timer(number), 6)) for number in sorted(self.timers_read))

    def timer(self, number: int) -> float:
        """[ms] The value of a timer."""
        value, at, running = self.timers.get(number, (0.0, 0.0, False))
        return value + 1e3 * (self.now - at) if running else value
