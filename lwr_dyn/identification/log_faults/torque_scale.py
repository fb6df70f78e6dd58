"""Torques in the wrong unit: a thousand times too large or too small beside the gravity of the arm's table.

    tau_j = a_j g_j(q) + friction and offset of joint j

The slope a_j is 1, give or take what the arm differs from its table; 1000 or 0.001 is a unit (mN m read as N m, or the
other way). Of a joint that carries no weight nothing can be said.
"""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.log_faults.log_fault import LogFault
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm

SLIPS = {1e-3: "in N m, read as mN m", 1e3: "in mN m, read as N m"}
"""Slopes of torques in the wrong unit, and what went wrong."""
WITHIN = 4.0
"""Factor by which a slope may miss 1 or a slip."""
EXPLAINED = 0.5
"""Share of what friction leaves of a joint's torque that the prediction must explain, or nothing is said."""
SLOW = 1e-3
"""Speed of an instant whose friction is not asked for [rad/s or m/s]."""


def torque_scale_faults(samples: Samples, arm: Arm) -> tuple[LogFault, ...]:
    """A fault for all torques in the wrong unit, or for each joint's."""
    columns = TorqueColumns(arm.chain, friction="directions")
    own = columns.own(arm)
    own[[k for j in range(arm.n) for k in range(columns.of_joint(j).start + 1, columns.of_joint(j).stop)]] = 0.0
    still = np.zeros(samples.q.shape)
    predicted = columns(samples.q, still, still) @ own
    slopes = np.array([_slope(samples, columns, predicted[:, j], j) for j in range(arm.n)])
    known = np.isfinite(slopes)
    where = ", ".join(dict.fromkeys(samples.sources))
    faults: list[LogFault] = []
    for slip, text in SLIPS.items():
        hit = known & (slopes > slip / WITHIN) & (slopes < slip * WITHIN)
        if not hit.any():
            continue
        joints = tuple((np.flatnonzero(hit) + 1).tolist())
        whole = bool((hit == known).all()) and len(joints) > 1
        names = "all torques" if whole else ", ".join(f"tau{j}" for j in joints)
        shown = ", ".join(f"{slopes[j - 1]:.3g} (joint {j})" for j in joints)
        found = f"{names} {text}: times the gravity of the table {shown}"
        needed = f"N m: --units tau={'N m' if slip < 1.0 else 'mN m'}" if whole else "one unit for all joints"
        faults.append(LogFault("unit", () if whole else joints, where, found, needed, severe=True))
    return tuple(faults)


def _slope(samples: Samples, columns: TorqueColumns, predicted: Array, joint: int) -> float:
    """a_j, NaN where it is not known."""
    rows = np.abs(samples.dq[:, joint]) > SLOW
    friction = columns.own_columns(joint, samples.dq, samples.ddq)[rows, 1:]
    beside = np.column_stack([friction[:, np.abs(friction).any(axis=0)], np.ones(len(friction))])
    if len(beside) <= beside.shape[1] + 1:
        return float("nan")
    both = np.column_stack([samples.tau[rows, joint], predicted[rows]])
    tau, part = (both - beside @ np.linalg.lstsq(beside, both, rcond=None)[0]).T
    squares = float(part @ part)
    slope = float(part @ tau) / squares if squares > 0.0 else float("nan")
    left = tau - slope * part
    return slope if float(left @ left) < (1.0 - EXPLAINED) * float(tau @ tau) else float("nan")
