"""LSPB laws: linear segments with parabolic blends (trapezoidal speed), rest to rest, in three quadratic pieces.

    s = A t^2/2                     0 <= t <= t_c
    s = (L - V t_f)/2 + V t         t_c < t <= t_f - t_c          V = A t_c = L/(t_f - t_c)
    s = L - A (t_f - t)^2/2         t_f - t_c < t <= t_f

Two of duration t_f, blend time t_c, velocity V and acceleration A fix the law of a length L. What the WAM paper prints
as velocity in (3), 4 L/(t_f^2 - (2 (t_c - t_f/2))^2) = L/(t_c (t_f - t_c)), is the acceleration A.
"""

from __future__ import annotations

import numpy as np

from lwr_dyn.errors import OptionError
from lwr_dyn.trajectory.laws import DEGREE, Law, positive

NAME = "LSPB"
ROUNDING = 1e-12
"""Relative: how far a request may stand beyond the triangular profile and still mean it."""


def lspb(length: float, duration: float, blend: float) -> Law:
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

    >>> law = lspb(0.5, 7.0, 1.0)
    >>> round(law.peaks().speed, 6), round(law.peaks().acceleration, 6), law.at([3.5]).s
    (0.083333, 0.083333, array([0.25]))
    """
    duration, blend = positive("duration", duration), positive("blend", blend)
    if blend > duration / 2.0 * (1.0 + ROUNDING):
        raise OptionError("blend", f"{blend:g} s", f"above 0, at most {duration / 2.0:g} s, half of {duration:g} s")
    blend = min(blend, duration / 2.0)
    if length == 0.0:
        return Law(NAME, 0.0, np.array([0.0, duration]), np.zeros((1, DEGREE + 1)))
    length = positive("length", length)
    velocity = length / (duration - blend)
    acceleration = velocity / blend
    knots = [0.0, blend, duration - blend, duration]
    rows = [
        [0.0, 0.0, acceleration / 2.0],
        [velocity * blend / 2.0, velocity, 0.0],
        [length - velocity * blend / 2.0, velocity, -acceleration / 2.0],
    ]
    if not knots[1] < knots[2]:  # no cruise
        knots, rows = [0.0, duration / 2.0, duration], [rows[0], rows[2]]
    return Law(NAME, length, np.array(knots), np.array([row + [0.0] * (DEGREE - 2) for row in rows]))


def lspb_at_velocity(length: float, duration: float, velocity: float) -> Law:
    """LSPB in a given time with a given cruise velocity.

    Parameters
    ----------
    length : float
        [m or rad]; 0 is an axis that stands still for `duration`, whatever the velocity.
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
    duration, velocity = positive("duration", duration), positive("velocity", velocity)
    if length == 0.0:
        return lspb(0.0, duration, duration / 2.0)
    length = positive("length", length)
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


def lspb_at_rates(length: float, velocity: float, acceleration: float) -> Law:
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
    length = positive("length", length)
    velocity, acceleration = positive("velocity", velocity), positive("acceleration", acceleration)
    if velocity**2 > acceleration * length * (1.0 + ROUNDING):
        raise OptionError(
            "velocity",
            f"{velocity:g} with acceleration {acceleration:g} over {length:g}",
            f"at most {np.sqrt(acceleration * length):.6g}, or an acceleration of at least {velocity**2 / length:.6g}",
        )
    blend = velocity / acceleration
    duration = max(length / velocity + blend, 2.0 * blend)
    return lspb(length, duration, blend)
