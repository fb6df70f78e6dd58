"""Torques that never change while their joint moves: a sensor that is off, a column never written, or always a bound.

A torque cut off below the friction of its joint is at one bound or the other all the time, and measures nothing.
"""

from collections.abc import Sequence

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.log_faults.log_fault import LogFault
from lwr_dyn.identification.log_faults.still_joints import still_joints
from lwr_dyn.identification.logs.joint_log import JointLog

AT_ENDS = 0.95
"""Share of rows at its least or its largest value from which a torque is one that measures nothing."""


def silent_torques(logs: Sequence[JointLog]) -> tuple[LogFault, ...]:
    """A severe fault for all joints that move and whose torque has one value, or two, in all logs.

    Torques cut out do not count. A joint that stands still may well have one torque: `still_joints` says that.
    """
    moving = set(logs[0].joints) - {joint for fault in still_joints(logs) for joint in fault.joints}
    silent: dict[int, str] = {}
    for j, joint in enumerate(logs[0].joints):
        tau = np.concatenate([log.tau[:, j] for log in logs])
        ends = _ends(tau[np.isfinite(tau)]) if joint in moving else ""
        if ends:
            silent[joint] = ends
    if not silent:
        return ()
    where = ", ".join(dict.fromkeys(log.source for log in logs))
    names = ", ".join(f"tau{joint}" for joint in silent)
    values = ", ".join(silent.values())
    several = len(silent) > 1
    found = f"{names} never change{'' if several else 's'} ({values} N m or N) while the joint{'s' * several} moved"
    return (LogFault("silent", tuple(silent), where, found, "torques of a sensor that measures", severe=True),)


def _ends(tau: Array) -> str:
    """The value that a torque always has, or the two; empty for others."""
    if tau.size == 0:
        return ""
    low, high = float(tau.min()) + 0.0, float(tau.max()) + 0.0  # 0.0: not -0
    if low == high:
        return f"{low:g}"
    return f"{low:g} or {high:g}" if float(np.mean((tau == low) | (tau == high))) >= AT_ENDS else ""
