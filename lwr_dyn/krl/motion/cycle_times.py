"""The cycle time by three laws, because no published figure of KUKA's decides between them.

overlap      the ramps from and to rest of two motions overlap, as the motion itself is planned here: points at
             distance L are passed at sqrt(a L), which is the only public figure's law (second-hand)
advance      the path with rounded corners, on which the controller can stop at the end of the $ADVANCE-th motion ahead
known        the same path with all its motions known beforehand
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.motion.chains import chains_of, limits_of_chain
from lwr_dyn.krl.motion.path_speed import fastest_speeds, times_along
from lwr_dyn.krl.motion.timeline import Timeline, TimelineItem

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
    """[s] The duration of one timeline by each law; without a chain of motions all are the same."""

    overlap: float
    advance: float
    known: float
    chained: int
    """Motions that pass into one another without a stop."""

    def to_json(self) -> dict[str, Any]:
        """As JSON values."""
        times = {"overlap": self.overlap, "advance": self.advance, "known": self.known}
        return {**times, "chained": self.chained, "assumed": list(ASSUMED)}

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
