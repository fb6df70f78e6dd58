"""Plots of a report page: curves of numbers, or of a series of one of the page's runs, which is packed only once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from lwr_dyn.arrays import Array, read_only
from lwr_dyn.errors import OptionError

Quantity = Literal[
    "q", "q_ref", "dq", "dq_ref", "position error", "velocity error", "torque", "friction",
    "tip error", "flange x", "flange y", "flange z", "reference x", "reference y", "reference z", "energy",
]  # fmt: skip
"""Series of a run; errors are reference minus actual, "flange" and "reference" positions in the base frame."""
JOINT_QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)[:8]


@dataclass(frozen=True, slots=True)
class Series:
    """A series of run `run` of the page's replay; `joint` is 0-based and needed for joint quantities."""

    run: int
    quantity: Quantity
    joint: int | None = None
    scale: float = 1.0

    def __post_init__(self) -> None:
        if self.quantity not in get_args(Quantity):
            raise OptionError("quantity", repr(self.quantity), ", ".join(get_args(Quantity)))
        if (self.joint is not None) != (self.quantity in JOINT_QUANTITIES):
            allowed = "a 0-based joint for joint quantities, none for others"
            raise OptionError(f"joint of {self.quantity!r}", repr(self.joint), allowed)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A curve of numbers or of a run's series; without `x` a series is drawn over the run's time [s].

    A NaN in `y` leaves a gap. `text` names single points on hover. `colour` counts in the page's palette; without it
    curves are coloured in their order.
    """

    label: str
    y: Array | Series
    x: Array | Series | None = None
    style: Literal["line", "points", "both"] = "line"
    dashed: bool = False
    colour: int | None = None
    text: tuple[str, ...] = ()

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


@dataclass(frozen=True, slots=True)
class Level:
    """A straight line across a panel: a limit or a printed value, at `value` on the axis named."""

    label: str
    value: float
    axis: Literal["x", "y"] = "y"


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """One pair of axes."""

    title: str
    y_label: str
    y_unit: str
    curves: tuple[Curve, ...]
    levels: tuple[Level, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """A figure in the form of the document's; `where` is its name there ("Fig. 4").

    With `over_time` x is the run's time [s], and the cursor of the replay follows. `columns` of panels on wide screens.
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
