"""Normal equations by their eigenvectors, columns scaled to length 1: inverse, rank, what they leave open."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array

RANK = 1e-12
"""Eigenvalue, as a share of the largest, below which rounding alone can give it: the direction is not determined."""
SHARED = 1e-6
"""Share (squared) of the undetermined directions that makes a parameter undetermined."""


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """W^T W = D U diag(lengths) U^T D with D = diag(scale), rising lengths (p,) and axes U (p, p)."""

    scale: Array
    lengths: Array
    axes: Array

    @classmethod
    def of(cls, matrix: Array) -> "Spectrum":
        """Of normal equations (p, p); a column of zeros keeps the scale 1."""
        size = np.sqrt(np.diag(matrix))
        scale = np.where(size > 0.0, size, 1.0)
        return cls(scale, *np.linalg.eigh(matrix / np.outer(scale, scale)))

    @property
    def shown(self) -> NDArray[np.bool_]:
        """Which axes are determined, (p,)."""
        return np.asarray(self.lengths > max(RANK * self.lengths[-1], 0.0))

    @property
    def rank(self) -> int:
        """How many."""
        return int(np.count_nonzero(self.shown))

    @property
    def condition(self) -> float:
        """Condition number of the scaled columns W D^-1; infinite with an axis that is not determined."""
        return float(np.sqrt(self.lengths[-1] / self.lengths[0])) if self.shown[0] else float("inf")

    @property
    def determined(self) -> NDArray[np.bool_]:
        """Which parameters are, (p,): their share of the other axes is nothing."""
        return np.asarray(np.sum(self.axes[:, ~self.shown] ** 2, axis=1) < SHARED)

    def inverse(self) -> Array:
        """(W^T W)^-1 in the axes that are determined, 0 in the others, (p, p)."""
        root = self.axes[:, self.shown] / np.sqrt(self.lengths[self.shown]) / self.scale[:, None]
        return np.asarray(root @ root.T)

    def factor(self) -> Array:
        """R (p, p), upper triangular with a diagonal >= 0 and R^T R = W^T W."""
        R = np.linalg.qr(np.sqrt(np.maximum(self.lengths, 0.0))[:, None] * self.axes.T * self.scale, mode="r")
        return np.asarray(R * np.where(np.diag(R) < 0.0, -1.0, 1.0)[:, None])


def solved(matrix: Array, side: Array, inverse: Array) -> Array:
    """matrix^-1 side with one step of refinement; least length in scaled columns where the inverse is partial."""
    values = inverse @ side
    return np.asarray(values + inverse @ (side - matrix @ values))
