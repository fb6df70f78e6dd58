"""The margins of one sampled loop at one pose: poles, |S_ii|, how far gains and delay may move.

Each number is exact for the linear loop (see `sampled_loop`), found by scaling or delaying the loop until its spectral
radius passes 1. Libraries that read margins off a frequency response of a loop with several inputs do not find these.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.design.loop_response import refined_peaks
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, Sampling
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.simulation.options import MOST_DELAY

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

    def to_json(self) -> dict[str, Any]:
        """The result as JSON values; poles as pairs of real and imaginary part."""
        return {
            "q": self.q, "radius": self.radius, "stable": self.is_stable,
            "poles": np.column_stack([self.poles.real, self.poles.imag]),
            "peak": self.peak if self.is_stable else None, "peak_hz": self.peak_hz if self.is_stable else None,
            "gain_up": self.gain_up, "gain_down": self.gain_down,
            "all_up": self.all_up, "all_down": self.all_down, "delay_margin": self.delay_margin,
        }  # fmt: skip


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
