"""What logs say of the base parameters: weighted least squares with the noise of every joint, and what they leave open.

    chi^2(b) = sum_j |tau_j - W_j b|^2 / s_j^2,    precision = sum_j W_j^T W_j / s_j^2,    R^T R = precision

s_j is the noise of joint j, from its own residuals unless it is given.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array, freeze_arrays
from lwr_dyn.identification.regression.base_parameters import BaseParameters
from lwr_dyn.identification.regression.normal_equations import NormalEquations, normal_equations
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

UNSEEN = 1e-12
"""Eigenvalue of W^T W with columns of length 1, as a share of the largest, that rounding alone can give."""
LEAKS = 1e-3
"""Share of a parameter's column that may lie in directions a log does not show, and the parameter counts as seen."""
ROUNDS = 20
SETTLED = 1e-6
QUIET = 1e-7
"""Noise below this share of a joint's torques is rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Information:
    """Base parameters that fit best, and how well logs determine all of them.

    `values` (b,) and `precision` (b, b) in SI; `noise` (n,) [N m or N], NaN for a joint without equations; `equations`
    (n,) used; `chi2` at the values, `dof` equations less parameters; `determined` (b,): whether the log shows a
    parameter at all. Where it does not the values are those of least length (columns scaled) and sigma is infinite.
    """

    columns: TorqueColumns
    base: BaseParameters
    values: Array
    precision: Array
    noise: Array
    equations: NDArray[np.intp]
    chi2: float
    dof: int
    determined: NDArray[np.bool_]
    normal: NormalEquations
    """Of every joint alone, for residuals by joint and for other weights."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "precision", "noise")

    @property
    def joint_precision(self) -> Array:
        """W_j^T W_j / s_j^2 of every joint, (n, b, b): their sum is the precision."""
        seen = self.equations > 0
        return self.normal.matrices * np.where(seen, 1.0 / np.where(seen, self.noise, 1.0) ** 2, 0.0)[:, None, None]

    @property
    def covariance(self) -> Array:
        """(b, b): the inverse of the precision in the directions that the log shows; see `sigma` for the others."""
        scale, lengths, turned = _spectrum(self.precision)
        shown = lengths > UNSEEN * lengths[-1]
        root = (turned[:, shown] / np.sqrt(lengths[shown])) * scale[:, None]
        return np.asarray(root @ root.T)

    @property
    def sigma(self) -> Array:
        """Standard errors (b,), infinite where not determined."""
        return np.where(self.determined, np.sqrt(np.diag(self.covariance)), np.inf)

    @property
    def factor(self) -> Array:
        """R (b, b), upper triangular with R^T R = precision."""
        scale, lengths, turned = _spectrum(self.precision)
        root = np.sqrt(np.maximum(lengths, 0.0))[:, None] * turned.T / scale
        R = np.linalg.qr(root, mode="r")
        return np.asarray(R * np.where(np.diag(R) < 0.0, -1.0, 1.0)[:, None])

    @property
    def condition(self) -> float:
        """Condition number of the weighted columns scaled to length 1; infinite where a parameter is not seen."""
        lengths = _spectrum(self.precision)[1]
        return float(np.sqrt(lengths[-1] / lengths[0])) if lengths[0] > UNSEEN * lengths[-1] else float("inf")

    def chi2_of(self, values: Array) -> float:
        """chi^2 of other base values (b,)."""
        away = values - self.values
        return self.chi2 + float(away @ self.precision @ away)

    def residual_rms(self, values: Array) -> Array:
        """RMS residual of every joint (n,) with base values (b,) [N m or N]; NaN without equations."""
        squares = self.normal.residual_squares(values)
        return np.sqrt(np.where(self.equations > 0, squares / np.maximum(self.equations, 1), np.nan))


def information_of(
    samples: Samples | Iterable[Samples],
    columns: TorqueColumns,
    base: BaseParameters | None = None,
    noise: Array | None = None,
) -> Information:
    """What instants of logs say of the base parameters.

    Parameters
    ----------
    samples : Samples or iterable of Samples
        All instants, or a part at a time (`sample_parts`).
    columns : TorqueColumns
    base : BaseParameters, optional
        Those of the columns if not given.
    noise : (n,) array, optional
        Standard deviation of every joint's torque [N m or N]; estimated from the residuals if not given.

    Returns
    -------
    Information

    Raises
    ------
    ShapeError
        Samples of another number of joints.
    """
    chosen = columns.base() if base is None else base
    return solve(normal_equations(samples, columns, chosen), columns, chosen, noise)


def solve(
    normal: NormalEquations, columns: TorqueColumns, base: BaseParameters, noise: Array | None = None
) -> Information:
    """The same from normal equations, such as sums of those of recordings."""
    level = np.ones(columns.n) if noise is None else np.asarray(noise, dtype=np.float64)
    values = _best(*normal.weighted(level))
    for _ in range(ROUNDS if noise is None else 0):
        before, level = level, _noise(normal, values, level)
        values = _best(*normal.weighted(level))
        known = normal.equations > 0
        if np.allclose(level[known], before[known], rtol=SETTLED, atol=0.0):
            break
    precision, _ = normal.weighted(level)
    shown = normal.equations > 0
    squares = normal.residual_squares(values)[shown] / level[shown] ** 2
    determined = _determined(precision)
    rank = _rank(precision)
    return Information(
        columns, base, values, precision, np.where(shown, level, np.nan), normal.equations,
        float(squares.sum()), int(normal.equations.sum()) - rank, determined, normal,
    )  # fmt: skip


def _spectrum(precision: Array) -> tuple[Array, Array, Array]:
    """Factors that scale the columns to length 1 (b,), eigenvalues (rising) and eigenvectors of what is left."""
    size = np.diag(precision)
    scale = np.where(size > 0.0, 1.0 / np.sqrt(np.where(size > 0.0, size, 1.0)), 0.0)
    lengths, turned = np.linalg.eigh(precision * np.outer(scale, scale))
    return np.where(scale > 0.0, scale, 1.0), lengths, turned


def _best(matrix: Array, side: Array) -> Array:
    scale, lengths, turned = _spectrum(matrix)
    shown = lengths > UNSEEN * lengths[-1]
    T = turned[:, shown]
    values = scale * (T @ ((T.T @ (scale * side)) / lengths[shown]))
    left = side - matrix @ values  # one step of refinement
    return np.asarray(values + scale * (T @ ((T.T @ (scale * left)) / lengths[shown])))


def _rank(precision: Array) -> int:
    lengths = _spectrum(precision)[1]
    return int(np.count_nonzero(lengths > UNSEEN * lengths[-1]))


def _determined(precision: Array) -> NDArray[np.bool_]:
    _, lengths, turned = _spectrum(precision)
    hidden = turned[:, lengths <= UNSEEN * lengths[-1]]
    return np.asarray(np.linalg.norm(hidden, axis=1) < LEAKS)


def _noise(normal: NormalEquations, values: Array, level: Array) -> Array:
    """Of every joint from its residuals; each joint pays for its own share of the parameters."""
    matrix, _ = normal.weighted(level)
    scale, lengths, turned = _spectrum(matrix)
    shown = lengths > UNSEEN * lengths[-1]
    root = turned[:, shown] / np.sqrt(lengths[shown]) * scale[:, None]
    shares = np.einsum("bk,jbc,ck->j", root, normal.matrices, root, optimize=True) / level**2
    free = np.maximum(normal.equations - shares, 1.0)
    floor = QUIET**2 * normal.squares / np.maximum(normal.equations, 1)
    found = np.maximum(normal.residual_squares(values) / free, floor)
    return np.where(normal.equations > 0, np.sqrt(np.maximum(found, 1e-300)), 1.0)
