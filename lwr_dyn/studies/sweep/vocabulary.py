"""What a study can vary, by path, and the metrics of its runs, by name.

`arm.mass` is a factor for each link, drawn by itself; `arm.mass.all` one for all of them, `arm.mass.3` that of link 3
alone. `controller.OPTION` and `task.OPTION` are the options of `lwr-dyn simulate`. A path has its unit, bounds, a usual
distribution, and how many numbers a run has; a metric its unit, and which side of a bound is bad.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import inf
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.model.chain import JointKind

AXES = ("x", "y", "z")
ALL = "all"
OPTION = "OPTION"
"""Stands for the name of an option in the paths of controller and task."""


@dataclass(frozen=True, slots=True)
class PathRow:
    """What can be varied under one path.

    `least` and `most` are the smallest and largest value (`above` where `least` itself is not allowed), `nominal` what
    the arm is modelled with, `usual` a usual distribution in words, `of` what is numbered ("link", "joint" or nothing).
    """

    words: str
    unit: str = ""
    usual: str = ""
    least: float = -np.inf
    most: float = np.inf
    above: bool = False
    nominal: float | None = None
    of: str = ""
    axes: bool = False
    whole: bool = False
    text: bool = False

    @property
    def allowed(self) -> str:
        """Its values in words."""
        kind = "a whole number" if self.whole else "a number"
        unit = f", in {self.unit}" if self.unit else ""
        if np.isfinite(self.most):
            return f"{kind} from {self.least:g} to {self.most:g}{unit}"
        if np.isfinite(self.least):
            return f"{kind} above {self.least:g}{unit}" if self.above else f"{kind} from {self.least:g} on{unit}"
        return f"{kind}{unit}"

    def allows(self, value: float) -> bool:
        """Whether a value is inside the bounds, and whole where it must be."""
        inside = self.least < value if self.above else self.least <= value
        return bool(np.isfinite(value) and inside and value <= self.most and (not self.whole or value == round(value)))


PATHS: Mapping[str, PathRow] = MappingProxyType(
    {
        "reading": PathRow("reading of the arm's tables that the plant has", usual="choice", text=True),
        "arm.mass": PathRow(
            "factor on masses; the centres stay, and the tensors about them",
            usual="uniform 0.8 to 1.2", least=0.0, above=True, nominal=1.0, of="link",
        ),
        "arm.inertia": PathRow(
            "factor on the tensors about the centres of mass",
            usual="uniform 0.8 to 1.2", least=0.0, above=True, nominal=1.0, of="link",
        ),
        "arm.com": PathRow(
            "shift of the centres of mass in the links' frames, each axis by itself",
            "m", "uniform -0.01 to 0.01", nominal=0.0, of="link", axes=True,
        ),
        "arm.armature": PathRow(
            "factor on the rotors' inertia at the joints",
            usual="uniform 0.9 to 1.1", least=0.0, nominal=1.0, of="joint"
        ),
        "payload.mass": PathRow("point mass at the flange", "kg", "uniform 0 to 7", least=0.0, nominal=0.0),
        "payload.com": PathRow(
            "where the payload is, in the flange's frame", "m", "uniform -0.05 to 0.05", nominal=0.0, axes=True
        ),
        "payload.known": PathRow(
            "share of the payload that the controller's model has; robust has a middle load of its own in its place",
            usual="choice 0, 1", least=0.0, most=1.0, nominal=0.0
        ),
        "friction.coulomb": PathRow(
            "Coulomb friction of the plant as a share of the torque limit, in place of the arm's own",
            usual="uniform 0 to 0.05", least=0.0, nominal=0.0, of="joint",
        ),
        "friction.viscous": PathRow(
            "viscous friction of the plant, in place of the arm's own",
            "N m s/rad", "uniform 0 to 1", least=0.0, nominal=0.0, of="joint",
        ),
        "sensor.resolution": PathRow("one count of the encoders", "rad or m", "choice 0, 1e-5", least=0.0, nominal=0.0),
        "sensor.noise": PathRow(
            "standard deviation of the encoders' noise", "rad or m", "uniform 0 to 1e-5", least=0.0, nominal=0.0
        ),
        "loop.delay": PathRow(
            "samples from a command to its torque", "samples", "choice 0, 1, 2, 3, 4", 0.0, 8.0, nominal=0.0, whole=True
        ),
        "limits.torque": PathRow(
            "factor on the torque limits", usual="uniform 0.8 to 1", least=0.0, above=True, nominal=1.0, of="joint"
        ),
        f"controller.{OPTION}": PathRow("an option of every controller of the study, such as controller.omega_n"),
        f"task.{OPTION}": PathRow("an option of the task, such as task.duration", usual="choice"),
    }
)  # fmt: skip
"""Paths, without the numbers of links and joints."""


@dataclass(frozen=True, slots=True)
class ParameterPath:
    """A path that was read: its row, the number of its link or joint (from 1) or "all", its axis, or its option."""

    text: str
    name: str
    row: PathRow
    number: str = ""
    axis: str = ""
    option: str = ""

    def columns(self, n: int) -> tuple[str, ...]:
        """Names of its numbers of a run, for an arm of n joints."""
        if self.option:
            return (self.text,)
        axes = [self.axis] if self.axis else list(AXES)
        numbers = [self.number] if self.number else [str(i) for i in range(1, n + 1)]
        lists = [numbers] * bool(self.row.of) + [axes] * self.row.axes
        return tuple(".".join([self.name, *part]) for part in product(*lists))


def parameter_path(text: str, n: int) -> ParameterPath:
    """The path of a text for an arm of n joints; raises `UnknownNameError`, which says what is near, and `OptionError`.

    >>> parameter_path("arm.com.3.z", 7).columns(7)
    ('arm.com.3.z',)
    >>> [len(parameter_path(text, 7).columns(7)) for text in ("arm.com", "arm.com.all", "arm.mass", "payload.mass")]
    [21, 3, 7, 1]
    """
    group, _, option = text.partition(".")
    if group in ("controller", "task") and option:
        name = f"{group}.{OPTION}"
        return ParameterPath(text, name, PATHS[name], option=option.replace("-", "_"))
    name = max((path for path in PATHS if f"{text}.".startswith(f"{path}.")), key=len, default="")
    if not name:
        raise UnknownNameError("parameter path", text, PATHS)
    row, rest = PATHS[name], text.split(".")[name.count(".") + 1 :]
    number = rest.pop(0) if rest and row.of else None
    if number not in (None, ALL, *map(str, range(1, n + 1))):
        allowed = f"the number of a {row.of}, from 1 to {n}, or {ALL}"
        raise OptionError(f"parameter path {name}", repr(number), allowed)
    axis = rest.pop(0) if rest and row.axes else None
    if axis not in (None, *AXES):
        raise UnknownNameError(f"axis of {name}", axis, AXES)
    if rest:
        forms = [name, *([f"{name}.all", f"{name}.3"] if row.of else [])]
        raise OptionError("parameter path", repr(text), " or ".join([*forms, f"{forms[-1]}.z"] if row.axes else forms))
    return ParameterPath(text, name, row, number or "", axis or "")


@dataclass(frozen=True, slots=True)
class MetricRow:
    """One metric; `per_joint` where it has one number a joint, `at_least` where a bound is a lower one."""

    unit: str
    words: str
    per_joint: bool = False
    at_least: bool = False
    signed: bool = False
    """Whether it can be negative."""
    needs_effort: bool = False
    """Whether it says nothing of a joint without a torque limit."""


METRICS: Mapping[str, MetricRow] = MappingProxyType(
    {
        "tip_rms": MetricRow("m", "error of the tip, RMS over the samples"),
        "tip_max": MetricRow("m", "error of the tip, largest"),
        "tip_final": MetricRow("m", "error of the tip at the end"),
        "position_rms": MetricRow("rad or m", "error of a joint, RMS over the samples", per_joint=True),
        "position_max": MetricRow("rad or m", "error of a joint, largest", per_joint=True),
        "peak_torque": MetricRow("N m or N", "largest torque that acts", per_joint=True),
        "peak_command": MetricRow("N m or N", "largest torque that the law asks for", per_joint=True),
        "torque_rms": MetricRow("N m or N", "torque that acts, RMS over the samples", per_joint=True),
        "peak_speed": MetricRow("rad/s or m/s", "largest speed", per_joint=True),
        "saturated_s": MetricRow("s", "time beyond the torque limit", per_joint=True, needs_effort=True),
        "limit_margin": MetricRow("rad or m", "least distance from a position limit", True, at_least=True, signed=True),
        "first_violation": MetricRow("s", "when the tip first leaves the tolerance, inf if never", at_least=True),
    }
)
"""Metrics of every run, in SI units; `tip_q95` and the like come with the quantiles of a study."""


def metric_row(name: str, quantiles: Sequence[float] = ()) -> MetricRow:
    """The metric of a name; raises `UnknownNameError`, which says what is near.

    >>> metric_row("tip_rms").unit
    'm'
    """
    shares = {}
    if quantiles:  # the rollouts, which name them, are imported where there is one
        from lwr_dyn.codegen.rollouts.result import quantile_name

        shares = {quantile_name(share): share for share in quantiles}
    if name in shares:
        return MetricRow("m", f"error of the tip, {100 * shares[name]:g} % quantile over time")
    if name not in METRICS:
        raise UnknownNameError("metric", name, (*METRICS, *(shares or ("tip_q95 with quantiles = [0.95]",))))
    return METRICS[name]


SHOWN = {"m": ("mm", 1e3), "rad": ("mrad", 1e3), "rad or m": ("mrad or mm", 1e3)}
"""Unit -> the unit for people, and how many of it are one; others stay."""


@dataclass(frozen=True, slots=True)
class MetricWords:
    """Title and unit for people; `factor` times SI is that unit; `worse` is +1 where large values are bad, else -1."""

    name: str
    title: str
    unit: str
    factor: float
    worse: int

    def shown(self, badness: Any) -> Any:
        """Values of the `badness`, a number or an array, in the unit for people."""
        return self.factor * self.worse * badness

    def badness(self, values: Array) -> Array:
        """One number a run (runs,) that is the larger the worse, of the worst joint of (runs, n); inf for NaN."""
        signed = self.worse * np.asarray(values, dtype=np.float64)
        whole = np.where(np.isnan(signed), inf, signed)
        return whole if whole.ndim == 1 else np.asarray(whole.max(axis=1))

    def is_within(self, values: Array, bound: float) -> NDArray[np.bool_]:
        """Which runs (runs,) keep a bound in SI units with all joints; a run without a number keeps none."""
        return np.asarray(self.badness(values) <= self.worse * bound)


def metric_words(name: str, quantiles: Sequence[float] = (), kinds: Collection[JointKind] = ()) -> MetricWords:
    """The words of a metric; `quantiles` over time are those of the study, `kinds` the kinds of the arm's joints.

    Raises
    ------
    UnknownNameError
        No metric of that name.

    >>> one = metric_words("limit_margin")
    >>> one.unit, one.worse, one.badness(np.array([[0.5, 0.2], [np.nan, 0.1]])).tolist()
    ('mrad or mm', -1, [-0.2, inf])
    """
    row = metric_row(name, quantiles)
    turning, _, sliding = row.unit.partition(" or ")
    own = {frozenset([JointKind.REVOLUTE]): turning, frozenset([JointKind.PRISMATIC]): sliding or turning}
    shown = own.get(frozenset(kinds), row.unit)
    unit, factor = SHOWN.get(shown, (shown, 1.0))
    title = f"{row.words}, worst joint" if row.per_joint else row.words
    return MetricWords(name, title, unit, factor, -1 if row.at_least else 1)
