"""Torques in the wrong unit: a thousand times too large or too small beside what the arm's table predicts.

    tau_j = a_j (Y pi_table)_j + friction and offset of joint j

The slope a_j is 1, give or take what the arm differs from its table; 1000 or 0.001 is a unit (mN m read as N m, or the
other way). Of a joint whose torque is nearly all friction nothing can be said.
"""

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.identification.log_faults.log_fault import LogFault
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm

SLIPS = {1e-3: "in N m, read as mN m", 1e3: "in mN m, read as N m"}
"""Slopes of torques in the wrong unit, and what went wrong."""
WITHIN = 4.0
"""Factor by which a slope may miss 1 or a slip."""
SIGMAS = 6.0
"""Standard errors by which a slope must differ from 0."""
SLOW = 1e-3
"""Speed of an instant whose friction is not asked for [rad/s or m/s]."""


def torque_scale_faults(samples: Samples, arm: Arm) -> tuple[LogFault, ...]:
    """A fault for all torques in the wrong unit, or for each joint's."""
    columns = TorqueColumns(arm.chain, friction="directions")
    own = columns.own(arm)
    own[[k for j in range(arm.n) for k in range(columns.of_joint(j).start + 1, columns.of_joint(j).stop)]] = 0.0
    predicted = columns(samples.q, samples.dq, samples.ddq) @ own
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
        found = f"{names} {text}: times the torques of the table {shown}"
        needed = f"N m: --units tau={'N m' if slip < 1.0 else 'mN m'}" if whole else "one unit for all joints"
        faults.append(LogFault("unit", () if whole else joints, where, found, needed, severe=True))
    return tuple(faults)


def _slope(samples: Samples, columns: TorqueColumns, predicted: Array, joint: int) -> float:
    """a_j, NaN where it is not known."""
    rows = np.abs(samples.dq[:, joint]) > SLOW
    friction = columns.own_columns(joint, samples.dq, samples.ddq)[rows, 1:]
    X = np.column_stack([predicted[rows], friction[:, np.abs(friction).any(axis=0)]])
    size = np.linalg.norm(X, axis=0)
    if len(X) <= X.shape[1] or not size.all():
        return float("nan")
    inverse = np.linalg.pinv(X / size)
    values = inverse @ samples.tau[rows, joint]
    left = samples.tau[rows, joint] - X / size @ values
    error = np.sqrt(left @ left / (len(X) - X.shape[1])) * np.linalg.norm(inverse[0])
    return float(values[0] / size[0]) if abs(values[0]) > SIGMAS * error else float("nan")
