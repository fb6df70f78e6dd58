"""Columns of a data file as TOML: one line each, numbers by repr, which is read back bit-exact."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import UNKNOWN


@dataclass(frozen=True, slots=True)
class ColumnText:
    """A column to be written: None in `values` is unknown."""

    name: str
    values: Any
    unit: str | Sequence[str]
    where: str
    kind: str = "computed"
    more: str = ""
    """Further fields as TOML, each with a comma before it."""

    def line(self) -> str:
        """The column as an inline table."""
        fields = f"values = {literal(self.values)}, unit = {literal(_short(self.unit))}{self.more}"
        return f"{self.name} = {{ {fields}, where = {quoted(self.where)}, kind = {quoted(self.kind)} }}"


def table_text(name: str, columns: Sequence[ColumnText], *lines: str) -> list[str]:
    """A table of columns, after lines of its own; nothing where there are no columns and no lines."""
    return [f"[{name}]", *lines, *(column.line() for column in columns), ""] if columns or lines else []


def literal(value: Any) -> str:
    """A number, a text, None (unknown) or a nested list as TOML.

    >>> literal([1, 0.5, None, np.float64(-0.0)])
    '[1, 0.5, "unknown", 0.0]'
    """
    if isinstance(value, np.ndarray | np.generic):
        return literal(value.tolist())
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(literal, value))}]"
    if value is None:
        return quoted(UNKNOWN)
    if isinstance(value, str):
        return quoted(value)
    return repr(value + 0.0) if isinstance(value, float) else repr(value)  # no negative zero


def quoted(text: str) -> str:
    r"""A basic string of TOML.

    >>> print(quoted('a "b" \x7f'))
    "a \"b\" \u007f"
    """
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _short(unit: str | Sequence[str]) -> str | list[str]:
    """One unit where all are the same."""
    units = [unit] if isinstance(unit, str) else list(unit)
    return units[0] if len(set(units)) == 1 else units
