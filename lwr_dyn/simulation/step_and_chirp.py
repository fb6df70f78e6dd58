"""What a loop made of steps and chirps, joint by joint: what `simulate` says of the tasks `step` and `chirp`.

Of a step rise, overshoot and settling; of a chirp the frequency response and its bandwidth:

    H(f) = sum Y U* / sum |U|^2        coherence = |sum Y U*|^2 / (sum |Y|^2 sum |U|^2)

over the lines of the spectra of answer Y and set-point U within a 24th of an octave. Sweep and answer begin and end at
rest, so neither is cut off, and for a linear loop without noise H is exact: no window is needed. A coherence below 1
tells of noise, friction or torques that were cut.

References
----------
Pintelon, Schoukens, System Identification: A Frequency Domain Approach, section 2.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.document import Fact, Note
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run

RISE = (0.1, 0.9)
"""Shares of the step between which the rise time counts."""

BAND = 0.02
"""Share of the step within which it counts as settled."""

LAST = 0.1
"""Share of the window, at its end, over which the error that is left is averaged."""


Seconds = float | None


class StepRecord(TypedDict):
    """`StepResponse.to_json`."""

    joint: Annotated[int, "From 1."]
    size: Annotated[float, "Of the step, rad (m)."]
    rise: Annotated[Seconds, "From 10 to 90 %, s; null where the window ended before."]
    peak: Annotated[Seconds, "When it is largest, s."]
    overshoot: Annotated[float, "Beyond the step, a share of it."]
    settling: Annotated[Seconds, "When it comes within 2 % for good, s; null where it does not."]
    left: Annotated[float, "Error at the end, a share of the step."]
    cut: Annotated[float, "How long some torque was cut at its limit, s."]


@dataclass(frozen=True, slots=True, eq=False)
class StepResponse:
    """The response of one joint to its step: times from the step on [s], NaN where the window ended before.

    `joint` from 1; `rise` from 10 to 90 %, `peak` when it is largest, `overshoot` beyond the step as a share of it,
    `settling` when it comes within 2 % for good, `left` the error at the end as a share. `cut` [s]: how long some
    torque was cut at its limit; then the response is not that of a linear loop. `t` (k,) [s], `y` (k,) from 0 to 1.
    """

    joint: int
    size: float
    rise: float
    peak: float
    overshoot: float
    settling: float
    left: float
    cut: float
    t: Array
    y: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "t", "y")

    def to_json(self) -> dict[str, Any]:
        """The figures as JSON values; None for NaN."""
        return _record(self, StepRecord)


def about_task(run: Run, task: str) -> dict[str, Any]:
    """What a run's record says of its reference; raises `OptionError` unless it is of the task given."""
    about = dict(run.meta.get("reference", {}).get("about", {}))
    if about.get("task") != task:
        raise OptionError("run", f"of the task {about.get('task', 'unknown')!r}", f"a run of the task {task!r}")
    return about


def step_responses(run: Run, arm: Arm | None = None) -> tuple[StepResponse, ...]:
    """The response of each joint that stepped; `arm` is the run's own if not given.

    Raises `OptionError` for a run of another task.
    """
    about = about_task(run, "step")
    return tuple(
        _step_response(run, arm, joint - 1, about["size"], about["begin"] + k * about["window"], about["window"])
        for k, joint in enumerate(about["joints"])
        if about["begin"] + k * about["window"] < run.t[-1]
    )


def _step_response(run: Run, arm: Arm | None, joint: int, size: float, begin: float, window: float) -> StepResponse:
    rows = slice(*np.searchsorted(run.t, [begin - 1e-9, begin + window - 1e-9]))
    t = run.t[rows] - run.t[rows][0]
    y = (run.q[rows, joint] - run.q[rows, joint][0]) / size
    target = (run.q_ref[rows, joint][0] - run.q[rows, joint][0]) / size  # 1 where it was at rest on its reference
    low, high = (_first(t, y - share * target) for share in RISE)
    outside = np.flatnonzero(np.abs(y - target) > BAND * abs(target))
    settling = _first(t, BAND * abs(target) - np.abs(y - target), int(outside[-1]) if outside.size else 0)
    last = t >= t[-1] - LAST * window
    return StepResponse(
        joint=joint + 1, size=size, rise=high - low, peak=float(t[np.argmax(y)]),
        overshoot=max(0.0, float(y.max() - target)), settling=settling,
        left=float(np.mean(target - y[last])), cut=seconds_cut(run, arm, rows), t=t, y=y,
    )  # fmt: skip


def seconds_cut(run: Run, arm: Arm | None, rows: slice) -> float:
    """How long the command of some joint was beyond its torque limit [s]."""
    effort = (arm_of(run) if arm is None else arm).effort
    return float(np.sum((np.abs(run.tau_command[rows]) > effort).any(axis=1)) * np.mean(np.diff(run.t[rows])))


def _first(t: Array, y: Array, begin: int = 0) -> float:
    """When y first comes to 0 from below after row `begin`, between two samples by a line; NaN where it does not."""
    above = np.flatnonzero(y[begin:] >= 0.0)
    if above.size == 0:
        return float("nan")
    k = begin + int(above[0])
    if k == 0:
        return float(t[0])
    return float(t[k - 1] + (t[k] - t[k - 1]) * y[k - 1] / (y[k - 1] - y[k]))


HALF_POWER = 1.0 / np.sqrt(2.0)
"""The magnitude at the bandwidth: -3 dB of a unit answer."""

PER_OCTAVE = 24

USABLE = 0.05
"""Share of the sweep at each of its ends whose frequencies are not used: there the amplitude rises and falls."""


class ChirpRecord(TypedDict):
    """`FrequencyResponse.to_json`."""

    joint: Annotated[int, "From 1."]
    bandwidth: Annotated[float | None, "Where |H| first falls below -3 dB, Hz; null where it does not."]
    phase: Annotated[float | None, "At the bandwidth, rad."]
    peak: Annotated[float, "Largest |H|."]
    peak_at: Annotated[float, "Where it is, Hz."]
    least_coherence: Annotated[float | None, "Up to the bandwidth, or over the whole sweep."]
    cut: Annotated[float, "How long some torque was cut at its limit, s."]


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
        return _record(self, ChirpRecord)


def frequency_responses(run: Run, arm: Arm | None = None) -> tuple[FrequencyResponse, ...]:
    """The frequency response of each joint that was swept; `arm` is the run's own if not given.

    Raises `OptionError` for a run of another task.
    """
    about = about_task(run, "chirp")
    length = about["sweep"] + about["rest"]
    return tuple(
        _frequency_response(run, arm, joint - 1, about, k * length)
        for k, joint in enumerate(about["joints"])
        if (k + 1) * length <= run.t[-1] + 1e-9
    )


def _frequency_response(
    run: Run, arm: Arm | None, joint: int, about: dict[str, Any], begin: float
) -> FrequencyResponse:
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


def responses_of(run: Run, arm: Arm | None = None) -> tuple[StepResponse, ...] | tuple[FrequencyResponse, ...]:
    """The responses in a run of the task step or chirp; empty for a run of another one."""
    task = run.meta.get("reference", {}).get("about", {}).get("task")
    return step_responses(run, arm) if task == "step" else frequency_responses(run, arm) if task == "chirp" else ()


def _record(response: StepResponse | FrequencyResponse, form: type) -> dict[str, Any]:
    values = {name: getattr(response, name) for name in form.__annotations__}
    return {name: None if np.isnan(value) else value for name, value in values.items()}


def response_parts(run: Run, arm: Arm | None = None) -> list[Fact | Table | Note]:
    """The same for a document: a table, a note on torques that were cut, and the records."""
    found = responses_of(run, arm)
    says = "Answers to the steps or chirps of the tasks step and chirp, one a joint; empty for other tasks."
    records = [one.to_json() for one in found]
    parts: list[Fact | Table | Note] = [Fact("responses", records, says, kind=list[StepRecord | ChirpRecord])]
    if found:
        cut = [f"joint {one.joint} ({one.cut:.3g} s)" for one in found if one.cut > 0.0]
        note = f"torque was cut while {', '.join(cut)} answered: not the response of a linear loop; try a smaller size"
        table = _steps(found) if isinstance(found[0], StepResponse) else _chirps(found)
        parts += [table, Note(note, bool(cut))]
    return parts


def _steps(found: Any) -> Table:
    heads = (
        Heading("joint"), Heading("rise [ms]", format=_number), Heading("overshoot", format=_share),
        Heading("settling [ms]", format=_number), Heading("error left", format=_share),
    )  # fmt: skip
    rows = [(one.joint, 1e3 * one.rise, one.overshoot, 1e3 * one.settling, one.left) for one in found]
    return Table("response to the step: rise 10 to 90 %, settled within 2 %", heads, rows)


def _chirps(found: Any) -> Table:
    heads = (
        Heading("joint"), Heading("bandwidth [Hz]", format=_number), Heading("phase there [deg]", format=_number),
        Heading("largest |H|", format=_number), Heading("at [Hz]", format=_number),
        Heading("least coherence", format=_number),
    )  # fmt: skip
    rows = [
        (one.joint, one.bandwidth, math.degrees(one.phase), one.peak, one.peak_at, one.least_coherence) for one in found
    ]
    return Table("response to the chirp: bandwidth at -3 dB", heads, rows)


def _number(value: float) -> str:
    return "not reached" if math.isnan(value) else f"{value:.4g}"


def _share(value: float) -> str:
    return f"{100.0 * value:.2f} %"
