"""Friction that grows with the torque that a gear carries: a share of it, beside Coulomb and viscous friction.

    tau_j = W_j b + load_j |r_j| sign(dq_j),      r = W_rigid b_rigid

r is what bodies and rotors ask of a joint, by the parameters that are looked for. So columns and parameters are found
in turn: of parameters without the term first, then of the last ones, until neither moves. The column is a predicted
torque, never a measured one: noise in a column shrinks what it is the column of. At the end

    X^T S (tau - f(b)) = 0,      X = [W, |r| sign(dq)]

with f the torques and S the weights. The slope of these equations is not -X^T S X but -M, because r moves with b:
M = X^T S J, J = df/db. So a step is that of least squares times M^-1 X^T S X (without it, parameters that a log shows
poorly swing from round to round), and the precision is M^T (X^T S X)^-1 M.

References
----------
Hamon, Gautier, Garrec, Dynamic identification of robots with a dry friction model depending on load and velocity
(2010): the model, with the torque behind the gear as the load; here with the rotor's, which torques do not always tell
from the bodies'. Huber, The behavior of maximum likelihood estimates under nonstandard conditions (1967), for the
precision.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError
from lwr_dyn.identification.regression.information import BLOCK, Information, information_of
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import LOAD, TorqueColumns

ROUNDS, SETTLED = 30, 0.01
"""Of columns and parameters in turn, at most; the change of parameters that ends them, in standard errors."""


def load_indices(columns: TorqueColumns) -> NDArray[np.intp]:
    """Columns of friction that grows with the load, (n,), or (0,) without."""
    names = [f"{LOAD}_{j + 1}" for j in range(columns.n)]
    return np.flatnonzero(np.isin(columns.names, names))


def with_load_friction(samples: Samples, columns: TorqueColumns) -> TorqueColumns:
    """The columns with friction that grows with the torques of bodies and rotors, as the samples give them.

    Raises
    ------
    LogError
        A joint that turns one way alone, where the term is a share of the joint's torque as a gain would be; or rounds
        that do not settle.
    """
    source = ", ".join(dict.fromkeys(samples.sources))
    _check_both_ways(samples, columns, source)
    if columns.carried is None:  # columns of zeros: a start without the term
        columns = replace(columns, carried=np.zeros(columns.table_indices.size))
    values, furthest = information_of(samples, columns).values, np.inf
    for _ in range(ROUNDS):
        columns = replace(columns, carried=rigid_values(columns, values))
        found = information_of(samples, columns)
        step = found.values - values
        furthest = float((np.abs(step) / found.sigma).max(initial=0.0))
        if furthest < SETTLED:
            return columns
        moving = np.eye(step.size) + found.covariance @ _weighted(found, loads_moved(samples, found, values))
        values = values + np.linalg.solve(moving, step)
    needed = "torques in which friction is a small share of what bodies ask"
    raise LogError(source, "friction with the load", f"moves by {furthest:.2g} sigma after {ROUNDS} rounds", needed)


def rigid_values(columns: TorqueColumns, values: Array) -> Array:
    """Bodies and rotors (11 n,) that have the base values (b,): those kept, 0 for all others."""
    whole = np.zeros(columns.count)
    whole[columns.base().kept] = values
    return whole[columns.table_indices]


def _check_both_ways(samples: Samples, columns: TorqueColumns, source: str) -> None:
    speeds = columns.drive_speeds(samples.dq)
    for j in range(columns.n):
        own = speeds[samples.used[:, j], j]
        if own.size and ((own > 0.0).all() or (own < 0.0).all()):
            found = f"joint {j + 1} turns one way alone, so that its friction with the load is a share of its torque"
            raise LogError(source, f"q{j + 1}", found, "a motion of the joint both ways, or no --load-friction")


def with_moving_loads(samples: Samples, information: Information) -> Information:
    """The same with errors that take the torque that a gear carries as found with the parameters, not as known."""
    moving = _weighted(information, loads_moved(samples, information, information.values))
    return replace(information, precision=moved_precision(information, moving))


def moved_precision(information: Information, moving: Array) -> Array:
    """M^T (X^T S X)^-1 M (b, b) of M = X^T S X + `moving`, which is X^T S (J - X)."""
    slope = information.precision + moving
    precision = slope.T @ information.covariance @ slope
    return np.asarray(0.5 * (precision + precision.T))


def _weighted(information: Information, moved: Array) -> Array:
    weight = np.where(information.equations > 0, np.nan_to_num(information.noise, nan=1.0) ** -2.0, 0.0)
    return np.tensordot(weight, moved, 1)


def loads_moved(samples: Samples, information: Information, values: Array) -> Array:
    """X_j^T (J_j - X_j) of each joint at base values (b,), (n, b, b), without weights.

    J - X is load sign(dq) sign(r) times the columns of bodies and rotors.
    """
    columns, kept = information.columns, information.base.kept
    rigid, share = np.isin(kept, columns.table_indices), values[np.isin(kept, load_indices(columns))]
    out = np.zeros((columns.n, kept.size, kept.size))
    for first in range(0, len(samples), BLOCK):
        part = samples.select(slice(first, first + BLOCK))
        X = columns(part.q, part.dq, part.ddq)[:, :, kept]
        change = share * np.sign(part.dq) * np.sign(X @ np.where(rigid, values, 0.0)) * part.used
        out += np.moveaxis(X, 0, 2) @ np.moveaxis(X * rigid * change[:, :, None], 0, 1)
    return out
