"""The sampled loop over frequency: its gain L, and the sensitivity of each joint with all other loops closed.

At the torques of the plant the loop is u = -L(z) u, L = z^-d K(z) P(z), with P the exact zero-order hold of the plant
and K the controller. The entry i of the diagonal of S = (I + L)^-1 is 1 / (1 + L_i), where L_i is the loop cut at
joint i alone: |S_ii| does not change with the units of the joints, and 1 / max |S_ii| is the distance of the Nyquist
curve of L_i from -1. By it the gain of joint i alone may at least grow by Ms / (Ms - 1) and fall by Ms / (Ms + 1).

References
----------
Skogestad, Postlethwaite, *Multivariable Feedback Control*, section 2.4 (Ms and the margins that it guarantees).
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.control.linear_feedback import LinearFeedback
from lwr_dyn.design.resting_plant import RestingPlant
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, Sampling
from lwr_dyn.foundation.arrays import Array

Complex = NDArray[np.complexfloating[Any, Any]]
FREQUENCIES = 160
"""Of the grid: neighbours differ by 6 %."""
DECADES = 4.0
"""Below half the rate."""
PART = 50
"""Poses that are computed at once: their matrices take some 10 MB."""
FINER = 12
"""Frequencies between two neighbours of the grid, where a peak is refined."""


def frequency_grid(rate: float, count: int = FREQUENCIES) -> Array:
    """Frequencies [Hz], evenly in their logarithm, from rate / 2e4 to just below half the rate."""
    return np.asarray(0.4999 * rate * np.logspace(-DECADES, 0.0, count))


@dataclass(frozen=True, slots=True, eq=False)
class PlantResponse:
    """What the sensors of a held plant read of its torques, at points z of the unit circle: (k, f, n, n) each.

    `torque` is None on a plant without joint torque sensors.
    """

    z: Complex
    position: Complex
    velocity: Complex
    torque: Complex | None

    @classmethod
    def of(cls, plant: RestingPlant, rate: float, hz: Array) -> Self:
        """At frequencies (f,) [Hz], or (k, f) where each pose has its own."""
        z = np.exp(2j * np.pi * np.atleast_2d(hz) / rate)
        A, b = plant.held(1.0 / rate)
        shifted = z[..., None, None] * np.eye(plant.size) - A[:, None]
        state = np.linalg.solve(shifted, np.broadcast_to(b[:, None], (*shifted.shape[:2], *b.shape[1:])))
        torque = None if plant.torque is None else _complex(plant.torque[:, None] @ state)
        return cls(z, _complex(plant.position @ state), _complex(plant.velocity @ state), torque)

    def loop_gain(self, law: LinearFeedback, sampling: Sampling) -> Complex:
        """L (k, f, n, n) with this controller, whose matrices are those of a `RestingLoop`."""
        z, T = self.z[..., None, None], 1.0 / sampling.rate
        pole = sampling.filter_pole
        speed = self.velocity
        if sampling.cutoff_hz is not None:
            speed = (1 - pole) / T * (1 - 1 / z) / (1 - pole / z) * self.position
        total = law.position[:, None] @ self.position + law.velocity[:, None] @ speed
        if law.integral is not None:
            integral = np.diag(law.integral) if law.integral.ndim == 1 else law.integral[:, None]
            total = total + (T / (z - 1)) * (integral @ self.position)
        if law.torque is not None:
            read = np.eye(law.torque.shape[-1]) / z if self.torque is None else self.torque
            total = total + law.torque[:, None] @ read
        return np.asarray(z**-sampling.delay * total)


def _complex(values: Any) -> Complex:
    return np.asarray(values, dtype=np.complex128)


def loop_gain(loop: RestingLoop, sampling: Sampling, hz: Array) -> Complex:
    """L (k, f, n, n) of a loop at frequencies [Hz] as `PlantResponse.of` takes them."""
    return PlantResponse.of(loop.plant, sampling.rate, hz).loop_gain(loop.feedback, sampling)


def sensitivity(gain: Complex) -> Complex:
    """S_ii (k, f, n): the diagonal of (I + L)^-1."""
    inverse = np.linalg.inv(np.eye(gain.shape[-1]) + gain)
    return np.asarray(np.diagonal(inverse, axis1=-2, axis2=-1))


def single_loops(gain: Complex) -> Complex:
    """L_i = 1 / S_ii - 1 (k, f, n): the loop cut at joint i, all others closed."""
    return np.asarray(1.0 / sensitivity(gain) - 1.0)


def largest_sensitivity(loop: RestingLoop, sampling: Sampling, count: int = FREQUENCIES) -> Array:
    """max |S_ii| over a grid of `count` frequencies, (k, n) for each pose and joint; inf where the loop is unstable."""
    hz, k = frequency_grid(sampling.rate, count), len(loop.plant.A)
    parts = [np.arange(i, min(i + PART, k)) for i in range(0, k, PART)]
    return np.concatenate([_largest(loop.at(rows), sampling, hz) for rows in parts])


def _largest(loop: RestingLoop, sampling: Sampling, hz: Array) -> Array:
    found = np.abs(sensitivity(loop_gain(loop, sampling, hz))).max(axis=1)
    found[loop.radius(sampling) > GROWS] = np.inf
    return np.asarray(found)


def refined_peaks(loop: RestingLoop, sampling: Sampling) -> tuple[Array, Array]:
    """max |S_ii| of one pose and the frequency [Hz] where it is, (n,) each, between the points of the grid.

    Of an unstable loop too, whose |S_ii| is the distance from -1 all the same and no margin.
    """
    hz = frequency_grid(sampling.rate)
    coarse = np.abs(sensitivity(loop_gain(loop, sampling, hz)))[0]
    near = np.clip(coarse.argmax(axis=0), 1, hz.size - 2)
    fine = np.geomspace(hz[near - 1], hz[near + 1], 2 * FINER + 1)  # (f, n)
    values = np.array([np.abs(sensitivity(loop_gain(loop, sampling, fine[:, i])))[0, :, i] for i in range(near.size)])
    at = values.argmax(axis=1)
    joints = np.arange(near.size)
    return values[joints, at], fine[at, joints]
