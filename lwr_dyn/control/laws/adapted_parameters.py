"""What the adaptive law adapts: the ten parameters of what the flange carries, or those of all links; gains and bounds.

Gains are scaled by the unit of the parameter: g for a mass [kg], g (0.1 m)^2 for a first moment [kg m], g (0.1 m)^4 for
a second moment [kg m^2]. One gain for all ten makes the second moments, whose torques are small, ruin the loop.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from lwr_dyn.control.laws.slotine_li_regressor import PER_LINK, SlotineLiRegressor
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm

SETS = ("payload", "base")
LENGTH = 0.1
"""[m] Of a load: a first moment is of the order of its mass times it."""
HEAVIEST = 20.0
"""[kg] The largest load, where the arm has no rating; three times the rating otherwise."""
FAR = 0.5
"""[m] The farthest centre of a load from the frame of the last joint."""
STATES, SEED = 100, 0
"""Random states whose torques show which combinations of parameters matter."""
RANK = 1e-9
"""Of the largest singular value: a combination below it moves no torque."""


@dataclass(frozen=True, slots=True, eq=False)
class AdaptedParameters:
    """theta (m,), added to the parameters of the arm's model: pi_hat = pi + W theta.

    `W` (10 n, m), or None where theta are the last ten; `gains`, `lower`, `upper` (m,) of theta.
    """

    name: str
    W: Array | None
    gains: Array
    lower: Array
    upper: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "gains", "lower", "upper")

    @classmethod
    def payload(cls, arm: Arm, regressor: SlotineLiRegressor, gain: float) -> Self:
        """The ten of what is fixed to the last link; the mass of both together stays positive."""
        most = _heaviest(arm)
        moments = np.r_[[FAR * most] * 3, [FAR**2 * most] * 6]
        own = float(regressor.parameters[-len(PER_LINK)])
        return cls("payload", None, scaled_gains(gain), np.r_[-own, -moments], np.r_[most, moments])

    @classmethod
    def base(cls, arm: Arm, regressor: SlotineLiRegressor, gain: float) -> Self:
        """All combinations of the parameters of all links that move a torque, in coordinates in which the gains are 1.

        W = S V with S the roots of the scaled gains and V (10 n, m) an orthonormal base of the row space of Y S. The
        gradient law for all 10 n parameters never leaves this space, so it is that law with fewer numbers.
        """
        root = np.sqrt(np.tile(scaled_gains(gain), arm.n))
        states = np.random.default_rng(SEED).uniform(-np.pi, np.pi, (STATES, 4, arm.n))
        rows = np.concatenate([regressor(*state) for state in states]) * root
        _, sizes, V = np.linalg.svd(rows, full_matrices=False)
        V = V[sizes > RANK * sizes[0]]
        bound = np.full(len(V), len(PER_LINK) * _heaviest(arm) / np.sqrt(gain))
        return cls("base", root[:, None] * V.T, np.ones(len(V)), -bound, bound)

    @classmethod
    def of(cls, name: str, arm: Arm, regressor: SlotineLiRegressor, gain: float) -> Self:
        """One of `SETS`; raises `OptionError` for another name, or a gain that is not above 0."""
        if name not in SETS:
            raise OptionError("adapt", repr(name), ", ".join(SETS))
        if not (np.isfinite(gain) and gain > 0.0):
            raise OptionError("adapt_gain", gain, "a number above 0")
        return cls.payload(arm, regressor, gain) if name == SETS[0] else cls.base(arm, regressor, gain)

    def link_parameters(self, theta: Array) -> Array:
        """What is added to the parameters: of the payload (10,), or of all links (10 n,)."""
        return theta if self.W is None else np.asarray(self.W @ theta)

    def columns(self, Y: Array) -> Array:
        """The columns (n, m) of theta out of all columns Y (n, 10 n)."""
        return Y[:, -len(PER_LINK) :] if self.W is None else np.asarray(Y @ self.W)


def scaled_gains(gain: float) -> Array:
    """Gains of the ten parameters of one body, in the order of `PER_LINK`.

    >>> scaled_gains(100.0)[[0, 1, 4]].round(9).tolist()
    [100.0, 1.0, 0.01]
    """
    return np.array(gain * np.r_[1.0, [LENGTH**2] * 3, [LENGTH**4] * 6])


def _heaviest(arm: Arm) -> float:
    rated = arm.ratings.payload
    return HEAVIEST if rated is None else 3.0 * rated
