"""Stribeck speeds: the one nonlinear parameter of friction, by a bounded search with all others linear.

Each pass over the samples has several v_s of every joint as columns. The chi^2 of any choice of one v_s a joint follows
from the same normal equations, so the choice is made joint after joint without looking at the samples again; the next
pass is finer about it.

How well they are known, and what that costs the other parameters, follows from their tangent as columns:

    d tau_j / d v_s = drop sign(dq) exp(-(dq/v_s)^2) 2 dq^2 / v_s^3

With T these columns and W those of the base parameters, both weighted by the noise, the precision of all is
[W^T W, W^T T; T^T W, T^T T]. The covariance of v_s is the inverse of its Schur complement, and the precision of the
base parameters with v_s unknown is W^T W - W^T T (T^T T)^-1 T^T W.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.regression import information
from lwr_dyn.identification.regression.information import BLOCK, Information, NormalEquations, normal_equations
from lwr_dyn.identification.regression.least_squares import RANK, BaseParameters, Spectrum
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

SPEEDS = 12
"""Of v_s in a pass, a joint."""
PASSES = 3
SWEEPS = 4
"""Over the joints, at most."""
WORTH = 25.0
"""Drop of chi^2 that a Stribeck term of a joint must bring (the second parameter is found by search: Davies 1987)."""
WIDEST = 1.0 / 3.0
"""Largest v_s, as a share of a joint's largest speed: beyond it the term is hardly more than viscous friction."""
NARROWEST = 0.5
"""Smallest v_s, as a share of the least speed that is used."""
LEAST = 1e-3
"""Smallest v_s, as a share of a joint's largest speed."""


@dataclass(frozen=True, slots=True, eq=False)
class StribeckSearch:
    """The columns with the v_s found, (n,) NaN where a Stribeck term is not worth it, and what the samples then say.

    `drop` (n,) of chi^2 by the term of each joint, 0 without; `lowest`, `highest` (n,) the bounds of the search
    [rad/s or m/s]; `at_bound` (n,): the v_s is one of them, so the true one may be beyond.
    """

    columns: TorqueColumns
    speeds: Array
    information: Information
    drop: Array
    lowest: Array
    highest: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "speeds", "drop", "lowest", "highest")

    @property
    def at_bound(self) -> NDArray[np.bool_]:
        """(n,)"""
        return np.asarray((self.speeds <= 1.01 * self.lowest) | (self.speeds >= 0.99 * self.highest))


def stribeck_search(samples: Samples, columns: TorqueColumns) -> StribeckSearch:
    """The Stribeck speed of every joint whose torques ask for one.

    Parameters
    ----------
    samples : Samples
        With low speeds in them: a rule whose `slowest` is well below the v_s that is looked for.
    columns : TorqueColumns
        Whose geometry and form of friction stay; their v_s do not count.

    Notes
    -----
    Standard errors of `information` take v_s as known; `with_unknown_speeds` does not.

    References
    ----------
    Golub and Pereyra, The differentiation of pseudo-inverses and nonlinear least squares problems (1973), section 2,
    for the separation of linear parameters; Davies, Hypothesis testing when a nuisance parameter is present only under
    the alternative (1987).
    """
    plain = replace(columns, stribeck_velocity=None)
    lowest, highest = _bounds(samples, columns)
    low, high = lowest.copy(), highest.copy()
    for _ in range(PASSES):
        grid = np.geomspace(low, high, SPEEDS, axis=1)
        chosen, drop = _choice(samples, replace(plain, stribeck_velocity=grid), plain.base())
        step = (high / low) ** (1.0 / (SPEEDS - 1))
        middle = np.where(chosen >= 0, grid[np.arange(columns.n), chosen], np.sqrt(low * high))
        found = chosen >= 0
        low = np.where(found, np.maximum(middle / step, lowest), low)
        high = np.where(found, np.minimum(middle * step, highest), high)
    speeds = np.where(chosen >= 0, grid[np.arange(columns.n), chosen], np.nan)
    final = plain if (chosen < 0).all() else replace(plain, stribeck_velocity=speeds)
    return StribeckSearch(final, speeds, information.information_of(samples, final), drop, lowest, highest)


def _bounds(samples: Samples, columns: TorqueColumns) -> tuple[Array, Array]:
    size = np.abs(columns.drive_speeds(samples.dq))  # of the motor where the equation of its number counts
    fastest = np.max(size, axis=0, where=samples.used, initial=0.0)
    slowest = np.min(size, axis=0, where=samples.used, initial=np.inf)
    fastest = np.where(fastest > 0.0, fastest, 1.0)  # a joint without equations has no term whatever the bounds
    highest = WIDEST * fastest
    lowest = np.maximum(NARROWEST * np.where(np.isfinite(slowest), slowest, 0.0), LEAST * fastest)
    return np.minimum(lowest, highest / 2.0), highest


def _choice(samples: Samples, several: TorqueColumns, plain: BaseParameters) -> tuple[NDArray[np.intp], Array]:
    """Which v_s of each joint's is best, -1 for none, and the drop of chi^2 that it brings."""
    at = {name: k for k, name in enumerate(several.names)}  # columns of drops have moved the kept ones
    terms, kept = _terms(several), np.array([at[plain.names[k]] for k in plain.kept], dtype=np.intp)
    whole = BaseParameters(several.names, np.concatenate([kept, *terms.reshape(-1, terms.shape[2])]), np.eye(1))
    normal = normal_equations(samples, several, whole)
    b, width = plain.count, terms.shape[2]
    chosen = np.full(several.n, -1, dtype=np.intp)
    drop = np.zeros(several.n)
    noise = information.solve(_part(normal, np.arange(b)), several, plain).noise
    for _ in range(SWEEPS):
        before = chosen.copy()
        for j in range(several.n):
            chosen[j] = -1
            without = _chi2(normal, _places(chosen, b, width), noise)[0]
            drop[j] = 0.0
            for k in range(SPEEDS):
                trial = chosen.copy()
                trial[j] = k
                places = _places(trial, b, width)
                chi2, values = _chi2(normal, places, noise)
                rises = values[-width * np.count_nonzero(trial[j:] >= 0) :][:width].sum() > 0.0
                if rises and without - chi2 > max(WORTH, drop[j]):
                    chosen[j], drop[j] = k, without - chi2
        noise = information.solve(_part(normal, _places(chosen, b, width)), several, plain).noise
        if (chosen == before).all():
            break
    return chosen, drop


def _terms(several: TorqueColumns) -> NDArray[np.intp]:
    """Columns of the Stribeck drops, (n, SPEEDS, 1 or 2)."""
    out = []
    for j, joint in enumerate(several.joints):
        part = several.of_joint(j)
        out.append(np.arange(part.start + joint.linear, part.stop).reshape(SPEEDS, -1))
    return np.array(out)


def _places(chosen: NDArray[np.intp], b: int, width: int) -> NDArray[np.intp]:
    """Of the plain parameters and of the chosen drops among all columns of the pass."""
    drops = [b + (j * SPEEDS + k) * width + np.arange(width) for j, k in enumerate(chosen) if k >= 0]
    return np.concatenate([np.arange(b), *drops])


def _part(normal: NormalEquations, places: NDArray[np.intp]) -> NormalEquations:
    matrices = normal.matrices[:, places[:, None], places]
    return NormalEquations(matrices, normal.sides[:, places], normal.squares, normal.equations)


def _chi2(normal: NormalEquations, places: NDArray[np.intp], noise: Array) -> tuple[float, Array]:
    """Least chi^2 with some of the columns, up to a constant, and the values."""
    matrix, side = normal.weighted(noise)
    M, y = matrix[np.ix_(places, places)], side[places]
    size = np.sqrt(np.diag(M))
    size = np.where(size > 0.0, size, 1.0)
    scaled, right = M / np.outer(size, size), y / size
    try:
        values = cho_solve(cho_factor(scaled), right) / size
    except LinAlgError:  # parameters that the samples do not show
        values = np.linalg.lstsq(scaled, right, rcond=RANK)[0] / size
    return float(-(y @ values)), np.asarray(values)


def with_unknown_speeds(samples: Samples, information: Information) -> tuple[Information, Array]:
    """The same with errors that take v_s as found from the samples, not as known; and the standard errors of v_s.

    Parameters
    ----------
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
