"""Endless loops: a run ends when the state of the whole program comes back at the head of a loop.

The model is deterministic, so a program whose variables, axes and pending events are as they were some passes before
repeats these passes for ever: their time is the cycle time. If no time has passed either, the loop only watches.
Timers that the program never asks for are no part of the state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lwr_dyn.krl.diagnostics import SourcePosition
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.running.values import Value, Variable

ALIKE = 3
"""Passes of an endless LOOP that take the same time between the same axes, after which the run may end."""
PATIENCE = 65
"""Passes before that: a loop that counts up to 32, such as the places of a pallet, comes back to its state first."""
SAME = 1e-6
"""[s]"""
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
    """Timers at that time; they go on while a loop only watches, so they are held apart."""

    def is_same(self, head: tuple[Any, ...], tables: Sequence[Mapping[str, Variable]]) -> bool:
        """Whether a present state is this one."""
        if self.head != head or len(tables) != len(self.tables):
            return False
        for kept, now in zip(self.tables, tables, strict=True):
            if len(kept) != len(now) or any(name not in kept or kept[name] != x.value for name, x in now.items()):
                return False
        return True


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
