"""A reference for the joints from a timed pose path, the arm's inverse kinematics and an arm angle.

The arm angle along the path is the best curve, one fixed angle, or a curve that is given.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, real_array
from lwr_dyn.foundation.errors import OptionError, OutOfReachError, OutsideLimitsError, PathLimitError, SingularArmError
from lwr_dyn.kinematics.arm_angle import ArmAngleCurve, best_arm_angle
from lwr_dyn.kinematics.arm_geometry import require_srs
from lwr_dyn.kinematics.solution import BRANCHES, TURN, Branch, joint_ranges
from lwr_dyn.kinematics.srs import arm_triangle, closed_form, follow
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, short_repr
from lwr_dyn.trajectory.pose_path import TimedPosePath
from lwr_dyn.trajectory.references.position_limits import LimitMargin, largest_violation, limit_margin

PLACES = 1401
"""Places on the path at which the arm angle is chosen: 1 mm apart on IST."""


class ArmAngle(Protocol):
    """An arm angle along a path, and the branch of the inverse kinematics it belongs to."""

    @property
    def branch(self) -> Branch:
        """Signs of shoulder, elbow and wrist."""

    @property
    def reference(self) -> Array | None:
        """The direction (3,) from which the angle is measured; None for the arm's own."""

    def evaluate(self, s: Array) -> tuple[Array, Array, Array]:
        """psi, dpsi/ds, d2psi/ds2 at lengths s (k,) [rad, rad/m, rad/m^2]."""


@dataclass(frozen=True, slots=True, eq=False)
class FixedArmAngle:
    """The same arm angle `psi` [rad] all along, on a given branch."""

    psi: float
    branch: Branch
    reference: Array | None = None

    def evaluate(self, s: Array) -> tuple[Array, Array, Array]:
        """psi, dpsi/ds, d2psi/ds2 at lengths s (k,)."""
        still = np.zeros(len(s))
        return np.full(len(s), self.psi), still, still


def choose_arm_angle(arm: Arm, poses: TimedPosePath, wanted: float | ArmAngle | None) -> tuple[ArmAngle, str]:
    """The arm angle for a path, and how it was chosen; `wanted` and the errors are those of `pose_path_reference`."""
    if wanted is None:
        curve = _best(arm, poses)
        how = "the curve of the largest joint-limit margin; the paper's own is not known"
        return curve, "; ".join(filter(None, (how, curve.one_turn)))
    if isinstance(wanted, float | int | np.number):
        return _fixed(arm, poses, float(wanted)), f"{float(wanted)!r} rad all along, given"
    return wanted, "a curve, given"


def place_at(poses: TimedPosePath, t: float) -> str:
    """The point of the path at time t [s], in words."""
    x, y, z = poses.at(t).T[0, :3, 3] + 0.0
    return f"point ({x:.4g}, {y:.4g}, {z:.4g}) m"


def _best(arm: Arm, poses: TimedPosePath) -> ArmAngleCurve:
    s = _places(poses)
    try:
        return best_arm_angle(arm, s, poses.poses(s))
    except OutOfReachError as fault:
        raise out_of_reach(poses, _when(poses, fault.at), fault.distance) from fault
    except OutsideLimitsError as fault:
        when = _when(poses, fault.at)
        fault_text = f"no arm angle keeps {fault.joint} within its limits, {fault.excess:.3g} rad outside ({fault.why})"
        allowed = "a path inside the position limits"
        raise PathLimitError(when, place_at(poses, when), fault_text, allowed, fault.joint, fault.excess) from fault


def _fixed(arm: Arm, poses: TimedPosePath, psi: float) -> FixedArmAngle:
    """The branch whose smallest margin over the path is the largest."""
    if not math.isfinite(psi):
        raise OptionError("arm_angle", repr(psi), "a finite number of radians")
    geometry, ranges, s = require_srs(arm), joint_ranges(arm), _places(poses)
    T = poses.poses(s)
    excess = arm_triangle(geometry, T).reach_excess
    if np.any(excess > 0.0):
        worst = int(np.argmax(excess))
        raise out_of_reach(poses, _when(poses, float(s[worst])), float(excess[worst]))
    angles = np.full(len(s), psi)
    margins = [limit_margin(arm, s, closed_form(geometry, ranges, T, angles, branch)).margin for branch in BRANCHES]
    return FixedArmAngle(psi, BRANCHES[int(np.argmax(margins))])


def _places(poses: TimedPosePath) -> Array:
    """Lengths along the path; every joint between two segments is one of them."""
    starts = poses.path.starts
    gap = poses.length / (PLACES - 1)
    parts = [np.linspace(a, b, max(math.ceil((b - a) / gap), 1), endpoint=False) for a, b in pairwise(starts)]
    return np.concatenate([*parts, starts[-1:]])


def out_of_reach(poses: TimedPosePath, when: float, distance: float) -> PathLimitError:
    """The error for a wrist out of reach at time `when` [s], by `distance` [m]."""
    fault = f"the wrist is {distance:.3g} m out of reach"
    return PathLimitError(when, place_at(poses, when), fault, "a path within reach of the arm")


def _when(poses: TimedPosePath, s: float) -> float:
    """The time [s] at which the profile reaches s [m], by bisection: s never falls."""
    if s <= 0.0:
        return 0.0
    low, high = 0.0, poses.duration
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if poses.profile.at(middle).s[0] < s else (low, middle)
    return high


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
