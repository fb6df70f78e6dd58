"""Legs one after another: through the space of the tip, or through joint positions, each with its time.

q(u) is a spline of degree 5 through the positions of a leg, so q, dq and ddq are exact derivatives of each other, and
the tip leaves the curve by what the spline rounds. That is measured between the positions, which are doubled where it
is more than `OFF_CURVE`. With u(t) = 10 x^3 - 15 x^4 + 6 x^5, x = t / duration, a leg starts and ends at rest:

    dq = q'(u) du        ddq = q''(u) du^2 + q'(u) ddu
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, make_interp_spline

from lwr_dyn.foundation.arrays import Array, real_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.arm_geometry import srs_geometry
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion
from lwr_dyn.trajectory.cartesian import tracking
from lwr_dyn.trajectory.cartesian.tracking import PathStopError, Tracked, is_inside, onto_pose
from lwr_dyn.trajectory.motion_files import WaypointError, Waypoints
from lwr_dyn.trajectory.motion_profile import MotionProfile, quintic
from lwr_dyn.trajectory.pose_path import PoseCurve, steps_between, straight, through
from lwr_dyn.trajectory.references.position_limits import largest_violation

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
        off = float(np.abs(tracking.pose_error(arm, curve.poses(between), spline(between), turning)[0]).max())
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

    Raises `OptionError`: a joint would have to be faster than its limit; `where` names the leg.
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


STARTS = 8
"""Joint positions of the first waypoint that are tried when no start is given."""

MOMENTS = 4001
"""Moments of a curve between which the speed of the tip is looked at."""

DENSE = 400
"""Places at which a smooth curve through joint positions is checked against the limits."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseLeg:
    """One leg in space, its duration [s] where it is given, and its name in messages."""

    curve: PoseCurve
    duration: float | None
    name: str


@dataclass(frozen=True, slots=True)
class Pace:
    """Largest speeds of the tip [m/s, rad/s], and whether its orientation follows the legs."""

    speed: float
    turn_speed: float
    turning: bool

    def least(self, curve: PoseCurve) -> float:
        """The shortest time [s] of a curve: through waypoints, it is not passed at an even speed along u."""
        ways, turns = steps_between(curve.poses(quintic(1.0, 1.0).at(np.linspace(0.0, 1.0, MOMENTS)).s))
        way = max(PEAK_SPEED * curve.length, float(ways.max()) * (MOMENTS - 1))
        turn = max(PEAK_SPEED * curve.turn, float(turns.max()) * (MOMENTS - 1))
        return max(way / self.speed, turn / self.turn_speed if self.turning else 0.0)


def follow_legs(arm: Arm, q: Array, legs: Sequence[PoseLeg], pace: Pace, about: Mapping[str, Any]) -> LegsReference:
    """Legs in space followed from joint positions q (n,) [rad or m]; `about` is what is known of them before.

    Raises `PathStopError`: the arm cannot follow a leg; `OptionError`: a leg's duration is too short for a joint's
    speed.
    """
    curves: list[SmoothCurve] = []
    for leg in legs:
        begin = curves[-1].spline(1.0) if curves else q
        attempts = tracking.attempts(arm, leg.curve, begin, pace.turning)
        curves.append(_smooth(arm, leg, attempts, pace.turning))
    return _timed(arm, legs, curves, pace, about)


def _timed(
    arm: Arm, legs: Sequence[PoseLeg], curves: Sequence[SmoothCurve], pace: Pace, about: Mapping[str, Any]
) -> LegsReference:
    timed = tuple(
        timed_leg(arm, curve.spline, leg.duration, pace.least(leg.curve), leg.name)
        for leg, curve in zip(legs, curves, strict=True)
    )
    held = {"speed": pace.speed, "turn_speed": pace.turn_speed, "free_orientation": not pace.turning}
    return LegsReference(timed, {**about, **held, "off_curve": max(curve.off for curve in curves)})


def _smooth(arm: Arm, leg: PoseLeg, attempts: Iterable[Tracked], turning: bool) -> SmoothCurve:
    """The smooth curve of the first attempt that has one; else raises for the one that came furthest."""
    tried = []
    for tracked in attempts:
        smooth = smooth_curve(arm, leg.curve, tracked, turning) if tracked.is_whole else None
        if smooth is not None:
            return smooth
        tried.append(tracked)
    raise tracking.stop_of(arm, leg.curve, max(tried, key=lambda x: float(x.u[-1])), turning, leg.name)


def follow_waypoints(
    arm: Arm, points: Waypoints, start: Array | None, smooth: bool, pace: Pace, about: Mapping[str, Any]
) -> LegsReference:
    """The waypoints from `start` (n,), or from the joint positions of the first one with which all can be followed.

    Raises `PathStopError`: of the attempt that came furthest; `OptionError`: two waypoints that are the same, half a
    turn apart, or too little time between them.
    """
    if start is not None:
        return follow_legs(arm, start, _pose_legs(points, flange_pose(arm.chain, start), smooth), pace, about)
    legs, furthest = _pose_legs(points, None, smooth), (-1, -1.0)
    if pace.turning and srs_geometry(arm.chain) is not None:
        found = tracking.best_legs(arm, [leg.curve for leg in legs], [leg.name for leg in legs])
        curves = [_smooth(arm, leg, [tracked], True) for leg, tracked in zip(legs, found, strict=True)]
        return _timed(arm, legs, curves, pace, about)
    names = [leg.name for leg in legs]
    place = points.tip_poses()[0, :3, 3]
    fault = PathStopError("the first waypoint", 0.0, place, "reach", "no joint positions inside the limits reach it")
    for q in _first_positions(arm, points):
        try:
            return follow_legs(arm, q, legs, pace, about)
        except PathStopError as stop:
            came = (names.index(stop.line), stop.share)
            furthest, fault = (came, stop) if came > furthest else (furthest, fault)
    raise fault


def _pose_legs(points: Waypoints, begin: Array | None, smooth: bool) -> list[PoseLeg]:
    """Legs between waypoints; from pose `begin` (4, 4) to the first one too where it is given and elsewhere."""
    poses, times, legs = points.tip_poses(), points.times, []
    if begin is not None:
        if points.poses is None:
            poses[:, :3, :3] = begin[:3, :3]
        first = straight(begin, poses[0], "waypoint 1")
        if first.length > 0.0 or first.turn > 0.0:
            legs.append(PoseLeg(first, None if times is None else float(times[0]), "the leg to waypoint 1"))
    if smooth and len(poses) > 2:
        return [*legs, PoseLeg(through(poses), None, "the curve through the waypoints")]
    for k in range(len(poses) - 1):
        curve = straight(poses[k], poses[k + 1], f"waypoint {k + 2}")
        if curve.length == 0.0 and curve.turn == 0.0:
            raise OptionError(f"waypoints {k + 1} and {k + 2}", "the same pose", "waypoints apart from each other")
        duration = None if times is None else float(times[k + 1] - times[k])
        legs.append(PoseLeg(curve, duration, f"the leg from waypoint {k + 1} to {k + 2}"))
    return legs


def _first_positions(arm: Arm, points: Waypoints) -> list[Array]:
    """Joint positions (n,) at the first waypoint, those with the largest margin first."""
    T = points.tip_poses()[0]
    if points.poses is not None:
        return [solution.q for solution in inverse_kinematics(arm, T).solutions[:STARTS]]
    low, high = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    starts = [(low + high) / 2.0, *np.random.default_rng(0).uniform(low, high, (4 * STARTS, arm.n))]
    found = [q for q in (onto_pose(arm, T, start, turning=False) for start in starts) if is_inside(arm, q)]
    return sorted(found, key=lambda q: -float(np.minimum(arm.upper - q, q - arm.lower).min()))[:STARTS]


def joint_legs(arm: Arm, file: str, points: Waypoints, start: Array | None, smooth: bool) -> tuple[JointLeg, ...]:
    """Legs through the joint positions of a file, at `SPEED_SHARE` of the speed limits where it gives no times.

    Raises `WaypointError`: another number of joints, a waypoint or the smooth curve outside the limits, or nothing that
    says how long; `OptionError`: too little time for a joint's speed.
    """
    q, times = points.joint_positions(arm.n, file), points.times
    outside = largest_violation(arm, q)
    if outside is not None:
        raise WaypointError(file, f"waypoint {outside.row + 1}", outside.fault, outside.allowed)
    if start is not None and not np.array_equal(start, q[0]):
        q, times = np.vstack([start, q]), None if times is None else np.concatenate([[0.0], times])
    if times is None and not np.isfinite(arm.velocity).all():
        raise WaypointError(
            file, "columns", f"no times, and {arm.name} has joints without speed limits", "a column time"
        )
    if smooth and len(q) > 2:
        steps = np.abs(np.diff(q, axis=0)).max(axis=1)
        u = np.concatenate([[0.0], np.cumsum(steps)]) / max(float(steps.sum()), np.finfo(float).tiny)
        if not (np.diff(u) > 0.0).all():
            raise WaypointError(file, "waypoints", "two neighbours are the same", "waypoints apart from each other")
        spline = make_interp_spline(u, q, k=min(3, len(u) - 1))
        outside = largest_violation(arm, spline(np.linspace(0.0, 1.0, DENSE)))
        if outside is not None:
            raise WaypointError(
                file, "the smooth curve", outside.fault, f"{outside.allowed}, or stops at the waypoints"
            )
        return (timed_leg(arm, spline, None, 0.0, "the curve through the waypoints"),)
    out = []
    for k in range(len(q) - 1):
        duration = None if times is None else float(times[k + 1] - times[k])
        spline = make_interp_spline([0.0, 1.0], q[k : k + 2], k=1)
        out.append(timed_leg(arm, spline, duration, 0.0, f"the leg to row {k + 2} of the joint positions"))
    return tuple(out)
