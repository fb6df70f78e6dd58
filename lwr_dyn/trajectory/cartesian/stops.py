"""Why an arm cannot follow a curve further: a joint at its limit, a singular position, or the end of its reach."""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind
from lwr_dyn.trajectory.cartesian.pose_curves import PoseCurve
from lwr_dyn.trajectory.cartesian.tracking import Tracked, margins, onto_pose, pose_error

LOOK_AHEAD = 0.002
"""Share of the curve ahead of the stop at which its cause is looked for."""
STARTS = 40
"""Random positions from which a place out of reach is looked for, where only the place of the tip counts."""


class PathStopError(LwrDynError, ValueError):
    """An arm cannot follow `line`: `why` is "limit", "singular" or "reach", at `share` of its way.

    `joint` is the joint at its limit.
    """

    def __init__(self, line: str, share: float, place: Array, why: str, words: str, joint: str = "") -> None:
        x, y, z = place + 0.0
        where = f"at {100.0 * share:.3g} % of its way, point ({x:.4g}, {y:.4g}, {z:.4g}) m"
        super().__init__(f"{line} stops {where}: {words}; allowed: a line that the arm can follow")
        self.line, self.share, self.why, self.joint = line, share, why, joint


def stop_of(arm: Arm, curve: PoseCurve, tracked: Tracked, turning: bool, line: str) -> PathStopError:
    """The error for a curve that was not followed to its end; `line` names it."""
    if tracked.is_whole:  # but its spline leaves the curve or the limits
        tracked = _to_least_margin(arm, tracked)
    u, q = float(tracked.u[-1]), tracked.q[-1]
    ahead = min(u + LOOK_AHEAD, 1.0)
    T = curve.poses(np.array([u, ahead]))
    if tracked.at_limit is not None:
        joint = arm.joint_names[tracked.at_limit]
        return PathStopError(line, u, T[0, :3, 3], "limit", _limit_words(arm, tracked.at_limit), joint)
    return PathStopError(line, u, T[0, :3, 3], *_cause(arm, T[1], q, turning))


def _limit_words(arm: Arm, i: int) -> str:
    unit = "rad" if arm.chain.links[i].kind is JointKind.REVOLUTE else "m"
    return f"{arm.joint_names[i]} comes to its limit ({arm.lower[i]:.4g} to {arm.upper[i]:.4g} {unit})"


def _cause(arm: Arm, T: Array, q: Array, turning: bool) -> tuple[str, str]:
    """ "singular" or "reach", with the reason."""
    _, J = pose_error(arm, T, q, turning)
    smallest = f"smallest singular value of J {np.linalg.svd(J, compute_uv=False).min():.2g}"
    if _is_reached(arm, T, turning):
        return "singular", f"the arm is singular there ({smallest}) and would have to jump to another branch"
    return "reach", f"no joint positions reach the pose behind it ({smallest})"


def _to_least_margin(arm: Arm, tracked: Tracked) -> Tracked:
    """The positions up to the one that comes nearest to a limit."""
    row, joint = np.unravel_index(int(np.argmin(margins(arm, tracked.q))), tracked.q.shape)
    return Tracked(tracked.u[: row + 1], tracked.q[: row + 1], int(joint))


def _is_reached(arm: Arm, T: Array, turning: bool) -> bool:
    """Whether any joint positions, in or out of the limits, were found for a pose."""
    if not turning:
        starts = np.random.default_rng(0).uniform(-np.pi, np.pi, (STARTS, arm.n))
        return any(np.isfinite(onto_pose(arm, T, start, turning)).all() for start in starts)
    try:
        return inverse_kinematics(arm, T, limits=False).status == "solved"
    except LwrDynError:
        return False
