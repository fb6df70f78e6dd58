"""The `[task]` table of a study's file: a task and its options, by the names that they have in `lwr-dyn simulate`."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.fields import Fields
from lwr_dyn.foundation.errors import PaperError, did_you_mean
from lwr_dyn.foundation.registry import REQUIRED, Option, Quantity, Registry, options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.option_values import si_value
from lwr_dyn.studies.sweep.study.study_fields import number_at
from lwr_dyn.studies.sweep.study.study_setup import field_of
from lwr_dyn.trajectory.references.tasks import REFERENCES

LISTS = {Quantity.ANGLES: 3, Quantity.POINT: 3}
"""Options that are lists, and how many numbers they have; joint positions have one a joint."""


@dataclass(frozen=True, slots=True)
class TaskFields:
    """A task, its options by keyword in rad and m, and the files that they name."""

    name: str
    options: Mapping[str, Any]
    files: tuple[Path, ...]


def read_task(table: Any, file: str, folder: Path, arm: Arm) -> TaskFields:
    """The task of a study's file; raises `PaperError`."""
    fields = Fields(table, file, "task")
    name = fields.take("name", str)
    with field_of(file, "task.name"):
        known = {option.flag_name: option for option in options_of(REFERENCES.load(name)).values()}
    options, files = {}, []
    for key in (key for key in table if key != "name"):
        written = key.replace("_", "-")
        if written not in known:
            found = f"unknown field{did_you_mean(written, known)}"
            raise PaperError(file, f"task.{key}", found, ", ".join(["name", *known]))
        option = known[written]
        value = _value(table[key], option, file, f"task.{key}", arm, name)
        if isinstance(value, str) and (folder / value).is_file():
            value = str((folder / value).resolve())
            files.append(Path(value))
        options[option.keyword] = value
    return TaskFields(name, options, tuple(files))


def missing_option(task: TaskFields, varied: set[str]) -> str | None:
    """An option that the task needs, and that is neither given nor varied, by its name in the file."""
    for option in options_of(REFERENCES.load(task.name)).values():
        if option.default is REQUIRED and option.keyword not in {*task.options, *varied}:
            return option.flag_name
    return None


def _value(value: Any, option: Option, file: str, field: str, arm: Arm, task: str) -> Any:
    """A value as the task's factory takes it."""
    kind, words = option.kind, option.help.rstrip(".")
    if kind is bool:
        if not isinstance(value, bool):
            raise PaperError(file, field, repr(value), "true or false")
        return (not option.default) if value else option.default
    if kind in (int, float, Quantity.ANGLE):
        number = number_at(value, file, field, f"a number ({words})")
        if kind is int and number % 1.0:
            raise PaperError(file, field, repr(value), f"a whole number ({words})")
        return float(np.radians(number)) if kind is Quantity.ANGLE else kind(number)
    if isinstance(kind, Quantity):
        return _list(value, option, file, field, arm, task)
    return _text(value, option, file, field)


def _text(value: Any, option: Option, file: str, field: str) -> str:
    if not isinstance(value, str):
        raise PaperError(file, field, repr(value), f"a text ({option.help.rstrip('.')})")
    if isinstance(option.kind, Registry):
        with field_of(file, field):
            option.kind[value]
    return value


def _list(value: Any, option: Option, file: str, field: str, arm: Arm, task: str) -> Any:
    count = LISTS.get(option.kind, arm.n)
    allowed = f"{count} numbers" + ("" if option.kind in LISTS else f", one a joint of {arm.name}")
    if not isinstance(value, list) or len(value) != count:
        found = f"{len(value)} numbers" if isinstance(value, list) else repr(value)
        raise PaperError(file, field, found, f"a list of {allowed} ({option.help.rstrip('.')})")
    numbers = np.array([number_at(x, file, f"{field}[{i}]") for i, x in enumerate(value)])
    if option.kind is Quantity.POINT:
        return numbers
    key = field.partition(".")[2]
    return si_value(option, tuple(numbers.tolist()), arm, f"--{key}")
