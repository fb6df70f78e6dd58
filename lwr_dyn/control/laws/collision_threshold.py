"""Levels that the estimate of a momentum observer passes only in a collision: what the model lacks, plus noise.

    level = bias + SIGMAS sigma

The bias (n,) [N m] bounds what an unknown payload and friction leave in the estimate. sigma (n,) is the standard
deviation that noise e of the encoders leaves: the observer differentiates p = B v, and v is itself a filtered
difference of the readings, so r_i = sum_j B_ij H e_j with

    H(z) = (1 - a) / (1 - a z^-1) (1 - z^-1) / T  (1 - a_v) / (1 - a_v z^-1) (1 - z^-1) / T,
    a = exp(-K_O T),   a_v = exp(-2 pi f_c T),

and sigma_i = |e| ||H||_2 (sum_j B_ij^2)^(1/2). The share of e in B, C and g is left out: it is smaller by K_O^-1 times
the slope of g over that of B v, a hundredth on the LWR 4+. Rounding to counts of `delta` adds delta^2/12 to |e|^2.

With Gaussian noise 7 sigma are passed once in 4e11 independent values a joint; they are not independent, and bias and
noise are not all that there is, so a rate of false alarms is only what runs have shown.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, pi
from typing import Any

import numpy as np

from lwr_dyn.control.velocity import FilteredDifference
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import with_payload
from lwr_dyn.model.run import Motion

PAYLOAD, OFFSET, NOISE, CUTOFF = 0.3, 0.05, 1e-5, 100.0
"""Payload error [kg] and how far from the flange's centre it may be [m], noise of the encoders [rad], cut-off of
the velocity filter [Hz] where nothing else is known."""
SIGMAS = 7.0
"""Gaussian noise passes three once in 370 independent values: every few seconds at 1 kHz."""
POSES, SEED = 2000, 26
"""Poses of the joint box from which the bounds of `box_threshold` are taken."""


@dataclass(frozen=True, slots=True, eq=False)
class CollisionThreshold:
    """Levels of a momentum observer: `bias` (n,) [N m]; `inertia` (n,), the largest (sum_j B_ij^2)^(1/2) [kg m^2].

    `noise` is the standard deviation of the readings [rad], `cutoff_hz` that of their velocity filter [Hz].
    """

    bias: Array
    inertia: Array | None = None
    noise: float = 0.0
    cutoff_hz: float = CUTOFF

    def __post_init__(self) -> None:
        freeze_arrays(self, "bias")
        if not (np.isfinite(self.noise) and self.noise >= 0.0):
            raise OptionError("observer noise", self.noise, "a number >= 0, in rad or m")

    def sigma(self, gain: Array, interval: float) -> Array:
        """Noise of the estimate (n,) [N m] for the gain K_O (n,) [1/s] and samples `interval` [s] apart."""
        if self.noise == 0.0 or self.inertia is None:
            return np.zeros_like(self.bias)
        FilteredDifference(self.cutoff_hz, 1.0 / interval)  # raises where the cut-off is not below half the rate
        each: Array = self.noise * self.inertia * [noise_gain(k, self.cutoff_hz, interval) for k in gain.tolist()]
        return each

    def level(self, gain: Array, interval: float) -> Array:
        """bias + SIGMAS sigma (n,) [N m]."""
        return self.bias + SIGMAS * self.sigma(gain, interval)

    def record(self) -> dict[str, Any]:
        """The threshold as JSON values."""
        inertia = None if self.inertia is None else self.inertia.tolist()
        noise = {"noise": self.noise, "cutoff_hz": self.cutoff_hz, "sigmas": SIGMAS}
        return {"bias": self.bias.tolist(), "inertia": inertia, **noise}


def noise_gain(gain: float, cutoff_hz: float, interval: float) -> float:
    """||H||_2 [1/s^2]: standard deviation of the estimate a unit of inertia and of noise; see this module."""
    a, c = exp(-gain * interval), exp(-2 * pi * cutoff_hz * interval)
    k = np.arange(int(np.ceil(40.0 / (1.0 - max(a, c)))))
    # (1 - z^-1)^2 over two poles: the step responses' second differences, by the convolution of both decays
    both = (k + 1) * a**k if abs(a - c) < 1e-9 else (a ** (k + 1) - c ** (k + 1)) / (a - c)
    response = np.diff(both, 2, prepend=[0.0, 0.0]) * (1 - a) * (1 - c) / interval**2
    return float(np.linalg.norm(response))


def box_threshold(
    arm: Arm, dynamics: Dynamics, payload: float = PAYLOAD, noise: float = NOISE, cutoff_hz: float = CUTOFF
) -> CollisionThreshold:
    """The threshold for any pose: bias from the weight of a payload error at the flange, and friction.

    The payload's inertia is left out: motions that accelerate the flange by a share of g need a threshold larger by
    this share, or `motion_threshold`. Raises `OptionError` for a payload error or a noise below 0.
    """
    lower, upper = (np.where(np.isfinite(x), x, end) for x, end in ((arm.lower, -np.pi), (arm.upper, np.pi)))
    q = np.random.default_rng(SEED).uniform(lower, upper, (POSES, arm.n))
    return _threshold(arm, dynamics, _payload_bias(arm, payload, lambda d: d.gravity_vector(q)), q, noise, cutoff_hz)


def motion_threshold(
    arm: Arm,
    dynamics: Dynamics,
    motion: Motion,
    payload: float = PAYLOAD,
    noise: float = NOISE,
    cutoff_hz: float = CUTOFF,
) -> CollisionThreshold:
    """The threshold for one motion: bias from the torque that a payload error at the flange takes on it, and friction.

    Raises as `box_threshold`.
    """
    state = motion.q, motion.dq, motion.ddq
    bias = _payload_bias(arm, payload, lambda d: d.inverse_dynamics(*state))
    return _threshold(arm, dynamics, bias, motion.q, noise, cutoff_hz)


def _payload_bias(arm: Arm, payload: float, torques: Callable[[Dynamics], Array]) -> Array:
    """The largest torque (n,) of a payload error, its centre anywhere within `OFFSET` of that of the flange.

    The torque is linear in the first moment, and `OFFSET`^2 of its inertia is next to nothing: so along each axis once.
    """
    without = torques(dynamics_of(arm))
    centre, *moved = (
        torques(dynamics_of(arm.with_chain(with_payload(arm.chain, payload, com)))) - without
        for com in (np.zeros(3), *(OFFSET * np.eye(3)))
    )
    aside = np.sqrt(sum((torque - centre) ** 2 for torque in moved))
    return np.asarray((np.abs(centre) + aside).max(axis=0))


def _threshold(arm: Arm, dynamics: Dynamics, bias: Array, q: Array, noise: float, cutoff: float) -> CollisionThreshold:
    rows = np.linalg.norm(dynamics.mass_matrix(q), axis=-1).max(axis=0)
    return CollisionThreshold(bias + friction_level(arm), rows, noise, cutoff)


def friction_level(arm: Arm) -> Array:
    """The most that each joint's friction can take (n,) [N m], up to its speed limit; 0 where it is not known."""
    levels = np.zeros(arm.n)
    fastest = np.where(np.isfinite(arm.velocity), arm.velocity, 0.0)
    for j, model in enumerate(arm.friction_models()):
        if model is not None:
            sides = (model.positive, model.negative)
            levels[j] = abs(model.offset) + max(
                max(d.holding, d.coulomb) + max(d.viscous, 0.0) * fastest[j] for d in sides
            )
    return levels
