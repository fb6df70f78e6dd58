"""How well Stribeck speeds are known, and what that costs the other parameters: their tangent as columns.

    d tau_j / d v_s = drop sign(dq) exp(-(dq/v_s)^2) 2 dq^2 / v_s^3

With T these columns and W those of the base parameters, both weighted by the noise, the precision of all is
[W^T W, W^T T; T^T W, T^T T]. The covariance of v_s is the inverse of its Schur complement, and the precision of the
base parameters with v_s unknown is W^T W - W^T T (T^T T)^-1 T^T W.

References
----------
Golub and Pereyra, The differentiation of pseudo-inverses and nonlinear least squares problems (1973), section 2.
"""

from dataclasses import replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.normal_equations import BLOCK
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.spectrum import Spectrum
from lwr_dyn.identification.regression.torque_columns import TorqueColumns


def with_unknown_speeds(samples: Samples, information: Information) -> tuple[Information, Array]:
    """The same with errors that take v_s as found from the samples, not as known; and the standard errors of v_s.

    Parameters
    ----------
    samples : Samples
    information : Information
        Of columns with one v_s a joint, NaN for none.

    Returns
    -------
    Information, (n,) array
        NaN for a joint without v_s [rad/s or m/s].
    """
    columns, kept = information.columns, information.base.kept
    speeds = np.asarray(columns.stribeck_velocity, dtype=np.float64)
    values = np.zeros(columns.count)
    values[kept] = information.values
    weight = np.where(information.equations > 0, information.noise**-2.0, 0.0)
    n, b = columns.n, len(kept)
    across, alone = np.zeros((b, n)), np.zeros((n, n))
    for first in range(0, len(samples), BLOCK):
        part = samples.select(slice(first, first + BLOCK))
        W = columns(part.q, part.dq, part.ddq)[:, :, kept]
        T = _tangents(columns, speeds, values, part.dq) * (part.used * weight)[:, :, None]
        across += np.einsum("kjb,kjt->bt", W, T, optimize=True)
        alone += np.einsum("kjs,kjt->st", _tangents(columns, speeds, values, part.dq), T, optimize=True)
    there = np.flatnonzero(np.diag(alone) > 0.0)
    W_T, T_T = across[:, there], alone[np.ix_(there, there)]
    left = T_T - W_T.T @ information.covariance @ W_T
    sigma = np.full(n, np.nan)
    sigma[there] = np.sqrt(np.diag(Spectrum.of(left).inverse()))
    precision = information.precision - W_T @ np.linalg.solve(T_T, W_T.T)
    return replace(information, precision=0.5 * (precision + precision.T)), sigma


def _tangents(columns: TorqueColumns, speeds: Array, values: Array, dq: Array) -> Array:
    """Change of the torques (k, n) per v_s of each joint, (k, n, n)."""
    out = np.zeros((*dq.shape, columns.n))
    for i in np.flatnonzero(np.isfinite(speeds)):
        part, joint = columns.of_joint(int(i)), columns.joints[i]
        drops = values[part.start + joint.linear : part.stop]
        own = dq[:, i] if columns.transmission is None else dq @ columns.transmission.matrix[i]
        drop = np.where(own > 0.0, drops[0], drops[-1])
        v = speeds[i]
        slope = drop * np.sign(own) * np.exp(-np.square(own / v)) * 2.0 * own**2 / v**3
        for j in range(columns.n):
            if reach := columns.reach(j, int(i)):
                out[:, j, i] = reach * slope
    return out
