"""Joints that met their position stops in a run: how often, and for how long they rested there.

A stop takes part in the motion, like a hand that holds the joint: the errors of such a run are not the controller's
alone. `StopContacts.sentence` is the one place that puts it into words, for text, JSON, pages and tables.
"""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array, freeze_arrays
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run


@dataclass(frozen=True, slots=True, eq=False)
class StopContacts:
    """Of each joint: `seconds` (n,) at its stop [s], and `impacts`, how often it ran into it."""

    joints: tuple[str, ...]
    seconds: Array
    impacts: tuple[int, ...]

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


def stop_contacts(run: Run, arm: Arm) -> StopContacts:
    """The stops that joints met in a run, by the limits of `arm`.

    The simulation gives a joint at its stop the limit itself, to the last bit: two such samples one after the other
    are time at the stop. Runs without stops (`position_limits=False`) pass the limits and meet none.
    """
    at_limit = (run.q == arm.lower) | (run.q == arm.upper)
    seconds = np.diff(run.t) @ (at_limit[:-1] & at_limit[1:])
    struck = [event.joint for event in run.events if event.kind == "stop"]
    return StopContacts(arm.joint_names, seconds, tuple(struck.count(j) for j in range(run.n)))
