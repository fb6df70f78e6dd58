"""Fields of a study's file: numbers, counts and tables, each refused with the file and the field.

The `[[parameter]]` tables of a study's file: a path, a distribution with a range, where it comes from.

Whether what a study varies exists: in its arm, in its controllers, in its task.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.catalog import readings
from lwr_dyn.arms.papers.schema import KINDS
from lwr_dyn.control.controllers import CONTROLLERS, ControllerSpec
from lwr_dyn.foundation.errors import PaperError, did_you_mean
from lwr_dyn.foundation.fields import Fields
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.registry import Option, options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.studies.sweep.sampling import DISTRIBUTIONS, VariedParameter
from lwr_dyn.studies.sweep.sweep_study import (
    MOST_REFERENCES,
    SweepStudy,
    arm_of_study,
    field_of,
    is_task,
    option_name,
    spec_of_study,
    try_controller,
)
from lwr_dyn.studies.sweep.vocabulary import ALL, ParameterPath, PathRow, parameter_path
from lwr_dyn.trajectory.references.references import REFERENCES

LARGEST = 1e30
"""No quantity of a study is larger."""


def number_at(value: Any, file: str, field: str, allowed: str = "a number") -> float:
    """A finite number of a field; raises `PaperError`."""
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not math.isfinite(value)
        or abs(value) > LARGEST
    ):
        raise PaperError(file, field, repr(value), allowed)
    return float(value)


def take_number(
    fields: Fields, key: str, file: str, default: float | None = None, *, above: float = -math.inf
) -> float | None:
    """A number above a bound, or the default where the field is not given; raises `PaperError`."""
    value = fields.take(key, object, None)
    if value is None:
        return default
    field = fields.name_of(key)
    allowed = f"a number above {above:g}" if math.isfinite(above) else "a number"
    number = number_at(value, file, field, allowed)
    if number <= above:
        raise PaperError(file, field, repr(value), allowed)
    return number


def take_numbers(fields: Fields, key: str, file: str, default: tuple[float, ...] | None = None) -> tuple[float, ...]:
    """A list of one or more numbers, each once, or the default where it is not given; raises `PaperError`."""
    field = fields.name_of(key)
    values = fields.take(key, list, *([] if default is None else [list(default)]))
    if not values and default is None:
        raise PaperError(file, field, "an empty list", "one number or more")
    numbers = tuple(number_at(x, file, f"{field}[{i}]") for i, x in enumerate(values))
    _refuse_twice(numbers, file, field)
    return numbers


def take_texts(fields: Fields, key: str, file: str) -> tuple[str, ...]:
    """A list of one or more texts, each once; raises `PaperError`."""
    field, values = fields.name_of(key), fields.take(key, list)
    if not values:
        raise PaperError(file, field, "an empty list", "one text or more")
    for i, text in enumerate(values):
        if not isinstance(text, str):
            raise PaperError(file, f"{field}[{i}]", repr(text), "a text")
    _refuse_twice(tuple(values), file, field)
    return tuple(values)


def _refuse_twice(values: tuple[Any, ...], file: str, field: str) -> None:
    for i, value in enumerate(values):
        if value in values[:i]:
            raise PaperError(file, f"{field}[{i}]", f"{value!r} twice", "each once")


FIELDS = {
    "uniform": ("low", "high"), "normal": ("mean", "deviation"), "choice": ("values",),
    "levels": ("low", "high", "count"), "fixed": ("value",),
}  # fmt: skip
"""Distribution -> the fields that it needs."""

MOST_LEVELS = 100_000

FAR = 8
"""Deviations from the mean within which a normal distribution has values."""


def read_parameter(table: Any, file: str, index: int, n: int) -> VariedParameter:
    """One `[[parameter]]` for an arm of n joints; raises `PaperError`."""
    field = f"parameter[{index}]"
    fields = Fields(table, file, field)
    text = fields.take("path", str)
    with field_of(file, f"{field}.path"):
        path = parameter_path(text, n)
    row = path.row
    name = _distribution(fields, table, row, file, field)
    facts = _facts(fields, name, path, file, field)
    parameter = VariedParameter(
        text, name, path.columns(n), row.unit, row.words, kind=fields.choice("kind", KINDS, "assumed"),
        note=fields.take("note", str, ""), nominal=row.nominal, **facts,
    )  # fmt: skip
    fields.refuse_unknown()
    return parameter


def _distribution(fields: Fields, table: dict[str, Any], row: PathRow, file: str, field: str) -> str:
    """The distribution: its name, or what its fields belong to."""
    guess = next((name for name in ("levels", "normal", "uniform", "choice", "fixed") if _has(table, name)), None)
    name = fields.choice("distribution", DISTRIBUTIONS, guess)
    if "distribution" not in table and guess is None:
        allowed = "low and high, or mean and deviation, or values, or value"
        raise PaperError(file, field, "no distribution", f"{allowed}{_usual(row)}")
    if row.text and name not in ("choice", "fixed"):
        raise PaperError(file, f"{field}.distribution", repr(name), "choice (values) or fixed (value): names")
    return name


def _has(table: dict[str, Any], name: str) -> bool:
    return all(key in table for key in FIELDS[name])


def _usual(row: PathRow) -> str:
    return f"; usual here: {row.usual}" if row.usual else ""


def _facts(fields: Fields, name: str, path: ParameterPath, file: str, field: str) -> dict[str, Any]:
    """The numbers of a distribution, inside what the path allows."""
    readers: dict[str, Callable[[Fields, PathRow, str, str], dict[str, Any]]] = {
        "uniform": _uniform, "normal": _normal, "choice": _choice, "levels": _levels, "fixed": _fixed,
    }  # fmt: skip
    return readers[name](fields, path.row, file, field)


def _uniform(fields: Fields, row: PathRow, file: str, field: str) -> dict[str, Any]:
    if row.whole:
        raise PaperError(file, f"{field}.distribution", "uniform", f"choice or levels: {row.allowed}")
    return _range(fields, row, file, field)


def _range(fields: Fields, row: PathRow, file: str, field: str) -> dict[str, Any]:
    low, high = (_bound(fields, key, row, file, field) for key in ("low", "high"))
    if low >= high:
        words = "an empty range" if low > high else "a range of one value"
        allowed = f"low < high, or value = {low:g} for all runs{_usual(row)}"
        raise PaperError(file, field, f"{words}, low = {low:g} and high = {high:g}", allowed)
    return {"low": low, "high": high}


def _bound(fields: Fields, key: str, row: PathRow, file: str, field: str) -> float:
    return _inside(fields.take(key, object), row, file, f"{field}.{key}")


def _inside(value: Any, row: PathRow, file: str, field: str) -> float:
    number = number_at(value, file, field, row.allowed)
    if not row.allows(number):
        raise PaperError(file, field, f"{number:g}", row.allowed)
    return number


def _normal(fields: Fields, row: PathRow, file: str, field: str) -> dict[str, Any]:
    if row.whole:
        raise PaperError(file, f"{field}.distribution", "normal", f"choice or levels: {row.allowed}")
    mean = number_at(fields.take("mean", object), file, f"{field}.mean")
    deviation = number_at(fields.take("deviation", object), file, f"{field}.deviation")
    if deviation <= 0.0:
        raise PaperError(file, f"{field}.deviation", f"{deviation:g}", "a number above 0")
    low, high = _end(fields, "low", row.least, row, file), _end(fields, "high", row.most, row, file)
    if low >= high:
        raise PaperError(file, field, f"an empty range, low = {low:g} and high = {high:g}", "low < high")
    if mean + FAR * deviation < low or mean - FAR * deviation > high:
        raise PaperError(file, f"{field}.mean", f"{mean:g}", f"a mean within {FAR} deviations of low and high")
    return {"mean": mean, "deviation": deviation, "low": low, "high": high}


def _end(fields: Fields, key: str, bound: float, row: PathRow, file: str) -> float:
    """Where a normal distribution is cut, which must be given where the path has a bound; infinite if not given."""
    value, field = fields.take(key, object, None), fields.name_of(key)
    if value is not None:
        return _inside(value, row, file, field)
    if math.isfinite(bound):
        found = f"missing, and a normal distribution passes {bound:g}"
        raise PaperError(file, field, found, f"where it is cut: {row.allowed}")
    return bound


def _choice(fields: Fields, row: PathRow, file: str, field: str) -> dict[str, Any]:
    if row.text:
        return {"values": take_texts(fields, "values", file)}
    values = take_numbers(fields, "values", file)
    return {"values": tuple(_inside(x, row, file, f"{field}.values[{i}]") for i, x in enumerate(values))}


def _levels(fields: Fields, row: PathRow, file: str, field: str) -> dict[str, Any]:
    ends = _range(fields, row, file, field)
    count = fields.take("count", int)
    if not 2 <= count <= MOST_LEVELS:
        raise PaperError(file, f"{field}.count", repr(count), f"a whole number from 2 to {MOST_LEVELS}")
    values = np.linspace(ends["low"], ends["high"], count).tolist()
    for value in values:
        if not row.allows(value):
            raise PaperError(file, f"{field}.count", f"{count}, a level at {value:g}", row.allowed)
    return {"values": tuple(values), **ends}


def _fixed(fields: Fields, row: PathRow, file: str, field: str) -> dict[str, Any]:
    if row.text:
        return {"values": (fields.take("value", str),)}
    return {"values": (_bound(fields, "value", row, file, field),)}


def refuse_overlaps(parameters: Sequence[VariedParameter], file: str) -> None:
    """Raise `PaperError` where two parameters set the same number."""
    places: dict[str, str] = {}
    for i, one in enumerate(parameters):
        for column in one.columns:
            other = next((places[key] for key in places if _same(key, column)), None)
            if other is not None:
                raise PaperError(file, f"parameter[{i}].path", f"{one.path} beside {other}", "each number once")
        places |= dict.fromkeys(one.columns, one.path)


def _same(one: str, other: str) -> bool:
    """Whether two columns are the same number, where `all` stands for every link or joint."""
    parts = one.split("."), other.split(".")
    if len(parts[0]) != len(parts[1]):
        return False
    return all(a == b or (i == 2 and ALL in (a, b)) for i, (a, b) in enumerate(zip(*parts, strict=True)))


SEPARATE = "each in one place"


@dataclass(frozen=True, slots=True)
class ParameterCheck:
    """One parameter of a study, and where it stands in the file."""

    study: SweepStudy
    arm: Arm
    one: VariedParameter
    file: str
    field: str

    def refuse(self, found: str, allowed: str, key: str = "path") -> PaperError:
        """The error, to be raised."""
        return PaperError(self.file, f"{self.field}.{key}", found, allowed)

    def reading(self) -> None:
        """Readings that the robot has."""
        study = self.study
        if ends_in(study.robot, ".urdf", ".xacro"):
            raise self.refuse("reading of a URDF", "a robot of a data file, which has readings")
        known = readings(study.robot)
        for name in self.one.values:
            if name not in known:
                raise self.refuse(
                    f"no reading named {name!r}{did_you_mean(str(name), known)}", ", ".join(known), "values"
                )

        for name in map(str, self.one.values):
            with field_of(self.file, f"{self.field}.values"):
                other = arm_of_study(self.study, name)
            if not same_frames(self.arm, other):
                found = f"{name}, with other frames of the links than {self.arm.reading}"
                raise self.refuse(found, "readings that differ in masses, rotors or limits alone", "values")

    def armature(self) -> None:
        """Rotors that the arm gives."""
        if not self.arm.armature.any():
            raise self.refuse(f"{self.one.path}, and {self.arm.name} gives no rotors", "an arm with rotors")

    def share_of_torque(self) -> None:
        """Torque limits of the joints that are varied."""
        limited = np.isfinite(self.arm.effort)
        for part in (column.split(".")[2] for column in self.one.columns):
            joints = range(self.arm.n) if part == "all" else [int(part) - 1]
            for joint in (joint for joint in joints if not limited[joint]):
                name = self.arm.joint_names[joint]
                raise self.refuse(
                    f"{self.one.path}, and {name} of {self.arm.name} has no torque limit", "joints with one"
                )

    def friction(self) -> None:
        """Friction that the loop has."""
        if self.study.loop["friction"] == "none":
            raise self.refuse(f"{self.one.path} beside loop.friction = 'none'", "loop.friction = 'smooth', or left out")
        if self.one.path.startswith("friction.coulomb"):
            self.share_of_torque()

    def payload(self) -> None:
        """A payload, where its place or who knows it is varied."""
        if not any(other.path == "payload.mass" for other in self.study.parameters):
            raise self.refuse(f"{self.one.path} without a payload", "payload.mass beside it, perhaps with one value")

    def of_task(self) -> None:
        """An option of the task that is a number, of a few values."""
        task, keyword = self.study.task, option_name(self.one.path)
        known = {key: x for key, x in options_of(REFERENCES.load(task)).items() if x.kind in (int, float)}
        self._number(keyword, known, f"task {task}", keyword in self.study.task_options, "[task]")
        if not self.one.values:
            found = f"{self.one.distribution}, and each value is a reference of its own"
            raise self.refuse(found, f"values (a choice), or levels; at most {MOST_REFERENCES}", "distribution")

    def of_controller(self) -> None:
        """An option of every controller that is a number."""
        for text in self.study.controllers:
            spec = spec_of_study(self.study, text)
            if not spec.is_file:
                known = {key: x for key, x in _options(spec).items() if x.kind in (int, float)}
                keyword = option_name(self.one.path)
                self._number(keyword, known, f"controller {text}", keyword in spec.options, f"controller {text!r}")
            for end in (self.one.lowest, self.one.highest):
                with field_of(self.file, self.field):
                    try_controller(self.study, text, {option_name(self.one.path): end})

    def _number(self, keyword: str, known: dict[str, Option], owner: str, given: bool, place: str) -> None:
        if keyword not in known:
            near = did_you_mean(keyword, known)
            raise self.refuse(
                f"{owner} has no number {keyword!r}{near}", ", ".join(known) or "no number of its options"
            )
        if given:
            raise self.refuse(f"{self.one.path}, and {keyword} in {place}", SEPARATE)
        if known[keyword].kind is int and any(float(value) % 1.0 for value in self.one.values or (0.5,)):
            raise self.refuse(
                f"{self.one.distribution_words}, and {keyword} is a whole number", "values that are whole"
            )


CHECKS: dict[str, Callable[[ParameterCheck], None]] = {
    "reading": ParameterCheck.reading,
    "arm.armature": ParameterCheck.armature,
    "limits.torque": ParameterCheck.share_of_torque,
    "friction": ParameterCheck.friction,
    "payload.com": ParameterCheck.payload,
    "payload.known": ParameterCheck.payload,
    "task": ParameterCheck.of_task,
    "controller": ParameterCheck.of_controller,
}
"""Start of a path -> its check."""


def same_frames(one: Arm, other: Arm) -> bool:
    """Whether two arms have the same joints at the same places, to rounding, and the same gravity."""
    if [link.kind for link in one.chain.links] != [link.kind for link in other.chain.links]:
        return False
    poses = [[p.matrix() for link in a.chain.links for p in (link.before, link.after)] for a in (one, other)]
    ends = [[a.chain.flange.matrix()] for a in (one, other)]
    same = np.allclose(poses[0] + ends[0], poses[1] + ends[1], rtol=0.0, atol=1e-12)
    return bool(same and np.array_equal(one.chain.gravity, other.chain.gravity))


def check_parameters(study: SweepStudy, arm: Arm, file: str) -> None:
    """Raise `PaperError` for the first parameter that the study cannot have."""
    if not study.varied:
        raise PaperError(file, "parameter", "nothing that varies", "one [[parameter]] or more with a range or values")
    for i, one in enumerate(study.parameters):
        for start, check in CHECKS.items():
            if f"{one.path}.".startswith(f"{start}."):
                check(ParameterCheck(study, arm, one, file, f"parameter[{i}]"))
    tasks = prod(len(one.values) for one in study.parameters if is_task(one.path))
    if tasks > MOST_REFERENCES:
        raise PaperError(
            file, "parameter", f"{tasks} tasks", f"at most {MOST_REFERENCES}: each is a reference of its own"
        )


def _options(spec: ControllerSpec) -> dict[str, Option]:
    return options_of(CONTROLLERS.load(spec.base))
