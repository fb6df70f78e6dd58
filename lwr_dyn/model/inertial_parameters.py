"""The ten inertial parameters of a body as its pseudo-inertia P (4, 4), and in another frame.

They are (m, m c_x, m c_y, m c_z, I_xx, I_xy, I_xz, I_yy, I_yz, I_zz) about the origin of the frame [kg, kg m, kg
m^2], the order of `lwr_dyn.dynamics.regressor.INERTIAL`. P is the integral of x x^T dm with x = (position, 1), so a
frame in which x is T x has T P T^T.
"""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm


def pseudo_inertia_weights(c: Array) -> Array:
    """G (..., 4, 4) with c . pi = trace(G P), for factors c (..., 10)."""
    m, mx, my, mz, xx, xy, xz, yy, yz, zz = np.moveaxis(c, -1, 0)
    # I_xx = integral of y^2 + z^2, I_xy = -integral of x y
    rows = (
        (yy + zz, -xy / 2.0, -xz / 2.0, mx / 2.0),
        (-xy / 2.0, xx + zz, -yz / 2.0, my / 2.0),
        (-xz / 2.0, -yz / 2.0, xx + yy, mz / 2.0),
        (mx / 2.0, my / 2.0, mz / 2.0, m),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


TENSOR = np.array([[4, 5, 6], [5, 7, 8], [6, 8, 9]])
"""Places (3, 3) of a tensor's entries among the parameters."""
_WEIGHTS = pseudo_inertia_weights(np.eye(10)).reshape(10, 16)
UNITS = np.round(np.linalg.pinv(_WEIGHTS).T, 9).reshape(10, 4, 4)
"""P of one unit of each parameter, (10, 4, 4): P = sum pi_k UNITS_k."""


def pseudo_inertias(parameters: Array) -> Array:
    """P (..., 4, 4) of inertial parameters (..., 10) [kg, kg m, kg m^2].

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


PINOCCHIO = (0, 1, 2, 3, 4, 5, 7, 6, 8, 9)
"""Places of Pinocchio's parameters among these: it has I_yy before I_xz. It is its own inverse."""


def parameter_turns(arm: Arm) -> Array:
    """(n, 10, 10) of each link: its parameters in the frame of its joint -> in that of the URDF's link.

    Both in Pinocchio's order. The link's frame of an arm that was read from a URDF is that of its file. The URDF that
    is written of another arm has the frames of the joints, so these are identities.
    """
    if arm.layout is None:
        return np.tile(np.eye(10), (arm.n, 1, 1))
    T = np.array([link.after.inverse().matrix() for link in arm.chain.links])[:, None]
    turned = inertial_parameters(T @ UNITS @ np.swapaxes(T, -1, -2))
    return np.asarray(np.swapaxes(turned, 1, 2)[:, PINOCCHIO][:, :, PINOCCHIO])
