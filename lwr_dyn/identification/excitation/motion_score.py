"""What a motion is worth: both objectives and the sigma of every base parameter, on its own terms and unsmoothed."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array, freeze_arrays
from lwr_dyn.identification.excitation.fourier import FourierMotion
from lwr_dyn.identification.excitation.objectives import cond_value, d_value
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.shown import short_repr

SCORE_RATE = 100.0
"""[Hz] Rows of a log of which each counts as an equation of its own."""
_BLOCK = 500
"""Rows whose columns are in memory at a time."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionScore:
    """Objectives of a motion's rows at `SCORE_RATE`, and what noise leaves of the base parameters."""

    d: float
    """-log det of the information of one row, per parameter; each 2 less is e times less sigma."""
    condition: float
    """Of the regressor with its columns scaled to length 1."""
    sigma: Array
    """(b,) of the base parameters [SI], for torques with the stated noise."""
    names: tuple[str, ...]
    """(b,) Columns that stand for the base parameters."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "sigma")


def motion_score(columns: TorqueColumns, motion: FourierMotion, noise: Array, rate: float = SCORE_RATE) -> MotionScore:
    """The score of a motion for torque noise (n,) [N m or N], all rows used.

    A parameter that the motion does not show makes `d` and `condition` 20 or its exponential, and its sigma NaN.
    """
    M, rows = information_per_row(columns, motion, noise, rate)
    d, _ = d_value(M)
    condition, _ = cond_value(M)
    base = columns.base()
    scale = np.sqrt(np.diag(M))
    known = bool(np.isfinite(scale).all() and (scale > 0.0).all() and condition < 15.0)
    inverse = np.linalg.inv(M / np.outer(scale, scale)) if known else np.full_like(M, np.nan)
    sigma = np.sqrt(np.diag(inverse) / rows) / scale if known else np.full(len(M), np.nan)
    return MotionScore(d, float(np.exp(condition)), sigma, tuple(base.names[k] for k in base.kept))


def information_per_row(columns: TorqueColumns, motion: FourierMotion, noise: Array, rate: float) -> tuple[Array, int]:
    """W^T S^-1 W / k (b, b) of the k rows of a motion at `rate` [Hz], and k."""
    states = motion.sample(np.arange(max(1, round(motion.duration * rate))) / rate)
    kept, k = columns.base().kept, len(states.t)
    M = np.zeros((len(kept), len(kept)))
    for i in range(0, k, _BLOCK):
        part = slice(i, i + _BLOCK)
        W = columns(states.q[part], states.dq[part], states.ddq[part])[:, :, kept] / noise[:, None]
        rows = W.reshape(-1, len(kept))
        M += rows.T @ rows
    return M / k, k
