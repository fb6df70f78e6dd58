"""The cycle time by three laws, because no published figure of KUKA's decides between them.

overlap      the ramps from and to rest of two motions overlap, as the motion itself is planned here: points at
             distance L are passed at sqrt(a L), which is the only public figure's law (second-hand)
advance      the path with rounded corners, on which the controller can stop at the end of the $ADVANCE-th motion ahead
known        the same path with all its motions known beforehand

A corner is a parabola between tangents of equal length on both motions: the least of the distance that is set and half
of each motion. In space the speed v on curvature k keeps v^2 k <= $ACC.CP; PTP motions keep the bounds of each axis.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Annotated

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.motion.motion_segments import CartesianSegment, PtpSegment
from lwr_dyn.krl.motion.pose_paths import HUGE, STILL, PathLimits, fastest_speeds, times_along, with_fine_ends
from lwr_dyn.krl.motion.timeline import Timeline, TimelineItem
from lwr_dyn.trajectory.path import SHORTEST, ArcSegment, LineSegment

STEP = 0.005
"""[m, s] Distance of the nodes between corners, of which there are `FEWEST` to `MOST`."""
FEWEST, MOST = 2, 80
PARABOLA = np.linspace(0.0, 1.0, 7)
"""Nodes of a corner."""


def chains_of(items: Sequence[TimelineItem]) -> Iterator[tuple[TimelineItem, ...]]:
    """The longest runs of items, two or more, of one planner that pass into one another."""
    chain: list[TimelineItem] = []
    for item in items:
        if chain and not (item.overlap > 0.0 and _same_path(chain[-1], item)):
            if len(chain) > 1:
                yield tuple(chain)
            chain = []
        chain.append(item)
    if len(chain) > 1:
        yield tuple(chain)


def _same_path(before: TimelineItem, after: TimelineItem) -> bool:
    a, b = before.part, after.part
    if isinstance(a, PtpSegment) and isinstance(b, PtpSegment):
        return True
    if not (isinstance(a, CartesianSegment) and isinstance(b, CartesianSegment)):
        return False
    simple = all(isinstance(x.path.segment, LineSegment | ArcSegment) and x.path.length > SHORTEST for x in (a, b))
    return simple and a.shares_branch(b)


@dataclass(slots=True, eq=False)
class _Nodes:
    """Nodes of a path while it is put together; where two pieces meet the tighter bounds count."""

    blocks: list[tuple[Array, ...]] = field(default_factory=list)
    count: int = 0

    def add(self, steps: Array, fastest: Array, first: Array, second: Array, most: Array) -> None:
        """Nodes at `steps` (k,) from the last node on, of which the first one is that node."""
        if self.blocks:
            s, cap = self.blocks[-1][:2]
            cap[-1] = min(cap[-1], fastest[0])
            steps, fastest, first, second, most = (x[1:] for x in (steps + s[-1], fastest, first, second, most))
        self.blocks.append((steps, fastest.copy(), first, second, most))
        self.count += len(steps)

    def limits(self) -> PathLimits:
        """The bounds at all nodes."""
        return PathLimits(*(np.concatenate(x) for x in zip(*self.blocks, strict=True)))


def limits_of_chain(chain: Sequence[TimelineItem]) -> tuple[PathLimits, list[int]]:
    """The bounds along a chain, and the nodes at which its motions end."""
    cuts = [0.0, *(_cut(a, b) for a, b in pairwise(chain)), 0.0]
    nodes, ends = _Nodes(), []
    for i, item in enumerate(chain):
        part = item.part
        rest = _length(part) - cuts[i] - cuts[i + 1]
        if rest > STILL:
            steps = np.linspace(0.0, rest, int(np.clip(np.ceil(rest / STEP), FEWEST, MOST)) + 1)
            steps = with_fine_ends(steps, begin=i == 0, end=i + 1 == len(chain))
            nodes.add(steps, *_straight(part, len(steps)))
        if i + 1 < len(chain):
            nodes.add(*_corner(part, chain[i + 1].part, cuts[i + 1]))
        ends.append(nodes.count - 1 - (len(PARABOLA) // 2 if i + 1 < len(chain) else 0))
    return nodes.limits(), ends


def _length(part: object) -> float:
    """[m] of a path; of a PTP the time at rated speed [s]."""
    if isinstance(part, CartesianSegment):
        return part.path.length
    assert isinstance(part, PtpSegment)
    return float(np.max(np.abs(part.end - part.start) / part.speeds.axis))


def _cut(before: TimelineItem, after: TimelineItem) -> float:
    """The length of the tangents of a corner."""
    assert after.corner is not None
    return min(after.corner.before * _length(before.part), after.corner.after * _length(after.part))


def _straight(part: object, k: int) -> tuple[Array, ...]:
    if isinstance(part, PtpSegment):
        rate = np.tile((part.end - part.start) / _length(part), (k, 1))
        return _axis_bounds(part, part, rate, np.zeros_like(rate))
    assert isinstance(part, CartesianSegment)
    bend = 1.0 / part.path.segment.radius if isinstance(part.path.segment, ArcSegment) else 0.0
    turn = np.tile(_turn(part), (k, 1))
    return _path_bounds(part, part, np.full(k, bend), turn, np.zeros_like(turn))


def _corner(a: object, b: object, cut: float) -> tuple[Array, ...]:
    """Nodes of a parabola, whose tangents have the length `cut`, with their bounds."""
    u = PARABOLA[:, None]
    if isinstance(a, PtpSegment) and isinstance(b, PtpSegment):
        begin, end = ((x.end - x.start) / _length(x) for x in (a, b))
        second = np.tile((end - begin) / (2.0 * cut), (len(u), 1))
        return (2.0 * cut * PARABOLA, *_axis_bounds(a, b, (1.0 - u) * begin + u * end, second))
    assert isinstance(a, CartesianSegment)
    assert isinstance(b, CartesianSegment)
    begin = a.path.segment.at(np.array([a.path.segment.length])).dp[0]
    end = b.path.segment.at(np.zeros(1)).dp[0]
    size = np.linalg.norm((1.0 - u) * begin + u * end, axis=1)
    sine = float(np.linalg.norm(np.cross(begin, end)))
    turned_back = size < 1e-6
    bend = np.where(turned_back, HUGE, sine / (2.0 * cut * np.where(turned_back, 1.0, size) ** 3))
    middle = 0.5 * (size[1:] + size[:-1])
    steps = np.concatenate([[0.0], np.cumsum(2.0 * cut * np.maximum(middle, 1e-3) * np.diff(PARABOLA))])
    # the turns of both tangents happen on the shorter way of the parabola
    turn = ((1.0 - u) * _turn(a) + u * _turn(b)) / np.maximum(size, 1e-3)[:, None]
    return (steps, *_path_bounds(a, b, bend, turn, np.gradient(turn, steps, axis=0)))


def _turn(part: CartesianSegment) -> Array:
    """(3,) [rad/m] The turn of the orientation along the path."""
    return np.asarray(part.path.orientation.at(np.zeros(1)).rate[0])


def _axis_bounds(a: PtpSegment, b: PtpSegment, first: Array, second: Array) -> tuple[Array, ...]:
    speed, ramp = np.minimum(a.speeds.axis, b.speeds.axis), np.minimum(a.speeds.axis_ramp, b.speeds.axis_ramp)
    fastest = np.min((speed / np.maximum(np.abs(first), 1e-12)) ** 2, axis=1)
    return fastest, first, second, np.tile(ramp, (len(first), 1))


def _path_bounds(
    a: CartesianSegment, b: CartesianSegment, bend: Array, turn: Array, change: Array
) -> tuple[Array, ...]:
    """Bounds of the speed, of the acceleration along and across the path, and of the orientation."""
    names = ("cp", "cp_ramp", "ori", "ori_ramp")
    speed, ramp, ori, ori_ramp = (min(getattr(a.speeds, n), getattr(b.speeds, n)) for n in names)
    fastest = np.minimum(speed**2, ramp / np.maximum(bend, 1.0 / HUGE))
    fastest = np.minimum(fastest, (ori / np.maximum(np.linalg.norm(turn, axis=1), 1e-12)) ** 2)
    fastest = np.minimum(fastest, ori_ramp / np.maximum(np.linalg.norm(change, axis=1), 1e-12))
    ones = np.ones((len(bend), 1))
    most = np.hstack([ramp * ones, ori_ramp * np.ones((len(bend), 3))])
    return fastest, np.hstack([ones, turn]), np.hstack([0.0 * ones, change]), most


SAME = 1e-9
"""[s] Times nearer than this are one."""
STEADY = 1e-6
"""Share of a pass by which one more repetition may still change it."""
MOST_REPEATED = 2000
"""Items of all repetitions of a pass."""

ASSUMED = (
    "constant path acceleration without a bound on jerk or torque",
    "corners are parabolas that keep v^2 curvature <= $ACC.CP",
    "no grid of 12 ms",
    "no KUKA figure tests these times",
)


@dataclass(frozen=True, slots=True)
class CycleTimes:
    """The duration of one timeline by each law; without a chain of motions all are the same."""

    overlap: Annotated[float, "[s] The ramps of neighbours overlap; the motion itself is by this law."]
    advance: Annotated[float, "[s] By $ADVANCE."]
    known: Annotated[float, "[s] The whole path is known beforehand."]
    chained: Annotated[int, "Motions that pass into one another without a stop."]
    assumed: Annotated[tuple[str, ...], "What the three laws are."] = ASSUMED

    def lines(self, of: str = "") -> tuple[str, ...]:
        """As text, with what they are `of`; none where no motion is passed without a stop."""
        if not self.chained:
            return ()
        laws = f"{self.overlap:.3f} s overlap of ramps, {self.advance:.3f} s $ADVANCE, {self.known:.3f} s all known"
        return (f"look-ahead{of} ({self.chained} motions without a stop): {laws}; no KUKA figure tests them",)


def cycle_times(timeline: Timeline) -> CycleTimes:
    """The times of all motions; a chain counts by each law, all else stays as it is planned."""
    if not timeline.items:
        return CycleTimes(0.0, 0.0, 0.0, 0)
    ends, count = _ends(timeline.items)
    return CycleTimes(float(ends[0, -1]), float(ends[1, -1]), float(ends[2, -1]), count)


def pass_times(timeline: Timeline, seconds: float, passes: int = 1) -> CycleTimes:
    """The times of one pass of a loop of which the last `passes` fill the last `seconds` of a timeline.

    Where a pass goes over into the next one without a stop, it is repeated until its times change no more.
    """
    mine = [x for x in timeline.items if x.end > timeline.duration - seconds + SAME]
    if not mine:
        return CycleTimes(seconds / passes, seconds / passes, seconds / passes, 0)
    times, repeats, goes_over = np.full(3, np.inf), 1, mine[0].overlap > 0.0
    while True:
        items = [replace(x, begin=x.begin + k * seconds) for k in range(repeats) for x in mine]
        ends, count = _ends(items)
        last = (repeats // 2 + 1) * len(mine) - 1
        before = ends[:, last - len(mine)] if goes_over and repeats > 1 else timeline.duration - seconds
        old, times = times, ends[:, last] - before
        steady = np.abs(times - old).max() <= STEADY * seconds
        if not goes_over or steady or len(items) > MOST_REPEATED:
            overlap, advance, known = (float(x) for x in times / passes)
            return CycleTimes(overlap, advance, known, round(count / repeats / passes))
        repeats = 2 * repeats + 1


def _ends(items: Sequence[TimelineItem]) -> tuple[Array, int]:
    """When each of k items ends by the three laws (3, k) [s], a chained one in the middle of its corner; how many."""
    out, count = np.tile([x.end for x in items], (3, 1)), 0
    place = {id(x): i for i, x in enumerate(items)}
    for chain in chains_of(items):
        first = place[id(chain[0])]
        limits, nodes = limits_of_chain(chain)
        # with $ADVANCE = 0 nothing is passed, so such a motion is in no chain
        ahead = [max(1, item.part.speeds.advance) for item in chain]  # type: ignore[union-attr]
        for row, law in zip(out[1:], ((nodes, ahead), ((), ())), strict=True):
            planned = row[first + len(chain) - 1]
            begin = chain[0].begin + row[first] - chain[0].end
            row[first : first + len(chain)] = begin + times_along(limits.s, fastest_speeds(limits, *law))[nodes]
            row[first + len(chain) :] += row[first + len(chain) - 1] - planned
        count += len(chain)
    return out, count
