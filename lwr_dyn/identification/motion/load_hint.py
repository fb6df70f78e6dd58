"""Whether a fit without friction that grows with the load asks for it: what its columns would gain on unseen motions.

The load is that of the bodies and rotors of the fit (`regression.load_friction`, without its rounds). Each part of the
motion is predicted by fits to the others, from normal equations: with the columns and without. Chance gives a gain of
some per cent and shares of a few standard errors to a log whose friction has none of it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import reduce
from operator import add

import numpy as np
from scipy import stats

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.motion.validation import Folds
from lwr_dyn.identification.regression.information import Information, solve
from lwr_dyn.identification.regression.load_friction import load_indices, rigid_values

LEAST = 0.1
"""Share of the unseen torques that is worth a line."""
LEVEL = 1e-3
"""Probability that chance gives so large a share to any joint (Bonferroni)."""


@dataclass(frozen=True, slots=True)
class LoadHint:
    """RMS torque of unseen motions that is left over all joints [N m or N], and the surest share of the load."""

    without: float
    with_load: float
    joint: int
    """From 1."""
    share: float
    sigma: float
    """Standard error of the share."""

    @property
    def gain(self) -> float:
        """Share of the torques left that the columns explain."""
        return 1.0 - self.with_load / self.without

    @property
    def words(self) -> str:
        """In a line."""
        return (
            f"friction that grows with the load would leave {self.with_load:.3g} N m (N) of unseen torques in place of "
            f"{self.without:.3g}, {100.0 * self.gain:.0f} % less (joint {self.joint}: {self.share:.2g} +- "
            f"{self.sigma:.1g} of it): --load-friction"
        )


def load_hint(folds: Folds, information: Information, said: Callable[[Folds], Information]) -> LoadHint | None:
    """None where friction grows with the load already, or where chance explains what that would gain.

    Parameters
    ----------
    folds : Folds
        The motions of the fit.
    information : Information
        What they say together.
    said : callable
        The same of other folds, with errors for residuals that last.
    """
    columns, motors = folds.columns, folds.columns.transmission
    coupled = motors is not None and motors.coupled.any()
    if columns.carried is not None or coupled or not information.equations.any():
        return None
    grown = folds.with_columns(replace(columns, carried=rigid_values(columns, information.values)))
    found = said(grown)
    at = np.searchsorted(found.base.kept, load_indices(found.columns))
    shares, sigma = found.values[at], found.sigma[at]
    surest = int(np.argmax(shares / sigma))
    noise = np.where(np.isfinite(information.noise), information.noise, 1.0)
    hint = LoadHint(_unseen(folds, noise), _unseen(grown, noise), surest + 1, float(shares[surest]),
                    float(sigma[surest]))  # fmt: skip
    sure = stats.norm.sf(hint.share / hint.sigma) * columns.n < LEVEL
    return hint if sure and hint.gain >= LEAST else None


def _unseen(folds: Folds, noise: Array) -> float:
    """RMS of what fits to the other folds leave of the torques of each."""
    squares = 0.0
    for i, part in enumerate(folds.normal):
        others = reduce(add, (one for k, one in enumerate(folds.normal) if k != i))
        squares += part.residual_squares(solve(others, folds.columns, folds.base, noise).values).sum()
    return float(np.sqrt(squares / sum(part.equations.sum() for part in folds.normal)))
