"""Profiles with a trapezoid of speed, rest to rest, in three quadratic pieces: LSPB, and the fastest under bounds.

LSPB, linear segments with parabolic blends:

    s = A t^2/2                     0 <= t <= t_c
    s = (L - V t_f)/2 + V t         t_c < t <= t_f - t_c          V = A t_c = L/(t_f - t_c)
    s = L - A (t_f - t)^2/2         t_f - t_c < t <= t_f

Two of duration t_f, blend time t_c, velocity V and acceleration A fix the profile of a length L. What the WAM paper
prints as velocity in (3), 4 L/(t_f^2 - (2 (t_c - t_f/2))^2) = L/(t_c (t_f - t_c)), is the acceleration A.
"""

import math

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.motion_profile import DEGREE, MotionProfile, positive_number

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


def lspb_at_velocity(length: float, duration: float, velocity: float) -> MotionProfile:
    """LSPB in a given time with a given cruise velocity.

    Parameters
    ----------
    length : float
        [m or rad]; 0 is an axis that stands still for `duration`, for any velocity.
    duration : float
        [s]
    velocity : float
        Above L/t_f, where blends would take no time, at most 2 L/t_f, where no cruise is left [per s].

    Raises
    ------
    OptionError
        A number that is not positive, a negative length, a velocity outside, with the feasible range.

    >>> lspb_at_velocity(0.5, 7.0, 0.1).knots.tolist()
    [0.0, 2.0, 5.0, 7.0]
    """
    duration, velocity = positive_number("duration", duration), positive_number("velocity", velocity)
    if length == 0.0:
        return lspb(0.0, duration, duration / 2.0)
    length = positive_number("length", length)
    slowest, fastest = length / duration, 2.0 * length / duration
    blend = duration - length / velocity
    if velocity > fastest * (1.0 + ROUNDING) or blend <= ROUNDING * duration:
        raise OptionError(
            "velocity",
            f"{velocity:g} for {length:g} in {duration:g} s",
            f"above {slowest:.6g}, at most {fastest:.6g}, or a duration above {length / velocity:.6g} s, "
            f"at most {2.0 * length / velocity:.6g} s",
        )
    return lspb(length, duration, min(blend, duration / 2.0))


def lspb_at_rates(length: float, velocity: float, acceleration: float) -> MotionProfile:
    """LSPB with a given cruise velocity and acceleration; the duration L/V + V/A follows.

    Parameters
    ----------
    length : float
        [m or rad]; an axis of length 0 has no duration of its own and is refused.
    velocity, acceleration : float
        With V^2 <= A L, or the velocity is not reached [per s, per s^2].

    Raises
    ------
    OptionError
        A number that is not positive, a velocity that is not reached, with the feasible range.

    >>> lspb_at_rates(0.5, 0.1, 0.05).duration
    7.0
    """
    if length == 0.0:
        raise OptionError("length", "0 with velocity and acceleration", "above 0, or a duration to stand still for")
    length = positive_number("length", length)
    velocity, acceleration = positive_number("velocity", velocity), positive_number("acceleration", acceleration)
    if velocity**2 > acceleration * length * (1.0 + ROUNDING):
        raise OptionError(
            "velocity",
            f"{velocity:g} with acceleration {acceleration:g} over {length:g}",
            f"at most {np.sqrt(acceleration * length):.6g}, or an acceleration of at least {velocity**2 / length:.6g}",
        )
    blend = velocity / acceleration
    duration = max(length / velocity + blend, 2.0 * blend)
    return lspb(length, duration, blend)


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
