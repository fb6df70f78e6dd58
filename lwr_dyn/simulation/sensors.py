"""Encoders: measured positions are rounded to counts and noisy; velocities are filtered differences of them."""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Self

import numpy as np

from lwr_dyn.control.velocity import FilteredDifference
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError

Sensor = Callable[[Array, Array], tuple[Array, Array]]
"""True (q, dq) -> measured (q, dq); called once a sample, in order."""


@dataclass(frozen=True, slots=True)
class Encoder:
    """A position sensor at every joint, and the filter that computes velocities from its readings.

    Parameters
    ----------
    resolution : float
        One count [rad or m]; 0 for no rounding.
    noise : float
        Standard deviation of the Gaussian noise before rounding [rad or m].
    cutoff_hz : float
        Cut-off of the velocity filter [Hz], see `FilteredDifference`.

    Raises
    ------
    OptionError
        A negative or non-finite resolution or noise; the cut-off is checked against the rate by `velocity_filter`.
    """

    resolution: float = 0.0
    noise: float = 0.0
    cutoff_hz: float = 100.0

    def __post_init__(self) -> None:
        for name, value in (("encoder resolution", self.resolution), ("encoder noise", self.noise)):
            if not (isfinite(value) and value >= 0.0):
                raise OptionError(name, value, "a number >= 0, in rad or m")

    @classmethod
    def of_bits(cls, bits: int, noise: float = 0.0, cutoff_hz: float = 100.0) -> Self:
        """An encoder with 2^bits counts a turn.

        >>> round(Encoder.of_bits(12).resolution * 1e3, 3)
        1.534
        """
        return cls(2 * np.pi / 2**bits, noise, cutoff_hz)

    def velocity_filter(self, rate: float) -> FilteredDifference:
        """The filter for readings at `rate` [Hz]; raises `OptionError` for a cut-off not below half of it."""
        return FilteredDifference(self.cutoff_hz, rate)

    def noise_of(self, samples: int, n: int, seed: int) -> Array:
        """What is added to each reading before rounding, (samples, n) [rad or m]."""
        return np.random.default_rng(seed).normal(0.0, self.noise, (samples, n))

    def sensor(self, q0: Array, dq0: Array, samples: int, rate: float, seed: int) -> Sensor:
        """A sensor for one run of `samples` readings at `rate` [Hz]; the same seed gives the same noise.

        The velocity filter starts at the first reading with velocity dq0.
        """
        noise = iter(self.noise_of(samples, q0.size, seed))
        resolution, velocity = self.resolution, self.velocity_filter(rate)
        begun = False

        def read(q: Array) -> Array:
            noisy = q + next(noise)
            return np.asarray(np.round(noisy / resolution) * resolution if resolution > 0.0 else noisy)

        def measure(q: Array, dq: Array) -> tuple[Array, Array]:
            nonlocal begun
            reading = read(q)
            if begun:
                return reading, velocity(reading)
            begun = True
            velocity.start(reading, dq0)
            return reading, dq0

        return measure
