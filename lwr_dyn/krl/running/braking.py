"""BRAKE in an interrupt: the arm stops on its path, and goes on along it later, unless RESUME gives the motion up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import ExecutionError, SourcePosition
from lwr_dyn.krl.motion.motion_segments import MotionSegment
from lwr_dyn.krl.motion.timeline import Pause, SlowedPart, Timeline, TimelineItem
from lwr_dyn.krl.running.motions import ExecutedMotion, Motions

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
    q, speed = (x[0] for x in (part.axes(np.array([since])).q, np.abs(part.axes(np.array([since])).dq)))
    seconds = float(np.max(speed / m.controller.speeds().axis_ramp))
    slowed = SlowedPart(part, since, 1.0, 0.0, seconds)
    if index is None or seconds <= 0.0 or slowed.until >= part.duration:
        return None
    items = tuple(x for x in m.timeline.items if x.begin > item.begin)
    later = tuple(m.executed[index + 1 :])
    stopped = StoppedMotion(slowed, m.executed[index], m.controller.q, begin + part.duration, items, later)
    m.controller.assumptions.note("BRAKE", "", "the arm stops on its path, each axis within its ramp; BRAKE F alike")
    m.timeline.add_at(slowed, time)
    m.executed[index:] = [replace(m.executed[index], end=time, q=q)]
    _stand(m, slowed, position, "BRAKE")
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


def _stand(m: Motions, part: SlowedPart, position: SourcePosition, kind: str) -> None:
    """The arm stands where a part ends."""
    q = part.axes(np.array([part.duration])).q[0]
    item = m.timeline.items[-1]
    m.executed.append(ExecutedMotion(position, kind, item.begin, item.end, q))
    m.controller.q = q
    m.blend, m.advance = None, False
