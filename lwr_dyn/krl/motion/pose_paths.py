"""Paths of the tool centre point with their orientation, the axes along them, and the fastest speeds on them.

With s the parameter of the path, x = ds^2 and u = dds constant between two nodes, x grows by 2 h u over a step h. All
bounds have the form |first u + second x| <= most and hold at both ends of a step. Backwards: the largest x from which
the end can be reached; forwards: the largest u that stays below it (Pham and Pham, TOPP-RA, IEEE T-RO 34, 2018).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.krl.diagnostics import ExecutionError, Report
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.motion_profile import DEGREE, MotionProfile
from lwr_dyn.trajectory.path import SHORTEST, ArcSegment, LineSegment, Segment
from lwr_dyn.trajectory.pose_path import Orientation, Slerp, slerp


@dataclass(frozen=True, slots=True, eq=False)
class Speeds:
    """The speeds when a motion is planned: axes (n,) [rad/s, rad/s^2], path [m/s, m/s^2], orientation [rad/s ...]."""

    axis: Array
    axis_ramp: Array
    cp: float
    cp_ramp: float
    ori: float
    ori_ramp: float
    advance: int = 3
    """$ADVANCE: motions that are planned ahead."""


@dataclass(frozen=True, slots=True)
class Blend:
    """How a point may be passed: the keywords of the statement, and the distances when it is planned."""

    kinds: tuple[str, ...]
    cdis: float
    """[m]"""
    cptp: float
    """[%]"""
    cori: float
    """[rad]"""
    cvel: float
    """[%]"""


@dataclass(frozen=True, slots=True)
class Corner:
    """The shares of the motions before and after a point, at most a half, in which it may be passed."""

    before: float
    after: float


@dataclass(frozen=True, slots=True)
class ProfileBounds:
    """The bounds of a motion profile: speed and acceleration of its parameter [per s, per s^2]."""

    speed: float
    ramp: float


TURN = 2.0 * math.pi
STILL = 1e-9
"""[m, rad] A smaller motion is none."""


@dataclass(frozen=True, slots=True, eq=False)
class PosePath:
    """A line or arc of the tool centre point, with the orientation turning about one axis in proportion; or a spline.

    The parameter of both is the length [m]; of a turn in place, which has no length, it is the angle [rad].
    """

    segment: Segment
    orientation: Orientation
    length: float
    """[m]"""
    angle: float
    """[rad] Turn of the orientation."""

    @property
    def is_still(self) -> bool:
        """Whether nothing moves."""
        return self.length < STILL and self.angle < STILL


def path_bounds(path: PosePath, speeds: Speeds) -> ProfileBounds:
    """Of a path that is not still: the tighter of path and orientation; on an arc v^2 / radius <= $ACC.CP (assumed)."""
    whole = path.segment.length
    cp = min(speeds.cp, fastest_on_arc(path, speeds))
    both = [(path.length / whole, cp, speeds.cp_ramp), (path.angle / whole, speeds.ori, speeds.ori_ramp)]
    moving = [(rate, v, a) for rate, v, a in both if rate * whole > STILL]
    return ProfileBounds(min(v / rate for rate, v, _ in moving), min(a / rate for rate, _, a in moving))


def fastest_on_arc(path: PosePath, speeds: Speeds) -> float:
    """[m/s] At which the acceleration across an arc, v^2 / radius, is $ACC.CP; infinite on a line."""
    segment = path.segment
    return math.sqrt(speeds.cp_ramp * segment.radius) if isinstance(segment, ArcSegment) else math.inf


def path_between(start: Array, end: Array, through: Array | None = None, angle: float | None = None) -> PosePath:
    """The path from one pose (4, 4) to another: a line, or an arc through a third pose; `angle` [rad] is CIRC's CA.

    Raises `ExecutionError`: half a turn of the orientation, three points of an arc in line.
    """
    try:
        turn = slerp(start[:3, :3], end[:3, :3], 1.0)
    except OptionError:
        hint = "put a point in between: either way is as short"
        raise ExecutionError("half-turn", "the orientation turns by 180 deg", hint) from None
    if through is not None:
        segment: LineSegment | ArcSegment = _arc(start[:3, 3], through[:3, 3], end[:3, 3], angle)
        length = segment.length
    else:
        way = end[:3, 3] - start[:3, 3]
        length = float(np.linalg.norm(way))
        parameter = turn.rate if length < SHORTEST and turn.rate > STILL else max(length, STILL)
        segment = LineSegment(start[:3, 3], way / parameter, parameter)
    return PosePath(segment, Slerp(turn.R, turn.axis, turn.rate / segment.length), length, turn.rate)


def _arc(a: Array, b: Array, c: Array, angle: float | None) -> ArcSegment:
    """The arc from a through b to c (3,) [m]."""
    u, v = b - a, c - a
    normal = np.cross(u, v)
    area = float(normal @ normal)
    if area < 1e-12 * max(float(u @ u), 1e-12) * max(float(v @ v), 1e-12):
        raise ExecutionError("no-arc", "start, auxiliary point and end lie in line", "three points that make a circle")
    centre = a + (np.cross(normal, u) * (v @ v) + np.cross(v, normal) * (u @ u)) / (2.0 * area)
    radius = float(np.linalg.norm(a - centre))
    x, z = (a - centre) / radius, normal / math.sqrt(area)
    y = np.cross(z, x)
    whole = math.atan2(float((c - centre) @ y), float((c - centre) @ x)) % TURN
    if angle is not None:
        whole = abs(angle)
        y = math.copysign(1.0, angle) * y
    if whole * radius < 1e-9:
        raise ExecutionError("no-arc", "the arc has no length", "an angle CA that is not 0")
    return ArcSegment(centre, radius, x, y, radius * whole)


NEAR = np.radians(1.0)
"""[rad] With A5 this near to 0 on a path, axes 4 and 6 are in line."""
FLIP = np.radians(90.0)
"""[rad] A4 or A6 that turns by more between two samples of a path has flipped."""


def axes_along(arm: Arm, start: Array, flange: Array, along: Array, report: Report) -> tuple[int, Array] | None:
    """The axes (m, n) [rad] from `start` (n,) through flange poses (m, 4, 4) at shares `along` (m,) of a path.

    With their branch of the inverse kinematics. None with a fault that is reported: reach, a wrist that flips or is
    singular, limits.
    """
    solutions = all_branches(arm, flange)
    away = np.abs((solutions.q[0] - start + np.pi) % TURN - np.pi).max(axis=-1)
    branch = int(np.nanargmin(np.where(np.isnan(away), np.inf, away)))
    excess = solutions.reach_excess[:, branch]
    if (excess > 0.0).any():
        k = int(np.argmax(excess))
        message = f"the path is out of reach by {1e3 * excess[k]:.4g} mm, {100 * along[k]:.0f} % along"
        report("error", "out-of-reach", message, "move the points nearer, or go there by PTP")
        return None
    wrist = solutions.clearance[:, branch, 2]
    passed = int(np.argmin(wrist))
    q = np.unwrap(np.vstack([start, solutions.q[:, branch]]), axis=0)[1:]
    if wrist[passed] < NEAR:
        place = f"{100 * along[passed]:.0f} % along (A5 {degrees_text(q[passed, 4])} deg)"
        message = f"the path passes the wrist singularity {place}"
        report("error", "singularity", message, "go there by PTP, or tilt the tool")
    if np.abs(q[0] - start).max() > 1e-6:
        if wrist[passed] >= NEAR:
            report("error", "singularity", "the path begins where axes are not determined", "leave the place by PTP")
        return None
    return (branch, q) if _no_flip(q, along, report) and inside_limits(arm, q, report) else None


def _no_flip(q: Array, along: Array, report: Report) -> bool:
    step = np.abs(np.diff(q[:, [3, 5]], axis=0))
    k, axis = np.unravel_index(int(np.argmax(step)), step.shape)
    if step[k, axis] <= FLIP:
        return True
    turned = f"{('A4', 'A6')[int(axis)]} turns by {degrees_text(step[k, axis])} deg at once"
    message = f"the wrist flips: {turned}, {100 * along[k]:.0f} % along"
    report("error", "wrist-flip", message, "go there by PTP, or keep A5 away from 0")
    return False


def inside_limits(arm: Arm, q: Array, report: Report) -> bool:
    """Whether the axes q (m, n) at even steps along a path are inside their ranges; if not, it is reported."""
    over = np.maximum(q - arm.upper, arm.lower - q)
    k, i = np.unravel_index(int(np.argmax(over)), over.shape)
    if over[k, i] <= 1e-9:
        return True
    along = 100.0 * k / max(len(q) - 1, 1)
    far = f"by {degrees_text(over[k, i])} deg, {along:.0f} % along the path"
    message = f"{arm.joint_names[int(i)]} leaves its range {far}"
    report("error", "outside-limits", message, "another Status at the start, or a PTP")
    return False


def degrees_text(x: float) -> str:
    """An angle [rad] in deg, for a message."""
    return f"{np.degrees(x):.4g}"


FINE = np.array([1.0, 4.0, 16.0]) / 64.0
"""Shares of a step."""
HUGE = 1e30
"""Stands for no bound."""


@dataclass(frozen=True, slots=True, eq=False)
class PathLimits:
    """Bounds at k nodes s (k,) of a path: x <= `fastest` (k,), and |first u + second x| <= most, each (k, m)."""

    s: Array
    fastest: Array
    first: Array
    second: Array
    most: Array


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """The bounds of the steps between nodes: |u + ratio x| <= bound, (k - 1, 2 m), at the two ends of each step."""

    h: Array
    ratio: Array
    bound: Array
    cap: Array
    """(k,) Largest x that leaves a u."""


def fastest_speeds(limits: PathLimits, ends: Sequence[int] = (), ahead: Sequence[int] = ()) -> Array:
    """x = ds^2 at the nodes (k,), from rest to rest.

    With `ends`, the nodes at which motions end, and `ahead`, how many motions further each of them knows, it is
    everywhere possible to stop at the end of what is known.
    """
    steps = _steps(limits)
    cap = steps.cap.copy()
    first = 0
    for i, n in enumerate(ahead):
        known = ends[min(i + n, len(ends) - 1)]
        if known < ends[-1]:
            stop = cap.copy()
            stop[known] = 0.0
            _backwards(steps, stop, first, known)
            np.minimum(cap[first + 1 : ends[i] + 1], stop[first + 1 : ends[i] + 1], out=cap[first + 1 : ends[i] + 1])
        first = ends[i]
    cap[0] = cap[-1] = 0.0
    _backwards(steps, cap, 0, len(cap) - 1)
    return _forwards(steps, cap)


def _steps(limits: PathLimits) -> _Steps:
    h = np.diff(limits.s)
    # at its end a step has x + 2 h u
    first = np.hstack([limits.first[:-1], limits.first[1:] + 2.0 * h[:, None] * limits.second[1:]])
    second = np.hstack([limits.second[:-1], limits.second[1:]])
    most = np.hstack([limits.most[:-1], limits.most[1:]])
    size = np.maximum(np.abs(first), 1e-12)
    ratio, bound = np.where(first < 0.0, -second, second) / size, most / size
    cap = limits.fastest.copy()
    with np.errstate(divide="ignore", invalid="ignore"):
        for j in range(ratio.shape[1]):
            # some u meets bounds i and j together
            apart = np.abs(ratio - ratio[:, j : j + 1])
            x = np.where(apart > 0.0, (bound + bound[:, j : j + 1]) / apart, HUGE).min(axis=1)
            cap[:-1] = np.minimum(cap[:-1], x)
        # and the next x is not negative
        slope = ratio - 0.5 / h[:, None]
        cap[:-1] = np.minimum(cap[:-1], np.where(slope > 0.0, bound / slope, HUGE).min(axis=1))
    return _Steps(h, ratio, bound, np.minimum(cap, HUGE))


def _backwards(steps: _Steps, cap: Array, begin: int, end: int) -> None:
    """Lower `cap` (k,) so that the x of node `end` can be reached from each node from `begin` on."""
    h = 2.0 * steps.h[begin:end, None]
    denominator = 1.0 - h * steps.ratio[begin:end]
    free = denominator <= 0.0
    gain = np.where(free, 0.0, 1.0 / np.where(free, 1.0, denominator))
    rest = np.where(free, HUGE, h * steps.bound[begin:end] * gain)
    x = float(cap[end])
    for k in range(end - 1, begin - 1, -1):
        x = min(float(cap[k]), float((x * gain[k - begin] + rest[k - begin]).min()))
        cap[k] = x


def _forwards(steps: _Steps, cap: Array) -> Array:
    out = np.zeros(len(cap))
    x = 0.0
    for k in range(len(steps.h)):
        u = float((steps.bound[k] - steps.ratio[k] * x).min())
        x = out[k + 1] = max(0.0, min(float(cap[k + 1]), x + 2.0 * float(steps.h[k]) * u))
    return out


def with_fine_ends(s: Array, begin: bool = True, end: bool = True) -> Array:
    """Nodes (k,) with a few more beside the first and the last one, where a ramp from rest may be short.

    >>> with_fine_ends(np.array([0.0, 1.0]), end=False)
    array([0.      , 0.015625, 0.0625  , 0.25    , 1.      ])
    """
    first = s[0] + FINE * (s[1] - s[0]) if begin else s[:0]
    last = s[-1] - FINE[::-1] * (s[-1] - s[-2]) if end else s[:0]
    return np.unique(np.concatenate([s, first, last]))


def times_along(s: Array, x: Array) -> Array:
    """The time (k,) [s] at each node."""
    v = np.sqrt(x)
    return np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / np.maximum(v[1:] + v[:-1], 1e-15))])


def profile_along(s: Array, x: Array) -> MotionProfile:
    """The motion profile with x = ds^2 at the nodes s, of constant dds from node to node."""
    u = np.diff(x) / (2.0 * np.diff(s))
    rows = np.zeros((len(u), DEGREE + 1))
    rows[:, 0], rows[:, 1], rows[:, 2] = s[:-1] - s[0], np.sqrt(x[:-1]), 0.5 * u
    return MotionProfile("spline", float(s[-1] - s[0]), times_along(s, x), rows)


def seconds_at(profile: MotionProfile, s: Array) -> Array:
    """The time (k,) [s] at which a profile of constant dds from knot to knot reaches s (k,)."""
    c = profile.coefficients
    piece = np.clip(np.searchsorted(c[:, 0], s, side="right") - 1, 0, len(c) - 1)
    way, v, u = s - c[piece, 0], c[piece, 1], 2.0 * c[piece, 2]
    later = np.sqrt(np.maximum(v**2 + 2.0 * u * way, 0.0))
    return np.asarray(profile.knots[piece] + 2.0 * way / np.maximum(v + later, 1e-15))
