"""A figure is described once: `lwr_dyn.pages.plotting` draws it as PNG and SVG, pages draw it themselves.

Its curves are numbers, or series of runs, which a page packs only once for the 3D view and for all figures. Axes follow
the data: their range, a few round ticks, and numbers as short texts.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, get_args

import numpy as np

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.number_text import short, true_minus
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

GREY = 7
"""The `colour` of a curve that is a reference."""

SeriesName = Literal[
    "q", "q_ref", "dq", "dq_ref", "position error", "velocity error", "torque", "friction",
    "tip error", "flange x", "flange y", "flange z", "reference x", "reference y", "reference z", "energy",
]  # fmt: skip
"""Series of a run; errors are reference minus actual, "flange" and "reference" positions in the base frame."""

JOINT_QUANTITIES: tuple[SeriesName, ...] = get_args(SeriesName)[:8]

_FIELDS = {"torque": "tau_applied", "friction": "tau_friction"}


def run_series(one: ReplayedRun, quantity: SeriesName) -> Array:
    """A quantity over all samples of a run: (k, n) [rad, rad/s, N m; m, m/s, N] of joints, else (k,) [m, J]."""
    run = one.run
    if quantity.startswith(("flange ", "reference ")):
        pose = one.pose if quantity.startswith("flange") else one.pose_ref
        return np.asarray(pose[:, "xyz".index(quantity[-1]), 3])
    if quantity == "tip error":
        return one.tip_error
    if quantity == "position error":
        return np.asarray(run.q_ref - run.q)
    if quantity == "velocity error":
        return np.asarray(run.dq_ref - run.dq)
    return np.asarray(getattr(run, _FIELDS.get(quantity, quantity)))


@dataclass(frozen=True, slots=True)
class Series:
    """A series of run `run` (0-based) of those that the figure is drawn from; `joint` is 0-based."""

    run: int
    quantity: SeriesName
    joint: int | None = None
    scale: float = 1.0

    def __post_init__(self) -> None:
        if self.quantity not in get_args(SeriesName):
            raise OptionError("quantity", repr(self.quantity), ", ".join(get_args(SeriesName)))
        if (self.joint is not None) != (self.quantity in JOINT_QUANTITIES):
            allowed = "a 0-based joint for joint quantities, none for others"
            raise OptionError(f"joint of {self.quantity!r}", repr(self.joint), allowed)

    @property
    def is_reference(self) -> bool:
        """Whether it is what the run follows."""
        return self.quantity.startswith("reference ") or self.quantity.endswith("_ref")

    def values(self, runs: Sequence[ReplayedRun]) -> Array:
        """The numbers, (k,), times `scale`; raises `OptionError` for a run or a joint that is not there."""
        if not 0 <= self.run < len(runs):
            raise OptionError("run of a series", self.run, f"0 to {len(runs) - 1}" if runs else "no run is shown")
        one = runs[self.run]
        if self.joint is not None and not 0 <= self.joint < one.arm.n:
            raise OptionError("joint of a series", self.joint, f"0 to {one.arm.n - 1}")
        whole = run_series(one, self.quantity)
        return self.scale * (whole if self.joint is None else whole[:, self.joint])


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A curve of numbers or of a run's series; without `x` a series is drawn over the run's time [s].

    A NaN in `y` leaves a gap. `text` names single points. `colour` is the place of a run's colour, or `GREY`.
    `is_filled` tints what the curve encloses.
    """

    label: str
    y: Array | Series
    x: Array | Series | None = None
    style: Literal["line", "points", "both"] = "line"
    dashed: bool = False
    colour: int | None = None
    text: tuple[str, ...] = ()
    is_filled: bool = False

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            value = getattr(self, name)
            if value is not None and not isinstance(value, Series):
                object.__setattr__(self, name, read_only(np.asarray(value, dtype=np.float64)))
        x, y, where = self.x, self.y, f"curve {self.label!r}"
        if isinstance(y, Series):
            if x is not None and not (isinstance(x, Series) and x.run == y.run):
                raise OptionError(where, "x of something else than y", "a series of the same run, or no x")
        elif isinstance(x, Series) or x is None:
            raise OptionError(where, "y as numbers, x not", "both as numbers")
        elif not (x.ndim == 1 and x.shape == y.shape and x.size > 0):
            raise OptionError(where, f"x of shape {x.shape}, y of shape {y.shape}", "the same (k,), k > 0")
        if self.text and (isinstance(y, Series) or len(self.text) != y.size):
            raise OptionError(f"{where}, text", f"{len(self.text)} names", "one per point, for curves of numbers")

    @property
    def series(self) -> tuple[Series, ...]:
        """The series among x and y."""
        return tuple(one for one in (self.x, self.y) if isinstance(one, Series))

    @property
    def is_reference(self) -> bool:
        """Whether it shows what a run follows."""
        return isinstance(self.y, Series) and self.y.is_reference

    def points(self, runs: Sequence[ReplayedRun]) -> tuple[Array, Array]:
        """x and y, (k,) each; raises `OptionError` for a run or a joint that is not there."""
        y = self.y.values(runs) if isinstance(self.y, Series) else self.y
        if self.x is None:  # then y is a series
            return runs[self.series[0].run].run.t, y
        return self.x.values(runs) if isinstance(self.x, Series) else self.x, y


@dataclass(frozen=True, slots=True)
class Level:
    """A straight line across a panel: a limit or a printed value, at `value` on the axis named."""

    label: str
    value: float
    axis: Literal["x", "y"] = "y"


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """One pair of axes; `note` explains its levels in PNG and SVG, where a page writes beside each level."""

    title: str
    y_label: str
    y_unit: str
    curves: tuple[Curve, ...]
    levels: tuple[Level, ...] = ()
    note: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """A figure as the document has it; `where` is its name there ("Fig. 4"), `id` its name on a page.

    With `over_time` x is the run's time [s], and the cursor of the replay follows. At most `columns`
    panels stand side by side.
    """

    id: str
    title: str
    where: str
    x_label: str
    x_unit: str
    panels: tuple[Panel, ...]
    over_time: bool = False
    equal_aspect: bool = False
    columns: int = 1
    note: str = ""

    @property
    def curves(self) -> tuple[Curve, ...]:
        """The curves of all panels."""
        return tuple(curve for panel in self.panels for curve in panel.curves)

    @property
    def labels(self) -> tuple[str, ...]:
        """The names of the curves, each once."""
        return tuple(dict.fromkeys(curve.label for curve in self.curves))


_PADDING = 0.06
"""Of the range, left free at either end."""

_STEPS = (1.0, 2.0, 5.0)

_LONGEST = 6
"""Letters of a tick; beyond, a power of ten stands beside the axis."""


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis from `low` to `high` with its ticks."""

    low: float
    high: float
    ticks: tuple[float, ...]
    is_logarithmic: bool = False

    def share(self, values: Array | float) -> Array:
        """How far along the axis values are, 0 at `low`, 1 at `high`."""
        low, high, x = self.low, self.high, np.asarray(values, dtype=np.float64)
        if self.is_logarithmic:
            low, high, x = math.log10(low), math.log10(high), np.log10(np.maximum(x, self.low))
        return np.asarray((x - low) / (high - low))

    @property
    def power(self) -> int:
        """The power of ten that stands beside the axis, so that its ticks are short; 0 for none."""
        largest = max(map(abs, self.ticks), default=0.0)
        if self.is_logarithmic or largest == 0.0 or (largest < 1e4 and max(map(len, self._texts(0))) <= _LONGEST):
            return 0
        return 3 * math.floor(math.log10(largest) / 3)

    @property
    def labels(self) -> tuple[str, ...]:
        """The ticks as text, in units of the power of ten: as many decimals as their step needs."""
        return tuple(map(short, self.ticks)) if self.is_logarithmic else self._texts(self.power)

    def _texts(self, power: int) -> tuple[str, ...]:
        ticks = [tick / 10.0**power for tick in self.ticks]
        step = min((b - a for a, b in pairwise(ticks)), default=1.0)
        decimals = next((d for d in range(12) if abs(step * 10**d - round(step * 10**d)) < 1e-6 * step * 10**d), 12)
        return tuple(true_minus(f"{tick + 0.0:.{decimals}f}") for tick in ticks)


def axis_of(values: Array, most: int = 4, padding: float = _PADDING) -> Axis:
    """A linear axis over the finite numbers among values; at least two ticks.

    >>> axis_of(np.array([0.0, 14.0]), padding=0.0).ticks
    (0.0, 5.0, 10.0)
    """
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        half = 0.1 * abs(high) or 1.0
        low, high = low - half, high + half
    pad = padding * (high - low)
    low, high = low - pad, high + pad
    return Axis(low, high, _ticks(low, high, most))


def logarithmic_axis(values: Array, decades: int = 6) -> Axis:
    """A logarithmic axis over the positive numbers among values, at most `decades` down from the largest."""
    positive = values[np.isfinite(values) & (values > 0.0)]
    top = math.ceil(math.log10(positive.max()))
    bottom = max(math.floor(math.log10(np.quantile(positive, 0.02))), top - decades)
    bottom = min(bottom, top - 1)
    every = -(-(top - bottom) // 6)
    return Axis(10.0**bottom, 10.0**top, tuple(10.0**k for k in range(bottom, top + 1, every)), True)


def frequency_axis(values: Array) -> Axis:
    """A logarithmic axis over positive numbers as they are; ticks at 1, 2, 5 times powers of ten, or at powers.

    >>> frequency_axis(np.array([0.6, 45.0])).ticks
    (1.0, 2.0, 5.0, 10.0, 20.0)
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    steps = _STEPS if high < 200.0 * low else _STEPS[:1]
    ticks = tuple(10.0**k * step for k in powers for step in steps if low <= 10.0**k * step <= high)
    return Axis(low, high, ticks or (low, high), True)


def _ticks(low: float, high: float, most: int) -> tuple[float, ...]:
    """Multiples of a round step within the axis: at most `most`, at least two."""
    scale = 10.0 ** math.floor(math.log10((high - low) / most))
    steps = [scale * power * step for power in (0.1, 1.0, 10.0) for step in _STEPS]
    multiples = [(step, math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)) for step in steps]
    enough = [found for found in multiples if found[2] > found[1]]
    step, first, last = next((found for found in enough if found[2] - found[1] < most), enough[-1])
    return tuple(step * k for k in range(first, last + 1))


def round_length(most: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is at most `most`, which is positive.

    >>> round_length(0.49), round_length(0.2), round_length(1e3)
    (0.2, 0.2, 1000.0)
    """
    scale = 10.0 ** math.floor(math.log10(most) + 1e-9)
    return next(step * scale for step in (5.0, 2.0, 1.0) if step * scale <= most * (1.0 + 1e-6))


def apart(shares: Sequence[float], least: float) -> list[float]:
    """Places from 0 to 1 in ascending order, moved until neighbours are `least` apart and none is beyond 1.

    >>> [round(place, 3) for place in apart([0.2, 0.25, 1.0], 0.1)], apart([0.875, 1.0], 0.25)
    ([0.2, 0.3, 1.0], [0.75, 1.0])
    """
    places: list[float] = []
    for share in shares:
        places.append(max(share, places[-1] + least) if places else share)
    beyond = max(0.0, places[-1] - 1.0) if places else 0.0
    return [place - beyond for place in places]
