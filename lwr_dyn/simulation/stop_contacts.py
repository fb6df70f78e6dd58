"""Joints that met their position stops in a run: how often, and for how long they rested there.

A stop takes part in the motion, like a hand that holds the joint: the errors of such a run are not the controller's
alone. `StopContacts.sentence` is the one place that puts it into words, for text, JSON, pages and tables.
"""

from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run


@dataclass(frozen=True, slots=True, eq=False)
class StopContacts:
    """Of each joint: `seconds` (n,) at its stop [s], and `impacts`, how often it ran into it."""

    joints: tuple[str, ...]
    seconds: Array
    impacts: tuple[int, ...]
    first_s: tuple[float | None, ...] = ()
    """When each ran into its stop first [s]."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "seconds")

    @property
    def met(self) -> bool:
        """Whether a joint met a stop at all."""
        return any(self.impacts) or bool((self.seconds > 0.0).any())

    def sentence(self) -> str:
        """Which joints were on their stops, and for how long in all; empty if none was.

        >>> StopContacts(("a", "b"), np.array([0.0, 0.93]), (0, 4)).sentence()
        'b on its stop for 0.93 s'
        """
        return ", ".join(
            f"{name} on its stop for {time:.2g} s" if time > 0.0 else f"{name} met its stop"
            for name, time, impacts in zip(self.joints, self.seconds, self.impacts, strict=True)
            if time > 0.0 or impacts
        )

    def contacts(self) -> str:
        """The same with the impacts.

        >>> StopContacts(("a", "b"), np.array([0.0, 0.93]), (0, 4), (None, 0.02)).contacts()
        'b ran into its stop 4 times (first at 0.02 s) and was on it for 0.93 s'
        """
        return ", ".join(
            f"{name} {' and '.join(_contact(time, impacts, first))}"
            for name, time, impacts, first in zip_longest(self.joints, self.seconds, self.impacts, self.first_s)
            if time > 0.0 or impacts
        )


def _contact(time: float, impacts: int, first: float | None) -> list[str]:
    often = {1: "once", 2: "twice"}.get(impacts, f"{impacts} times")
    when = "" if first is None else f" (first at {first:.3g} s)" if impacts > 1 else f" (at {first:.3g} s)"
    ran = [f"ran into its stop {often}{when}"] if impacts else []
    return ran + ([f"was on {'it' if impacts else 'its stop'} for {time:.2g} s"] if time > 0.0 else [])


def stop_contacts(run: Run, arm: Arm) -> StopContacts:
    """The stops that joints met in a run.

    The simulation counts the samples in which a stop holds a joint with a torque: a joint that stands at its limit by
    itself, or that friction alone holds there, does not lean on it. In a run file without that count, two samples at a
    limit of `arm`, to the last bit, one after the other, are time at the stop.
    """
    times = [[e.t for e in run.events if e.kind == "stop" and e.joint == j] for j in range(run.n)]
    first = tuple(t[0] if t else None for t in times)
    return StopContacts(arm.joint_names, _seconds(run, arm), tuple(map(len, times)), first)


def _seconds(run: Run, arm: Arm) -> Array:
    counted = run.meta.get("at_stop_s")
    if counted is not None:
        return fixed_array("at_stop_s", counted, (run.n,))
    at_limit = (run.q == arm.lower) | (run.q == arm.upper)
    return np.asarray(np.diff(run.t) @ (at_limit[:-1] & at_limit[1:]))
