"""Least squares of equations in groups, such as joints, from their normal equations; each group has its own noise.

As `information`, for columns that are not those of one arm alone: a load in its hand, the two sides of its gears.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.regression.normal_equations import NormalEquations
from lwr_dyn.identification.regression.spectrum import Spectrum, solved

ROUNDS = 50
"""Of noise and fit in turn, at most."""
SETTLED = 1e-6
"""Share by which the noise may still change in the last round."""
QUIET = 1e-7
"""Noise below this share of a group's right side may be rounding alone."""

LEAST = 1e-9
"""[N m or N] Least noise, also of a group whose right sides are all 0: its weight stays a number that others bear."""


@dataclass(frozen=True, slots=True, eq=False)
class GroupedEstimate:
    """Parameters (p,) with covariance (p, p), and the noise (g,) of every group of equations, NaN of an empty one.

    Parameters that the equations leave open are those of least norm among scaled columns; `determined` (p,) says which
    are not, and their variance is infinite.
    """

    values: Array
    covariance: Array
    noise: Array
    normal: NormalEquations
    determined: NDArray[np.bool_]

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "covariance", "noise")

    @property
    def sigma(self) -> Array:
        """Standard errors (p,), infinite where a parameter is not determined."""
        return np.sqrt(np.diag(self.covariance))

    def rms(self, values: Array) -> Array:
        """RMS residual of every group (g,) with parameters (p,); NaN of an empty group."""
        count = self.normal.equations
        return np.sqrt(np.where(count > 0, self.normal.residual_squares(values) / np.maximum(count, 1), np.nan))


def equations_of(X: Array, y: Array, used: NDArray[np.bool_]) -> NormalEquations:
    """The normal equations of rows X (k, g, p), y (k, g) where `used` (k, g)."""
    rows = [(X[u, g], y[u, g]) for g, u in enumerate(used.T)]
    return NormalEquations(
        np.array([W.T @ W for W, _ in rows]), np.array([W.T @ b for W, b in rows]), np.array([b @ b for _, b in rows]),
        np.count_nonzero(used, axis=0),
    )  # fmt: skip


def grouped(normal: NormalEquations, start: Array, known: bool = False) -> GroupedEstimate:
    """min sum over groups of |y - X b|^2 / s_g^2, with s_g^2 = |y - X b|^2 / (m_g - p_g) from the round before.

    Parameters
    ----------
    normal : NormalEquations
        Of g groups.
    start : (g,) array
        Noise of the groups in the first round, above 0.
    known : bool
        That noise is right and stays.

    Returns
    -------
    GroupedEstimate

    Notes
    -----
    p_g = trace(X_g^T X_g C) / s_g^2 is the share of the parameters that a group pays for: they sum to p, and the noise
    has no bias (C the covariance of b).

    References
    ----------
    Harville, Maximum likelihood approaches to variance component estimation, J. Am. Stat. Assoc. 72 (1977), 3.

    >>> rows = equations_of(np.ones((3, 1, 1)), np.array([[1.0], [2.0], [3.0]]), np.ones((3, 1), dtype=bool))
    >>> fit = grouped(rows, np.ones(1))
    >>> fit.values.round(6).tolist(), fit.noise.round(6).tolist()
    ([2.0], [1.0])
    """
    count = normal.equations
    floor = QUIET * np.sqrt(normal.squares / np.maximum(count, 1)) + LEAST
    noise = np.asarray(start, dtype=np.float64)
    for _ in range(0 if known else ROUNDS):
        matrix, side = normal.weighted(noise)
        inverse = Spectrum.of(matrix).inverse()
        squares = normal.residual_squares(solved(matrix, side, inverse))
        before, paid = noise, np.einsum("gij,ji->g", normal.matrices, inverse) / noise**2
        freedom = count - paid
        found = np.sqrt(squares / np.maximum(freedom, 0.5))
        noise = np.where(freedom > 0.5, np.maximum(found, floor), noise)
        if np.abs(noise / before - 1.0).max() < SETTLED:
            break
    matrix, side = normal.weighted(noise)
    spectrum = Spectrum.of(matrix)
    covariance, determined = spectrum.inverse(), spectrum.determined
    values = solved(matrix, side, covariance)
    covariance[~determined] = covariance[:, ~determined] = 0.0
    covariance[~determined, ~determined] = np.inf
    return GroupedEstimate(values, covariance, np.where(count > 0, noise, np.nan), normal, determined)
