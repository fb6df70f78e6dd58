"""Legs and pauses along one clock; a blend is an overlap: a leg begins while the one before it still slows down.

In the overlap the two add up, so that a corner is passed on a parabola: with the way left d (1 - u)^2 and the way gone
d u^2 the corner is never further than d. What is left over of a leg keeps its own law.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.forward import forward_kinematics
from lwr_dyn.krl.legs import Axes, JointLeg, Leg, PoseLeg, Poses, axes_of_poses
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion

HALVINGS = 40


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """Standing still at q (n,) for a time."""

    q: Array
    duration: float

    def axes(self, t: Array) -> Axes:
        """At times t (k,) [s]."""
        still = np.zeros((len(t), len(self.q)))
        return Axes(np.broadcast_to(self.q, still.shape), still, still)


Part: TypeAlias = JointLeg | PoseLeg | Rest


@dataclass(frozen=True, slots=True)
class Entry:
    """A leg or pause on the clock: from `begin` [s]; the first `overlap` seconds of it the one before goes on."""

    part: Part
    begin: float
    overlap: float = 0.0

    @property
    def end(self) -> float:
        """[s]"""
        return self.begin + self.part.duration


@dataclass(slots=True, eq=False)
class Timeline:
    """What a program moves, in order; grows while the program runs."""

    arm: Arm
    entries: list[Entry] = field(default_factory=list)

    @property
    def duration(self) -> float:
        """[s]"""
        return self.entries[-1].end if self.entries else 0.0

    def add(self, part: Part, overlap: float = 0.0) -> Entry:
        """Put a part at the end, the first `overlap` [s] of it together with the last of the one before."""
        entry = Entry(part, self.duration - overlap, overlap)
        self.entries.append(entry)
        return entry

    def sample(self, t: Array) -> Motion:
        """The movement at times t (k,) [s]; before 0 and after `duration` it stands still."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        if not self.entries:
            raise ValueError("an empty timeline has no axes")
        n = self.arm.n
        q, dq, ddq = (np.zeros((len(times), n)) for _ in range(3))
        begins = np.array([entry.begin for entry in self.entries])
        owner = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(begins) - 1)
        for i in np.unique(owner):
            mine = np.flatnonzero(owner == i)
            entry = self.entries[i]
            both = (times[mine] - entry.begin < entry.overlap) & (i > 0)
            for rows, axes in (
                (mine[~both], self._alone(entry, times[mine[~both]])),
                (mine[both], self._together(self.entries[i - 1], entry, times[mine[both]])),
            ):
                q[rows], dq[rows], ddq[rows] = axes.q, axes.dq, axes.ddq
        return Motion(times, q, dq, ddq)

    def _alone(self, entry: Entry, t: Array) -> Axes:
        return entry.part.axes(np.clip(t - entry.begin, 0.0, entry.part.duration)) if len(t) else _nothing(self.arm.n)

    def _together(self, before: Entry, after: Entry, t: Array) -> Axes:
        if not len(t):
            return _nothing(self.arm.n)
        a, b = before.part, after.part
        ta, tb = t - before.begin, t - after.begin
        if isinstance(a, PoseLeg) and isinstance(b, PoseLeg) and _one_space(a, b):
            return _blend_in_space(a, b, ta, tb)
        x, y = a.axes(np.clip(ta, 0.0, a.duration)), b.axes(np.clip(tb, 0.0, b.duration))
        corner = y.q * 0.0 + (b.start if not isinstance(b, Rest) else b.q)
        return Axes(x.q + y.q - corner, x.dq + y.dq, x.ddq + y.ddq)


def _nothing(n: int) -> Axes:
    return Axes(np.zeros((0, n)), np.zeros((0, n)), np.zeros((0, n)))


def _one_space(a: PoseLeg, b: PoseLeg) -> bool:
    """Whether both are tracks of one tool on one branch, so that they add up in space."""
    return a.branch == b.branch and bool(np.array_equal(a.tool, b.tool))


def _blend_in_space(a: PoseLeg, b: PoseLeg, ta: Array, tb: Array) -> Axes:
    x, y = a.poses(np.clip(ta, 0.0, a.duration)), b.poses(np.clip(tb, 0.0, b.duration))
    corner, R0 = b.track.place, b.track.rotation
    B = y.R @ R0.T  # the turn of the second leg so far, in base axes: it carries the first one along
    wx = np.einsum("kij,kj->ki", B, x.w)
    dw = y.dw + np.einsum("kij,kj->ki", B, x.dw) + np.cross(y.w, wx)
    blended = Poses(x.p + y.p - corner, B @ x.R, x.v + y.v, y.w + wx, x.a + y.a, dw)
    near = np.broadcast_to(b.start, (len(ta), len(b.start)))
    return axes_of_poses(a.arm, a.tool, a.branch, blended, near)


def ramp_seconds(leg: Leg, tail: bool) -> float:
    """The time of the last ramp (tail) or of the first [s]."""
    knots = leg.law.knots
    return float(knots[-1] - knots[-2]) if tail else float(knots[1])


def seconds_within(leg: Leg, share: float, tail: bool) -> float:
    """The time [s] in which the last (tail) or the first `share` of a leg's way is gone, within that ramp."""
    ramp = ramp_seconds(leg, tail)
    gone = leg.law.coefficients[0, 2] * ramp**2
    return ramp * float(np.sqrt(min(1.0, max(share, 0.0) / gone)))


def seconds_near(leg: Leg, tool: Array, distance: float, tail: bool) -> float:
    """The time [s], within the ramp, in which the tool centre point stays within `distance` [m] of the leg's end."""
    if isinstance(leg, PoseLeg) and leg.track.length > 0.0:
        # on an arc the chord is shorter than the way: this keeps to the safe side
        return seconds_within(leg, distance / leg.track.length, tail)
    low, high = 0.0, ramp_seconds(leg, tail)
    corner = _tool_point(leg, tool, leg.duration if tail else 0.0)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        at = np.linspace(0.0, middle, 9)
        points = [_tool_point(leg, tool, leg.duration - t if tail else t) for t in at]
        inside = max(float(np.linalg.norm(p - corner)) for p in points) <= distance
        low, high = (middle, high) if inside else (low, middle)
    return low


def _tool_point(leg: Leg, tool: Array, t: float) -> Array:
    q = leg.axes(np.array([t])).q[0]
    return np.asarray((forward_kinematics(leg.arm.chain, q) @ tool)[:3, 3])
