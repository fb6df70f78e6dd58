"""TRIGGER: switching actions at a place of the next motion, at the time at which the planned motion is there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import ExecutionError, SourcePosition
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.motion.planner import tool_pose
from lwr_dyn.krl.running.braking import StoppedMotion, brake, go_on
from lwr_dyn.krl.running.clock import ProgramClock
from lwr_dyn.krl.running.motions import Motions

SAMPLES = 400
"""Points of a motion between which a place on its path is found."""


@dataclass(frozen=True, slots=True, eq=False)
class PathTrigger:
    """A trigger before its motion is planned: its place, its delay [s], the tool (4, 4) [m] and what it does."""

    statement: s.Trigger
    value: float
    delay: float
    tool: Array
    action: Callable[[], None]


@dataclass(frozen=True, slots=True, eq=False)
class PlannedTrigger:
    """A trigger whose motion is planned: the time [s] of its place on the timeline, its number on the clock."""

    place: float
    number: int
    trigger: PathTrigger


@dataclass(slots=True, eq=False)
class Triggers:
    """Those that wait for a motion, those whose motion may still be blended with the next one, those that are timed."""

    motions: Motions
    clock: ProgramClock
    waiting: list[PathTrigger] = field(default_factory=list)
    planned: list[PlannedTrigger] = field(default_factory=list)
    bound: list[tuple[SourcePosition, int, PathTrigger]] = field(default_factory=list)
    """The position of a trigger's motion, and the number of motions executed before it."""

    def add(self, trigger: PathTrigger) -> None:
        """Let a trigger wait for the next motion; raises `ExecutionError` for a place that no motion has."""
        if trigger.statement.place == "DISTANCE" and trigger.value not in (0.0, 1.0):
            raise ExecutionError("number-range", f"DISTANCE = {trigger.value:g}", "0 (the start) or 1 (the end)")
        self.waiting.append(trigger)

    def bind(self, position: SourcePosition, before: int) -> None:
        """The waiting triggers belong to the motion of this position; a spline block plans it at its end."""
        self.bound += [(position, before, x) for x in self.waiting]
        self.waiting = []

    def plan(self, final: bool) -> None:
        """Put each trigger whose motion can no longer change on the clock; with `final` all that have a motion."""
        for place, x in self._take_timed(final):
            self._add(place, x, 0.0)

    def _add(self, place: float, x: PathTrigger, earliest: float) -> None:
        number = self.clock.add(max(place + x.delay, earliest) + self.motions.idle, x.action)
        self.planned.append(PlannedTrigger(place, number, x))

    def stop(self, time: float, position: SourcePosition) -> tuple[StoppedMotion, list[PlannedTrigger]] | None:
        """BRAKE at a time [s]: what is left of the motion, and the triggers at places that the arm does not reach."""
        bound, timed = self.bound, self._take_timed(final=True)
        stopped = brake(self.motions, time, position)
        if stopped is None:
            self.bound = bound
            return None
        for place, x in timed:
            self._add(place, x, 0.0)
        later = {x.number: x for x in self.planned if x.place > stopped.time}
        taken = self.clock.take_back(later)
        self.planned, left = [], []
        for number, waiting in later.items():
            passed = stopped.passed_at(waiting.place)
            if number in taken and passed is not None:
                self._add(passed, waiting.trigger, stopped.time)
            elif number in taken:
                left.append(waiting)
        return stopped, left

    def go_on(self, stopped: StoppedMotion, left: Sequence[PlannedTrigger]) -> None:
        """The motion goes on, and the triggers at places that are left; raises `ExecutionError` as `go_on`."""
        begin = self.motions.timeline.duration
        passed_at = go_on(self.motions, stopped)
        for x in left:
            self._add(passed_at(x.place), x.trigger, begin)

    def _take_timed(self, final: bool) -> list[tuple[float, PathTrigger]]:
        """The time [s] of the place of each trigger whose motion can no longer change; with `final` of all planned."""
        executed = self.motions.executed
        out, rest = [], []
        for position, before, x in self.bound:
            k = next((i for i in range(before, len(executed)) if executed[i].position == position), None)
            fixed = final or self.motions.blend_now() is None
            if k is not None and (fixed or k + 1 < len(executed)):
                out.append((self._time(k, x), x))
            elif k is None and before < len(executed):  # its motion goes nowhere: the arm stood there already
                out.append((executed[before].begin, x))
            else:
                rest.append((position, before, x))
        self.bound = rest
        return out

    def _time(self, k: int, x: PathTrigger) -> float:
        """[s] Of its place on the timeline. The start or end of a blended motion is the middle of its blend."""
        motion = self.motions.executed[k]
        after = self.motions.executed[k + 1].overlap if k + 1 < len(self.motions.executed) else 0.0
        begin, end = motion.begin + 0.5 * motion.overlap, motion.end - 0.5 * after
        if x.statement.place == "DISTANCE":
            return begin if x.value == 0.0 else end
        anchor = begin if x.statement.on_start else end
        return self._time_at_path(k, x, anchor)

    def _time_at_path(self, k: int, x: PathTrigger, anchor: float) -> float:
        """[s] At which the tool has gone `value` [mm] from where it is at the time `anchor`, along its path."""
        executed = self.motions.executed
        last = executed[min(k + 1, len(executed) - 1)].end if x.value > 0.0 else anchor
        t = np.union1d(np.linspace(executed[k].begin, max(last, anchor), SAMPLES), [anchor])
        q = self.motions.timeline.sample(t).q
        places = np.array([tool_pose(self.motions.controller.arm, row, x.tool)[:3, 3] for row in q])
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
        wanted = float(np.interp(anchor, t, way)) + x.value / 1e3
        return float(np.interp(wanted, way, t))
