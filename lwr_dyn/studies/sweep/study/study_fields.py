"""Fields of a study's file: numbers, counts and tables, each refused with the file and the field."""

import math
from typing import Any

from lwr_dyn.arms.papers.fields import Fields
from lwr_dyn.foundation.errors import PaperError

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
