"""What errors of the arm's own table do to a load that is fitted on it.

    y = X b + Y d + e,   d ~ N(0, t^2 C0),   b^ - b = (X^T W X)^-1 X^T W (Y d + e)

b are the load and the friction, Y d the torques of what the table has wrong of bodies and rotors. Their share t is the
one whose expected residual squares are those that neighbouring instants have in common.
"""

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.body_prior import body_prior
from lwr_dyn.identification.regression.normal_equations import NormalEquations
from lwr_dyn.identification.regression.spectrum import Spectrum
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

SURE = 5.0
"""Standard errors by which the residuals of neighbours must be alike, in all joints together."""


def model_squares(left: Array, used: NDArray[np.bool_], recording: NDArray[np.intp]) -> Array:
    """Mean squares (n,) of what is wrong in residuals (k, n), by their neighbours [(N m)^2 or N^2]; 0 if by chance.

    White noise has no covariance with its neighbour, an error of the model hardly changes from one to the next. For
    noise alone the sum over joints of m r, r the correlation in m pairs, has the variance of the sum of m.

    >>> one = np.tile([0.2, 0.2, -0.2, -0.2], 100)[:, None]
    >>> both = np.concatenate([one + 1.0, one - 1.0])
    >>> model_squares(both, np.ones((800, 1), dtype=bool), np.repeat([0, 1], 400)).round(2).tolist()
    [1.0]
    """
    pairs = used[1:] & used[:-1] & (recording[1:] == recording[:-1])[:, None]
    count = pairs.sum(axis=0)
    alike = np.where(pairs, left[1:] * left[:-1], 0.0).sum(axis=0) / np.maximum(count, 1)
    squares = np.where(used, left**2, 0.0).sum(axis=0) / np.maximum(used.sum(axis=0), 1)
    sure = float((count * alike / np.maximum(squares, 1e-300)).sum()) > SURE * float(np.sqrt(count.sum()))
    return np.asarray(np.maximum(alike, 0.0) * sure)


def arm_doubt(
    normal: NormalEquations, columns: TorqueColumns, own: Array, fitted: int, noise: Array, wrong: Array
) -> tuple[float, Array]:
    """How far the arm seems to be off its table, and what that adds to the covariance of what was fitted.

    Parameters
    ----------
    normal : NormalEquations
        Of `fitted` columns, then all bodies and rotors of `columns`.
    columns : TorqueColumns
    own : (p,) array
        The table's parameters.
    fitted : int
    noise, wrong : (n,) array
        Noise that weighs each joint's equations, and the mean squares of `model_squares`.

    Returns
    -------
    share : float
        As the deviation of `consistent_fit`: 0.1 for an arm some 10 % off.
    covariance : (fitted, fitted) array
    """
    matrix, _ = normal.weighted(noise)
    prior = body_prior(columns, own).covariance(1.0)
    table = np.r_[0 : columns.bodies, columns.rotor_indices]
    prior = prior[np.ix_(table, table)]
    across = matrix[:fitted, fitted:]
    bias = Spectrum.of(matrix[:fitted, :fitted]).inverse() @ across
    left = matrix[fitted:, fitted:] - across.T @ bias
    seen = normal.equations > 0
    share = float((normal.equations * wrong / noise**2)[seen].sum()) / max(float((prior * left).sum()), 1e-300)
    return float(np.sqrt(share)), share * bias @ prior @ bias.T
