"""Momentum observer beside any controller ("LAW+observer"): the torque of external forces, without accelerations.

Its estimate and its collision flag are signals of a run.

With the momentum p = B(q) dq the equations of motion are dp/dt = tau + tau_ext + b, b = C(q, dq)^T dq - g(q), since
dB/dt = C + C^T. The estimate r (n,) [N m; N of a sliding joint] follows tau_ext as a first-order low-pass of gain K_O
[1/s], dr/dt = K_O (tau_ext - r). From sample to sample, T apart, with tau held between them:

    r+ = a r + (1 - a) ((p+ - p) / T - tau - (b + b+) / 2),   a = exp(-K_O T)

The bracket is the mean of tau_ext over the interval, to second order in T; the low-pass is exact for it. An Euler step
in place of it errs by K_O T / 2 of tau_ext.

Stability
---------
It acts on nothing, so the loop is as stable as without it. In continuous time and with the exact model r tends to a
constant tau_ext exponentially, and no force hides from it that does work on the joints' coordinates: a force along a
direction in which the arm cannot move (J^T f = 0) is not seen. Sampled, |a| < 1 for every gain; a gain above 1/T is
refused, since it no longer filters. A delay of the commands costs nothing where the loop tells the torque that is
applied (`sense`); otherwise r errs by the change of the torque over the delay. A torque that is cut at its limit is
taken as cut. What the model lacks is in r: an unknown payload (4.6 N m a kg at joint 2 of the LWR 4+ on its IST path),
friction, and noise of the encoders, of which it takes the second difference; the levels below are drawn from these.

On elastic joints the readings of the joint torque sensors take the place of the motors' torques, and B is that of the
links without the rotors, which stand on the other side of the spring.

Source: De Luca, Mattone, "Sensorless robot collision detection and hybrid force/motion control", ICRA 2005, eqs. 8 to
12; De Luca, Albu-Schaeffer, Haddadin, Hirzinger, IROS 2006; Haddadin, De Luca, Albu-Schaeffer, "Robot collisions: a
survey", IEEE Trans. Robotics 33 (2017), section IV. The discrete form follows from them by integration over a sample.

Levels
------
The estimate passes them only in a collision: what the model lacks, plus noise.

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

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import exp, pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control import protocol
from lwr_dyn.control.protocol import Controller, JointReadings, Wrapped, positive_gains, reset, saturate
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import with_payload
from lwr_dyn.model.run import Motion

GAIN = 50.0
"""K_O [1/s]: the estimate reaches 63 % of a step after 20 ms."""

SAME = 1e-9
"""Share by which intervals may differ and count as the same: rounding of the time."""


class MomentumObserver:
    """The estimate `r` (n,) [N m] of the external torque; see this module for the law and its source.

    Parameters
    ----------
    dynamics : Dynamics
        The model.
    gain : float or (n,) array_like
        K_O [1/s].
    rotor : (n,) array_like, optional
        Inertia [kg m^2] that is taken off B: the rotors, where tau is that of joint torque sensors behind the springs.

    Raises
    ------
    ShapeError, OptionError
        A gain of the wrong shape, or not above 0.
    """

    def __init__(self, dynamics: Dynamics, gain: ArrayLike = GAIN, rotor: ArrayLike | None = None) -> None:
        self.gain = positive_gains("observer gain", gain, dynamics.n)
        self._rotor = None if rotor is None else np.asarray(rotor, dtype=np.float64)
        raw = ungated(dynamics)
        self._mass, self._coriolis, self._gravity = raw.mass_matrix, raw.coriolis_matrix, raw.gravity_vector
        self.reset()

    def reset(self) -> None:
        """Forget: the next sample is the first, with r = 0."""
        self.interval = self._t = 0.0
        self.r = self._weight = np.zeros_like(self.gain)
        self._last: tuple[Array, Array] | None = None

    def __call__(self, t: float, q: Array, dq: Array, tau: Array | None) -> Array:
        """R (n,) at the sample of time t [s] with this state; tau (n,) is the mean torque since the sample before.

        Raises `OptionError` at the second sample for a gain above the rate.
        """
        interval, self._t = t - self._t, t
        p, b = self._mass(q) @ dq, dq @ self._coriolis(q, dq) - self._gravity(q)
        if self._rotor is not None:
            p = p - self._rotor * dq
        if self._last is None or tau is None:
            self._last = p, b
            return self.r
        if abs(interval - self.interval) > SAME * interval:
            self.sample_every(interval)
        return self.advance(p, b, tau)

    def sample_every(self, interval: float) -> None:
        """Take samples `interval` [s] apart from here on; `OptionError` for a gain that is too fast for it."""
        fastest = float(self.gain.max())
        if fastest * interval > 1.0 + SAME:
            allowed = f"at most the rate, {1 / interval:g} 1/s: a faster one filters nothing"
            raise OptionError("observer gain", f"{fastest:g} 1/s", allowed)
        self.interval, self._weight = interval, -np.expm1(-self.gain * interval)

    def advance(self, p: Array, b: Array, tau: Array) -> Array:
        """R (..., n) from p, b (..., n) of this sample and the mean torque since the last; for rows of states too."""
        if self._last is not None:
            p_last, b_last = self._last
            mean = (p - p_last) / self.interval - tau - (b + b_last) / 2
            self.r = self.r + self._weight * (mean - self.r)
        self._last = p, b
        return self.r


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
        protocol.filter_pole(self.cutoff_hz, 1.0 / interval)  # raises where the cut-off is not below half the rate
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
    return _threshold(arm, dynamics, q, lambda d: d.gravity_vector(q), payload, noise, cutoff_hz)


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
    return _threshold(arm, dynamics, motion.q, lambda d: d.inverse_dynamics(*state), payload, noise, cutoff_hz)


def _threshold(
    arm: Arm,
    dynamics: Dynamics,
    q: Array,
    torques: Callable[[Dynamics], Array],
    payload: float,
    noise: float,
    cutoff_hz: float,
) -> CollisionThreshold:
    """With the largest torque of a payload error, its centre anywhere within `OFFSET` of that of the flange.

    The torque is linear in the first moment, and `OFFSET`^2 of its inertia is next to nothing: so along each axis once.
    """
    without = torques(dynamics_of(arm))
    centre, *moved = (
        torques(dynamics_of(arm.with_chain(with_payload(arm.chain, payload, com)))) - without
        for com in (np.zeros(3), *(OFFSET * np.eye(3)))
    )
    aside = np.sqrt(sum((torque - centre) ** 2 for torque in moved))
    bias = (np.abs(centre) + aside).max(axis=0)
    rows = np.linalg.norm(dynamics.mass_matrix(q), axis=-1).max(axis=0)
    return CollisionThreshold(bias + friction_level(arm), rows, noise, cutoff_hz)


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
            levels[j] += 0.0 if model.sigmoid is None else model.sigmoid.most
    return levels


SAMPLED_ONLY = ("memory_size", "torque_and_rate")
"""Parts of an inner controller that a wrapper with samples of its own may not offer: a continuous run is refused."""


class Observed(Wrapped):
    """A controller with a momentum observer beside it; it gives the inner controller's torques.

    Signals: "external_torque" (n,), the estimate [N m], and "collision", 1 where a joint's is beyond the threshold.

    Parameters
    ----------
    inner : Controller
    observer, link_side : MomentumObserver
        For rigid joints, and for elastic ones, whose readings of joint torque sensors then take the motors' place.
    threshold : CollisionThreshold
    effort : (n,) array
        Torque limits [N m] of the motors.
    """

    word, label_word = "observer", "with momentum observer"

    def __init__(
        self,
        inner: Controller,
        observer: MomentumObserver,
        link_side: MomentumObserver,
        threshold: CollisionThreshold,
        effort: Array,
    ) -> None:
        super().__init__(inner)
        for part in SAMPLED_ONLY:
            vars(self).pop(part, None)
        self.reset, self.sense, self._inner_sense = self._reset, self._sense, getattr(inner, "sense", None)
        self._rigid, self._elastic, self.threshold, self._effort = observer, link_side, threshold, effort
        self._reset()

    def __getattr__(self, name: str) -> Any:
        if name in SAMPLED_ONLY:
            raise AttributeError(name)
        return super().__getattr__(name)

    @property
    def own_parameters(self) -> dict[str, Any]:
        """Gain and threshold."""
        return {"observer": {"gain": self._rigid.gain.tolist(), **self.threshold.record()}}

    @property
    def signals(self) -> Mapping[str, Any]:
        """The inner controller's, with the estimate and whether it is beyond the threshold."""
        r = self._observer.r
        own = {"external_torque": r, "collision": float((np.abs(r) > self._level).any())}
        return {**getattr(self.inner, "signals", {}), **own}

    def _reset(self) -> None:
        reset(self.inner)
        for observer in (self._rigid, self._elastic):
            observer.reset()
        self._observer = self._rigid
        self._interval, self._level = 0.0, np.full_like(self._effort, np.inf)
        self._readings: JointReadings | None = None
        self._torque: Array | None = None

    def _sense(self, readings: JointReadings) -> None:
        self._readings = readings
        if self._inner_sense is not None:
            self._inner_sense(readings)

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m] of the inner controller."""
        readings = self._readings
        if readings is not None and readings.theta is not readings.q:
            self._observer, torque = self._elastic, np.array(readings.torque)
            # the sensors are read at the samples, their torque is not held between them
            self._observe(t, readings.q, readings.dq, None if self._torque is None else (self._torque + torque) / 2)
            self._torque = torque
            return self.inner(t, q, dq, q_ref, dq_ref, ddq_ref)
        self._observe(t, q, dq, self._torque if readings is None else readings.torque)
        tau = self.inner(t, q, dq, q_ref, dq_ref, ddq_ref)
        if readings is None:
            self._torque = saturate(tau, self._effort)
        return tau

    def _observe(self, t: float, q: Array, dq: Array, torque: Array | None) -> None:
        observer = self._observer
        observer(t, q, dq, torque)
        if observer.interval != self._interval:
            self._interval, self._level = observer.interval, self.threshold.level(observer.gain, observer.interval)


def observed(
    controller: Controller,
    arm: Arm,
    dynamics: Dynamics,
    *,
    observer_gain: ArrayLike = GAIN,
    observer_payload: float = PAYLOAD,
    observer_noise: float = NOISE,
    observer_cutoff: float = CUTOFF,
    observer_threshold: CollisionThreshold | ArrayLike | None = None,
) -> Observed:
    """A controller with a momentum observer.

    Parameters
    ----------
    controller : Controller
    arm : Arm
        As the controller knows it.
    dynamics : Dynamics
        The observer's model.
    observer_gain : float or (n,) array_like
        K_O [1/s].
    observer_payload, observer_noise, observer_cutoff
        Payload error [kg], noise of the encoders [rad], cut-off of the velocity filter [Hz]; see `box_threshold`.
    observer_threshold : CollisionThreshold or (n,) array_like, optional
        In their place; levels [N m] as they stand.

    Raises
    ------
    ShapeError, OptionError
        A gain or level of the wrong shape, or not above 0; a payload error or noise below 0; an observer already.
    """
    if any(isinstance(layer, Observed) for layer in protocol.layers_of(controller)):
        raise OptionError("controller", f"{protocol.describe(controller)['name']} with observer again", "one observer")
    observer = MomentumObserver(dynamics, observer_gain)
    link_side = MomentumObserver(dynamics, observer_gain, arm.armature)
    if observer_threshold is None:
        threshold = box_threshold(arm, dynamics, observer_payload, observer_noise, observer_cutoff)
    elif isinstance(observer_threshold, CollisionThreshold):
        threshold = observer_threshold
    else:
        threshold = CollisionThreshold(positive_gains("observer threshold", observer_threshold, arm.n))
    return Observed(controller, observer, link_side, threshold, arm.effort)
