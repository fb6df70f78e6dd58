"""Joint positions for the poses of a recorded motion, row by row, without jumps."""

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import OutOfReachError, OutsideLimitsError
from lwr_dyn.kinematics.arm_angle import best_arm_angle
from lwr_dyn.kinematics.arm_geometry import require_srs, srs_geometry
from lwr_dyn.kinematics.branches import joint_ranges
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.srs import closed_form
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.cartesian.tracking import onto_pose
from lwr_dyn.trajectory.recorded.motion_file import MotionFileError, RecordedMotion

STARTS = 8
"""Joint positions of the first pose that are tried where no start is given."""
JUMP = 0.5
"""[rad or m] A joint that moves further from one row to the next has jumped to another solution."""
TURN = 2.0 * np.pi


def joints_of_poses(arm: Arm, file: str, motion: RecordedMotion, start: ArrayLike | None) -> Array:
    """Joint positions (m, n) [rad or m] at the poses of a motion.

    An S-R-S arm without a given start follows the arm angle with the largest margin; others go from row to row.

    Raises
    ------
    MotionFileError
        A pose that is not reached from the one before: when, and why.
    ShapeError
        A start that is not (n,).
    """
    poses = np.zeros((0, 4, 4)) if motion.poses is None else motion.poses
    if start is not None:
        return _followed(arm, file, motion.t, poses, fixed_array("start", start, (arm.n,)))
    if srs_geometry(arm.chain) is not None:
        return _at_best_arm_angle(arm, file, motion.t, poses)
    first = inverse_kinematics(arm, poses[0]).solutions[:STARTS]
    fault = MotionFileError(file, "t = 0 s", "the arm does not reach the pose", "poses within reach and limits")
    furthest = -1.0
    for solution in first:
        try:
            return _followed(arm, file, motion.t, poses, solution.q)
        except _RowError as stop:
            if stop.t > furthest:
                furthest, fault = stop.t, stop
    raise fault


class _RowError(MotionFileError):
    """The pose at time `t` [s] is not reached from the one before."""

    def __init__(self, file: str, t: float, found: str) -> None:
        super().__init__(file, f"t = {t:.6g} s", found, "poses within reach and limits, close to each other")
        self.t = t


def _at_best_arm_angle(arm: Arm, file: str, t: Array, poses: Array) -> Array:
    try:
        best = best_arm_angle(arm, t, poses)
    except OutOfReachError as fault:
        raise _RowError(file, fault.at, f"the wrist is {fault.distance:.3g} m out of reach") from None
    except OutsideLimitsError as fault:
        found = f"no arm angle keeps {fault.joint} within its limits, {fault.excess:.3g} rad outside"
        raise _RowError(file, fault.at, found) from None
    q = closed_form(require_srs(arm), joint_ranges(arm), poses, best.evaluate(t)[0], best.branch)
    return _without_jumps(arm, file, t, np.unwrap(q, axis=0))


def _followed(arm: Arm, file: str, t: Array, poses: Array, start: Array) -> Array:
    out = np.empty((t.size, arm.n))
    near = start
    for k, T in enumerate(poses):
        near = onto_pose(arm, T, near, turning=True)
        if not np.isfinite(near).all():
            raise _RowError(file, float(t[k]), "the arm does not reach the pose from the one before")
        out[k] = near
    return _without_jumps(arm, file, t, out)


def _without_jumps(arm: Arm, file: str, t: Array, q: Array) -> Array:
    steps = np.abs(np.diff(q, axis=0))
    row, joint = np.unravel_index(int(np.argmax(steps)), steps.shape)
    if steps[row, joint] > JUMP:
        found = f"{arm.joint_names[joint]} would move by {steps[row, joint]:.3g} (rad or m) from the row before"
        raise _RowError(file, float(t[row + 1]), found)
    return q
