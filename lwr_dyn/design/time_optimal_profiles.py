"""Motion profiles made of parabolas: from squared speeds on a grid of places, and with knots only at samples."""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.trajectory.motion_profile import DEGREE, MotionProfile

NAME = "least time"
EARLY = 1e-12
"""Share of its time by which a knot lies before its sample, so that rounding cannot put it behind."""


def profile_of_squares(s: Array, x: Array) -> MotionProfile:
    """s(t) with ds^2 = x (k,) at s (k,), from 0 and from rest to rest; dds is constant between two places."""
    speed = np.sqrt(x)
    return _parabolas(2.0 * np.diff(s) / (speed[:-1] + speed[1:]), s, speed)


def on_samples(profile: MotionProfile, rate: float) -> MotionProfile:
    """The profile with dds constant from sample to sample, `rate` [Hz] of them a second, and no faster anywhere.

    At the samples it has the speeds of the profile, stretched to a whole number of samples and by what the corners
    that are cut off take from its length.
    """
    samples = max(2, int(np.ceil(profile.duration * rate * (1.0 - 1e-12))))
    while True:
        times = np.full(samples, (1.0 - EARLY) / rate)
        speed = profile.at(np.linspace(0.0, profile.duration, samples + 1)).ds.copy()
        speed[[0, -1]] = 0.0
        s = np.concatenate([[0.0], np.cumsum(0.5 * (speed[:-1] + speed[1:]) * times)])
        if s[-1] >= profile.length:
            return _parabolas(times, s * (profile.length / s[-1]), speed * (profile.length / s[-1]))
        samples += 1


def times_at(profile: MotionProfile, s: float) -> list[float]:
    """When a profile that never stands still is at s, 0 < s < length [s]."""
    at = profile.at(profile.knots).s
    k = int(np.searchsorted(at, s, side="right")) - 1
    start, speed, half = profile.coefficients[k, :3]
    root = np.sqrt(max(speed**2 + 4.0 * half * (s - start), 0.0))
    return [float(profile.knots[k] + 2.0 * (s - start) / (speed + root))] if speed + root > 0.0 else []


def _parabolas(times: Array, s: Array, speed: Array) -> MotionProfile:
    c = np.zeros((times.size, DEGREE + 1))
    c[:, 0], c[:, 1], c[:, 2] = s[:-1], speed[:-1], np.diff(speed) / (2.0 * times)
    return MotionProfile(NAME, float(s[-1]), np.concatenate([[0.0], np.cumsum(times)]), c)
