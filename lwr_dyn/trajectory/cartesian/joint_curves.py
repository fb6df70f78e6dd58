"""Smooth joint curves through the positions found along legs, their timing, and the reference made of them.

q(u) is a spline of degree 5 through the positions of a leg, so q, dq and ddq are exact derivatives of each other, and
the tip leaves the curve by what the spline rounds. That is measured between the positions, which are doubled where it
is more than `OFF_CURVE`. With u(t) = 10 x^3 - 15 x^4 + 6 x^5, x = t / duration, a leg starts and ends at rest:

    dq = q'(u) du        ddq = q''(u) du^2 + q'(u) ddu
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, make_interp_spline

from lwr_dyn.foundation.arrays import Array, real_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion
from lwr_dyn.trajectory.cartesian.pose_curves import PoseCurve
from lwr_dyn.trajectory.cartesian.tracking import Tracked, is_inside, onto_pose, pose_error
from lwr_dyn.trajectory.motion_profile import MotionProfile, quintic

OFF_CURVE = 1e-8
"""How far the tip may be off its curve between the positions that were found [m and rad]."""
DOUBLINGS = 2
SAMPLES = 20_001
"""Moments of a leg at which the joints' speeds are looked at."""
SHORTEST = 1e-3
"""[s] Least duration of a leg."""
SPEED_SHARE = 0.95
"""Share of the joints' speed limits that a leg without a given time uses: a controller needs the rest."""
ROUNDING = 1e-9
"""Relative: a duration this much below the least one was rounded when it was printed."""
PEAK_SPEED = quintic(1.0, 1.0).peaks().speed
"""Largest du/dt of a leg that takes one second."""


@dataclass(frozen=True, slots=True, eq=False)
class JointLeg:
    """A leg from rest to rest: joint positions q(u) (n,) and u(t), from 0 to 1."""

    spline: BSpline
    profile: MotionProfile

    @property
    def duration(self) -> float:
        """[s]"""
        return self.profile.duration

    def at(self, t: Array) -> Motion:
        """The motion at times t (k,) [s] from the begin of the leg."""
        u = self.profile.at(t)
        first, second = self.spline(u.s, nu=1), self.spline(u.s, nu=2)
        du, ddu = u.ds[:, None], u.dds[:, None]
        return Motion(t, self.spline(u.s), first * du, second * du**2 + first * ddu)


@dataclass(frozen=True, slots=True, eq=False)
class LegsReference:
    """Legs one after another, with a rest between them; `about` (JSON) says what they are made of."""

    legs: tuple[JointLeg, ...]
    about: Mapping[str, Any] = field(default_factory=dict)
    name: ClassVar[str] = "LegsReference"
    """In run files."""

    @property
    def duration(self) -> float:
        """[s]"""
        return float(sum(leg.duration for leg in self.legs))

    def sample(self, t: ArrayLike) -> Motion:
        """The motion at times t (k,) [s]; before 0 and after `duration` it stands still; raises `ShapeError`."""
        times = np.atleast_1d(real_array("t", t))
        begins = np.concatenate([[0.0], np.cumsum([leg.duration for leg in self.legs])])
        owner = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(self.legs) - 1)
        parts = {int(i): self.legs[i].at(times[owner == i] - begins[i]) for i in np.unique(owner)}
        n = self.legs[0].spline.c.shape[1]
        q, dq, ddq = (np.empty((len(times), n)) for _ in range(3))
        for i, part in parts.items():
            q[owner == i], dq[owner == i], ddq[owner == i] = part.q, part.dq, part.ddq
        return Motion(times, q, dq, ddq)


@dataclass(frozen=True, slots=True, eq=False)
class SmoothCurve:
    """Joint positions q(u) (n,) along a curve, and how far their tip leaves it at most [m and rad]."""

    spline: BSpline
    off: float


def smooth_curve(arm: Arm, curve: PoseCurve, tracked: Tracked, turning: bool) -> SmoothCurve | None:
    """The spline through tracked positions; None where it leaves the curve or the limits between them."""
    u, q = tracked.u, tracked.q
    for _ in range(DOUBLINGS + 1):
        spline = make_interp_spline(u, q, k=5)
        between = (u[:-1] + u[1:]) / 2.0
        off = float(np.abs(pose_error(arm, curve.poses(between), spline(between), turning)[0]).max())
        if off <= OFF_CURVE:
            return SmoothCurve(spline, off) if is_inside(arm, spline(between)) else None
        more = np.array(
            [onto_pose(arm, T, spline(x), turning) for x, T in zip(between, curve.poses(between), strict=True)]
        )
        found = np.isfinite(more).all(axis=1)
        order = np.argsort(np.concatenate([u, between[found]]))
        u, q = np.concatenate([u, between[found]])[order], np.concatenate([q, more[found]])[order]
    return None


def timed_leg(arm: Arm, spline: BSpline, wanted: float | None, least: float, where: str) -> JointLeg:
    """A leg in `wanted` [s], else in the time of at least `least` [s] that takes `SPEED_SHARE` of a limit.

    Raises
    ------
    OptionError
        A joint would have to be faster than its limit; `where` names the leg.
    """
    x = np.linspace(0.0, 1.0, SAMPLES)
    rates = np.abs(spline(x**3 * (10.0 - 15.0 * x + 6.0 * x**2), nu=1)) * (30.0 * x**2 * (1.0 - x) ** 2)[:, None]
    of_limit = (rates / arm.velocity).max(axis=0)
    joint, needed = arm.joint_names[int(np.argmax(of_limit))], float(of_limit.max())
    if wanted is None:
        return JointLeg(spline, quintic(1.0, max(least, needed / SPEED_SHARE, SHORTEST)))
    if wanted < needed * (1.0 - ROUNDING):
        found = f"{wanted:g} s, in which {joint} needs {needed / wanted:.3g} times its speed limit"
        raise OptionError(f"duration of {where}", found, f"at least {needed:.4g} s")
    return JointLeg(spline, quintic(1.0, wanted))
