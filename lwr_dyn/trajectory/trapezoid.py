"""The trapezoid of speed: rest to rest with a ramp up, a cruise and a ramp down; the law of industrial controllers."""

from __future__ import annotations

import math

import numpy as np

from lwr_dyn.trajectory.laws import DEGREE, Law, positive

NAME = "trapezoid"


def trapezoid(length: float, speed: float, acceleration: float) -> Law:
    """Fastest law from rest to rest under bounds on speed and acceleration.

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
    length, speed = positive("length", length), positive("speed", speed)
    acceleration = positive("acceleration", acceleration)
    ramp = min(speed / acceleration, math.sqrt(length / acceleration))
    top = acceleration * ramp
    cruise = max(length / top - ramp, 0.0)
    rows = [[0.0, 0.0, acceleration / 2.0]]
    knots = [0.0, ramp]
    if cruise > 0.0:
        rows.append([top * ramp / 2.0, top, 0.0])
        knots.append(ramp + cruise)
    rows.append([top * (ramp / 2.0 + cruise), top, -acceleration / 2.0])
    knots.append(2.0 * ramp + cruise)
    return Law(NAME, length, np.array(knots), np.array([row + [0.0] * (DEGREE - 2) for row in rows]))
