"""The arm angle along a path: the best curve, one fixed angle, or a curve that is given."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, OutOfReachError, OutsideLimitsError, PathLimitError
from lwr_dyn.kinematics.arm_angle import ArmAngleCurve, best_arm_angle
from lwr_dyn.kinematics.arm_geometry import require_srs
from lwr_dyn.kinematics.branches import BRANCHES, Branch, joint_ranges
from lwr_dyn.kinematics.srs import arm_triangle, closed_form
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.pose_path import TimedPosePath
from lwr_dyn.trajectory.references.limits import limit_margin

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


class ChosenArmAngle(NamedTuple):
    """An arm angle, and how it was chosen, in words."""

    curve: ArmAngle
    how: str


def choose_arm_angle(arm: Arm, poses: TimedPosePath, wanted: float | ArmAngle | None) -> ChosenArmAngle:
    """The arm angle for a path; `wanted` and the errors are those of `pose_path_reference`."""
    if wanted is None:
        curve = _best(arm, poses)
        how = "the curve of the largest joint-limit margin; the paper's own is not known"
        return ChosenArmAngle(curve, "; ".join(filter(None, (how, curve.one_turn))))
    if isinstance(wanted, float | int | np.number):
        return ChosenArmAngle(_fixed(arm, poses, float(wanted)), f"{float(wanted)!r} rad all along, given")
    return ChosenArmAngle(wanted, "a curve, given")


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
