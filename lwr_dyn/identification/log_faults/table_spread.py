"""How far the parameters of an arm may be off its table, roughly: what a log must beat to say anything."""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm

DEVIATION = 0.5
"""Share of a link's mass, mass times reach, mass times reach squared."""
REACH = 0.15
"""[m] of a link's mass about its frame."""
EFFORT = 100.0
"""[N m or N] for a joint without a known limit."""


def efforts(arm: Arm) -> Array:
    """Limits of torque (n,) with `EFFORT` where they are not known."""
    return np.where(np.isfinite(arm.effort), arm.effort, EFFORT)


def table_spread(columns: TorqueColumns, arm: Arm, friction: float) -> Array:
    """Standard deviations (p,) of all parameters about the table; of friction and offset a share of the joint's limit.

    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("lwr4plus")
    >>> table_spread(TorqueColumns(arm.chain), arm, 0.05)[70:74].round(2)
    array([1. , 8.8, 8.8, 8.8])
    """
    own, n = columns.own(arm), columns.n
    masses = own[: columns.bodies : 10]
    known = masses[masses > 0.0]
    usual = np.where(masses > 0.0, masses, known.mean() if known.size else 1.0)
    by_kind = np.array([1.0, *[REACH] * 3, *[REACH**2] * 6])
    spread = np.empty(columns.count)
    spread[: columns.bodies] = (DEVIATION * usual[:, None] * by_kind).reshape(-1)
    for j in range(n):
        spread[columns.of_joint(j)] = friction * efforts(arm)[j]
    spread[columns.rotor_indices] = 1.0 + own[columns.rotor_indices]
    return spread
