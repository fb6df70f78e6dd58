"""Derivatives of a function of time that a person brings: by complex step where it takes complex numbers, else finite.

Im f(t + i h) / h with h = 1e-30 is f'(t) to the last digits: nothing is subtracted. f'' is a difference of f' over five
points. A function of real numbers only gets differences over seven points. The points lie between 0 and the duration.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np

from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import OptionError

Function = Callable[[Any], Any]

IMAGINARY = 1e-30
"""[s] The complex step."""
DIFFERENCES = {True: (2.0**-13, 2), False: (2.0**-9, 3)}
"""Whether complex steps are taken -> the spacing [s] of the points of a difference, and how many lie on each side."""
AGREE = 1e-6
"""Share of the largest speed by which a complex step may miss a difference of real values."""
SURE = 10.0
"""Times the estimated error of a difference, within which it is believed."""


@dataclass(frozen=True, slots=True, eq=False)
class TimeFunction:
    """A function of time with n numbers, on 0 to `duration` [s]; `takes_complex` chooses how it is differentiated."""

    function: Function
    n: int
    duration: float
    name: str
    takes_complex: bool = False

    def value(self, t: float) -> Array:
        """The n numbers at t [s]; raises `OptionError` where the function fails, `ShapeError` for other values."""
        try:
            given = self.function(float(t))
        except Exception as fault:
            found = f"{type(fault).__name__} at t = {t:.6g} s: {' '.join(str(fault).split())}"
            allowed = f"a function of the time in s, from 0 to {self.duration:g}, that gives {self.n} numbers"
            raise OptionError(self.name, found, allowed) from fault
        return fixed_array(f"{self.name} at t = {t:.6g} s", given, (self.n,))

    def values(self, times: Array) -> Array:
        """(k, n) at times (k,); raises as `value`."""
        return np.array([self.value(t) for t in times]).reshape(len(times), self.n)

    def complex_rate(self, times: Array) -> Array:
        """f' (k, n) by complex step; raises whatever the function does with a complex time."""
        out = np.empty((len(times), self.n))
        for row, t in zip(out, times, strict=True):
            row[:] = np.asarray(self.function(complex(t, IMAGINARY))).imag / IMAGINARY
        return out

    def rate(self, times: Array, stretch: float = 1.0) -> Array:
        """f' (k, n) at times (k,); differences take `stretch` times their spacing."""
        return self.complex_rate(times) if self.takes_complex else self._difference(self.values, times, 1, stretch)

    def second_rate(self, times: Array, stretch: float = 1.0) -> Array:
        """f'' (k, n), as `rate`."""
        if self.takes_complex:
            return self._difference(self.complex_rate, times, 1, stretch)
        return self._difference(self.values, times, 2, stretch)

    def rate_error(self, times: Array, second: bool = False) -> float:
        """Largest change at these times of f' or f'' when the points of a difference lie twice as far apart."""
        if self.takes_complex and not second:
            return 0.0
        method = self.second_rate if second else self.rate
        return float(np.abs(method(times) - method(times, 2.0)).max())

    def _difference(self, values: Callable[[Array], Array], times: Array, order: int, stretch: float) -> Array:
        """Derivative of the polynomial through points about each time; at the ends the points lie on one side."""
        spacing, side = DIFFERENCES[self.takes_complex]
        h = min(stretch * spacing, self.duration / (2 * side))
        centres = np.clip(times, side * h, self.duration - side * h)
        steps, powers = np.arange(-side, side + 1.0), np.arange(2 * side + 1)
        offset = ((times - centres) / h)[:, None]
        if order == 1:
            row = powers * offset ** np.maximum(powers - 1, 0)
        else:
            row = powers * (powers - 1) * offset ** np.maximum(powers - 2, 0)
        weights = row @ np.linalg.inv(np.vander(steps, increasing=True)) / h**order
        points = np.clip(centres[:, None] + h * steps, 0.0, self.duration)
        found: Array = np.einsum("kp,kpn->kn", weights, values(points.ravel()).reshape(*points.shape, self.n))
        return found


def time_function(function: Function, n: int, duration: float, name: str, times: Array) -> TimeFunction:
    """The function with the way to differentiate it, tried at times (k,) [s].

    Complex steps are taken where the function takes them without a warning and they agree with differences: a function
    that forgets the imaginary part (`abs`, `float`) does not. Raises as `TimeFunction.value`.
    """
    plain = TimeFunction(function, n, duration, name)
    exact = TimeFunction(function, n, duration, name, takes_complex=True)
    near, far = plain.rate(times), plain.rate(times, 2.0)
    try:
        with catch_warnings():
            simplefilter("error")
            rates = exact.complex_rate(times)
    except Exception:
        return plain
    allowed = AGREE * (1e-3 + np.abs(near).max(axis=0)) + SURE * np.abs(near - far)
    return exact if bool((np.abs(rates - near) <= allowed).all()) else plain


def jump_of(
    value: Callable[[float], Array], times: Array, reach: float, least: float
) -> tuple[int, float, float] | None:
    """Joint, time [s] and size of a jump, or None.

    Where the values at times (k,) change most abruptly, joint by joint, the place is narrowed down to a fifth of
    `reach` [s]. A change above `least` is a jump if it stays when the time that it takes is made eight times shorter.
    Jumps that are smaller than the bend of the function from one of these times to the next are not searched for.
    """
    coarse = np.array([value(t) for t in times])
    for joint in range(coarse.shape[1]):
        start, end = _sharpest(times, coarse[:, joint])
        while end - start > reach / 5.0:
            fine = np.linspace(start, end, 17)
            start, end = _sharpest(fine, np.array([value(t)[joint] for t in fine]))
        middle, change = (start + end) / 2.0, []
        for width in (8.0 * reach, reach):
            a, b = np.clip([middle - width, middle + width], times[0], times[-1])
            change.append(float(value(b)[joint] - value(a)[joint]))
        if abs(change[1]) > max(least, 0.5 * abs(change[0])):
            return joint, float(middle), change[1]
    return None


def _sharpest(times: Array, values: Array) -> tuple[float, float]:
    """The interval whose change differs most from those of its neighbours, with these: a jump may lie on its edge."""
    steps = np.diff(values)
    ends = 3.0 * steps[[1, -2]] - 2.0 * steps[[2, -3]]  # so that the first and last are held against a line, too
    padded = np.concatenate([ends[:1], steps, ends[1:]])
    k = int(np.argmax(np.abs(steps - (padded[:-2] + padded[2:]) / 2.0)))
    return float(times[max(k - 1, 0)]), float(times[min(k + 2, len(steps))])
