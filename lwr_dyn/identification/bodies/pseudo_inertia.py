"""The pseudo-inertia of a body: its ten inertial parameters as a 4 x 4 matrix, positive exactly if it can be a body.

    P = integral of [x y z 1]^T [x y z 1] dm = [[Sigma, m c], [(m c)^T, m]],   Sigma = trace(I)/2 1 - I

P is linear in the parameters; its eigenvalues are positive exactly if mass in space, not all in one plane, has them.
"""

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array


def pseudo_inertia_weights(c: Array) -> Array:
    """G (..., 4, 4) with c . pi = trace(G P), for factors c (..., 10) in the order of `INERTIAL`."""
    m, mx, my, mz, xx, xy, xz, yy, yz, zz = np.moveaxis(c, -1, 0)
    # I_xx = integral of y^2 + z^2, I_xy = -integral of x y
    rows = (
        (yy + zz, -xy / 2.0, -xz / 2.0, mx / 2.0),
        (-xy / 2.0, xx + zz, -yz / 2.0, my / 2.0),
        (-xz / 2.0, -yz / 2.0, xx + yy, mz / 2.0),
        (mx / 2.0, my / 2.0, mz / 2.0, m),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


_WEIGHTS = pseudo_inertia_weights(np.eye(len(INERTIAL))).reshape(len(INERTIAL), 16)
UNITS = np.round(np.linalg.pinv(_WEIGHTS).T, 9).reshape(len(INERTIAL), 4, 4)
"""P of one unit of each parameter, (10, 4, 4): P = sum pi_k UNITS_k."""


def pseudo_inertias(parameters: Array) -> Array:
    """P (..., 4, 4) of inertial parameters (..., 10) in the order of `INERTIAL` [kg, kg m, kg m^2].

    References
    ----------
    Wensing, Kim, Slotine, Linear matrix inequalities for physically consistent inertial parameter identification
    (2018), eq. 13 and theorem 3.

    >>> pseudo_inertias(np.array([2.0, 0, 0, 1.0, 0.5, 0, 0, 0.5, 0, 0])).diagonal().tolist()
    [0.0, 0.0, 0.5, 2.0]
    """
    return np.tensordot(parameters, UNITS, axes=1)


def inertial_parameters(P: Array) -> Array:
    """The parameters (..., 10) of pseudo-inertias (..., 4, 4): the inverse of `pseudo_inertias`."""
    return np.asarray(P.reshape(*P.shape[:-2], 16) @ _WEIGHTS.T)


def are_bodies(parameters: Array) -> NDArray[np.bool_]:
    """Which parameters (..., 10) a body of mass in space can have: P positive definite, (...)."""
    P = pseudo_inertias(np.where(np.isfinite(parameters), parameters, -1.0))
    return np.asarray(np.linalg.eigvalsh(P)[..., 0] > 0.0)
