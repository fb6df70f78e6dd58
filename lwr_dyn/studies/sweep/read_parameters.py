"""The `[[parameter]]` tables of a study: a path, its distribution, and whether arm, controllers and task have it."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from math import isfinite, prod
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import ONE_READING
from lwr_dyn.arms.papers.catalog import readings
from lwr_dyn.arms.papers.schema import KINDS
from lwr_dyn.control.controllers import CONTROLLERS
from lwr_dyn.foundation import errors
from lwr_dyn.foundation.fields import Fields
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.registry import Option, options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.studies.sweep import sweep_study
from lwr_dyn.studies.sweep.sampling import DISTRIBUTIONS, VariedParameter
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
from lwr_dyn.studies.sweep.vocabulary import ALL, PathRow, parameter_path
from lwr_dyn.trajectory.references.references import REFERENCES


@contextmanager
def blamed(fields: Fields, key: str = "") -> Iterator[None]:
    """Gives other errors the file and the field that they come from; a missing package keeps its own words."""
    try:
        yield
    except (errors.PaperError, errors.MissingPackageError):
        raise
    except errors.UnknownNameError as fault:
        found, _, known = str(fault).partition("; known: ")
        raise fields.refuse(key, found, known) from fault
    except errors.FaultError as fault:
        raise fields.refuse(key, f"{fault.name}: {fault.found}", fault.allowed) from fault
    except errors.LwrDynError as fault:
        raise fields.refuse(key, str(fault), "another value") from fault


FIELDS = {
    "levels": ("low", "high", "count"), "normal": ("mean", "deviation"), "uniform": ("low", "high"),
    "choice": ("values",), "fixed": ("value",),
}  # fmt: skip
"""Distribution -> the fields that it needs; where none is named, it is the first whose fields are all there."""
MOST_LEVELS = 100_000
FAR = 8
"""Deviations from the mean within which a normal distribution has values."""


def read_parameters(tables: Sequence[Fields], n: int) -> tuple[VariedParameter, ...]:
    """All `[[parameter]]` tables, for an arm of n joints; raises `PaperError`, also where two set the same number."""
    found = tuple(_read_parameter(fields, n) for fields in tables)
    places: dict[str, str] = {}
    for fields, one in zip(tables, found, strict=True):
        for column in one.columns:
            for other, path in places.items():
                if _is_same(other, column):
                    raise fields.refuse("path", f"{one.path} beside {path}", "each number once")
        places |= dict.fromkeys(one.columns, one.path)
    return found


def _is_same(one: str, other: str) -> bool:
    """Whether two columns are the same number, where `all` stands for every link or joint."""
    a, b = one.split("."), other.split(".")
    return len(a) == len(b) and all(
        x == y or (i == 2 and ALL in (x, y)) for i, (x, y) in enumerate(zip(a, b, strict=True))
    )


def _read_parameter(fields: Fields, n: int) -> VariedParameter:
    text = fields.take("path", str)
    with blamed(fields, "path"):
        path = parameter_path(text, n)
    row = path.row
    guess = next((name for name, keys in FIELDS.items() if set(keys) <= set(fields.unread())), "")
    name = fields.choice("distribution", DISTRIBUTIONS, guess)
    if not name:
        raise fields.refuse(
            "", "no distribution", f"low and high, or mean and deviation, or values, or value{_usual(row)}"
        )
    if row.text and name not in ("choice", "fixed"):
        raise fields.refuse("distribution", repr(name), "choice (values) or fixed (value): names")
    if row.whole and name in ("uniform", "normal"):
        raise fields.refuse("distribution", name, f"choice or levels: {row.allowed}")
    parameter = VariedParameter(
        text, name, path.columns(n), row.unit, row.words, nominal=row.nominal, **_numbers(fields, name, row),
        kind=fields.choice("kind", KINDS, "assumed"), note=fields.take("note", str, ""),
    )  # fmt: skip
    fields.refuse_unknown()
    return parameter


def _numbers(fields: Fields, name: str, row: PathRow) -> dict[str, Any]:
    """The numbers of a distribution, inside what the path allows."""
    match name:
        case "uniform":
            return _range(fields, row)
        case "normal":
            return _normal(fields, row)
        case "levels":
            return _levels(fields, row)
        case "choice":
            values = fields.texts("values") if row.text else fields.numbers("values")
            keys = [f"values[{i}]" for i in range(len(values))]
        case _:
            values, keys = (fields.take("value", str if row.text else object),), ["value"]
    return {
        "values": values if row.text else tuple(_inside(fields, row, *pair) for pair in zip(keys, values, strict=True))
    }


def _inside(fields: Fields, row: PathRow, key: str, value: Any) -> float:
    number = fields.number_at(key, value, row.allowed)
    if not row.allows(number):
        raise fields.refuse(key, f"{number:g}", row.allowed)
    return number


def _range(fields: Fields, row: PathRow) -> dict[str, Any]:
    low, high = (_inside(fields, row, key, fields.take(key, object)) for key in ("low", "high"))
    if low >= high:
        words = "an empty range" if low > high else "a range of one value"
        allowed = f"low < high, or value = {low:g} for all runs{_usual(row)}"
        raise fields.refuse("", f"{words}, low = {low:g} and high = {high:g}", allowed)
    return {"low": low, "high": high}


def _usual(row: PathRow) -> str:
    return f"; usual here: {row.usual}" if row.usual else ""


def _levels(fields: Fields, row: PathRow) -> dict[str, Any]:
    ends = _range(fields, row)
    count = fields.take("count", int)
    if not 2 <= count <= MOST_LEVELS:
        raise fields.refuse("count", repr(count), f"a whole number from 2 to {MOST_LEVELS}")
    values = np.linspace(ends["low"], ends["high"], count).tolist()
    for value in values:
        if not row.allows(value):
            raise fields.refuse("count", f"{count}, a level at {value:g}", row.allowed)
    return {"values": tuple(values), **ends}


def _normal(fields: Fields, row: PathRow) -> dict[str, Any]:
    """Mean, deviation, and where it is cut, which must be given where the path has a bound."""
    mean, deviation = fields.number("mean"), fields.number("deviation")
    if deviation <= 0.0:
        raise fields.refuse("deviation", f"{deviation:g}", "a number above 0")
    ends = {"low": row.least, "high": row.most}
    for key, bound in ends.items():
        value = fields.take(key, object, None)
        if value is not None:
            ends[key] = _inside(fields, row, key, value)
        elif isfinite(bound):
            found = f"missing, and a normal distribution passes {bound:g}"
            raise fields.refuse(key, found, f"where it is cut: {row.allowed}")
    low, high = ends.values()
    if low >= high:
        raise fields.refuse("", f"an empty range, low = {low:g} and high = {high:g}", "low < high")
    if mean + FAR * deviation < low or mean - FAR * deviation > high:
        raise fields.refuse("mean", f"{mean:g}", f"a mean within {FAR} deviations of low and high")
    return {"mean": mean, "deviation": deviation, **ends}


def checked_parameters(study: SweepStudy, arm: Arm, whole: Fields, tables: Sequence[Fields]) -> SweepStudy:
    """The study with the nominal values of its parameters; raises `PaperError` for one that it cannot have."""
    if not study.varied:
        raise whole.refuse("parameter", "nothing that varies", "one [[parameter]] or more with a range or values")
    for one, fields in zip(study.parameters, tables, strict=True):
        for start, check in CHECKS.items():
            if f"{one.path}.".startswith(f"{start}."):
                check(study, arm, one, fields)
    tasks = prod(len(one.values) for one in study.parameters if sweep_study.is_task(one.path))
    if tasks > sweep_study.MOST_REFERENCES:
        allowed = f"at most {sweep_study.MOST_REFERENCES}: each is a reference of its own"
        raise whole.refuse("parameter", f"{tasks} tasks", allowed)
    return replace(study, parameters=tuple(replace(one, nominal=_nominal(study, arm, one)) for one in study.parameters))


def _check_reading(study: SweepStudy, arm: Arm, one: VariedParameter, fields: Fields) -> None:
    """Readings that the robot has, with the same frames."""
    if ends_in(study.robot, *ONE_READING):
        raise fields.refuse("path", "reading of a robot that has one", "a robot of a data file, which has readings")
    known = readings(study.robot)
    for name in one.values:
        if name not in known:
            found = f"no reading named {name!r}{errors.did_you_mean(str(name), known)}"
            raise fields.refuse("values", found, ", ".join(known))
    for name in map(str, one.values):
        with blamed(fields, "values"):
            other = sweep_study.arm_of_study(study, name)
        if not has_same_frames(arm, other):
            found = f"{name}, with other frames of the links than {arm.reading}"
            raise fields.refuse("values", found, "readings that differ in masses, rotors or limits alone")


def has_same_frames(one: Arm, other: Arm) -> bool:
    """Whether two arms have the same joints at the same places, to rounding, and the same gravity."""
    if [link.kind for link in one.chain.links] != [link.kind for link in other.chain.links]:
        return False
    frames = [
        [*(pose.matrix() for link in arm.chain.links for pose in (link.before, link.after)), arm.chain.flange.matrix()]
        for arm in (one, other)
    ]
    same = np.allclose(frames[0], frames[1], rtol=0.0, atol=1e-12)
    return bool(same and np.array_equal(one.chain.gravity, other.chain.gravity))


def _check_armature(study: SweepStudy, arm: Arm, one: VariedParameter, fields: Fields) -> None:
    if not arm.armature.any():
        raise fields.refuse("path", f"{one.path}, and {arm.name} gives no rotors", "an arm with rotors")


def _check_torque_limits(study: SweepStudy, arm: Arm, one: VariedParameter, fields: Fields) -> None:
    for part in (column.split(".")[2] for column in one.columns):
        for joint in range(arm.n) if part == ALL else [int(part) - 1]:
            if not np.isfinite(arm.effort[joint]):
                found = f"{one.path}, and {arm.joint_names[joint]} of {arm.name} has no torque limit"
                raise fields.refuse("path", found, "joints with one")


def _check_friction(study: SweepStudy, arm: Arm, one: VariedParameter, fields: Fields) -> None:
    if study.loop["friction"] == "none":
        found = f"{one.path} beside loop.friction = 'none'"
        raise fields.refuse("path", found, "loop.friction = 'smooth', or left out")
    if one.path.startswith("friction.coulomb"):
        _check_torque_limits(study, arm, one, fields)


def _check_payload(study: SweepStudy, arm: Arm, one: VariedParameter, fields: Fields) -> None:
    if not any(other.path == "payload.mass" for other in study.parameters):
        raise fields.refuse("path", f"{one.path} without a payload", "payload.mass beside it, perhaps with one value")


def _check_task(study: SweepStudy, arm: Arm, one: VariedParameter, fields: Fields) -> None:
    """An option of the task that is a number, of a few values."""
    options = options_of(REFERENCES.load(study.task))
    _check_option(one, options, f"task {study.task}", study.task_options, "[task]", fields)
    if not one.values:
        allowed = f"values (a choice), or levels; at most {sweep_study.MOST_REFERENCES}"
        raise fields.refuse("distribution", f"{one.distribution}, and each value is a reference of its own", allowed)


def _check_controllers(study: SweepStudy, arm: Arm, one: VariedParameter, fields: Fields) -> None:
    """An option of every controller that is a number; one in a file says itself what it takes."""
    for text in study.controllers:
        spec = sweep_study.spec_of_study(study, text)
        if not spec.is_file:
            options = options_of(CONTROLLERS.load(spec.base))
            _check_option(one, options, f"controller {text}", spec.options, f"controller {text!r}", fields)
        for end in (one.lowest, one.highest):
            with blamed(fields):
                sweep_study.try_controller(study, text, {sweep_study.option_name(one.path): end})


def _check_option(
    one: VariedParameter, options: dict[str, Option], owner: str, given: Any, place: str, fields: Fields
) -> None:
    keyword = sweep_study.option_name(one.path)
    known = {key: option for key, option in options.items() if option.kind in (int, float)}
    if keyword not in known:
        found = f"{owner} has no number {keyword!r}{errors.did_you_mean(keyword, known)}"
        raise fields.refuse("path", found, ", ".join(known) or "no number of its options")
    if keyword in given:
        raise fields.refuse("path", f"{one.path}, and {keyword} in {place}", "each in one place")
    if known[keyword].kind is int and any(float(value) % 1.0 for value in one.values or (0.5,)):
        found = f"{one.distribution_words}, and {keyword} is a whole number"
        raise fields.refuse("path", found, "values that are whole")


CHECKS: dict[str, Callable[[SweepStudy, Arm, VariedParameter, Fields], None]] = {
    "reading": _check_reading,
    "arm.armature": _check_armature,
    "limits.torque": _check_torque_limits,
    "friction": _check_friction,
    "payload.com": _check_payload,
    "payload.known": _check_payload,
    "task": _check_task,
    "controller": _check_controllers,
}
"""Start of a path -> its check."""


def _nominal(study: SweepStudy, arm: Arm, one: VariedParameter) -> float | None:
    """What a parameter is as modelled; None where there is nothing, or something else for each controller."""
    if sweep_study.is_task(one.path):
        return _default(options_of(REFERENCES.load(study.task)), one.path)
    if one.path.startswith("controller."):
        specs = [sweep_study.spec_of_study(study, text) for text in study.controllers]
        rows = [{} if spec.is_file else options_of(CONTROLLERS.load(spec.base)) for spec in specs]
        found = {_default(row, one.path) for row in rows}
        return found.pop() if len(found) == 1 else None
    if one.path.startswith("friction.") and arm.has_friction:
        assumed = study.assumed_friction
        return None if assumed is None else assumed if one.path.startswith("friction.coulomb") else 0.0
    return one.nominal


def _default(options: dict[str, Option], path: str) -> float | None:
    """The default of an option that is a number."""
    default = options[sweep_study.option_name(path)].default if sweep_study.option_name(path) in options else None
    return float(default) if isinstance(default, int | float) and not isinstance(default, bool) else None
