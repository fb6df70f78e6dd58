"""Motion profiles: a scalar s(t) with its exact derivatives, as polynomials in time from knot to knot.

Functions return the one record `MotionProfile`. Before 0 and after its duration a profile stands still.

A trapezoid of speed, rest to rest, is three quadratic pieces: LSPB, linear segments with parabolic blends,

    s = A t^2/2                     0 <= t <= t_c
    s = (L - V t_f)/2 + V t         t_c < t <= t_f - t_c          V = A t_c = L/(t_f - t_c)
    s = L - A (t_f - t)^2/2         t_f - t_c < t <= t_f

What the WAM paper prints as velocity in (3), 4 L/(t_f^2 - (2 (t_c - t_f/2))^2) = L/(t_c (t_f - t_c)), is the
acceleration A.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, freeze_arrays, real_array
from lwr_dyn.foundation.errors import OptionError

DEGREE = 5

SHORTEST, LONGEST = 1e-9, 1e9
"""Allowed range of lengths, times and bounds: numbers outside come from a wrong unit, and would lose their digits."""


@dataclass(frozen=True, slots=True, eq=False)
class ProfileSample:
    """A profile at k times: s, ds, dds, ddds (k,) [m or rad, per s, per s^2, per s^3]."""

    s: Array
    ds: Array
    dds: Array
    ddds: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "s", "ds", "dds", "ddds")


@dataclass(frozen=True, slots=True)
class Peaks:
    """The largest absolute speed, acceleration and jerk of a profile between its knots."""

    speed: float
    acceleration: float
    jerk: float


@dataclass(frozen=True, slots=True, eq=False)
class MotionProfile:
    """A profile of motion s(t) = sum_i c_i (t - t_j)^i on [t_j, t_(j+1)], from 0 to `length`.

    `knots` (m + 1,) [s] begins with 0; `coefficients` (m, 6) holds c_0 ... c_5 of each piece.
    """

    name: str
    length: float
    knots: Array
    coefficients: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "knots", "coefficients")

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.knots[-1])

    def at(self, t: ArrayLike) -> ProfileSample:
        """The profile and its derivatives at times t (k,) [s]; at a knot the piece that begins there counts.

        >>> quintic(1.0, 2.0).at([1.0]).ds
        array([0.9375])
        """
        times = np.atleast_1d(real_array("t", t))
        moving = (times >= 0.0) & (times <= self.duration)
        piece = np.clip(np.searchsorted(self.knots, times, side="right") - 1, 0, len(self.coefficients) - 1)
        local = np.clip(times, 0.0, self.duration) - self.knots[piece]
        powers = local[:, None] ** np.arange(DEGREE + 1)
        c, values = self.coefficients[piece], []
        for _ in range(4):
            values.append(np.sum(c * powers[:, : c.shape[1]], axis=1))
            c = _derivative(c)
        s, *rates = values
        return ProfileSample(np.clip(s, 0.0, self.length), *(np.where(moving, rate, 0.0) for rate in rates))

    def peaks(self) -> Peaks:
        """The exact peaks, from the roots of the derivatives of each piece.

        >>> constant_speed(3.0, 2.0).peaks()
        Peaks(speed=1.5, acceleration=0.0, jerk=0.0)
        """
        peaks, c = [], self.coefficients
        for _ in range(3):
            c = _derivative(c)
            peaks.append(max(map(_peak, c, np.diff(self.knots))))
        return Peaks(*peaks)


def constant_speed(length: float, duration: float) -> MotionProfile:
    """Constant speed, s = length t / duration; the speed jumps from and to zero at the two ends.

    Raises `OptionError`: length or duration not positive.
    """
    length, duration = positive_number("length", length), positive_number("duration", duration)
    coefficients = np.array([[0.0, length / duration, *[0.0] * (DEGREE - 1)]])
    return MotionProfile("constant speed", length, np.array([0.0, duration]), coefficients)


def quintic(length: float, duration: float) -> MotionProfile:
    """Quintic from rest to rest, s = length (10 x^3 - 15 x^4 + 6 x^5) with x = t / duration.

    Speed and acceleration are zero at both ends; the jerk steps there from and to 60 length / duration^3.

    Raises
    ------
    OptionError
        Length or duration not positive.

    References
    ----------
    Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, sec. 2.1.

    >>> quintic(1.0, 1.0).peaks().speed
    1.875
    """
    length, duration = positive_number("length", length), positive_number("duration", duration)
    c = [0.0, 0.0, 0.0, 10.0 / duration**3, -15.0 / duration**4, 6.0 / duration**5]
    return MotionProfile("quintic", length, np.array([0.0, duration]), length * np.array([c]))


def stretched(profile: MotionProfile, duration: float) -> MotionProfile:
    """The profile stretched in time by x to `duration` [s]: speed, acceleration and jerk scale with 1/x, 1/x^2, 1/x^3.

    Raises `OptionError`: duration not positive.

    >>> round(stretched(quintic(1.0, 1.0), 3.0).peaks().speed, 12)
    0.625
    """
    duration = positive_number("duration", duration)
    stretch = duration / profile.duration
    knots = profile.knots * stretch
    knots[-1] = duration
    return MotionProfile(profile.name, profile.length, knots, profile.coefficients / stretch ** np.arange(DEGREE + 1))


def concatenate(profiles: Sequence[MotionProfile]) -> MotionProfile:
    """Profiles one after the other, each from where the one before it ends; those that end at rest stop there.

    Raises `OptionError`: no profile given.

    >>> concatenate([quintic(1.0, 2.0), quintic(0.5, 1.0)]).at([2.0, 3.0]).s
    array([1. , 1.5])
    """
    if not profiles:
        raise OptionError("profiles", "none", "at least one profile")
    knots, coefficients, length = [0.0], [], 0.0
    for profile in profiles:
        begin = knots[-1]
        knots += [begin + float(t) for t in profile.knots[1:]]
        piece = profile.coefficients.copy()
        piece[:, 0] += length
        coefficients.append(piece)
        length += profile.length
    names = dict.fromkeys(profile.name for profile in profiles)
    return MotionProfile(", then ".join(names), length, np.array(knots), np.concatenate(coefficients))


def positive_number(name: str, value: float) -> float:
    """A positive amount as a float; raises `OptionError` with the allowed range.

    >>> positive_number("duration", 2)
    2.0
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not SHORTEST <= number <= LONGEST:
        raise OptionError(name, repr(value), f"a number from {SHORTEST:g} to {LONGEST:g}")
    return number


def _derivative(coefficients: Array) -> Array:
    return coefficients[..., 1:] * np.arange(1, coefficients.shape[-1])


def _peak(c: Array, end: float) -> float:
    """The largest absolute value on [0, end] of the polynomial with coefficients c, lowest first."""
    slope = np.trim_zeros(_derivative(c), "b")
    roots = np.roots(slope[::-1]) if len(slope) > 1 else np.empty(0)
    inside = [float(r.real) for r in roots if abs(r.imag) < 1e-9 * end and 0.0 < r.real < end]
    at = np.array([0.0, end, *inside])
    return float(np.max(np.abs(np.sum(c * at[:, None] ** np.arange(len(c)), axis=1))))


ROUNDING = 1e-12
"""Relative: a request that exceeds the triangular profile by less gives the triangular profile."""


def lspb(length: float, duration: float, blend: float) -> MotionProfile:
    """LSPB in a given time with a given blend time.

    Parameters
    ----------
    length : float
        [m or rad]; 0 is an axis that stands still for `duration`.
    duration, blend : float
        t_f and t_c [s], with t_c at most t_f / 2 (no cruise is left then).

    Raises
    ------
    OptionError
        A time that is not positive, a negative length, a blend too long, with the feasible range.

    References
    ----------
    WAM paper, eq. (2); Siciliano et al., section 4.2.1.

    >>> profile = lspb(0.5, 7.0, 1.0)
    >>> round(profile.peaks().speed, 6), round(profile.peaks().acceleration, 6), profile.at([3.5]).s
    (0.083333, 0.083333, array([0.25]))
    """
    duration, blend = positive_number("duration", duration), positive_number("blend", blend)
    if blend > duration / 2.0 * (1.0 + ROUNDING):
        raise OptionError("blend", f"{blend:g} s", f"above 0, at most {duration / 2.0:g} s, half of {duration:g} s")
    blend = min(blend, duration / 2.0)
    if length == 0.0:
        return MotionProfile("LSPB", 0.0, np.array([0.0, duration]), np.zeros((1, DEGREE + 1)))
    length = positive_number("length", length)
    velocity = length / (duration - blend)
    acceleration = velocity / blend
    ramp = velocity * blend / 2.0
    times = (blend, duration - blend, duration)
    return _three_pieces("LSPB", length, times, (ramp, length - ramp), velocity, acceleration)


def trapezoid(length: float, speed: float, acceleration: float) -> MotionProfile:
    """Fastest profile under bounds on speed and acceleration, as industrial controllers move.

    T = length / speed + speed / acceleration, or 2 sqrt(length / acceleration) where the speed is not reached.

    Parameters
    ----------
    length : float
        [m or rad, or 1]
    speed, acceleration : float
        The bounds, per s, per s^2.

    Raises
    ------
    OptionError
        One of them not positive.

    References
    ----------
    Siciliano et al., Robotics, sec. 4.2.1.

    >>> trapezoid(1.0, 0.5, 1.0).duration, trapezoid(1.0, 2.0, 1.0).duration
    (2.5, 2.0)
    """
    length, speed = positive_number("length", length), positive_number("speed", speed)
    acceleration = positive_number("acceleration", acceleration)
    ramp = min(speed / acceleration, math.sqrt(length / acceleration))
    top = acceleration * ramp
    cruise = max(length / top - ramp, 0.0)
    times, places = (ramp, ramp + cruise, 2.0 * ramp + cruise), (top * ramp / 2.0, top * (ramp / 2.0 + cruise))
    return _three_pieces("trapezoid", length, times, places, top, acceleration)


def _three_pieces(
    name: str,
    length: float,
    times: tuple[float, float, float],
    places: tuple[float, float],
    speed: float,
    acceleration: float,
) -> MotionProfile:
    """Ramp up, cruise, ramp down, which end at `times`; the last two begin at `places`."""
    knots = [0.0, *times]
    rows = [[0.0, 0.0, acceleration / 2.0], [places[0], speed, 0.0], [places[1], speed, -acceleration / 2.0]]
    if not times[0] < times[1]:  # no cruise
        del knots[2], rows[1]
    return MotionProfile(name, length, np.array(knots), np.array([row + [0.0] * (DEGREE - 2) for row in rows]))
