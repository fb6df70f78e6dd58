"""What a motion is worth: both objectives and the sigma of every base parameter, on its own terms and unsmoothed."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.excitation.objectives import LARGE, cond_value, d_value
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.run import Motion
from lwr_dyn.model.shown import short_repr

SCORE_RATE = 100.0
"""[Hz] Rows of a log of which each counts as an equation of its own."""
_BLOCK = 500
"""Rows whose columns are in memory at a time."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionScore:
    """Objectives of a motion's rows at `SCORE_RATE`, and what noise leaves of the base parameters."""

    d: float
    """-log det of the information of one row, per parameter; each 2 less is an error ellipsoid e times as small."""
    condition: float
    """Of the regressor with its columns scaled to length 1."""
    sigma: Array
    """(b,) of the base parameters [SI], for torques with the stated noise."""
    names: tuple[str, ...]
    """(b,) Columns that stand for the base parameters."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "sigma")

    @property
    def mean_sigma(self) -> float:
        """Geometric mean of `sigma`, at least exp(d / 2) / sqrt(rows); NaN where a parameter is not shown."""
        return float(np.exp(np.log(self.sigma).mean()))


def motion_score(columns: TorqueColumns, rows: Motion, noise: Array) -> MotionScore:
    """The score of the rows of any motion for torque noise (n,) [N m or N], each an equation of every joint.

    A parameter that the motion does not show makes `d` 20 and `condition` its exponential, and sigma NaN.
    """
    M = information_per_row(columns, rows, noise)
    d, _ = d_value(M)
    condition, _ = cond_value(M)
    base = columns.base()
    scale = np.sqrt(np.diag(M))
    known = bool(np.isfinite(scale).all() and (scale > 0.0).all() and condition < LARGE)
    inverse = np.linalg.inv(M / np.outer(scale, scale)) if known else np.full_like(M, np.nan)
    sigma = np.sqrt(np.diag(inverse) / len(rows.t)) / np.where(scale > 0.0, scale, 1.0)
    return MotionScore(d, float(np.exp(condition)), sigma, tuple(base.names[k] for k in base.kept))


def information_per_row(columns: TorqueColumns, rows: Motion, noise: Array) -> Array:
    """W^T S^-1 W / k (b, b) of the k rows of a motion."""
    kept, k = columns.base().kept, len(rows.t)
    M = np.zeros((len(kept), len(kept)))
    for i in range(0, k, _BLOCK):
        part = slice(i, i + _BLOCK)
        W = columns(rows.q[part], rows.dq[part], rows.ddq[part])[:, :, kept] / noise[:, None]
        flat = W.reshape(-1, len(kept))
        M += flat.T @ flat
    return M / k
