"""The tasks `step` and `chirp`: positions that a loop is asked for, of one joint or of each in turn.

Both are set-points: dq_ref and ddq_ref are zero, so that the response is that of the loop and not of a feed-forward. A
chirp with its rates as feed-forward is the option `rates`.

    step     q_ref = start + size (t >= begin)
    chirp    q_ref = start + size w(t) sin(phase(t)),    phase' = 2 pi low (high / low)^(t / sweep)

w rises and falls as a cosine over `TAPER` of the sweep at its ends; after each sweep the set-point rests.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays, real_array
from lwr_dyn.foundation.errors import OptionError, PathLimitError
from lwr_dyn.foundation.registry import Option, Quantity
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, short_repr
from lwr_dyn.trajectory.motion_profile import positive_number
from lwr_dyn.trajectory.references.position_limits import largest_violation
from lwr_dyn.trajectory.references.references import Start

BEFORE = 0.05
"""[s] At rest before the first step."""
REST = 1.0
"""[s] At rest after each sweep."""
TAPER = 0.05
"""Of a sweep, at each end."""

STEP, AMPLITUDE = float(np.radians(0.5)), float(np.radians(0.2))
"""[rad]"""
PERIODS = 3.0
"""Of the lowest frequency in a sweep at least."""

Size = Annotated[float, Option(Quantity.ANGLE, "Size of the step or amplitude of the chirp, deg.")]
Joint = Annotated[int | None, Option(int, "Which joint, from 1; each in turn if not given.")]


@dataclass(frozen=True, slots=True, eq=False)
class StepReference:
    """Steps of 0-based `joints` by `size` [rad or m] from `start` (n,), every `window` [s], the first at `BEFORE`."""

    start: Array
    joints: tuple[int, ...]
    size: float
    window: float
    about: Mapping[str, Any] = field(default_factory=dict)
    name: ClassVar[str] = "StepReference"
    """In run files."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "start")

    @property
    def duration(self) -> float:
        """[s]"""
        return BEFORE + len(self.joints) * self.window

    def sample(self, t: ArrayLike) -> Motion:
        """The set-point at times t (k,) [s]; dq and ddq are zero; raises `ShapeError`."""
        times = np.atleast_1d(real_array("t", t))
        q = np.tile(self.start, (times.size, 1))
        for k, joint in enumerate(self.joints):
            q[:, joint] += self.size * (times >= BEFORE + k * self.window - 1e-9)
        return Motion(times, q, np.zeros_like(q), np.zeros_like(q))


@dataclass(frozen=True, slots=True, eq=False)
class ChirpReference:
    """Sweeps from `low` to `high` [Hz] in `sweep` [s] of 0-based `joints` about `start` (n,), `size` [rad or m]."""

    start: Array
    joints: tuple[int, ...]
    size: float
    low: float
    high: float
    sweep: float
    rates: bool = False
    about: Mapping[str, Any] = field(default_factory=dict)
    name: ClassVar[str] = "ChirpReference"
    """In run files."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "start")

    @property
    def duration(self) -> float:
        """[s]"""
        return len(self.joints) * (self.sweep + REST)

    def sample(self, t: ArrayLike) -> Motion:
        """The set-point at times t (k,) [s]; dq and ddq are its exact derivatives with `rates`, else zero."""
        times = np.atleast_1d(real_array("t", t))
        q = np.tile(self.start, (times.size, 1))
        dq, ddq = np.zeros_like(q), np.zeros_like(q)
        for k, joint in enumerate(self.joints):
            x, dx, ddx = self._wave(times - k * (self.sweep + REST))
            q[:, joint] += x
            if self.rates:
                dq[:, joint], ddq[:, joint] = dx, ddx
        return Motion(times, q, dq, ddq)

    def _wave(self, t: Array) -> tuple[Array, Array, Array]:
        """The sweep and its two derivatives; zero outside of it."""
        inside = (t > 0.0) & (t < self.sweep)
        t = np.clip(t, 0.0, self.sweep)
        growth = np.log(self.high / self.low) / self.sweep
        pace = 2.0 * np.pi * self.low * np.exp(growth * t)
        phase = (pace - 2.0 * np.pi * self.low) / growth
        w, dw, ddw = self._taper(t)
        sine, cosine = np.sin(phase), np.cos(phase)
        x = w * sine
        dx = dw * sine + w * pace * cosine
        ddx = ddw * sine + 2.0 * dw * pace * cosine + w * (growth * pace * cosine - pace**2 * sine)
        return self.size * x * inside, self.size * dx * inside, self.size * ddx * inside

    def _taper(self, t: Array) -> tuple[Array, Array, Array]:
        """(1 - cos) / 2 over the first and the last part."""
        edge = TAPER * self.sweep
        end = np.minimum(t, self.sweep - t)
        rising, sign, k = end < edge, np.where(t < 0.5 * self.sweep, 1.0, -1.0), np.pi / edge
        w = np.where(rising, 0.5 - 0.5 * np.cos(k * end), 1.0)
        dw = np.where(rising, sign * 0.5 * k * np.sin(k * end), 0.0)
        return w, dw, np.where(rising, 0.5 * k**2 * np.cos(k * end), 0.0)


def step_reference(
    arm: Arm,
    *,
    start: Start,
    size: Size = STEP,
    joint: Joint = None,
    duration: Annotated[float, Option(float, "Time for each step or sweep, s.")] = 0.5,
) -> StepReference:
    """Steps of the set-point from `start` (n,) [rad or m]; `simulation.step_and_chirp` judges the run.

    Parameters
    ----------
    arm : Arm
    start : (n,) array_like
    size : float
        [rad or m], not 0.
    joint : int, optional
        From 1; each in turn, without way back, if not given.
    duration : float
        [s] Of each.

    Raises
    ------
    ShapeError, OptionError
        Wrong shapes, a joint that is not there, a size of 0, a duration that is not positive.
    PathLimitError
        A set-point outside the position limits.
    """
    q, joints = _given(arm, start, joint, size)
    window = positive_number("duration", duration)
    about = {"task": "step", "joints": [j + 1 for j in joints], "size": float(size), "window": window, "begin": BEFORE}
    reference = StepReference(q, joints, float(size), window, about)
    _check_inside(arm, reference.sample(np.array([0.0, reference.duration])))
    return reference


def chirp_reference(
    arm: Arm,
    *,
    start: Start,
    size: Size = AMPLITUDE,
    joint: Joint = None,
    low: Annotated[float, Option(float, "Frequency at which a sweep begins, Hz.")] = 0.5,
    high: Annotated[float, Option(float, "Frequency at which a sweep ends, Hz.")] = 50.0,
    duration: Annotated[float, Option(float, "Time for each step or sweep, s.")] = 6.0,
    rates: Annotated[bool, Option(bool, "Tell the controller the speed and acceleration of the chirp too.")] = False,
) -> ChirpReference:
    """Sweeps of the set-point about `start` (n,) [rad or m]; `simulation.step_and_chirp` judges the run.

    Parameters
    ----------
    arm : Arm
    start : (n,) array_like
    size : float
        [rad or m] Amplitude, not 0.
    joint : int, optional
        From 1; each in turn if not given.
    low, high : float
        [Hz], low below high.
    duration : float
        [s] Of each sweep.
    rates : bool
        With dq_ref and ddq_ref: the response then shows what feed-forward leaves.

    Raises
    ------
    ShapeError, OptionError, PathLimitError
        As `step_reference`; frequencies that do not rise, less than three periods of the lowest one in a sweep.
    """
    q, joints = _given(arm, start, joint, size)
    low, high, sweep = (positive_number(*x) for x in (("low", low), ("high", high), ("duration", duration)))
    if not low < high:
        raise OptionError("low, high", f"{low:g} to {high:g} Hz", "frequencies that rise")
    if low * sweep < PERIODS:
        least = f"at least {PERIODS / low:g} s, {PERIODS:g} periods"
        raise OptionError("duration", f"{sweep:g} s at {low:g} Hz", least)
    about = {
        "task": "chirp", "joints": [j + 1 for j in joints], "size": float(size), "low": low, "high": high,
        "sweep": sweep, "rest": REST, "rates": rates,
    }  # fmt: skip
    reference = ChirpReference(q, joints, float(size), low, high, sweep, rates, about)
    outer = np.concatenate([q + abs(size) * sign * np.eye(arm.n)[list(joints)] for sign in (1.0, -1.0)])
    _check_inside(arm, Motion(np.zeros(len(outer)), outer, outer, outer))
    return reference


def _given(arm: Arm, start: ArrayLike, joint: int | None, size: float) -> tuple[Array, tuple[int, ...]]:
    q = fixed_array("start", start, (arm.n,))
    if joint is not None and not (isinstance(joint, int) and 1 <= joint <= arm.n):
        raise OptionError("joint", joint, f"1 to {arm.n}")
    positive_number("size", abs(size))
    return q, tuple(range(arm.n)) if joint is None else (joint - 1,)


def _check_inside(arm: Arm, motion: Motion) -> None:
    outside = largest_violation(arm, motion.q)
    if outside is not None:
        raise PathLimitError(0.0, "set-point", outside.fault, outside.allowed, outside.joint, outside.excess)
