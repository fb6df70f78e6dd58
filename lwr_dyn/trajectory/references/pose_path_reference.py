"""A reference for the joints from a timed pose path, the arm's inverse kinematics and an arm angle."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, real_array
from lwr_dyn.foundation.errors import OutOfReachError, PathLimitError, SingularArmError
from lwr_dyn.kinematics.branches import TURN, joint_ranges
from lwr_dyn.kinematics.path_following import follow
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion
from lwr_dyn.model.shown import short_repr
from lwr_dyn.trajectory.pose_path import TimedPosePath
from lwr_dyn.trajectory.references.arm_angles import ArmAngle, choose_arm_angle, out_of_reach, place_at
from lwr_dyn.trajectory.references.limits import LimitMargin, largest_violation, limit_margin

TIMES = 1401
"""Times at which the position limits are checked, besides the knots of the profile: 10 ms apart on IST."""


@dataclass(frozen=True, slots=True, eq=False)
class PosePathReference:
    """A path of poses as a reference for the joints; q, dq, ddq are exact derivatives.

    `poses` is the path in space with its timing, `arm_angle` the arm angle along it, `nearest_limit` where the
    motion comes nearest to a position limit, and `about` (JSON) says what is printed, assumed or estimated.
    """

    arm: Arm
    poses: TimedPosePath
    arm_angle: ArmAngle
    nearest_limit: LimitMargin
    about: Mapping[str, Any] = field(default_factory=dict)
    turns: "_WholeTurns | None" = None
    """Where a joint goes beyond half a turn from the middle of its range; None where none does."""
    name: ClassVar[str] = "TaskReference"
    """In run files."""
    __repr__ = short_repr

    @property
    def duration(self) -> float:
        """[s]"""
        return self.poses.duration

    @property
    def margin(self) -> float:
        """Smallest distance from a position limit [rad]."""
        return self.nearest_limit.margin

    def sample(self, t: ArrayLike) -> Motion:
        """The motion at times t (k,) [s]; before 0 and after `duration` it stands still; raises `ShapeError`."""
        motion = _motion(self.arm, self.poses, self.arm_angle, np.atleast_1d(real_array("t", t)))
        return motion if self.turns is None else replace(motion, q=self.turns.added(motion.t, motion.q))

    def trace(self, places: int = TIMES) -> Array:
        """Points (places, 3) [m] of the path in the base frame, evenly spaced."""
        return self.poses.path.at(np.linspace(0.0, self.poses.length, places)).p


@dataclass(frozen=True, slots=True, eq=False)
class _WholeTurns:
    """Positions q (k, n) [rad] without jumps at times t (k,) [s]: they say which whole turn a joint is in."""

    t: Array
    q: Array

    @classmethod
    def of(cls, arm: Arm, t: Array, q: Array) -> "_WholeTurns | None":
        """From positions that may jump by whole turns; None where none does."""
        through = np.unwrap(q, axis=0)
        if (through == q).all():
            return None
        ranges, middle = joint_ranges(arm), (through.min(axis=0) + through.max(axis=0)) / 2.0
        jumps = (through != q).any(axis=0) & np.isfinite(ranges.half)
        return cls(t, through + np.where(jumps, TURN * np.round((ranges.middle - middle) / TURN), 0.0))

    def added(self, t: Array, q: Array) -> Array:
        """Positions q (m, n) of the closed form at times t (m,), each in its whole turn."""
        near = np.column_stack([np.interp(t, self.t, column) for column in self.q.T])
        return np.asarray(q + TURN * np.round((near - q) / TURN))


def pose_path_reference(
    arm: Arm,
    poses: TimedPosePath,
    arm_angle: float | ArmAngle | None = None,
    about: Mapping[str, Any] | None = None,
    limits: bool = True,
) -> PosePathReference:
    """A timed pose path of the flange as a reference for the joints of an S-R-S arm.

    Parameters
    ----------
    arm : Arm
    poses : TimedPosePath
        Of the flange, in the arm's base frame.
    arm_angle : float or ArmAngle, optional
        [rad], the same all along, on the branch with the largest margin; or a curve. If not given, the curve of
        `best_arm_angle`: the one that keeps the largest joint-limit margin.
    about : mapping, optional
        What a run file says about the task.
    limits : bool
        False lets a fixed or given arm angle leave the position limits, to study a path that may have been followed
        without them: the margin is then negative, and `about` says so.

    Raises
    ------
    OptionError
        The arm is no S-R-S arm, or the arm angle is not finite.
    PathLimitError
        The path leaves the reach or the position limits; says when, where, which joint and by how much.
    SingularArmError
        The path passes a singularity at speed.
    """
    curve, how = choose_arm_angle(arm, poses, arm_angle)
    t = np.union1d(np.linspace(0.0, poses.duration, TIMES), poses.profile.knots)
    q = _placed_motion(arm, poses, curve, t).q
    turns = _WholeTurns.of(arm, t, q)
    q = q if turns is None else turns.q
    outside = largest_violation(arm, q)
    if limits and outside is not None:
        when = float(t[outside.row])
        where = place_at(poses, when)
        raise PathLimitError(when, where, outside.fault, outside.allowed, outside.joint, outside.excess)
    nearest = limit_margin(arm, t, q)
    record = {
        **(about or {}),
        "arm_angle": {"value": how, "branch": curve.branch.label, "kind": "assumed"},
        "margin": _margin_record(nearest, outside is None),
    }
    return PosePathReference(arm, poses, curve, nearest, record, turns)


def _margin_record(nearest: LimitMargin, kept: bool) -> dict[str, Any] | None:
    """None where the arm has no limits: JSON has no infinity."""
    if not np.isfinite(nearest.margin):
        return None
    return {"value": nearest.margin, "joint": nearest.joint, "t": nearest.t, "limits_kept": kept}


def _placed_motion(arm: Arm, poses: TimedPosePath, curve: ArmAngle, t: Array) -> Motion:
    """`_motion`, with errors that say when and where instead of the row."""
    try:
        return _motion(arm, poses, curve, t)
    except OutOfReachError as fault:
        raise out_of_reach(poses, float(t[int(fault.at)]), fault.distance) from fault
    except SingularArmError as fault:
        when = float(t[fault.index])
        raise SingularArmError(fault.index, f"{fault.why} at t = {when:.6g} s, {place_at(poses, when)}") from fault


def _motion(arm: Arm, poses: TimedPosePath, curve: ArmAngle, t: Array) -> Motion:
    """psi is a function of the length s, so dpsi/dt = psi' ds and d2psi/dt2 = psi'' ds^2 + psi' dds."""
    at = poses.at(t)
    ds, dds = at.profile.ds, at.profile.dds
    psi, slope, bend = curve.evaluate(at.profile.s)
    rates = (slope * ds, bend * ds**2 + slope * dds)
    q, dq, ddq = follow(
        arm, curve.branch, at.T, at.velocity, at.acceleration, psi, *rates, reference=curve.reference
    )  # fmt: skip
    return Motion(t, q, dq, ddq)
