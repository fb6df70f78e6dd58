"""A TOML table that is emptied field by field: what is missing, of another type or left over is an error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lwr_dyn.errors import PaperError

_WORDS = {str: "text", int: "an integer", dict: "a table", list: "a list"}
_REQUIRED = object()


class Fields:
    """Takes the fields of one table; `done` complains about those nobody took."""

    def __init__(self, table: Any, file: str, path: str) -> None:
        if not isinstance(table, dict):
            raise PaperError(file, path, repr(table), "a table")
        self._left = dict(table)
        self._taken: list[str] = []
        self._file, self._path = file, path

    def _name(self, key: str) -> str:
        return f"{self._path}.{key}" if self._path else key

    def take(self, key: str, kind: type, default: Any = _REQUIRED) -> Any:
        """The value of `key`; raises `PaperError` when it is missing or not of `kind`."""
        self._taken.append(key)
        if key not in self._left:
            if default is _REQUIRED:
                raise PaperError(self._file, self._name(key), "missing", _WORDS.get(kind, "a value"))
            return default
        value = self._left.pop(key)
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            raise PaperError(self._file, self._name(key), repr(value), _WORDS.get(kind, kind.__name__))
        return value

    def refuse_unknown(self) -> None:
        """Raise `PaperError` for a field nobody asked for."""
        for key in self._left:
            raise PaperError(self._file, self._name(key), "unknown field", ", ".join(self._taken))


def choice(value: Any, allowed: Sequence[str], file: str, field: str) -> str:
    """`value` when it is one of the allowed words; raises `PaperError` otherwise."""
    if value not in allowed:
        found = "missing" if value is None else repr(value)
        raise PaperError(file, field, found, f"one of {', '.join(allowed)}")
    return str(value)
