"""The plant, which need not be the arm that the controller models; external torques on it; the encoders that read it.

Measured positions are rounded to counts and noisy; velocities are filtered differences of them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.protocol import filter_pole, joint_torque
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics, UngatedDynamics, ungated
from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import NotPhysicalError, OptionError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import unphysical_links
from lwr_dyn.simulation.arm_friction import ArmFriction, Mask

ExternalTorque = Callable[[float, Array, Array], Array]
"""tau_external(t, q, dq) (n,) [N m; N of a sliding joint]: B ddq + C dq + g = tau - tau_friction + tau_external.

It must depend on nothing else. An object with `name`, `parameters` and `energy(q)` [J] may stand for it."""


def checked_external(external: ExternalTorque, n: int) -> ExternalTorque:
    """The function, which now raises `ShapeError`, or `OptionError` for one that is not finite or for no function."""
    if not callable(external):
        raise OptionError("external", repr(external), "a function f(t, q, dq) -> tau")

    def checked(t: float, q: Array, dq: Array) -> Array:
        tau = joint_torque(f"external torque at t = {t:g} s", external(t, q, dq), n)
        if not isfinite(tau.dot(tau)) and np.isfinite(q + dq).all():
            raise OptionError(f"external torque at t = {t:g} s", tau.tolist(), "finite numbers")
        return tau

    return checked


@dataclass(frozen=True, slots=True, eq=False)
class Plant:
    """An arm with its dynamics, friction and limits; a limit that is off or unknown is infinite."""

    arm: Arm
    dynamics: Dynamics
    friction: ArmFriction
    lower: Array
    upper: Array
    effort: Array

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.arm.n

    @property
    def ungated(self) -> UngatedDynamics:
        """The engine without the shape gate."""
        return ungated(self.dynamics)

    def at_limit(self, q: Array) -> Array:
        """+1 at or above an upper limit, -1 at or below a lower one, else 0, (n,)."""
        return (q >= self.upper).astype(np.float64) - (q <= self.lower)

    def beyond(self, q: Array) -> Mask:
        """Whether a joint is past a limit, (n,)."""
        return np.asarray((q > self.upper) | (q < self.lower))


def plant_of(
    arm: Arm,
    engine: str | Dynamics,
    friction: ArmFriction | None = None,
    saturate: bool = True,
    position_limits: bool = True,
    allow_unphysical: bool = False,
) -> Plant:
    """The plant of an arm, without friction if none is given.

    Raises `MissingDataError`, `UnknownNameError` (the arm has no inertias; no engine of that name), `ShapeError`
    (dynamics of another number of joints), `NotPhysicalError` (an inertia that no body can have, unless
    `allow_unphysical`).
    """
    bad = unphysical_links(arm.require_dynamics())
    dynamics = dynamics_of(arm, engine) if isinstance(engine, str) else engine
    if dynamics.n != arm.n:
        raise ShapeError("engine", f"{dynamics.n} joints", f"{arm.n} joints, as the plant has")
    if bad and not allow_unphysical:
        raise NotPhysicalError(f"{arm.name} ({arm.reading})", bad)
    free = np.full(arm.n, np.inf)
    return Plant(
        arm, dynamics, friction or ArmFriction.function("none", arm.n, None),
        lower=arm.lower if position_limits else -free,
        upper=arm.upper if position_limits else free,
        effort=arm.effort if saturate else free,
    )  # fmt: skip


Sensor = Callable[[Array, Array], tuple[Array, Array]]
"""True (q, dq) -> measured (q, dq); called once a sample, in order."""


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
        As `filter_pole`.

    >>> v = FilteredDifference(cutoff_hz=100.0, rate=1000.0)
    >>> v.start([0.0])
    >>> for k in range(1, 50):
    ...     out = v(np.array([k * 2e-3]))
    >>> out.round(9)
    array([2.])
    """

    __slots__ = ("_last", "_value", "cutoff_hz", "pole", "rate")

    def __init__(self, cutoff_hz: float, rate: float) -> None:
        self.pole = filter_pole(cutoff_hz, rate)
        self.cutoff_hz, self.rate = float(cutoff_hz), float(rate)
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


@dataclass(frozen=True, slots=True)
class Encoder:
    """A position sensor at every joint, and the filter that computes velocities from its readings.

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
        A negative or non-finite resolution or noise; the cut-off is checked against the rate by `velocity_filter`.
    """

    resolution: float = 0.0
    noise: float = 0.0
    cutoff_hz: float = 100.0

    def __post_init__(self) -> None:
        for name, value in (("encoder resolution", self.resolution), ("encoder noise", self.noise)):
            if not (isfinite(value) and value >= 0.0):
                raise OptionError(name, value, "a number >= 0, in rad or m")

    @classmethod
    def of_bits(cls, bits: int, noise: float = 0.0, cutoff_hz: float = 100.0) -> Self:
        """An encoder with 2^bits counts a turn.

        >>> round(Encoder.of_bits(12).resolution * 1e3, 3)
        1.534
        """
        return cls(2 * np.pi / 2**bits, noise, cutoff_hz)

    def velocity_filter(self, rate: float) -> FilteredDifference:
        """The filter for readings at `rate` [Hz]; raises `OptionError` for a cut-off not below half of it."""
        return FilteredDifference(self.cutoff_hz, rate)

    def noise_of(self, samples: int, n: int, seed: int) -> Array:
        """What is added to each reading before rounding, (samples, n) [rad or m]."""
        return np.random.default_rng(seed).normal(0.0, self.noise, (samples, n))

    def sensor(self, q0: Array, dq0: Array, samples: int, rate: float, seed: int) -> Sensor:
        """A sensor for one run of `samples` readings at `rate` [Hz]; the same seed gives the same noise.

        The velocity filter starts at the first reading with velocity dq0.
        """
        noise = iter(self.noise_of(samples, q0.size, seed))
        resolution, velocity = self.resolution, self.velocity_filter(rate)
        begun = False

        def read(q: Array) -> Array:
            noisy = q + next(noise)
            return np.asarray(np.round(noisy / resolution) * resolution if resolution > 0.0 else noisy)

        def measure(q: Array, dq: Array) -> tuple[Array, Array]:
            nonlocal begun
            reading = read(q)
            if begun:
                return reading, velocity(reading)
            begun = True
            velocity.start(reading, dq0)
            return reading, dq0

        return measure
