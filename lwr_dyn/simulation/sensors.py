"""Encoders: what the controller sees of the joints is rounded to counts, noisy, and has no velocity."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.control.velocity import FilteredDifference
from lwr_dyn.errors import OptionError

Sensor = Callable[[Array, Array], tuple[Array, Array]]
"""(q, dq) as they are -> (q, dq) as they are measured; called once a sample, in order."""


@dataclass(frozen=True, slots=True)
class Encoder:
    """A position sensor at every joint, and the filter that makes velocities of its readings.

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
        A negative or non-finite resolution or noise; the cut-off is judged against the rate when a run begins.
    """

    resolution: float = 0.0
    noise: float = 0.0
    cutoff_hz: float = 100.0

    def __post_init__(self) -> None:
        for name, value in (("encoder resolution", self.resolution), ("encoder noise", self.noise)):
            if not (isfinite(value) and value >= 0.0):
                raise OptionError(name, value, "a number >= 0, in rad or m")

    @classmethod
    def of_bits(cls, bits: int, noise: float = 0.0, cutoff_hz: float = 100.0) -> Encoder:
        """An encoder with 2^bits counts a turn.

        >>> round(Encoder.of_bits(12).resolution * 1e3, 3)
        1.534
        """
        return cls(2 * np.pi / 2**bits, noise, cutoff_hz)

    def sensor(self, q0: Array, dq0: Array, samples: int, rate: float, seed: int) -> Sensor:
        """A sensor for one run of `samples` readings at `rate` [Hz]; the same seed gives the same noise.

        The velocity filter starts at the first reading with velocity dq0.
        """
        offsets = np.random.default_rng(seed).normal(0.0, self.noise, (samples, q0.size))
        rows = iter(offsets)
        resolution = self.resolution
        velocity = FilteredDifference(self.cutoff_hz, rate)
        begun = False

        def read(q: Array) -> Array:
            shown = q + next(rows)
            return np.asarray(np.round(shown / resolution) * resolution if resolution > 0.0 else shown)

        def measure(q: Array, dq: Array) -> tuple[Array, Array]:
            nonlocal begun
            shown = read(q)
            if not begun:
                begun = True
                velocity.start(shown, dq0)
                return shown, dq0
            return shown, velocity(shown)

        return measure
