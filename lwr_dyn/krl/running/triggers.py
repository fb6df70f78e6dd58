"""The time of a running program: its clock, its events and timers, TRIGGER and BRAKE.

A trigger switches at a place of the next motion, at the time at which the planned motion is there. BRAKE in an
interrupt stops the arm on its path; it goes on along it later, unless RESUME gives the motion up.
"""

import heapq
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import ExecutionError, SourcePosition
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.motion.motion_segments import MotionSegment, tool_pose
from lwr_dyn.krl.motion.timeline import Pause, SlowedPart, Timeline, TimelineItem
from lwr_dyn.krl.running.motions import ExecutedMotion, Motions

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
    looked: float = 0.0
    """[s] Until when conditions on what moves have been looked at."""
    added: int = 0
    ran: float = -1.0
    """[s] The time of what has happened last of what was pending."""
    at_once: int = 0
    """How much has happened at that time."""

    @property
    def now(self) -> float:
        """[s] From the start, with what was waited before the arm stood anywhere."""
        return self.motions.now if self.at is None else self.at

    def add(self, time: float, action: Callable[[], None]) -> int:
        """Let something happen at a time [s]; its number."""
        self.added += 1
        heapq.heappush(self.pending, (time, self.added, action))
        return self.added

    def add_later(self, after: float, action: Callable[[], None]) -> None:
        """Let something happen some time [s] from now."""
        self.add(self.now + after, action)

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

    def due(self, until: float) -> float | None:
        """[s] When the next of what is pending happens, up to a time [s]; None where nothing does."""
        return self.pending[0][0] if self.pending and self.pending[0][0] <= until + SAME else None

    def run_next(self, then: Callable[[], object]) -> None:
        """Let the next of what is pending happen, and then what follows from it."""
        time, _, action = heapq.heappop(self.pending)
        self.at_once = self.at_once + 1 if time - self.ran <= SAME else 1
        self.ran = time
        self.run_at(time, action, then)

    def run_at(self, time: float, action: Callable[[], object], then: Callable[[], object]) -> None:
        """Let something happen at a time [s], and then what follows from it."""
        self.at = time
        try:
            action()
            then()
        finally:
            self.at = None

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

    def read_timer(self, number: int) -> float:
        """[ms] The value of a timer for which the program asks."""
        self.timers_read.add(number)
        return self.timer(number)

    def timer(self, number: int) -> float:
        """[ms] The value of a timer."""
        value, at, running = self.timers.get(number, (0.0, 0.0, False))
        return value + 1e3 * (self.now - at) if running else value


MOVED = 1e-6
"""[rad] By which the arm may have left the place where it stopped."""


@dataclass(frozen=True, slots=True, eq=False)
class StoppedMotion:
    """A motion that BRAKE has stopped: what is left of it."""

    slowed: SlowedPart
    motion: ExecutedMotion
    goal: Array
    """(n,) [rad] Where the program's motions were to end."""
    end: float
    """[s] When the part was to end."""
    items: tuple[TimelineItem, ...]
    """What was planned after it: the rest of a spline block."""
    motions: tuple[ExecutedMotion, ...]

    @property
    def begin(self) -> float:
        """[s] When the part has begun."""
        return self.end - self.slowed.part.duration

    @property
    def time(self) -> float:
        """[s] From which on the arm stops."""
        return self.begin + self.slowed.since

    def passed_at(self, planned: float) -> float | None:
        """[s] When the arm, while it stops, is where it was to be at a `planned` time; None where it stops before."""
        inside = planned - self.begin
        return None if inside > self.slowed.until else self.time + self.slowed.reached(inside)


def brake(m: Motions, time: float, position: SourcePosition) -> StoppedMotion | None:
    """Stop the arm from a time [s] of the timeline on; None where it stands or stops there anyway.

    In a blend it begins to stop where the blend ends.
    """
    moving = _moving_at(m.timeline, time)
    if moving is None or m.controller.q is None:
        return None
    item, part, begin = moving
    time = max(time, item.begin + item.overlap)
    index = next((i for i in reversed(range(len(m.executed))) if m.executed[i].begin <= time < m.executed[i].end), None)
    since = time - begin
    now = part.axes(np.array([since]))
    seconds = float(np.max(np.abs(now.dq[0]) / m.controller.speeds().axis_ramp))
    slowed = SlowedPart(part, since, 1.0, 0.0, seconds)
    if index is None or seconds <= 0.0 or slowed.until >= part.duration:
        return None
    items = tuple(x for x in m.timeline.items if x.begin > item.begin)
    later = tuple(m.executed[index + 1 :])
    stopped = StoppedMotion(slowed, m.executed[index], m.controller.q, begin + part.duration, items, later)
    m.controller.assume("BRAKE", "", "the arm stops on its path, each axis within its ramp; BRAKE F alike")
    m.timeline.add_at(slowed, time)
    m.executed[index:] = [replace(m.executed[index], end=time, q=now.q[0], tcp=m.controller.tcp_in_base(now.q[0]))]
    item, m.controller.q = m.timeline.items[-1], slowed.axes(np.array([slowed.duration])).q[0]
    m.note(position, "BRAKE", item.begin, item.end, m.controller.q)
    m.blend, m.advance = None, False
    return stopped


def _moving_at(timeline: Timeline, time: float) -> tuple[TimelineItem, MotionSegment, float] | None:
    """What moves the arm at a time [s], its segment, and when that has begun or would have; None where it stands.

    A motion that goes on after BRAKE is taken from where it has its own speed again.
    """
    at = next((i for i in reversed(range(len(timeline.items))) if timeline.items[i].begin <= time), None)
    if at is None or time >= timeline.items[at].end:
        return None
    item = timeline.items[at]
    if isinstance(item.part, SlowedPart) and item.part.first == 0.0 and at + 1 < len(timeline.items):
        item = timeline.items[at + 1]
    if isinstance(item.part, Pause):
        return None
    if isinstance(item.part, SlowedPart):
        own = item.part.first == item.part.last == 1.0
        return (item, item.part.part, item.begin - item.part.since) if own else None
    return item, item.part, item.begin


def go_on(m: Motions, stopped: StoppedMotion) -> Callable[[float], float]:
    """Go on along the path: when the arm is now where it was to be at a planned time, both [s].

    Raises `ExecutionError` where the arm has left the path.
    """
    x = stopped.slowed
    end = x.axes(np.array([x.duration])).q[0]
    if m.controller.q is None or np.abs(m.controller.q - end).max() > MOVED:
        hint = "RESUME, or a motion back to where it stopped"
        raise ExecutionError("interrupted-motion", "the arm has left the path of the interrupted motion", hint)
    left = x.part.duration - x.until
    ramp = min(x.duration, float(np.sqrt(2.0 * x.duration * left)))
    again = SlowedPart(x.part, x.until, 0.0, ramp / x.duration, ramp)
    begin = m.timeline.add(again).begin
    if x.part.duration - again.until > 0.0:
        m.timeline.add(SlowedPart(x.part, again.until, 1.0, 1.0, x.part.duration - again.until))
    m.executed.append(replace(stopped.motion, begin=begin, end=m.timeline.duration, overlap=0.0))
    later = m.timeline.duration - stopped.end
    m.timeline.items += [replace(i, begin=i.begin + later) for i in stopped.items]
    m.executed += [replace(e, begin=e.begin + later, end=e.end + later) for e in stopped.motions]
    m.controller.q = stopped.goal
    m.blend, m.advance = None, True

    def passed_at(planned: float) -> float:
        inside = planned - stopped.begin
        if inside <= again.until:
            return begin + again.reached(inside)
        return planned + later  # its own speed from there on

    return passed_at


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
