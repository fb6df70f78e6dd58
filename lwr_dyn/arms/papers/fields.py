"""A TOML table read field by field: a field that is missing, of another type or unknown raises `PaperError`."""

import tomllib
from collections.abc import Callable, Sequence
from typing import Any

from lwr_dyn.foundation.errors import PaperError, did_you_mean

_TYPE_NAMES = {str: "text", int: "an integer", dict: "a table", list: "a list"}
_REQUIRED = object()


class Fields:
    """Reads the fields of one table; `refuse_unknown` raises for those that were not read."""

    def __init__(self, table: Any, file: str, path: str) -> None:
        if not isinstance(table, dict):
            raise PaperError(file, path, repr(table), "a table")
        self._unread = dict(table)
        self._read: list[str] = []
        self._file, self._path = file, path

    def name_of(self, key: str) -> str:
        """The name of a field in messages."""
        return f"{self._path}.{key}" if self._path else key

    def take(self, key: str, kind: type, default: Any = _REQUIRED) -> Any:
        """The value of `key`; raises `PaperError` when it is missing or not of `kind`."""
        self._read.append(key)
        if key not in self._unread:
            if default is _REQUIRED:
                raise PaperError(self._file, self.name_of(key), "missing", _TYPE_NAMES.get(kind, "a value"))
            return default
        value = self._unread.pop(key)
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            raise PaperError(self._file, self.name_of(key), repr(value), _TYPE_NAMES.get(kind, kind.__name__))
        return value

    def take_one_of(self, key: str, allowed: Sequence[str], default: Any = _REQUIRED) -> str:
        """The text of `key`, one of the allowed words (or the default); raises `PaperError`."""
        value = self.take(key, str, default)
        return str(value) if value is default else choice(value, allowed, self._file, self.name_of(key))

    def refuse_unknown(self) -> None:
        """Raise `PaperError` for a field that was not read."""
        for key in self._unread:
            found = f"unknown field{did_you_mean(key, self._read)}"
            raise PaperError(self._file, self.name_of(key), found, ", ".join(self._read))


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


def choice(value: Any, allowed: Sequence[str], file: str, field: str) -> str:
    """`value` when it is one of the allowed words; raises `PaperError` otherwise."""
    if value not in allowed:
        actual = "missing" if value is None else repr(value)
        raise PaperError(file, field, actual, f"one of {', '.join(allowed)}")
    return str(value)
