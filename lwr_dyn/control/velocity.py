"""Velocity from an encoder: the difference of two samples, smoothed by a first-order low-pass."""

from math import exp, isfinite, pi

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import OptionError


class FilteredDifference:
    """v_k = a v_{k-1} + (1 - a) (q_k - q_{k-1}) / T, a = exp(-2 pi f_c T): a first-order low-pass, exact under hold.

    It lags by half a period (the difference) plus about 1/(2 pi f_c) (the filter); one count of an encoder makes a
    velocity of (1 - a) count/T instead of count/T.

    Parameters
    ----------
    cutoff_hz : float
        f_c [Hz], where the low-pass is 3 dB down.
    rate : float
        Samples per second, 1/T [Hz].

    Raises
    ------
    OptionError
        A frequency that is not positive, or a cut-off not below half the rate.

    >>> v = FilteredDifference(cutoff_hz=100.0, rate=1000.0)
    >>> v.start([0.0])
    >>> for k in range(1, 50):
    ...     out = v(np.array([k * 2e-3]))
    >>> out.round(9)
    array([2.])
    """

    __slots__ = ("_last", "_value", "cutoff_hz", "pole", "rate")

    def __init__(self, cutoff_hz: float, rate: float) -> None:
        if not (isfinite(rate) and rate > 0.0):
            raise OptionError("rate", rate, "a number above 0, in Hz")
        if not (isfinite(cutoff_hz) and 0.0 < cutoff_hz < rate / 2):
            raise OptionError("cut-off of the velocity filter", cutoff_hz, f"above 0 and below {rate / 2:g} Hz")
        self.cutoff_hz, self.rate = float(cutoff_hz), float(rate)
        self.pole = exp(-2.0 * pi * cutoff_hz / rate)
        self._last = self._value = np.zeros(0)

    def start(self, q: ArrayLike, dq: ArrayLike | None = None) -> None:
        """Starts at position q (n,) [rad] with velocity dq (n,) [rad/s], rest if not given; raises `ShapeError`."""
        self._last = np.atleast_1d(np.asarray(q, dtype=np.float64))
        n = self._last.size
        self._value = np.zeros(n) if dq is None else joint_array("dq", dq, n)

    def __call__(self, q: Array) -> Array:
        """The velocity (n,) [rad/s] after the next sample q (n,) [rad]."""
        difference = (q - self._last) * self.rate
        self._last = q
        self._value = difference + self.pole * (self._value - difference)
        return self._value
