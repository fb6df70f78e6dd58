"""The task `csv`: a motion that a person brings, through its rows by a spline of degree 5 in time.

q, dq and ddq are exact derivatives of each other. Noise in a file is followed like everything else: smooth it before.
Poses become joint positions row by row, without jumps. `trajectory.motion_files` describes the CSV file.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, make_interp_spline

from lwr_dyn.foundation.arrays import Array, fixed_array, real_array
from lwr_dyn.foundation.errors import OutOfReachError, OutsideLimitsError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.kinematics.arm_angle import best_arm_angle
from lwr_dyn.kinematics.arm_geometry import require_srs, srs_geometry
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import joint_ranges
from lwr_dyn.kinematics.srs import closed_form
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, short_repr
from lwr_dyn.trajectory.cartesian.tracking import onto_pose
from lwr_dyn.trajectory.motion_files import MotionFileError, RecordedMotion, read_motion
from lwr_dyn.trajectory.motion_profile import positive_number
from lwr_dyn.trajectory.references.position_limits import LimitViolation, largest_violation
from lwr_dyn.trajectory.references.references import StartIfGiven

STARTS = 8
"""Joint positions of the first pose that are tried where no start is given."""

JUMP = 0.5
"""[rad or m] A joint that moves further from one row to the next has jumped to another solution."""

TURN = 2.0 * np.pi


def joints_of_poses(arm: Arm, file: str, motion: RecordedMotion, start: ArrayLike | None) -> Array:
    """Joint positions (m, n) [rad or m] at the poses of a motion.

    An S-R-S arm without a given start follows the arm angle with the largest margin; others go from row to row. Raises
    `MotionFileError`: a pose that is not reached from the one before: when, and why; `ShapeError`: a start that is not
    (n,).
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


BETWEEN = 4
"""Places between two rows at which limits are checked."""

LARGE_ANGLE = 2.0 * np.pi
"""[rad] Positions beyond, in a file without units, look like degrees."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedReference:
    """A motion through given positions: q(t) is a spline of degree 5; before 0 and after its end it stands still."""

    spline: BSpline
    duration: float
    about: Mapping[str, Any] = field(default_factory=dict)
    name: ClassVar[str] = "RecordedReference"
    """In run files."""
    __repr__ = short_repr

    def sample(self, t: ArrayLike) -> Motion:
        """The motion at times t (k,) [s]; raises `ShapeError`."""
        times = np.atleast_1d(real_array("t", t))
        at = np.clip(times, 0.0, self.duration)
        moving = (times == at)[:, None]
        return Motion(times, self.spline(at), moving * self.spline(at, nu=1), moving * self.spline(at, nu=2))


def csv_reference(
    arm: Arm,
    *,
    file: Annotated[str, Option(str, "CSV: time, q1, q2, ... or time, x, y, z, roll, pitch, yaw; SI or q1 [deg].")],
    slower: Annotated[float, Option(float, "Factor on the times of the file.")] = 1.0,
    start: StartIfGiven = None,
) -> RecordedReference:
    """The motion of a CSV file as a reference for the joints.

    Parameters
    ----------
    arm : Arm
    file : str
        As `lwr_dyn.trajectory.motion_files` describes it.
    slower : float
        Factor on its times: 2 takes twice as long.
    start : (n,) array_like, optional
        [rad or m] With poses: joint positions near the first one; those with the largest margin if not given.

    Raises
    ------
    FileAccessError, MotionFileError
        The file cannot be read or is not what it should be; another number of joints; positions or speeds outside the
        limits, poses that are not reached: says when, which joint and by how much.
    OptionError, ShapeError
        `slower` not positive, a `start` of the wrong shape or with a file of joint positions.
    """
    slower = positive_number("slower", slower)
    motion = read_motion(file)
    t = slower * motion.t
    q = _positions(arm, str(file), motion, start)
    spline = make_interp_spline(t, q, k=5)
    _check_limits(arm, str(file), motion, t, spline, slower)
    ends = np.abs(spline(t[[0, -1]], nu=1)).max(axis=1)
    about = {
        "task": "csv", "file": str(file), "rows": int(t.size), "slower": slower,
        "given": "joint positions" if motion.poses is None else "poses", "left_out": list(motion.left_out),
        "speed_at_ends": ends.tolist(),
    }  # fmt: skip
    return RecordedReference(spline, float(t[-1]), about)


def _positions(arm: Arm, file: str, motion: RecordedMotion, start: ArrayLike | None) -> Array:
    if motion.joints is None:
        return joints_of_poses(arm, file, motion, start)
    if motion.joints.shape[1] != arm.n:
        raise MotionFileError(file, "columns", f"q1 to q{motion.joints.shape[1]}", f"q1 to q{arm.n} for {arm.name}")
    if start is not None:
        raise MotionFileError(file, "start", "given with joint positions", "a file of poses, or no start")
    return motion.joints


def _check_limits(arm: Arm, file: str, motion: RecordedMotion, t: Array, spline: BSpline, slower: float) -> None:
    shares = np.arange(BETWEEN + 1) / (BETWEEN + 1)
    places = np.append((t[:-1, None] + np.diff(t)[:, None] * shares).ravel(), t[-1])
    outside = largest_violation(arm, spline(places))
    if outside is not None:
        where = f"t = {places[outside.row] / slower:.6g} s"
        raise MotionFileError(file, where, outside.fault, f"{outside.allowed}{_degrees_hint(motion, outside)}")
    share = np.abs(spline(places, nu=1)) / arm.velocity
    row, joint = np.unravel_index(int(np.argmax(share)), share.shape)
    if share[row, joint] > 1.0:
        found = f"{arm.joint_names[joint]} at {share[row, joint]:.3g} times its speed limit"
        least = float(np.ceil(100.0 * slower * share[row, joint]) / 100.0)
        raise MotionFileError(file, f"t = {places[row] / slower:.6g} s", found, f"slower motion: --slower {least:g}")


def _degrees_hint(motion: RecordedMotion, outside: LimitViolation) -> str:
    if motion.joints is None or motion.in_degrees or np.abs(motion.joints).max() <= LARGE_ANGLE:
        return ""
    return "; are these degrees? then q1 [deg] in the header"
