"""The `[[parameter]]` tables of a study's file: a path, a distribution with a range, where it comes from."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.fields import Fields
from lwr_dyn.arms.papers.schema import KINDS
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.studies.sweep.study.distributions import DISTRIBUTIONS, VariedParameter
from lwr_dyn.studies.sweep.study.parameter_paths import ALL, ParameterPath, PathRow, parameter_path
from lwr_dyn.studies.sweep.study.study_fields import number_at, take_numbers, take_texts
from lwr_dyn.studies.sweep.study.study_setup import field_of

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
        text, name, path.columns(n), row.unit, row.words, kind=fields.take_one_of("kind", KINDS, "assumed"),
        note=fields.take("note", str, ""), nominal=row.nominal, **facts,
    )  # fmt: skip
    fields.refuse_unknown()
    return parameter


def _distribution(fields: Fields, table: dict[str, Any], row: PathRow, file: str, field: str) -> str:
    """The distribution: its name, or what its fields belong to."""
    guess = next((name for name in ("levels", "normal", "uniform", "choice", "fixed") if _has(table, name)), None)
    name = fields.take_one_of("distribution", DISTRIBUTIONS, guess)
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
