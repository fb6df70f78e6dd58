"""How a path in space is travelled in a given time: motion profiles by name, and corners rounded.

The double-S profile goes from rest to rest with bounded speed, acceleration and jerk, in seven cubic pieces. Blends
round corners and bends by quintics, so that they can be passed at speed: a blend leaves the path a given distance
before a joint and comes back the same distance after it, with position, tangent and curvature continuous, so the
acceleration along the path does not jump there.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.trajectory import motion_profile
from lwr_dyn.trajectory.motion_profile import DEGREE, MotionProfile, concatenate, positive_number, stretched
from lwr_dyn.trajectory.path import Path, PathJoint, PathSample, Segment, end_of, path_of, start_of

NAME = "double-S"


def double_s(length: float, speed: float, acceleration: float, jerk: float) -> MotionProfile:
    """Fastest profile from rest to rest under bounds on speed, acceleration and jerk (double-S).

    The jerk is +j, 0, -j, 0, -j, 0, +j; bounds that the length is too short for are not reached.

    Parameters
    ----------
    length : float
        [m or rad]
    speed, acceleration, jerk : float
        The bounds, per s, per s^2, per s^3.

    Raises
    ------
    OptionError
        One of them not positive.

    References
    ----------
    Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, sec. 3.4, with zero
    initial and final speed.

    >>> profile = double_s(1.0, 0.5, 1.0, 10.0)
    >>> round(profile.duration, 12), round(profile.peaks().speed, 12)
    (2.6, 0.5)
    """
    length, speed = positive_number("length", length), positive_number("speed", speed)
    acceleration, jerk = positive_number("acceleration", acceleration), positive_number("jerk", jerk)
    rise, ramp, cruise = _times(length, speed, acceleration, jerk)
    level = max(ramp - 2.0 * rise, 0.0)
    spans = (rise, level, rise, cruise, rise, level, rise)
    jerks = (jerk, 0.0, -jerk, 0.0, -jerk, 0.0, jerk)
    knots, rows, s, ds, dds = [0.0], [], 0.0, 0.0, 0.0
    for h, ddds in zip(spans, jerks, strict=True):
        if h > 0.0:
            rows.append([s, ds, dds / 2.0, ddds / 6.0] + [0.0] * (DEGREE - 3))
            knots.append(knots[-1] + h)
            s += h * (ds + h * (dds / 2.0 + h * ddds / 6.0))
            ds += h * (dds + h * ddds / 2.0)
            dds += h * ddds
    return MotionProfile(NAME, length, np.array(knots), np.array(rows))


def double_s_in(lengths: Sequence[float], duration: float, acceleration: float, jerk: float) -> MotionProfile:
    """Double-S over sections with a stop after each, in a given total time: one cruise speed for all sections.

    Only the cruise speed is solved for; the bounds on acceleration and jerk stay as given.

    Parameters
    ----------
    lengths : sequence of float
        [m or rad], one per section.
    duration : float
        [s], all sections together.
    acceleration, jerk : float
        The bounds, per s^2 and per s^3.

    Raises
    ------
    OptionError
        No section, a number that is not positive, or a duration shorter than the bounds allow.

    >>> profile = double_s_in([0.3, 0.1], 3.0, 1.0, 10.0)
    >>> profile.duration, round(profile.length, 12)
    (3.0, 0.4)
    """
    sections = [positive_number("length", length) for length in lengths]
    duration = positive_number("duration", duration)
    acceleration, jerk = positive_number("acceleration", acceleration), positive_number("jerk", jerk)
    if not sections:
        raise OptionError("lengths", "none", "at least one section")

    def excess(speed: float) -> float:
        times = [_times(length, speed, acceleration, jerk) for length in sections]
        return sum(2.0 * ramp + cruise for _, ramp, cruise in times) - duration

    # without a bound on it the speed reaches length / T_a, the mean speed of the two ramps
    fastest = max(length / _times(length, math.inf, acceleration, jerk)[1] for length in sections)
    if excess(fastest) > 1e-9 * duration:
        raise OptionError(
            "duration",
            f"{duration:g} s",
            f"at least {excess(fastest) + duration:.6g} s with {len(sections)} stops, acceleration {acceleration:g} "
            f"and jerk {jerk:g}",
        )
    speed = _falling_root(excess, sum(sections) / duration, fastest)
    profile = concatenate([double_s(length, speed, acceleration, jerk) for length in sections])
    return stretched(profile, duration)  # removes the rounding of the solved speed


def _times(length: float, speed: float, acceleration: float, jerk: float) -> tuple[float, float, float]:
    """Time of one jerk piece, of the whole acceleration, of the cruise (B&M T_j, T_a, T_v)."""
    if speed * jerk < acceleration**2:
        rise = math.sqrt(speed / jerk)
        ramp = 2.0 * rise
    else:
        rise = acceleration / jerk
        ramp = rise + speed / acceleration
    cruise = length / speed - ramp
    if cruise >= 0.0:
        return rise, ramp, cruise
    if length * jerk**2 >= 2.0 * acceleration**3:
        rise = acceleration / jerk
        return rise, rise / 2.0 + math.sqrt((rise / 2.0) ** 2 + length / acceleration), 0.0
    rise = math.cbrt(length / (2.0 * jerk))
    return rise, 2.0 * rise, 0.0


def _falling_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a falling function of the speed passes zero between low and high, by bisection to the last digit."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return high
        low, high = (middle, high) if function(middle) > 0.0 else (low, middle)


PANELS, NODES = 32, 10
"""Gauss-Legendre panels for the length of a quintic: exact to rounding for the blends of this file."""

NEWTON = 3
"""Newton steps from the table's linear guess to u(s): each squares the error, two reach rounding, one is a reserve."""

REVERSAL = math.radians(170.0)
"""[rad] A corner that turns by more cannot be rounded: the path goes back on itself."""

_X, _W = np.polynomial.legendre.leggauss(NODES)


@dataclass(frozen=True, slots=True, eq=False)
class QuinticCurve:
    """A quintic curve p(u), u from 0 to 1, by its length: `coefficients` (6, 3) [m], lowest power first."""

    coefficients: Array
    lengths: Array
    """Length from 0 to the end of each panel, (PANELS + 1,) [m]."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "coefficients", "lengths")

    @property
    def length(self) -> float:
        """[m]"""
        return float(self.lengths[-1])

    def at(self, s: Array) -> PathSample:
        """Position, tangent and curvature vector at s (k,) [m]; u(s) is solved to rounding."""
        u = np.interp(s, self.lengths, np.linspace(0.0, 1.0, PANELS + 1))
        for _ in range(NEWTON):
            u = np.clip(u - (self._length_to(u) - s) / _speed(self.coefficients, u), 0.0, 1.0)
        p, v, a = (_evaluate(self.coefficients, u, order) for order in range(3))
        square = np.sum(v * v, axis=1, keepdims=True)
        along = np.sum(v * a, axis=1, keepdims=True)
        return PathSample(p, v / np.sqrt(square), (a - v * along / square) / square)

    def _length_to(self, u: Array) -> Array:
        panel = np.minimum((u * PANELS).astype(int), PANELS - 1)
        begin = panel / PANELS
        half = 0.5 * (u - begin)
        nodes = begin[:, None] + half[:, None] * (1.0 + _X)
        rates = _speed(self.coefficients, nodes.ravel()).reshape(nodes.shape)
        out: Array = self.lengths[panel] + half * (rates @ _W)
        return out


@dataclass(frozen=True, slots=True, eq=False)
class PartOfSegment:
    """A part of a segment: it begins at `start` [m] and is `length` [m] long."""

    segment: Segment
    start: float
    length: float

    def at(self, s: Array) -> PathSample:
        """The segment at s + start."""
        return self.segment.at(s + self.start)


def quintic_between(before: PathSample, after: PathSample, speed: float) -> QuinticCurve:
    """The quintic with the position, tangent and curvature of two samples (k = 1), and |dp/du| = speed at its ends."""
    p0, v0, a0 = before.p[0], speed * before.dp[0], speed**2 * before.ddp[0]
    p1, v1, a1 = after.p[0], speed * after.dp[0], speed**2 * after.ddp[0]
    step = p1 - p0 - v0 - a0 / 2.0
    turn, pull = v1 - v0 - a0, a1 - a0
    c3 = 10.0 * step - 4.0 * turn + 0.5 * pull
    c4 = -15.0 * step + 7.0 * turn - pull
    c5 = 6.0 * step - 3.0 * turn + 0.5 * pull
    c = np.array([p0, v0, a0 / 2.0, c3, c4, c5])
    edges = np.linspace(0.0, 1.0, PANELS + 1)
    nodes = edges[:-1, None] + (0.5 / PANELS) * (1.0 + _X)
    panels = _speed(c, nodes.ravel()).reshape(nodes.shape) @ _W * (0.5 / PANELS)
    return QuinticCurve(c, np.concatenate([[0.0], np.cumsum(panels)]))


def blended(path: Path, corners: float = 0.0, bends: float = 0.0) -> Path:
    """The path with its corners and bends rounded.

    A corner that turns back (by more than 170 deg) stays: it needs a stop.

    Parameters
    ----------
    corners : float
        [m] Distance from a corner at which the path is left and met again; 0 keeps the corners.
    bends : float
        [m] The same where only the curvature jumps (a line that runs into an arc); 0 keeps the bends.

    Raises
    ------
    OptionError
        A distance that is negative, or too long for a segment between two blends.
    """
    sizes = {"corners": corners, "bends": bends}
    for name, size in sizes.items():
        if size != 0.0:
            positive_number(name, size)
    reach = [0.0, *(_reach(joint, corners, bends) for joint in path.joints()), 0.0]
    out: list[Segment] = []
    for i, segment in enumerate(path.segments):
        left = segment.length - reach[i] - reach[i + 1]
        if left < 0.0:
            raise OptionError(
                "blend", f"{reach[i]:g} m and {reach[i + 1]:g} m at the ends of segment {i}",
                f"together at most its length, {segment.length:g} m",
            )  # fmt: skip
        part = PartOfSegment(segment, reach[i], left) if reach[i] or reach[i + 1] else segment
        if reach[i]:
            out.append(_blend(end_of(out[-1]), start_of(part), reach[i]))
        out.append(part)
    return path_of([segment for segment in out if segment.length > 0.0])


def _reach(joint: PathJoint, corners: float, bends: float) -> float:
    if joint.is_corner:
        return corners if joint.turn < REVERSAL else 0.0
    return bends if joint.is_bend else 0.0


def _blend(before: PathSample, after: PathSample, reach: float) -> QuinticCurve:
    """With |dp/du| half-way between chord and legs: both the curvature and its slope are near their least there."""
    chord = float(np.linalg.norm(after.p[0] - before.p[0]))
    return quintic_between(before, after, reach + 0.5 * chord)


def _evaluate(c: Array, u: Array, order: int) -> Array:
    for _ in range(order):
        c = c[1:] * np.arange(1, len(c))[:, None]
    out: Array = (u[:, None] ** np.arange(len(c))) @ c
    return out


def _speed(c: Array, u: Array) -> Array:
    out: Array = np.linalg.norm(_evaluate(c, u, 1), axis=1)
    return out


@dataclass(frozen=True, slots=True)
class SmoothTiming:
    """What the smooth profiles keep: bounds along the path, and how far from a joint the path is left.

    `acceleration` [m/s^2] and `jerk` [m/s^3] of the length travelled; `ease` [m] at the bends (line into arc, arc
    into arc: passed at speed v unrounded, the acceleration would jump by v^2 / radius); `blend` [m] at corners,
    for "smooth-blended" only. ease = 0 follows the path exactly and has those jumps.
    """

    acceleration: float = 0.5
    jerk: float = 5.0
    ease: float = 0.005
    blend: float = 0.02


TimedPath = tuple[Path, MotionProfile]

MOTION_PROFILES: Registry[Callable[[Path, float, SmoothTiming], TimedPath]] = Registry(
    "motion_profile",
    {
        "constant": Row(
            "lwr_dyn.trajectory.timings:constant",
            "constant speed over the whole path: the speed jumps at both ends, its direction at corners",
        ),
        "quintic": Row(
            "lwr_dyn.trajectory.timings:quintic_per_segment",
            "a quintic from rest to rest on each segment of the path, in times proportional to their lengths",
        ),
        "smooth": Row(
            "lwr_dyn.trajectory.timings:smooth",
            "double-S, stops at corners, bends (where only the curvature jumps) eased and passed at speed",
            facts={"smoothness": True},
        ),
        "smooth-blended": Row(
            "lwr_dyn.trajectory.timings:smooth_blended",
            "double-S, corners blended and passed at speed, a stop only where the path turns back",
            facts={"smoothness": True},
        ),
    },
)
"""Each row times a path: `factory(path, duration, smoothness)` gives the path, blended or not, and its profile."""


def constant(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    """Constant speed over the whole path."""
    return path, motion_profile.constant_speed(path.length, duration)


def quintic_per_segment(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    """A quintic from rest to rest on each segment, in times proportional to the lengths."""
    pace = duration / path.length
    profiles = [motion_profile.quintic(part.length, pace * part.length) for part in path.segments]
    return path, stretched(concatenate(profiles), duration)


def smooth(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    """Double-S with a stop at each corner; bends are eased and passed at speed."""
    return _double_s(blended(path, bends=smoothness.ease), duration, smoothness)


def smooth_blended(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    """Double-S over bends and corners; a stop only where the path turns back."""
    return _double_s(blended(path, corners=smoothness.blend, bends=smoothness.ease), duration, smoothness)


def _double_s(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    return path, double_s_in(path.sections(), duration, smoothness.acceleration, smoothness.jerk)
