"""The cycle time by three laws, because no published figure of KUKA's decides between them.

overlap      the ramps from and to rest of two motions overlap, as the motion itself is planned here: points at
             distance L are passed at sqrt(a L), which is the only public figure's law (second-hand)
advance      the path with rounded corners, on which the controller can stop at the end of the $ADVANCE-th motion ahead
known        the same path with all its motions known beforehand
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from lwr_dyn.krl.motion.chains import chains_of, limits_of_chain
from lwr_dyn.krl.motion.path_speed import fastest_speeds, times_along
from lwr_dyn.krl.motion.timeline import Timeline

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

    def lines(self) -> tuple[str, ...]:
        """As text; none where no motion is passed without a stop."""
        if not self.chained:
            return ()
        laws = f"{self.overlap:.3f} s overlap of ramps, {self.advance:.3f} s $ADVANCE, {self.known:.3f} s all known"
        return (f"look-ahead ({self.chained} motions without a stop): {laws}; no KUKA figure tests them",)


def cycle_times(timeline: Timeline) -> CycleTimes:
    """The times of all motions; a chain counts by each law, all else stays as it is planned."""
    known = advance = whole = timeline.duration
    count = 0
    for chain in chains_of(timeline.items):
        limits, ends = limits_of_chain(chain)
        planned = chain[-1].end - chain[0].begin
        # with $ADVANCE = 0 nothing is passed, so such a motion is in no chain
        ahead = [max(1, item.part.speeds.advance) for item in chain]  # type: ignore[union-attr]
        known += float(times_along(limits.s, fastest_speeds(limits))[-1]) - planned
        advance += float(times_along(limits.s, fastest_speeds(limits, ends, ahead))[-1]) - planned
        count += len(chain)
    return CycleTimes(whole, advance, known, count)
