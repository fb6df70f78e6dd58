"""A momentum observer beside any controller, "LAW+observer": its estimate and collision flag as signals of a run."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.laws.collision_threshold import CUTOFF, NOISE, PAYLOAD, CollisionThreshold, box_threshold
from lwr_dyn.control.laws.momentum_observer import GAIN, MomentumObserver
from lwr_dyn.control.laws.wrapped import Wrapped, layers_of
from lwr_dyn.control.protocol import Controller, JointReadings, describe, positive_gains, reset, saturate
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm

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
