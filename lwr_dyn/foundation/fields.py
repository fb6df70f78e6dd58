"""A TOML table read field by field: one that is missing, wrong or unknown raises `PaperError` with its file and place.

Fields        a table that knows its file and its place in it
parse_toml    a text as tables
"""

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from lwr_dyn.foundation.errors import PaperError, did_you_mean

LARGEST = 1e30
"""Limit of every number in its printed unit: no quantity of a robot is larger, and products stay finite."""
_TYPE_NAMES = {str: "text", int: "an integer", dict: "a table", list: "a list"}
_REQUIRED: Any = object()


class Fields:
    """Reads the fields of one table; `refuse_unknown` raises for those that were not read.

    A method with `key` reads that field, or returns the default where it is not given; it raises `PaperError`.
    One whose name ends in `_at` checks a value that was read already, at a place such as ``"values[2]"``.

    `table` is what `parse_toml` gives (`PaperError` for anything else), `file` its name for messages, `path` where it
    stands in the file: ``"task"``, ``"point[3]"``; empty for the file itself.

    >>> fields = Fields({"mass": 1.5, "com": [0, 0, 1]}, "arm.toml", "payload")
    >>> fields.number("mass", above=0.0), fields.row("com", 3)
    (1.5, (0.0, 0.0, 1.0))
    >>> fields.number("length")
    Traceback (most recent call last):
    lwr_dyn.foundation.errors.PaperError: arm.toml: payload.length: missing; allowed: a value
    """

    def __init__(self, table: Any, file: str, path: str = "") -> None:
        self.file, self.path = file, path
        if not isinstance(table, Mapping):
            raise self.refuse("", repr(table), "a table")
        self._unread = dict(table)
        self._read: list[str] = []

    def name_of(self, key: str) -> str:
        """The name of a field in messages; that of the table for an empty key."""
        return f"{self.path}.{key}" if self.path and key else self.path + key

    def refuse(self, key: str, found: str, allowed: str) -> PaperError:
        """The error of a field, to be raised; of the table itself for an empty key."""
        return PaperError(self.file, self.name_of(key), found, allowed)

    def refuse_unknown(self) -> None:
        """Raise `PaperError` for a field that was not read."""
        for key in self._unread:
            raise self.refuse(key, f"unknown field{did_you_mean(key, self._read)}", ", ".join(self._read))

    def unread(self) -> tuple[str, ...]:
        """The fields that were not read yet: the free keys of a table."""
        return tuple(self._unread)

    def take(self, key: str, kind: Any, default: Any = _REQUIRED) -> Any:
        """A value of a kind, as `isinstance` takes it; a truth value is no integer."""
        self._read.append(key)
        if key not in self._unread:
            if default is _REQUIRED:
                raise self.refuse(key, "missing", _TYPE_NAMES.get(kind, "a value"))
            return default
        value = self._unread.pop(key)
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            raise self.refuse(key, repr(value), _TYPE_NAMES.get(kind) or kind.__name__)
        return value

    def text(self, key: str, default: Any = _REQUIRED) -> Any:
        """A text."""
        return self.take(key, str, default)

    def choice(self, key: str, allowed: Sequence[str], default: Any = _REQUIRED) -> str:
        """One of the allowed words."""
        value = self.take(key, str, default)
        return str(value) if value is default else self.choice_at(key, value, allowed)

    def choice_at(self, place: str, value: Any, allowed: Sequence[str]) -> str:
        """The value, one of the allowed words; None is a missing one."""
        if value not in allowed:
            raise self.refuse(place, "missing" if value is None else repr(value), f"one of {', '.join(allowed)}")
        return str(value)

    def truth(self, key: str, default: Any = _REQUIRED) -> Any:
        """True or false."""
        value = self.take(key, object, default)
        if value is not default and not isinstance(value, bool):
            raise self.refuse(key, repr(value), "true or false")
        return value

    def number(self, key: str, default: Any = _REQUIRED, **bounds: Any) -> Any:
        """A finite number within the bounds that `number_at` takes."""
        value = self.take(key, object, default)
        return value if value is default else self.number_at(key, value, **bounds)

    def number_at(
        self,
        place: str,
        value: Any,
        allowed: str = "",
        *,
        least: float = -LARGEST,
        most: float = LARGEST,
        above: float = -math.inf,
    ) -> float:
        """The value, a finite number from `least` to `most` and above `above`; `allowed` says so in other words."""
        if not (is_number(value) and least <= value <= most and value > above):
            bounded = f"a number from {least:g} to {most:g}" if least > -LARGEST else "a number"
            raise self.refuse(
                place, repr(value), allowed or (f"a number above {above:g}" if above > -math.inf else bounded)
            )
        return float(value)

    def row(self, key: str, count: int, allowed: str = "", default: Any = _REQUIRED, most: float = LARGEST) -> Any:
        """A list of `count` finite numbers, none larger than `most`, as a tuple."""
        values = self.take(key, list, default)
        return values if values is default else self.row_at(key, values, count, allowed, most)

    def row_at(
        self, place: str, values: Any, count: int, allowed: str = "", most: float = LARGEST
    ) -> tuple[float, ...]:
        """The value, a list of `count` finite numbers, as a tuple; `allowed` says so in other words."""
        listed = values if isinstance(values, list) else []
        if len(listed) != count or not all(is_number(x) and abs(x) <= most for x in listed):
            raise self.refuse(place, repr(values), allowed or f"a list of {count} finite numbers")
        return tuple(float(x) for x in listed)

    def numbers(self, key: str, default: Any = _REQUIRED) -> Any:
        """A list of one or more numbers, each once, as a tuple."""
        values = self._filled_list(key, "one number or more", default)
        numbers = tuple(self.number_at(f"{key}[{i}]", x) for i, x in enumerate(values))
        self._refuse_twice(key, numbers)
        return numbers

    def texts(self, key: str, default: Any = _REQUIRED) -> Any:
        """A list of one or more texts, each once, as a tuple."""
        values = self._filled_list(key, "one text or more", default)
        for i, text in enumerate(values):
            if not isinstance(text, str):
                raise self.refuse(f"{key}[{i}]", repr(text), "a text")
        self._refuse_twice(key, values)
        return tuple(values)

    def table(self, key: str, default: Any = _REQUIRED) -> "Fields":
        """A table inside this one."""
        return Fields(self.take(key, dict, default), self.file, self.name_of(key))

    def tables(self, key: str, default: Any = _REQUIRED) -> "tuple[Fields, ...]":
        """A list of tables inside this one: `[[key]]`."""
        rows = enumerate(self.take(key, list, default))
        return tuple(Fields(row, self.file, f"{self.name_of(key)}[{i}]") for i, row in rows)

    def _filled_list(self, key: str, allowed: str, default: Any) -> Sequence[Any]:
        values: Sequence[Any] = self.take(key, list, default)
        if not values and default is _REQUIRED:
            raise self.refuse(key, "an empty list", allowed)
        return values

    def _refuse_twice(self, key: str, values: Sequence[Any]) -> None:
        for i, value in enumerate(values):
            if value in values[:i]:
                raise self.refuse(f"{key}[{i}]", f"{value!r} twice", "each once")


def is_number(x: object) -> bool:
    """Whether a value is a finite number, and no truth value."""
    return isinstance(x, int | float) and not isinstance(x, bool) and abs(x) < math.inf


def parse_toml(text: str, file: str, parse_float: Callable[[str], Any] = float) -> dict[str, Any]:
    """A TOML text as tables; raises `PaperError` for broken TOML and for integers beyond TOML's 64 bits."""
    try:
        tables = tomllib.loads(text, parse_float=parse_float)
        _check_integers(tables)
    except (ValueError, RecursionError) as fault:
        reason = str(fault) if isinstance(fault, tomllib.TOMLDecodeError | RecursionError) else "an integer too long"
        raise PaperError(file, "TOML", reason, "valid TOML 1.0, with integers of 64 bits") from None
    return tables


def _check_integers(value: Any) -> None:
    """Raise `ValueError` for an integer of more than 64 bits: Python reads it, floats and messages cannot hold it."""
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ValueError
    for part in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        _check_integers(part)
