"""The axes along a path: one branch of the inverse kinematics, and the faults on it."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.krl.diagnostics import Report
from lwr_dyn.krl.motion.pose_paths import TURN
from lwr_dyn.model.arm import Arm

NEAR = np.radians(1.0)
"""[rad] With A5 this near to 0 on a path, axes 4 and 6 are in line."""
FLIP = np.radians(90.0)
"""[rad] A4 or A6 that turns by more between two samples of a path has flipped."""


@dataclass(frozen=True, slots=True, eq=False)
class AxisTable:
    """The axes (m, n) [rad] along a path, on one branch of the inverse kinematics."""

    branch: int
    q: Array


def axes_along(arm: Arm, start: Array, flange: Array, along: Array, report: Report) -> AxisTable | None:
    """The axes from `start` (n,) [rad] through flange poses (m, 4, 4) at shares `along` (m,) of a path.

    None with a fault that is reported: reach, a wrist that flips or is singular, limits.
    """
    solutions = all_branches(arm, flange)
    away = np.abs((solutions.q[0] - start + np.pi) % TURN - np.pi).max(axis=-1)
    branch = int(np.nanargmin(np.where(np.isnan(away), np.inf, away)))
    excess = solutions.reach_excess[:, branch]
    if (excess > 0.0).any():
        k = int(np.argmax(excess))
        message = f"the path is out of reach by {1e3 * excess[k]:.4g} mm, {100 * along[k]:.0f} % along"
        report("error", "out-of-reach", message, "move the points nearer, or go there by PTP")
        return None
    wrist = solutions.clearance[:, branch, 2]
    passed = int(np.argmin(wrist))
    q = np.unwrap(np.vstack([start, solutions.q[:, branch]]), axis=0)[1:]
    if wrist[passed] < NEAR:
        place = f"{100 * along[passed]:.0f} % along (A5 {degrees_text(q[passed, 4])} deg)"
        report(
            "error",
            "singularity",
            f"the path passes the wrist singularity {place}",
            "go there by PTP, or tilt the tool",
        )
    if np.abs(q[0] - start).max() > 1e-6:
        if wrist[passed] >= NEAR:
            report("error", "singularity", "the path begins where axes are not determined", "leave the place by PTP")
        return None
    fit = _no_flip(q, along, report) and inside_limits(arm, q, report)
    return AxisTable(branch, q) if fit else None


def _no_flip(q: Array, along: Array, report: Report) -> bool:
    step = np.abs(np.diff(q[:, [3, 5]], axis=0))
    k, axis = np.unravel_index(int(np.argmax(step)), step.shape)
    if step[k, axis] <= FLIP:
        return True
    name = ("A4", "A6")[int(axis)]
    message = (
        f"the wrist flips: {name} turns by {degrees_text(step[k, axis])} deg at once, {100 * along[k]:.0f} % along"
    )
    report("error", "wrist-flip", message, "go there by PTP, or keep A5 away from 0")
    return False


def inside_limits(arm: Arm, q: Array, report: Report) -> bool:
    """Whether the axes q (m, n) at even steps along a path are inside their ranges; if not, it is reported."""
    over = np.maximum(q - arm.upper, arm.lower - q)
    k, i = np.unravel_index(int(np.argmax(over)), over.shape)
    if over[k, i] <= 1e-9:
        return True
    along = 100.0 * k / max(len(q) - 1, 1)
    message = (
        f"{arm.joint_names[int(i)]} leaves its range by {degrees_text(over[k, i])} deg, {along:.0f} % along the path"
    )
    report("error", "outside-limits", message, "another Status at the start, or a PTP")
    return False


def degrees_text(x: float) -> str:
    """An angle [rad] in deg, for a message."""
    return f"{np.degrees(x):.4g}"
