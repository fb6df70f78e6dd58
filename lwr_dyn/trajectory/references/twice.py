"""A reference twice, with a quintic way back between: what a law that learns has learnt shows in the second pass."""

from dataclasses import dataclass, field, replace
from typing import Annotated, Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, Reference, Run
from lwr_dyn.model.shown import short_repr
from lwr_dyn.trajectory.motion_profile import MotionProfile, positive_number, quintic
from lwr_dyn.trajectory.references.ist import ist_clear_reference

BACK = 3.0
"""[s] From the end to the start."""
Back = Annotated[float, Option(float, "Time of the way back between the passes, s.")]
GRID = 1e-9
"""[s] By which a time may miss a sample."""


@dataclass(frozen=True, slots=True, eq=False)
class Twice:
    """`once` [0, D], a quintic from its end to its start in `back` [s], and `once` again [D + back, 2 D + back].

    The passes join smoothly where `once` begins and ends at rest. Raises `OptionError` unless `back` is above 0.
    """

    once: Reference
    back: float = BACK
    name: str = "Twice"
    _way: MotionProfile = field(init=False, repr=False)
    _ends: tuple[Array, Array] = field(init=False, repr=False)
    __repr__ = short_repr

    def __post_init__(self) -> None:
        object.__setattr__(self, "_way", quintic(1.0, positive_number("back", self.back)))
        ends = self.once.sample(np.array([self.once.duration, 0.0])).q
        object.__setattr__(self, "_ends", (ends[0], ends[1] - ends[0]))

    @property
    def second(self) -> float:
        """When the second pass begins [s]."""
        return self.once.duration + self.back

    @property
    def duration(self) -> float:
        """Of both passes and the way back [s]."""
        return self.second + self.once.duration

    @property
    def about(self) -> dict[str, Any]:
        """As that of the reference, with the way back."""
        about = dict(getattr(self.once, "about", {}))
        return {**about, "task": f"{about.get('task', 'reference')}-twice", "back": self.back, "second": self.second}

    def sample(self, t: Array) -> Motion:
        """The motion at times t (k,) [s].

        >>> from lwr_dyn import load, reference
        >>> arm = load("lwr4plus")
        >>> move = Twice(reference("point-to-point", arm, start=[0] * 7, end=[1] * 7, duration=2.0))
        >>> move.duration, move.sample(np.array([2.0, 3.5, 5.0, 6.0])).q[:, 0].round(9).tolist()
        (7.0, [1.0, 0.5, 0.0, 0.5])
        """
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        end = self.once.duration
        motion = self.once.sample(np.where(times < self.second, np.minimum(times, end), times - self.second))
        way = ((times > end) & (times < self.second))[:, None]
        if not way.any():
            return Motion(times, motion.q, motion.dq, motion.ddq)
        part, (start, shift) = self._way.at(times - end), self._ends
        return Motion(
            times,
            np.where(way, start + np.outer(part.s, shift), motion.q),
            np.where(way, np.outer(part.ds, shift), motion.dq),
            np.where(way, np.outer(part.dds, shift), motion.ddq),
        )


def part_of(run: Run, start: float, end: float | None = None) -> Run:
    """The part of a run from `start` to `end` [s] (its own end if not given) as a run of its own, from t = 0.

    Its audit and its time on stops, which are of the whole run, are left out. Raises `OptionError` for no samples.
    """
    last = float(run.t[-1]) if end is None else end
    rows = np.flatnonzero((run.t >= start - GRID) & (run.t <= last + GRID))
    if rows.size == 0:
        raise OptionError("part of a run", f"{start:g} to {last:g} s", f"times from 0 to {run.t[-1]:g} s")
    part = slice(int(rows[0]), int(rows[-1]) + 1)
    arrays = {name: getattr(run, name)[part] for name in _SAMPLED}
    meta = {key: value for key, value in run.meta.items() if key not in ("audit", "at_stop_s")}
    return replace(
        run, **arrays, t=run.t[part] - run.t[part.start],
        work={name: work[part] - work[part.start] for name, work in run.work.items()},
        signals={name: signal[part] for name, signal in run.signals.items()},
        events=tuple(replace(e, t=e.t - start) for e in run.events if start <= e.t <= last), meta=meta, setup=None,
    )  # fmt: skip


_SAMPLED = ("q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction", "energy")


def ist_clear_twice(arm: Arm, back: Back = BACK) -> Twice:
    """`ist-clear` twice; raises as `ist_clear_reference`, and `OptionError` unless `back` is above 0."""
    return Twice(ist_clear_reference(arm), back)
