"""The axes along a path of poses: one branch of the inverse kinematics all along, inside the limits."""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.krl.motion.path_axes import NEAR
from lwr_dyn.krl.robot.kuka_pose import status, turn
from lwr_dyn.model.arm import Arm

HOME = np.radians([0.0, -90.0, 90.0, 0.0, 0.0, 0.0])
"""[rad] Where mastering is not known."""
WHOLE = 2.0 * np.pi
NEAR_ZERO = np.radians(0.01)
"""[rad] The sign of an axis this near to zero, which Turn holds, may be lost where a pose is rounded."""
TAUGHT = 1e-4
"""[rad] A solution this near to the axes is theirs."""
TOUCH = 1e-9
"""[rad] Rounding allowed at a limit."""


def followed(arm: Arm, T: Array, s: int | None, t: int | None, source: str) -> Array:
    """The axes (k, n) [rad] of flange poses T (k, 4, 4) [m] on the branch that begins nearest to mastering.

    With Status `s` and Turn `t` where they are given. Raises `OptionError` with what stops the best branch.
    """
    branches = all_branches(arm, T)
    home = np.array(arm.mastering) if arm.mastering else HOME
    found: list[tuple[bool, float, int, Array]] = []
    faults: list[tuple[float, str]] = []
    for b in range(branches.q.shape[1]):
        q, fault = _along(arm, branches.q[:, b], float(branches.reach_excess[:, b].max()), home)
        if q is not None:
            S, here = status(arm, q[0]), turn(q[0])
            if (S if s is None else s & 7) != S or here != (here if t is None else t & 63):
                q, fault = None, (1.0, f"it begins with S {S} T {here}")
        if q is None:
            faults.append(fault)
        else:
            least = float(branches.clearance[:, b, 2].min())
            found.append((least < NEAR, float(np.abs(q[0] - home).max()), b, q))
    if not found:
        raise OptionError(source, f"no branch follows it: {max(faults)[1]}", "a path inside reach and limits")
    return min(found, key=lambda x: x[:3])[3]


def _along(arm: Arm, q: Array, excess: float, home: Array) -> tuple[Array | None, tuple[float, str]]:
    """One branch without jumps, each axis in its range; or None, how far it came (0 to 1), and why it ends."""
    if excess > 0.0:
        return None, (0.0, f"out of reach by {1e3 * excess:.4g} mm")
    q = np.unwrap(q, axis=0)
    step = np.abs(np.diff(q, axis=0)).max(axis=1)
    jump = int(np.argmax(step > 0.5 * np.pi))
    if step[jump] > 0.5 * np.pi:
        return None, (jump / len(q), f"an axis turns by {np.degrees(step[jump]):.4g} deg at sample {jump + 2}")
    q = q + WHOLE * np.round((home - q[0]) / WHOLE)
    for i in range(arm.n):
        turns = [k for k in (0, -1, 1) if _inside(arm, q[:, i] + WHOLE * k, i)]
        if not turns:
            over = np.maximum(q[:, i] - arm.upper[i], arm.lower[i] - q[:, i])
            return None, (0.5, f"{arm.joint_names[i]} leaves its range by {np.degrees(over.max()):.4g} deg")
        q[:, i] += WHOLE * turns[0]
    return q, (1.0, "")


def _inside(arm: Arm, q: Array, i: int) -> bool:
    return bool(((q <= arm.upper[i] + TOUCH) & (q >= arm.lower[i] - TOUCH)).all())


def taught_axes(arm: Arm, flange: Array, q: Array, clear: float) -> Array | None:
    """The solution (n,) [rad] of a rounded pose (4, 4) [m] that is nearest to q (n,).

    None where Status and Turn would not select it for sure: nearer than `clear` [rad] to the wrist singularity, or an
    axis at zero.
    """
    branches = all_branches(arm, flange[None])
    solutions = branches.q[0] + WHOLE * np.round((q - branches.q[0]) / WHOLE)
    away = np.nan_to_num(np.abs(solutions - q).max(axis=-1), nan=np.inf)
    best = int(np.argmin(away))
    if away[best] > TAUGHT or branches.clearance[0, best, 2] < clear or np.abs(q).min() < NEAR_ZERO:
        return None
    return np.asarray(solutions[best])
