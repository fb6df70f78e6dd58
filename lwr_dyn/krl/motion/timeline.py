"""Motion segments and pauses in time; in a blend a segment begins while the one before it still slows down.

In this overlap the two motions add up: d (1 - u)^2 is left of the first and d u^2 is done of the second, so the corner
is passed on a parabola within the distance d. Outside the overlap, which lies in the ramps, each segment keeps its own
motion profile. The corner begins where the rest of the way is below its distance (C_DIS), its share of half the way
(C_PTP), its angle (C_ORI), or where the motion that slows down is below its share of the programmed speed (C_VEL);
never before the middle of a motion.
"""

import math
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.krl.motion import motion_segments
from lwr_dyn.krl.motion.motion_segments import AxisMotion, AxisSplineSegment, CartesianSegment, MotionSegment
from lwr_dyn.krl.motion.pose_paths import STILL, Blend, Corner
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion
from lwr_dyn.trajectory.motion_profile import MotionProfile


@dataclass(frozen=True, slots=True, eq=False)
class Pause:
    """No motion: the axes stay at `start` (n,) [rad] for `duration` [s]."""

    start: Array
    duration: float

    def axes(self, t: Array) -> AxisMotion:
        """At times t (k,) [s]."""
        still = np.zeros((len(t), len(self.start)))
        return AxisMotion(np.broadcast_to(self.start, still.shape), still, still)


@dataclass(frozen=True, slots=True, eq=False)
class SlowedPart:
    """A part passed from its time `since` [s] on at a rate that goes evenly from `first` to `last`, 1 its own speed.

    So the arm stops on its path (1 to 0), and goes on along it (0 to 1); at the constant rate 1 it is the rest.
    """

    part: MotionSegment
    since: float
    first: float
    last: float
    duration: float

    @property
    def start(self) -> Array:
        """(n,) [rad]"""
        return np.asarray(self.axes(np.zeros(1)).q[0])

    @property
    def until(self) -> float:
        """[s] The time of the part at which this ends."""
        return self.since + 0.5 * (self.first + self.last) * self.duration

    def reached(self, time: float) -> float:
        """[s] From its beginning until it is at a `time` [s] of the part, from `since` to `until`."""
        way = min(time, self.until) - self.since
        if way <= 0.0:
            return 0.0
        root = self.first**2 + 2.0 * (self.last - self.first) / self.duration * way
        return 2.0 * way / (self.first + math.sqrt(max(root, 0.0)))

    def axes(self, t: Array) -> AxisMotion:
        """At times t (k,) [s]."""
        bend = (self.last - self.first) / self.duration if self.duration > 0.0 else 0.0
        rate = (self.first + bend * t)[:, None]
        x = self.part.axes(np.clip(self.since + self.first * t + 0.5 * bend * t**2, 0.0, self.part.duration))
        return AxisMotion(x.q, rate * x.dq, rate**2 * x.ddq + bend * x.dq)


Part: TypeAlias = MotionSegment | Pause | SlowedPart


@dataclass(frozen=True, slots=True)
class TimelineItem:
    """A segment or pause from `begin` [s]; in its first `overlap` seconds the one before it still moves."""

    part: Part
    begin: float
    overlap: float = 0.0
    corner: Corner | None = None
    """How the point at its beginning is passed."""

    @property
    def end(self) -> float:
        """[s]"""
        return self.begin + self.part.duration


@dataclass(slots=True, eq=False)
class Timeline:
    """The motions of a program in order; it grows while the program runs."""

    arm: Arm
    items: list[TimelineItem] = field(default_factory=list)

    @property
    def duration(self) -> float:
        """[s]"""
        return self.items[-1].end if self.items else 0.0

    def add(self, part: Part, overlap: float = 0.0, corner: Corner | None = None) -> TimelineItem:
        """Add a part, its first `overlap` [s] together with the end of the last one."""
        item = TimelineItem(part, self.duration - overlap, overlap, corner)
        self.items.append(item)
        return item

    def add_at(self, part: Part, begin: float) -> TimelineItem:
        """Add a part at a time [s]; from there on it takes the place of what was planned."""
        self.items = [x for x in self.items if x.begin < begin]
        item = TimelineItem(part, begin)
        self.items.append(item)
        return item

    def sample(self, t: Array) -> Motion:
        """The movement at times t (k,) [s]; before 0 and after `duration` it stands still."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        if not self.items:
            raise ValueError("an empty timeline has no axes")
        q, dq, ddq = (np.zeros((len(times), self.arm.n)) for _ in range(3))
        begins = np.array([item.begin for item in self.items])
        owner = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(begins) - 1)
        for i in np.unique(owner):
            item, mine = self.items[i], np.flatnonzero(owner == i)
            in_blend = (times[mine] - item.begin < item.overlap) & (i > 0)
            # a motion that goes on after BRAKE has parts, and each may be the one that still moves
            still = np.clip(np.searchsorted(begins[:i], times[mine], side="right") - 1, 0, max(int(i) - 1, 0))
            for j in np.unique(np.where(in_blend, still, -1)):
                rows = mine[in_blend & (still == j)] if j >= 0 else mine[~in_blend]
                axes = _axes(item, times[rows]) if j < 0 else _sum_of_axes(self.items[j], item, times[rows])
                q[rows], dq[rows], ddq[rows] = axes.q, axes.dq, axes.ddq
        return Motion(times, q, dq, ddq)


def _axes(item: TimelineItem, t: Array) -> AxisMotion:
    return item.part.axes(np.clip(t - item.begin, 0.0, item.part.duration))


def _sum_of_axes(before: TimelineItem, after: TimelineItem, t: Array) -> AxisMotion:
    """Both motions of a blend: added in space for two paths of one tool on one branch, else axis by axis."""
    a, b = before.part, after.part
    if isinstance(a, CartesianSegment) and isinstance(b, CartesianSegment) and a.shares_branch(b):
        return _sum_in_space(a, b, t - before.begin, t - after.begin)
    x, y = _axes(before, t), _axes(after, t)
    return AxisMotion(x.q + y.q - b.start, x.dq + y.dq, x.ddq + y.ddq)


def _sum_in_space(a: CartesianSegment, b: CartesianSegment, ta: Array, tb: Array) -> AxisMotion:
    x, y = a.timed.at(np.clip(ta, 0.0, a.duration)), b.timed.at(np.clip(tb, 0.0, b.duration))
    corner = b.timed.poses(0.0)[0]
    B = y.T[:, :3, :3] @ corner[:3, :3].T  # the turn of the second segment so far, which also turns the first
    w, dw = (np.einsum("kij,kj->ki", B, rates[:, 3:]) for rates in (x.velocity, x.acceleration))
    T, velocity, acceleration = y.T.copy(), x.velocity + y.velocity, x.acceleration + y.acceleration
    T[:, :3, :3], T[:, :3, 3] = B @ x.T[:, :3, :3], x.T[:, :3, 3] + y.T[:, :3, 3] - corner[:3, 3]
    velocity[:, 3:] = y.velocity[:, 3:] + w
    acceleration[:, 3:] = y.acceleration[:, 3:] + dw + np.cross(y.velocity[:, 3:], w)
    near = np.broadcast_to(b.start, (len(ta), len(b.start)))
    return motion_segments.axes_of_poses(a.arm, a.tool, a.branch, T, velocity, acceleration, near)


HALVINGS = 30
SAMPLES = np.linspace(0.0, 1.0, 9)


def append_segment(timeline: Timeline, segment: MotionSegment, blend: Blend | None, tool: Array) -> TimelineItem:
    """Adds the segment; it starts early where a blend allows overlap."""
    before = timeline.items[-1].part if timeline.items else None
    if blend is None or before is None or isinstance(before, Pause | SlowedPart):
        return timeline.add(segment)
    corner = Corner(corner_share(before, blend, tool, True), corner_share(segment, blend, tool, False))
    overlap = min(seconds_within(before, corner.before, True), seconds_within(segment, corner.after, False))
    return timeline.add(segment, overlap if overlap > 1e-9 else 0.0, corner)


def corner_share(segment: MotionSegment, blend: Blend, tool: Array, at_end: bool) -> float:
    """The share of the way, at most a half, at the end (or the beginning) of a segment that the corner may take."""
    if blend.kinds[0] == "C_PTP" and not isinstance(segment, CartesianSegment):
        return 0.5 * min(blend.cptp, 100.0) / 100.0
    kind = next((kind for kind in reversed(blend.kinds) if kind != "C_PTP"), "C_DIS")
    share = 0.5
    if kind == "C_VEL":
        slow = min(blend.cvel, 100.0) / 100.0 * segment.bounds.speed
        share = slow**2 / (2.0 * segment.bounds.ramp * segment.profile.length)
    elif kind == "C_ORI" and isinstance(segment, CartesianSegment):
        share = blend.cori / max(segment.path.angle, STILL)
    elif isinstance(segment, CartesianSegment):
        # on an arc the chord is shorter than the way: this is on the safe side
        share = blend.cdis / max(segment.path.length, STILL)
    else:
        share = _share_near(segment, tool, blend.cdis, at_end)
    return min(share, 0.5)


def seconds_within(segment: MotionSegment, share: float, at_end: bool) -> float:
    """The time [s], within the ramp, in which the last (or the first) `share` of the way is travelled."""
    profile = segment.profile
    knots, pieces = profile.knots, profile.coefficients
    ramp = float(knots[-1] - knots[-2]) if at_end else float(knots[1])
    if len(pieces) > 3:
        return _seconds_in_ramp(profile, share, at_end)
    travelled = pieces[0, 2] * ramp**2 / profile.length
    return ramp * math.sqrt(min(1.0, max(share, 0.0) / travelled))


def _seconds_in_ramp(profile: MotionProfile, share: float, at_end: bool) -> float:
    """The same for a spline, whose ramp has many pieces: as long as the speed grows from rest."""
    knots = profile.knots
    sample = profile.at(knots)
    s, t = (profile.length - sample.s[::-1], knots[-1] - knots[::-1]) if at_end else (sample.s, knots)
    v = sample.ds[::-1] if at_end else sample.ds
    falls = np.flatnonzero(np.diff(v) <= 0.0)
    last = int(falls[0]) if len(falls) else len(v) - 1
    # from rest the way grows with the square of the time
    return float(np.interp(math.sqrt(max(share, 0.0) * profile.length), np.sqrt(s[: last + 1]), t[: last + 1]))


def _share_near(
    segment: motion_segments.PtpSegment | AxisSplineSegment, tool: Array, distance: float, at_end: bool
) -> float:
    """The share of a motion of the axes, up to a half, in which the tool centre point is within `distance` [m]."""
    low, high = 0.0, 0.5
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        share = middle * SAMPLES
        q = segment.axes_at(1.0 - share if at_end else share)
        p = (flange_pose(segment.arm.chain, q) @ tool)[:, :3, 3]
        inside = float(np.max(np.linalg.norm(p - p[0], axis=1))) <= distance
        low, high = (middle, high) if inside else (low, middle)
    return low
