"""What a study can vary, by path: unit, words, bounds, what a usual distribution is, and how many numbers a run has.

`arm.mass` is a factor for each link, drawn by itself; `arm.mass.all` one for all of them, `arm.mass.3` that of link 3
alone. `controller.OPTION` and `task.OPTION` are the options of `lwr-dyn simulate`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

import numpy as np

from lwr_dyn.foundation.errors import OptionError, UnknownNameError

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
    parts = text.split(".")
    name = next((".".join(parts[:k]) for k in range(len(parts), 0, -1) if ".".join(parts[:k]) in PATHS), "")
    if not name:
        raise UnknownNameError("parameter path", text, PATHS)
    row, rest = PATHS[name], parts[len(name.split(".")) :]
    number, axis = "", ""
    if rest and row.of:
        number = _number(rest.pop(0), row.of, name, n)
    if rest and row.axes:
        axis = rest.pop(0)
        if axis not in AXES:
            raise UnknownNameError(f"axis of {name}", axis, AXES)
    if rest:
        raise OptionError("parameter path", repr(text), _forms(name, row))
    return ParameterPath(text, name, row, number, axis)


def _number(text: str, of: str, name: str, n: int) -> str:
    if text != ALL and text not in map(str, range(1, n + 1)):
        raise OptionError(f"parameter path {name}", repr(text), f"the number of a {of}, from 1 to {n}, or {ALL}")
    return text


def _forms(name: str, row: PathRow) -> str:
    forms = [name, *([f"{name}.all", f"{name}.3"] if row.of else [])]
    return " or ".join([*forms, f"{forms[-1]}.z"] if row.axes else forms)
