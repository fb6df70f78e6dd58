"""Joints that never move in any log."""

from collections.abc import Sequence

import numpy as np

from lwr_dyn.identification.friction.cruise import position_noise
from lwr_dyn.identification.log_faults.log_fault import LogFault
from lwr_dyn.identification.logs.joint_log import JointLog

LEAST = 1e-3
"""[rad or m] of travel, in all, below which a joint stands still."""
NOISES = 12.0
"""Standard deviations of the position noise that travel must exceed."""
LONGEST = 20_000
"""Rows of a log that the noise is taken from."""


def still_joints(logs: Sequence[JointLog]) -> tuple[LogFault, ...]:
    """A fault for every joint that moves in none of the logs; one alone where no joint moves."""
    where = ", ".join(dict.fromkeys(log.source for log in logs))
    faults = []
    for j, joint in enumerate(logs[0].joints):
        travel = [float(np.ptp(log.q[:, j])) for log in logs]
        noise = max(position_noise(log.q[:LONGEST, j]) for log in logs)
        if max(travel) < max(LEAST, NOISES * noise):
            found = f"joint {joint} never moves (at most {max(travel):.2g} rad or m)"
            needed = f"a log in which joint {joint} moves both ways: its friction, rotor and most of its link stay open"
            faults.append(LogFault("still", (joint,), f"{where}: column q{joint}", found, needed))
    if len(faults) > 1 and len(faults) == len(logs[0].joints):
        needed = "a log of a motion in which every joint moves both ways"
        return (LogFault("still", logs[0].joints, f"{where}: columns q1..", "no joint ever moves", needed),)
    return tuple(faults)
