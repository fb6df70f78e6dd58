"""A figure is described once: `lwr_dyn.pages.plotting` draws it as PNG and SVG, pages draw it themselves.

Its curves are numbers, or series of runs, which a page packs only once for the 3D view and for all figures.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import OptionError
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
