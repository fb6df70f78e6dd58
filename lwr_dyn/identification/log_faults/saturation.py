"""Saturated torques: rows in which a torque stands at a bound, so that it is not what moved the arm; cut out, and said.

A bound is the limit of the joint, or a level at which the recorded torque itself is cut off: its largest value comes
far more often than those next to it.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.log_faults.log_fault import LogFault
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.model.arm import Arm

AT_LIMIT = 0.999
"""Share of a joint's limit from which a torque counts as saturated."""
OFTEN = 8
"""Rows at the largest value, and times the rows of the values next to it, from which on it is a level.

The peak of a smooth torque in counts has three times the rows of the counts below it.
"""
NEXT = 3
"""Values next to the largest that it is compared with."""
FEW = 20
"""Different values a torque must have for that."""


def saturated_rows(log: JointLog, arm: Arm | None = None) -> NDArray[np.bool_]:
    """Which torques (k, n) of a log are at a bound; the joint's limit counts where the arm is given."""
    out = np.zeros(log.tau.shape, dtype=bool)
    for j in range(log.tau.shape[1]):
        tau = log.tau[:, j]
        out[:, j] = _at_level(tau) | _at_level(-tau)
        if arm is not None and np.isfinite(arm.effort[j]):
            with np.errstate(invalid="ignore"):
                out[:, j] |= np.abs(tau) >= AT_LIMIT * arm.effort[j]
    return out


def _at_level(tau: Array) -> NDArray[np.bool_]:
    """Rows at the largest value, if it comes too often for a peak."""
    none = np.zeros(tau.size, dtype=bool)
    known = tau[np.isfinite(tau)]
    if known.size == 0:
        return none
    at = np.equal(tau, float(known.max()))
    count = int(at.sum())
    if count < OFTEN:
        return none
    values, rows = np.unique(known, return_counts=True)
    beside = float(rows[-1 - NEXT : -1].mean()) if values.size > NEXT else 1.0
    if values.size < FEW or count < OFTEN * beside:
        return none
    return np.asarray(at)


def cut_saturated(log: JointLog, arm: Arm | None = None) -> tuple[JointLog, tuple[LogFault, ...]]:
    """The log with NaN for its saturated torques, which the regression leaves out, and what was cut, joint by joint."""
    rows = saturated_rows(log, arm)
    if not rows.any():
        return log, ()
    faults = []
    for j in np.flatnonzero(rows.any(axis=0)):
        level = float(np.abs(log.tau[rows[:, j], j]).min())
        count, first = int(rows[:, j].sum()), int(np.argmax(rows[:, j]))
        whole = rows[:, j].mean()
        found = f"{count} rows ({whole:.1%}, first {first + 1}) at {level:.4g} or beyond, cut out"
        needed = "torques below the bound: a slower or shorter motion"
        faults.append(
            LogFault("saturated", (int(log.joints[j]),), f"{log.source}: column tau{log.joints[j]}", found, needed)
        )
    tau = np.where(rows, np.nan, log.tau)
    return replace(log, tau=tau, notes=(*log.notes, *map(str, faults))), tuple(faults)
