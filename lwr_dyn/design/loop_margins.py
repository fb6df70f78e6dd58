"""The margins of one sampled loop at one pose: poles, |S_ii|, how far gains and delay may move.

Each number is exact for the linear loop (see `sampled_loop`), found by scaling or delaying the loop until its spectral
radius passes 1. Libraries that read margins off a frequency response of a loop with several inputs do not find these.

At the torques of the plant the loop is u = -L(z) u, L = z^-d K(z) P(z), with P the exact zero-order hold of the plant
and K the controller. The entry i of the diagonal of S = (I + L)^-1 is 1 / (1 + L_i), where L_i is the loop cut at
joint i alone: |S_ii| does not change with the units of the joints, and 1 / max |S_ii| is the distance of the Nyquist
curve of L_i from -1. By it the gain of joint i alone may at least grow by Ms / (Ms - 1) and fall by Ms / (Ms + 1).

References
----------
Skogestad, Postlethwaite, *Multivariable Feedback Control*, section 2.4 (Ms and the margins that it guarantees).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.control.gains import LinearFeedback
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, RestingPlant, Sampling
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.simulation.setup import MOST_DELAY

if TYPE_CHECKING:
    from control import StateSpace

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


FACTORS = np.geomspace(1.0, 1e3, 140)
"""Factors on the gain that are tried; neighbours differ by 5 %."""

LATER = (*range(1, 17), 19, 22, 26, 30, 35, 40)
"""Further delays that are tried [samples]."""

CLOSE = 1e-4
"""Relative, of a gain margin; of a sample, of a delay margin."""


@dataclass(frozen=True, slots=True, eq=False)
class LoopMargins:
    """The margins of a loop at one pose.

    Parameters
    ----------
    q : (n,) array
        [rad or m]
    poles : (N,) array
        Eigenvalues of the step from sample to sample, the largest first; a real one at z decays by ln(z) rate [1/s].
    peak, peak_hz : (n,) array
        max |S_ii| of each joint with all other loops closed, and the frequency [Hz] where it is.
    gain_up, gain_down : (n,) array
        Factors on the torque of one joint, all others as they are, between which the loop is stable; inf and 0 where
        it is up to 1000 times as much, or down to a thousandth. NaN where the loop is unstable.
    all_up, all_down : float
        The same for the torques of all joints together.
    delay_margin : float
        [s] By which the torques of all joints may come later; inf where 40 samples do no harm, NaN of an unstable loop.
    """

    q: Array
    poles: NDArray[np.complex128]
    peak: Array
    peak_hz: Array
    gain_up: Array
    gain_down: Array
    all_up: float
    all_down: float
    delay_margin: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "q", "peak", "peak_hz", "gain_up", "gain_down")

    @property
    def radius(self) -> float:
        """Spectral radius: small deviations grow by it at each sample."""
        return float(np.abs(self.poles[0]))

    @property
    def is_stable(self) -> bool:
        """Whether no deviation grows."""
        return self.radius <= GROWS


def margins_at(loop: RestingLoop, sampling: Sampling, q: Array) -> LoopMargins:
    """The margins of a loop of one pose q (n,); raises `OptionError` for a loop of several poses."""
    if len(loop.plant.A) != 1:
        raise OptionError("loop", f"{len(loop.plant.A)} poses", "one pose: loop.at(np.array([i]))")
    n = loop.plant.n
    poles = np.linalg.eigvals(loop.step_matrices(sampling)[0]).astype(np.complex128)
    poles = poles[np.argsort(-np.abs(poles), kind="stable")]
    peak, peak_hz = refined_peaks(loop, sampling)
    if np.abs(poles[0]) > GROWS:
        nan = np.full(n, np.nan)
        return LoopMargins(q, poles, np.full(n, np.inf), peak_hz, nan, nan, np.nan, np.nan, np.nan)
    ends = [_gain_ends(loop, sampling, np.eye(n)[i]) for i in range(n)]
    up, down = np.array(ends).T
    all_up, all_down = _gain_ends(loop, sampling, np.ones(n))
    return LoopMargins(q, poles, peak, peak_hz, up, down, all_up, all_down, delay_margin(loop, sampling))


def _gain_ends(loop: RestingLoop, sampling: Sampling, joints: Array) -> tuple[float, float]:
    """Largest and smallest factor on the torques of some joints with which the loop is stable."""

    def unstable(factors: Array) -> NDArray[np.bool_]:
        scale = 1.0 + (factors[:, None] - 1.0) * joints
        return loop.at(np.zeros(len(factors), dtype=np.intp)).radius(sampling, scale=scale) > GROWS

    up = _first(FACTORS, unstable, np.inf)
    return up, 1.0 / _first(FACTORS, lambda factors: unstable(1.0 / factors), np.inf)


def _first(tries: Array, unstable: Callable[[Array], NDArray[np.bool_]], none: float) -> float:
    """The end of the stable range that begins at tries[0]: between two tries by bisection; `none` where all hold."""
    bad = np.flatnonzero(unstable(tries))
    if not bad.size:
        return none
    low, high = float(tries[max(bad[0] - 1, 0)]), float(tries[bad[0]])
    while high > (1.0 + CLOSE) * low:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if unstable(np.array([middle]))[0] else (middle, high)
    return low


def delay_margin(loop: RestingLoop, sampling: Sampling) -> float:
    """By how much the torques of all joints may come later [s], for a loop of one pose that is stable.

    Delays of whole samples are tried one after the other, then parts of the last sample: windows of instability between
    two whole samples are not seen. inf where 40 samples, or a delay of `MOST_DELAY` in all, do no harm.
    """
    T = 1.0 / sampling.rate

    def unstable(samples: float) -> bool:
        whole = int(samples)
        later = replace(sampling, delay=sampling.delay + whole)
        return bool(loop.radius(later, (samples - whole) * T)[0] > GROWS)

    low = 0.0
    for high in map(float, LATER):
        if sampling.delay + high > MOST_DELAY:
            return float(np.inf)
        if unstable(high):
            break
        low = high
    else:
        return float(np.inf)
    while high - low > CLOSE:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return low * T


@dataclass(frozen=True, slots=True, eq=False)
class LoopStateSpaces:
    """Discrete state spaces (dt = the sample) of a loop at one pose; inputs and outputs are named by joint.

    - `plant`: torques [N m] -> positions and speeds [rad, rad/s] that the controller reads, without delay;
    - `open_loop`: L, from the torques that leave the controller to what it makes of them; `feedback(L, I)` closes it;
    - `sensitivity`: S = (I + L)^-1, from a torque added to the controller's to their sum.

    The delay is in `open_loop` and `sensitivity` as states, a chain of samples. `control.stability_margins` is not for
    these loops: of several inputs it takes the determinant or one entry, and its discrete gain margins are off.
    """

    plant: StateSpace
    open_loop: StateSpace
    sensitivity: StateSpace


def state_spaces(loop: RestingLoop, sampling: Sampling, joints: tuple[str, ...]) -> LoopStateSpaces:
    """The state spaces of a loop of one pose.

    Raises `MissingPackageError`: python-control is not installed (extra `design`); `OptionError`: a loop of several
    poses.
    """
    try:
        import control
    except ModuleNotFoundError as fault:
        raise MissingPackageError(fault.name or "control", "design") from None
    if len(loop.plant.A) != 1:
        raise OptionError("loop", f"{len(loop.plant.A)} poses", "one pose: loop.at(np.array([i]))")
    T, n = 1.0 / sampling.rate, loop.plant.n
    Ad, Bd = loop.plant.held(T)
    A, B, C = (part[0] for part in loop.open_loop(sampling))
    torques = [f"tau_{name}" for name in joints]
    reads = np.vstack([loop.plant.position, loop.plant.velocity])
    named: Any = {"inputs": torques, "outputs": [f"{word}_{name}" for word in ("q", "dq") for name in joints]}
    back = {"inputs": torques, "outputs": [f"back_{name}" for name in joints]}
    total = {"inputs": torques, "outputs": [f"sum_{name}" for name in joints]}
    return LoopStateSpaces(
        control.ss(Ad[0], Bd[0], reads, np.zeros((2 * n, n)), T, name="plant", **named),
        control.ss(A, B, -C, np.zeros((n, n)), T, name="open_loop", **back),
        control.ss(A + B @ C, B, C, np.eye(n), T, name="sensitivity", **total),
    )
