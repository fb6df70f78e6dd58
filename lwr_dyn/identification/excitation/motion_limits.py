"""What a motion may use of an arm's positions, speeds and torques, and how a Fourier motion is fitted into it."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.excitation.fourier import FourierBasis
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind

MARGIN = 0.1
"""[rad] Kept from the position limits of a turning joint."""
SLIDING_MARGIN = 0.05
"""Share of its travel that a sliding joint keeps from its limits."""
SPEED_SHARE, TORQUE_SHARE = 0.9, 0.8
"""Of the limits, which a motion may use."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionLimits:
    """lower <= q <= upper, |dq| <= speed, |tau| <= torque, (n,) each [SI]; torque is infinite where it is unknown."""

    lower: Array
    upper: Array
    speed: Array
    torque: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "lower", "upper", "speed", "torque")

    @classmethod
    def of(
        cls, arm: Arm, margin: float = MARGIN, speed_share: float = SPEED_SHARE, torque_share: float = TORQUE_SHARE,
        unknown_speed: float | None = None,
    ) -> Self:  # fmt: skip
        """The limits of an arm.

        Parameters
        ----------
        arm : Arm
        margin : float
            [rad] Kept from position limits; sliding joints keep `SLIDING_MARGIN` of their travel. A turning joint
            without limits may use +-pi.
        speed_share, torque_share : float
            Of the arm's limits, above 0, at most 1.
        unknown_speed : float, optional
            [rad/s or m/s] Speed limit of joints whose own is unknown.

        Raises
        ------
        OptionError
            A number out of its range, margins that leave nothing, a sliding joint without position limits, a joint
            without speed limit when `unknown_speed` is not given.
        """
        for name, share in (("speed share", speed_share), ("torque share", torque_share)):
            if not 0.0 < share <= 1.0:
                raise OptionError(name, share, "above 0, at most 1")
        if not (math.isfinite(margin) and margin >= 0.0):
            raise OptionError("margin", margin, "0 or more, in rad")
        slides = np.array([link.kind is JointKind.PRISMATIC for link in arm.chain.links])
        lower, upper = (np.where(np.isinf(x) & ~slides, s * np.pi, x) for x, s in ((arm.lower, -1), (arm.upper, 1)))
        travel = upper - lower
        kept = np.where(slides, SLIDING_MARGIN * travel, margin)
        for j, name in enumerate(arm.joint_names):
            if not (np.isfinite(travel[j]) and travel[j] > 2.0 * kept[j]):
                more = f"more than twice the margin of {_in_words(kept[j], slides[j])}"
                raise OptionError(f"travel of {name}", _travel(lower[j], upper[j], slides[j]), more)
        speed = np.where(np.isinf(arm.velocity), np.nan if unknown_speed is None else unknown_speed, arm.velocity)
        for j, name in enumerate(arm.joint_names):
            if not (math.isfinite(speed[j]) and speed[j] > 0.0):
                raise OptionError(
                    f"speed limit of {name}", "unknown", "a limit for it, rad/s or m/s: unknown_speed (--speed)"
                )
        return cls(lower + kept, upper - kept, speed_share * speed, torque_share * arm.effort)

    def fitted(self, X: Array, basis: FourierBasis, fill: bool = False) -> Array:
        """Coordinates (b, n) whose motion is inside position and speed limits at the instants of the basis.

        A joint that is outside moves less about its centre, and its centre is shifted; `fill` also lets it move more.
        """
        out = X.copy()
        out[0] = 0.0
        q, dq = basis.position @ out, basis.speed @ out
        room = np.minimum(self.speed / np.abs(dq).max(axis=0), (self.upper - self.lower) / np.ptp(q, axis=0))
        share = room if fill else np.minimum(1.0, room)
        out *= share
        out[0] = np.clip(X[0], self.lower - share * q.min(axis=0), self.upper - share * q.max(axis=0))
        return out


def _travel(lower: float, upper: float, slides: bool) -> str:
    if math.isinf(upper - lower):
        return "unknown"
    return f"{_in_words(lower, slides)} to {_in_words(upper, slides)}"


def _in_words(x: float, slides: bool) -> str:
    return f"{x:.3g} m" if slides else f"{math.degrees(x):.4g} deg ({x:.3g} rad)"
