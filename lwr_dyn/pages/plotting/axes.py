"""Axes of a drawn panel: their range by the data, a few round ticks, and numbers as short texts."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lwr_dyn.foundation.arrays import Array

NEAR_LEVEL = 1.5
"""A level is drawn when it is at most so many times as far from zero as the data; otherwise it is said in words."""
_PADDING = 0.06
"""Of the range, left free at either end."""
_STEPS = (1.0, 2.0, 5.0)
_LONGEST = 6
"""Letters of a tick; beyond, a power of ten stands beside the axis."""


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis from `low` to `high` with its ticks."""

    low: float
    high: float
    ticks: tuple[float, ...]
    is_logarithmic: bool = False

    def share(self, values: Array | float) -> Array:
        """How far along the axis values are, 0 at `low`, 1 at `high`."""
        low, high, x = self.low, self.high, np.asarray(values, dtype=np.float64)
        if self.is_logarithmic:
            low, high, x = math.log10(low), math.log10(high), np.log10(np.maximum(x, self.low))
        return np.asarray((x - low) / (high - low))

    @property
    def power(self) -> int:
        """The power of ten that stands beside the axis, so that its ticks are short; 0 for none."""
        largest = max(map(abs, self.ticks), default=0.0)
        if self.is_logarithmic or largest == 0.0 or (largest < 1e4 and max(map(len, self._texts(0))) <= _LONGEST):
            return 0
        return 3 * math.floor(math.log10(largest) / 3)

    @property
    def labels(self) -> tuple[str, ...]:
        """The ticks as text, in units of the power of ten: as many decimals as their step needs."""
        return tuple(map(short, self.ticks)) if self.is_logarithmic else self._texts(self.power)

    def _texts(self, power: int) -> tuple[str, ...]:
        ticks = [tick / 10.0**power for tick in self.ticks]
        step = min((b - a for a, b in pairwise(ticks)), default=1.0)
        decimals = next((d for d in range(12) if abs(step * 10**d - round(step * 10**d)) < 1e-6 * step * 10**d), 12)
        return tuple(_signed(f"{tick + 0.0:.{decimals}f}") for tick in ticks)


def axis_of(values: Array, most: int = 4, padding: float = _PADDING) -> Axis:
    """A linear axis over the finite numbers among values; at least two ticks.

    >>> axis_of(np.array([0.0, 14.0]), padding=0.0).ticks
    (0.0, 5.0, 10.0)
    """
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        half = 0.1 * abs(high) or 1.0
        low, high = low - half, high + half
    pad = padding * (high - low)
    low, high = low - pad, high + pad
    return Axis(low, high, _ticks(low, high, most))


def logarithmic_axis(values: Array, decades: int = 6) -> Axis:
    """A logarithmic axis over the positive numbers among values, at most `decades` down from the largest."""
    positive = values[np.isfinite(values) & (values > 0.0)]
    top = math.ceil(math.log10(positive.max()))
    bottom = max(math.floor(math.log10(np.quantile(positive, 0.02))), top - decades)
    bottom = min(bottom, top - 1)
    every = -(-(top - bottom) // 6)
    return Axis(10.0**bottom, 10.0**top, tuple(10.0**k for k in range(bottom, top + 1, every)), True)


def frequency_axis(values: Array) -> Axis:
    """A logarithmic axis over positive numbers as they are; ticks at 1, 2, 5 times powers of ten, or at powers.

    >>> frequency_axis(np.array([0.6, 45.0])).ticks
    (1.0, 2.0, 5.0, 10.0, 20.0)
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    steps = _STEPS if high < 200.0 * low else _STEPS[:1]
    ticks = tuple(10.0**k * step for k in powers for step in steps if low <= 10.0**k * step <= high)
    return Axis(low, high, ticks or (low, high), True)


def _ticks(low: float, high: float, most: int) -> tuple[float, ...]:
    """Multiples of a round step within the axis: at most `most`, at least two."""
    scale = 10.0 ** math.floor(math.log10((high - low) / most))
    steps = [scale * power * step for power in (0.1, 1.0, 10.0) for step in _STEPS]
    multiples = [(step, math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)) for step in steps]
    enough = [found for found in multiples if found[2] > found[1]]
    step, first, last = next((found for found in enough if found[2] - found[1] < most), enough[-1])
    return tuple(step * k for k in range(first, last + 1))


def round_length(most: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is at most `most`, which is positive.

    >>> round_length(0.49), round_length(0.2), round_length(1e3)
    (0.2, 0.2, 1000.0)
    """
    scale = 10.0 ** math.floor(math.log10(most) + 1e-9)
    return next(step * scale for step in (5.0, 2.0, 1.0) if step * scale <= most * (1.0 + 1e-6))


def apart(shares: Sequence[float], least: float) -> list[float]:
    """Places from 0 to 1 in ascending order, moved until neighbours are `least` apart and none is beyond 1.

    >>> [round(place, 3) for place in apart([0.2, 0.25, 1.0], 0.1)], apart([0.875, 1.0], 0.25)
    ([0.2, 0.3, 1.0], [0.75, 1.0])
    """
    places: list[float] = []
    for share in shares:
        places.append(max(share, places[-1] + least) if places else share)
    beyond = max(0.0, places[-1] - 1.0) if places else 0.0
    return [place - beyond for place in places]


def short(value: float, digits: int = 3) -> str:
    """A number with a few significant digits and a true minus; far from 1 as a power of ten.

    >>> short(-0.000331), short(40.24), short(2.4e-7), short(0.0), short(1e-5)
    ('\u22120.000331', '40.2', '2.4\u00b710\u207b\u2077', '0', '10\u207b\u2075')
    """
    if value == 0.0 or 1e-4 <= abs(value) < 1e5:
        return _signed(f"{float(f'{value:.{digits}g}'):.10f}".rstrip("0").rstrip("."))
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    power = power_of_ten(int(exponent))
    return _signed(power if mantissa == "1" else f"{mantissa}\u00b7{power}")


def power_of_ten(exponent: int) -> str:
    """A power of ten with its exponent raised."""
    return f"10{str(exponent).translate(_RAISED)}"


def raised(text: str) -> str:
    """Text with the exponents 0 to 4 of units raised.

    >>> raised("kg m^2 s^-1")
    'kg m\u00b2 s\u207b\u00b9'
    """
    return re.sub(r"\^(-?[0-4])", lambda found: found[1].translate(_RAISED), text)


_RAISED = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")


def _signed(text: str) -> str:
    return text.replace("-", "\u2212")
