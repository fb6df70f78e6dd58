"""The task `csv`: a motion that a person brings, through its rows by a spline of degree 5 in time.

q, dq and ddq are exact derivatives of each other. Noise in a file is followed like everything else: smooth it before.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, make_interp_spline

from lwr_dyn.foundation.arrays import Array, real_array
from lwr_dyn.foundation.registry import Option, Quantity
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion
from lwr_dyn.model.shown import short_repr
from lwr_dyn.trajectory.motion_profile import positive_number
from lwr_dyn.trajectory.recorded.motion_file import MotionFileError, RecordedMotion, read_motion
from lwr_dyn.trajectory.recorded.pose_motion import joints_of_poses
from lwr_dyn.trajectory.references.limits import LimitViolation, largest_violation

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
    start: Annotated[
        ArrayLike | None, Option(Quantity.JOINT_POSITIONS, "Where the joints start (m for sliding).", "from-deg")
    ] = None,
) -> RecordedReference:
    """The motion of a CSV file as a reference for the joints.

    Parameters
    ----------
    arm : Arm
    file : str
        As `lwr_dyn.trajectory.recorded.motion_file` describes it.
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
