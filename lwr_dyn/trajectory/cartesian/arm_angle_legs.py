"""Legs of an S-R-S arm that may begin anywhere: the arm angle with the largest margin over the whole way."""

import math
from collections.abc import Sequence

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OutOfReachError, OutsideLimitsError
from lwr_dyn.kinematics.arm_angle import best_arm_angle
from lwr_dyn.kinematics.arm_geometry import require_srs
from lwr_dyn.kinematics.branches import joint_ranges
from lwr_dyn.kinematics.srs import closed_form
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.cartesian.pose_curves import PoseCurve
from lwr_dyn.trajectory.cartesian.stops import PathStopError
from lwr_dyn.trajectory.cartesian.tracking import Tracked, places_on


def best_legs(arm: Arm, curves: Sequence[PoseCurve], names: Sequence[str]) -> list[Tracked]:
    """Joint positions along all curves, one after the other, from `kinematics.arm_angle.best_arm_angle`.

    Raises
    ------
    PathStopError
        The wrist is out of reach, or no arm angle keeps the limits; `names` name the curves.
    OptionError
        Not an S-R-S arm, or the wrist passes the axis of joint 1, where the arm angle has no zero.
    """
    places = [places_on(curve) for curve in curves]
    s = np.concatenate([[0.0], *(k + u[1:] for k, u in enumerate(places))])
    T = np.concatenate([curves[0].poses(np.zeros(1)), *(c.poses(u[1:]) for c, u in zip(curves, places, strict=True))])
    try:
        best = best_arm_angle(arm, s, T)
    except OutOfReachError as fault:
        words = f"the wrist is {fault.distance:.3g} m out of reach"
        raise _stop(curves, names, fault.at, "reach", words) from None
    except OutsideLimitsError as fault:
        words = f"no arm angle keeps {fault.joint} within its limits, {fault.excess:.3g} rad outside ({fault.why})"
        raise _stop(curves, names, fault.at, "limit", words, fault.joint) from None
    q = closed_form(require_srs(arm), joint_ranges(arm), T, best.evaluate(s)[0], best.branch)
    ends = np.cumsum([0, *(len(u) - 1 for u in places)])
    return [Tracked(u, q[a : b + 1]) for u, a, b in zip(places, ends, ends[1:], strict=False)]


def _stop(
    curves: Sequence[PoseCurve], names: Sequence[str], at: float, why: str, words: str, joint: str = ""
) -> PathStopError:
    leg = max(math.ceil(at) - 1, 0)
    place: Array = curves[leg].poses(np.array([at - leg]))[0, :3, 3]
    return PathStopError(names[leg], at - leg, place, why, words, joint)
