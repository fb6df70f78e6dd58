"""What a loop made of chirps: frequency response and bandwidth, joint by joint, from a run of the task `chirp`.

    H(f) = sum Y U* / sum |U|^2        coherence = |sum Y U*|^2 / (sum |Y|^2 sum |U|^2)

over the lines of the spectra of answer Y and set-point U within a 24th of an octave. Sweep and answer begin and end at
rest, so neither is cut off, and for a linear loop without noise H is exact: no window is needed. A coherence below 1
tells of noise, friction or torques that were cut.

References
----------
Pintelon, Schoukens, System Identification: A Frequency Domain Approach, section 2.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.responses.step import about_task, seconds_cut

HALF_POWER = 1.0 / np.sqrt(2.0)
"""The magnitude at the bandwidth: -3 dB of a unit answer."""
PER_OCTAVE = 24
USABLE = 0.05
"""Share of the sweep at each of its ends whose frequencies are not used: there the amplitude rises and falls."""


@dataclass(frozen=True, slots=True, eq=False)
class FrequencyResponse:
    """The frequency response of one joint (from 1): `f` (m,) [Hz], `H` (m,) complex, `coherence` (m,).

    `bandwidth` [Hz]: where |H| first falls below -3 dB, NaN where it does not within the sweep. `peak` is the largest
    |H|, at `peak_at` [Hz]; `phase` [rad] at the bandwidth. `cut` [s]: how long some torque was cut at its limit.
    """

    joint: int
    f: Array
    H: NDArray[np.complex128]
    coherence: Array
    bandwidth: float
    phase: float
    peak: float
    peak_at: float
    cut: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "f", "coherence")

    @property
    def least_coherence(self) -> float:
        """Up to the bandwidth, or over the whole sweep."""
        below = self.f <= self.bandwidth if np.isfinite(self.bandwidth) else np.ones(self.f.size, dtype=bool)
        return float(self.coherence[below].min()) if below.any() else float("nan")

    def to_json(self) -> dict[str, Any]:
        """The figures as JSON values; None for NaN."""
        names = ("joint", "bandwidth", "phase", "peak", "peak_at", "least_coherence", "cut")
        figures = {name: getattr(self, name) for name in names}
        return {name: None if np.isnan(value) else value for name, value in figures.items()}


def frequency_responses(run: Run, arm: Arm | None = None) -> tuple[FrequencyResponse, ...]:
    """The frequency response of each joint that was swept; `arm` is the run's own if not given.

    Raises `OptionError` for a run of another task.
    """
    about = about_task(run, "chirp")
    length = about["sweep"] + about["rest"]
    return tuple(
        _response(run, arm, joint - 1, about, k * length)
        for k, joint in enumerate(about["joints"])
        if (k + 1) * length <= run.t[-1] + 1e-9
    )


def _response(run: Run, arm: Arm | None, joint: int, about: dict[str, Any], begin: float) -> FrequencyResponse:
    rows = slice(*np.searchsorted(run.t, [begin - 1e-9, begin + about["sweep"] + about["rest"] - 1e-9]))
    t = run.t[rows]
    asked = run.q_ref[rows, joint] - run.q_ref[rows, joint][0]
    answer = run.q[rows, joint] - run.q[rows, joint][0]
    lines = np.fft.rfftfreq(t.size, d=float(np.mean(np.diff(t))))
    U, Y = np.fft.rfft(asked), np.fft.rfft(answer)
    growth = (about["high"] / about["low"]) ** USABLE
    used = (lines >= about["low"] * growth) & (lines <= about["high"] / growth)
    band = np.round(PER_OCTAVE * np.log2(lines[used])).astype(int)
    _, band = np.unique(band, return_inverse=True)
    U, Y, lines = U[used], Y[used], lines[used]
    power, both = np.bincount(band, np.abs(U) ** 2), Y * U.conj()
    cross = np.bincount(band, both.real) + 1j * np.bincount(band, both.imag)
    f = np.bincount(band, lines * np.abs(U) ** 2) / power
    H = np.asarray(cross / power, dtype=np.complex128)
    coherence = np.abs(cross) ** 2 / (power * np.bincount(band, np.abs(Y) ** 2))
    size = np.abs(H)
    bandwidth = _crossing(f, size)
    angle = float(np.interp(bandwidth, f, np.unwrap(np.angle(H)))) if np.isfinite(bandwidth) else float("nan")
    top, cut = int(np.argmax(size)), seconds_cut(run, arm, rows)
    return FrequencyResponse(joint + 1, f, H, coherence, bandwidth, angle, float(size[top]), float(f[top]), cut)


def _crossing(f: Array, size: Array) -> float:
    """Where the magnitude first falls through -3 dB, by a line in logarithms; NaN where it does not."""
    below = np.flatnonzero(size < HALF_POWER)
    if below.size == 0 or below[0] == 0:
        return float("nan")
    k = int(below[0])
    x, y = np.log(f[k - 1 : k + 1]), np.log(size[k - 1 : k + 1])
    return float(np.exp(x[0] + (x[1] - x[0]) * (np.log(HALF_POWER) - y[0]) / (y[1] - y[0])))
