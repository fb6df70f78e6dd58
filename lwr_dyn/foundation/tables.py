"""A table is described once; its forms are aligned text, a record for programs, and (in reports) HTML."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import OptionError


@dataclass(frozen=True, slots=True)
class Heading:
    """The heading of a column, its unit, how its values are written, and its name in records (`head` if not given)."""

    head: str
    unit: str = ""
    format: str | Callable[[Any], str] = ""
    """A format specification for numbers, or a function; text is unchanged."""
    key: str = ""
    shade: Callable[[Any], float] | None = None
    """Darkness of a value's cell, from 0 to 1, where a table has colours."""

    @property
    def title(self) -> str:
        """The heading with its unit in brackets."""
        return f"{self.head} [{self.unit}]" if self.unit else self.head

    def cell(self, value: Any) -> str:
        """A value as text; None is an empty cell."""
        if value is None:
            return ""
        if callable(self.format):
            return self.format(value)
        return value if isinstance(value, str) else format(value, self.format)


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """Rows of values under headings; a heading may be plain text.

    Raises `OptionError` for a row with another number of values than there are headings.

    >>> table = Table("Largest inertia", (Heading("joint"), Heading("B_ii", "kg m^2", ".3f", key="b")), ((1, 2.924),))
    >>> print(table.text())
    Largest inertia
    joint  B_ii [kg m^2]
    -----  -------------
    1      2.924
    >>> table.record()
    [{'joint': 1, 'b': 2.924}]
    """

    title: str
    headings: Sequence[Heading | str]
    rows: Sequence[Sequence[Any]]
    note: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "headings", tuple(h if isinstance(h, Heading) else Heading(h) for h in self.headings))
        object.__setattr__(self, "rows", tuple(tuple(row) for row in self.rows))
        for i, row in enumerate(self.rows):
            if len(row) != len(self.headings):
                where = f"table {self.title!r}, row {i + 1}"
                raise OptionError(where, f"{len(row)} values", f"{len(self.headings)}, one per column")

    @property
    def columns(self) -> tuple[Heading, ...]:
        """The headings."""
        return self.headings  # type: ignore[return-value] # converted in __post_init__

    @property
    def cells(self) -> tuple[tuple[str, ...], ...]:
        """The values as text, row by row."""
        return tuple(tuple(h.cell(v) for h, v in zip(self.columns, row, strict=True)) for row in self.rows)

    @property
    def shades(self) -> tuple[tuple[float | None, ...], ...]:
        """Darkness of each cell, row by row; None for a cell without colour."""
        return tuple(
            tuple(None if h.shade is None else h.shade(v) for h, v in zip(self.columns, row, strict=True))
            for row in self.rows
        )

    def text(self) -> str:
        """Title, aligned columns, note."""
        lines = [self.title, aligned(self.cells, tuple(h.title for h in self.columns)), self.note]
        return "\n".join(line for line in lines if line)

    def __str__(self) -> str:
        return self.text()

    def record(self) -> list[dict[str, Any]]:
        """One dictionary per row, values unchanged."""
        keys = [h.key or h.head for h in self.columns]
        return [dict(zip(keys, row, strict=True)) for row in self.rows]


def aligned(rows: Sequence[tuple[str, ...]], head: tuple[str, ...]) -> str:
    """Rows of text, aligned under a heading.

    >>> print(aligned([("1", "2.9")], ("joint", "b")))
    joint  b
    -----  ---
    1      2.9
    """
    widths = [max(len(r[i]) for r in (head, *rows)) for i in range(len(head))]
    lines = ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in (head, *rows)]
    return "\n".join([lines[0], "  ".join("-" * w for w in widths), *lines[1:]])


def json_text(record: Any) -> str:
    """A record as JSON text: arrays become lists, NaN and infinity null.

    >>> json_text({"x": np.array([1.0, np.inf])})
    '{\\n  "x": [\\n    1.0,\\n    null\\n  ]\\n}'
    """
    return json.dumps(_plain(record), indent=2, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
