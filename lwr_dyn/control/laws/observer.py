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
friction, and noise of the encoders, of which it takes the second difference; `collision_threshold` is drawn from these.

On elastic joints the readings of the joint torque sensors take the place of the motors' torques, and B is that of the
links without the rotors, which stand on the other side of the spring.

Source: De Luca, Mattone, "Sensorless robot collision detection and hybrid force/motion control", ICRA 2005, eqs. 8 to
12; De Luca, Albu-Schaeffer, Haddadin, Hirzinger, IROS 2006; Haddadin, De Luca, Albu-Schaeffer, "Robot collisions: a
survey", IEEE Trans. Robotics 33 (2017), section IV. The discrete form follows from them by integration over a sample.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.laws.collision_threshold import CUTOFF, NOISE, PAYLOAD, CollisionThreshold, box_threshold
from lwr_dyn.control.protocol import (
    Controller,
    JointReadings,
    Wrapped,
    describe,
    layers_of,
    positive_gains,
    reset,
    saturate,
)
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm

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
    if any(isinstance(layer, Observed) for layer in layers_of(controller)):
        raise OptionError("controller", f"{describe(controller)['name']} with observer again", "one observer")
    observer, link_side = (
        MomentumObserver(dynamics, observer_gain),
        MomentumObserver(dynamics, observer_gain, arm.armature),
    )
    if observer_threshold is None:
        threshold = box_threshold(arm, dynamics, observer_payload, observer_noise, observer_cutoff)
    elif isinstance(observer_threshold, CollisionThreshold):
        threshold = observer_threshold
    else:
        threshold = CollisionThreshold(positive_gains("observer threshold", observer_threshold, arm.n))
    return Observed(controller, observer, link_side, threshold, arm.effort)
