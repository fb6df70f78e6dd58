"""The double-S profile: rest to rest with bounded speed, acceleration and jerk, in seven cubic pieces."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.motion_profile import DEGREE, MotionProfile, concatenate, positive_number, stretched

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
        return sum(_total(length, speed, acceleration, jerk) for length in sections) - duration

    fastest = max(_reachable_speed(length, acceleration, jerk) for length in sections)
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


def _total(length: float, speed: float, acceleration: float, jerk: float) -> float:
    _, ramp, cruise = _times(length, speed, acceleration, jerk)
    return 2.0 * ramp + cruise


def _reachable_speed(length: float, acceleration: float, jerk: float) -> float:
    """The largest speed reached without a bound on it: length / T_a, the mean speed of the two ramps."""
    _, ramp, _ = _times(length, math.inf, acceleration, jerk)
    return length / ramp


def _falling_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a falling function of the speed passes zero between low and high, by bisection to the last digit."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return high
        low, high = (middle, high) if function(middle) > 0.0 else (low, middle)
