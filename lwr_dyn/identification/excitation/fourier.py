"""Joint motions as finite Fourier series that begin and end at rest.

    q_j(t) = q0_j + sum_k a_jk / (k w) sin(k w t) - b_jk / (k w) cos(k w t),   w = 2 pi / T,  k = 1 ... H

With sum_k a_jk = 0 and sum_k k b_jk = 0 the speed and the acceleration vanish at t = 0 and t = T, so that a controller
can start and stop there. Both conditions are linear: the series has 2 H - 1 free coordinates a joint.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, freeze_arrays, real_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Motion
from lwr_dyn.model.shown import short_repr

MOST_HARMONICS = 50


@dataclass(frozen=True, slots=True, eq=False)
class FourierMotion:
    """A motion of n joints for `duration` [s]: `centre` (n,) [rad or m], `sines`, `cosines` (H, n) [rad/s or m/s].

    A reference that any simulation takes: before 0 and after its end it stands still.

    References
    ----------
    Swevers et al., Optimal robot excitation and identification (1997), eq. 13.
    """

    duration: float
    centre: Array
    sines: Array
    cosines: Array
    name: ClassVar[str] = "FourierMotion"
    """In run files."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "centre", "sines", "cosines")

    def sample(self, t: ArrayLike) -> Motion:
        """The motion at times t (k,) [s], exact derivatives; raises `ShapeError`."""
        times = np.atleast_1d(real_array("t", t))
        at = np.clip(times, 0.0, self.duration)
        moving = (times == at)[:, None]
        w = 2.0 * np.pi / self.duration * np.arange(1, len(self.sines) + 1)
        S, C = np.sin(np.outer(at, w)), np.cos(np.outer(at, w))
        q = self.centre + S @ (self.sines / w[:, None]) - C @ (self.cosines / w[:, None])
        dq = C @ self.sines + S @ self.cosines
        ddq = C @ (self.cosines * w[:, None]) - S @ (self.sines * w[:, None])
        return Motion(times, q, moving * dq, moving * ddq)


@dataclass(frozen=True, slots=True, eq=False)
class FourierBasis:
    """The series at fixed times: q = position @ X, dq = speed @ X, ddq = acceleration @ X, coordinates X (2 H - 1, n).

    `position`, `speed`, `acceleration` are (k, 2 H - 1); the first coordinate is the centre, the others move about it.
    """

    duration: float
    harmonics: int
    position: Array
    speed: Array
    acceleration: Array
    free: Array
    """(2 H + 1, 2 H - 1): centre, a, b of the free coordinates."""

    @property
    def count(self) -> int:
        """Free coordinates of a joint."""
        return int(self.free.shape[1])

    def motion(self, X: Array) -> FourierMotion:
        """The series of coordinates X (2 H - 1, n)."""
        centre, sines, cosines = np.split(self.free @ X, [1, 1 + self.harmonics])
        return FourierMotion(self.duration, centre[0], sines, cosines)


def fourier_basis(duration: float, harmonics: int, instants: int) -> FourierBasis:
    """The basis at `instants` times, equally spaced from 0, the last one before `duration`.

    Raises
    ------
    OptionError
        A duration that is not above 0; less than 2 or more than `MOST_HARMONICS` harmonics.

    >>> basis = fourier_basis(10.0, 5, 50)
    >>> basis.count, float(np.abs(basis.speed[0]).max().round(12)), float(np.abs(basis.acceleration[0]).max().round(12))
    (9, 0.0, 0.0)
    """
    if not (math.isfinite(duration) and duration > 0.0):
        raise OptionError("duration", duration, "a time above 0 s")
    if not 2 <= harmonics <= MOST_HARMONICS:
        raise OptionError("harmonics", harmonics, f"2 to {MOST_HARMONICS}")
    k = np.arange(1, harmonics + 1)
    w = 2.0 * np.pi / duration * k
    angle = np.outer(np.arange(instants) * (duration / instants), w)
    S, C, none = np.sin(angle), np.cos(angle), np.zeros((instants, 1))
    free = np.zeros((2 * harmonics + 1, 2 * harmonics - 1))
    free[0, 0] = 1.0
    free[1 : harmonics + 1, 1:harmonics] = _across(np.ones(harmonics))
    free[harmonics + 1 :, harmonics:] = _across(k.astype(np.float64))
    position, speed = np.hstack([none + 1.0, S / w, -C / w]) @ free, np.hstack([none, C, S]) @ free
    return FourierBasis(duration, harmonics, position, speed, np.hstack([none, -S * w, C * w]) @ free, free)


def _across(direction: Array) -> Array:
    """An orthonormal basis (H, H - 1) across a vector of positive numbers, by a Householder mirror."""
    v = direction / np.linalg.norm(direction)
    v = v + np.eye(len(v))[0]
    mirror = np.eye(len(v)) - 2.0 * np.outer(v, v) / (v @ v)
    return np.asarray(mirror[:, 1:])
