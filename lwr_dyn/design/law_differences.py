"""The linear form of any controller without memory, by central differences of its torque at rest."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.control.linear_feedback import LinearFeedback, Linearised
from lwr_dyn.control.protocol import Controller, WithMemory, label_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError

STEP = 1e-4
"""[rad, m; rad/s, m/s] of the differences."""
SAME = 1e-9
"""Of the largest torque: by less, two calls at one state agree."""
BENDS = 0.02
"""A slope that differs by more from one side to the other belongs to a law that is not smooth at rest."""


@dataclass(frozen=True, slots=True, eq=False)
class LawAtRest:
    """A controller near rest: its matrices, and where they come from.

    `bend` is by how much the slopes of the two sides differ, as a share of the largest slope; 0 for a law that gives
    its own linear form.
    """

    feedback: LinearFeedback
    by_differences: bool = False
    bend: float = 0.0

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of the linear form, in words; empty for a law that gives its own."""
        if not self.by_differences:
            return ()
        lines = ["the controller has no linear_feedback(q): linearised by central differences of its torque at rest"]
        if self.bend > BENDS:
            lines.append(
                f"its torque is not smooth at rest: slopes of the two sides differ by {100 * self.bend:.2g} %,"
                " and the linear results hold for none of them"
            )
        return tuple(lines)


def law_at_rest(controller: Controller, q: Array) -> LawAtRest:
    """The linear form of a controller at the poses q (k, n): its own, or by differences.

    The reference stands still at each pose; only what the torque makes of the measured position and speed counts.

    Raises
    ------
    OptionError
        A controller that remembers between calls and has no linear form, or whose torques are not n finite numbers.
    """
    if isinstance(controller, Linearised):
        return LawAtRest(controller.linear_feedback(q))
    _refuse_memory(controller, q[0])
    k, n = q.shape
    slopes, bend, largest = np.zeros((k, n, 2 * n)), 0.0, 0.0
    for i, pose in enumerate(q):
        torque = _torque_near(controller, pose)
        middle = torque(np.zeros(2 * n))
        for j, offset in enumerate(STEP * np.eye(2 * n)):
            ahead, behind = torque(offset), torque(-offset)
            slopes[i, :, j] = (ahead - behind) / (2 * STEP)
            bend = max(bend, float(np.abs(ahead + behind - 2 * middle).max()) / STEP)
        largest = max(largest, float(np.abs(slopes[i]).max()))
    share = bend / largest if largest > 0.0 else 0.0
    return LawAtRest(LinearFeedback(-slopes[:, :, :n], -slopes[:, :, n:]), True, share)


def _torque_near(controller: Controller, pose: Array) -> Callable[[Array], Array]:
    """Torque (n,) at a small deviation (2n,) of position and speed from a pose; raises `OptionError`."""
    n, zero = pose.size, np.zeros(pose.size)

    def torque(z: Array) -> Array:
        answer: Any = controller(0.0, pose + z[:n], z[n:].copy(), pose.copy(), zero.copy(), zero.copy())
        tau = np.asarray(answer, dtype=np.float64)
        if tau.shape != (n,) or not np.isfinite(tau).all():
            found = f"shape {tau.shape}" if tau.shape != (n,) else "a number that is not finite"
            raise OptionError(f"torque of {label_of(controller)}", found, f"{n} finite numbers")
        return tau.copy()

    return torque


def _refuse_memory(controller: Controller, pose: Array) -> None:
    """Raise `OptionError` for a controller that says, or shows, that it remembers between calls."""
    said = isinstance(controller, WithMemory) or hasattr(controller, "reset")
    if not said:
        torque, away = _torque_near(controller, pose), np.full(2 * pose.size, 10 * STEP)
        first, _, again = torque(away), torque(-2 * away), torque(away)
        said = bool(np.abs(again - first).max() > SAME * max(1.0, float(np.abs(first).max())))
    if said:
        raise OptionError(
            f"controller {label_of(controller)}", "remembers between calls and has no linear_feedback(q)",
            "a controller without memory, or with linear_feedback(q)",
        )  # fmt: skip
