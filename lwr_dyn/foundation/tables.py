"""A table is described once; its forms are aligned text, a record for programs, and (in `pages`) HTML.

NumPy is not imported: what has `tolist` is an array or a number of it.
"""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from lwr_dyn.foundation.errors import OptionError


@dataclass(frozen=True, slots=True)
class Heading:
    """The heading of a column, its unit, how its values are written, and its name in records (`head` if not given).

    Raises `OptionError` for a unit without a heading.
    """

    head: str = ""
    unit: str = ""
    format: str | Callable[[Any], str] = ""
    """A format specification for numbers, or a function; text is unchanged."""
    key: str | None = ""
    """Name in records; None: only shown. A column with a name and without a heading is only recorded."""
    says: str = ""
    """What it is, in a sentence: the schema's description, and what a page shows when the heading is pointed at."""
    kind: Any = None
    """Type of its values in the schema, such as `list[float]`, where the first row does not show it."""
    sigma: str = ""
    """Key of the column with its standard errors: shown as `value +- error`."""
    without: str = ""
    """What stands in place of `+- error` where the error is None."""
    page: bool = False
    """Shown on pages, not in text."""
    shade: Callable[[Any], float] | None = None
    """Darkness of a value's cell, from 0 to 1, where a table has colours."""
    cut: int = 0
    """Letters of a cell that text shows, and a page until it is opened; 0: all."""
    bar: float = 0.0
    """On a page a value is also drawn as a bar from the middle, full at this value."""
    pick: bool = False
    """On a page, rows can be chosen by it."""

    def __post_init__(self) -> None:
        if self.unit and not self.head:
            raise OptionError("heading", f"unit [{self.unit}] alone", "a heading with its unit")

    @property
    def is_shown(self) -> bool:
        """Whether people see the column."""
        return bool(self.head) or not self.key

    @property
    def title(self) -> str:
        """The heading with its unit in brackets."""
        return f"{self.head} [{self.unit}]" if self.unit else self.head

    def cell(self, value: Any) -> str:
        """A value as text; None, and NaN without a format of its own, is an empty cell."""
        if value is None or (isinstance(value, float) and value != value and not callable(self.format)):
            return ""
        if callable(self.format):
            return self.format(value)
        written = value if isinstance(value, str) else format(value, self.format)
        return written + MARKS.get(getattr(value, "mark", ""), "")


class Marked(float):
    """A number that is marked: the "best" of several (` *` in text, bold on pages), or "bad" (` !`, in --alarm)."""

    mark: str

    def __new__(cls, value: float, mark: str = "") -> "Marked":
        """The number."""
        out = super().__new__(cls, value)
        out.mark = mark
        return out


MARKS = {"best": " *", "bad": " !"}


class CellText(str):
    """The text of a cell, cut after so many letters, with the value that it shows."""

    value: Any

    def __new__(cls, text: str, value: Any, cut: int = 0) -> "CellText":
        """The cell."""
        out = super().__new__(cls, f"{text[: cut - 3]}..." if cut and len(text) > cut else text)
        out.value = value
        return out


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
    key: str | None = None
    """Name of its rows in a document's record."""
    says: str = ""
    """What they are, in a sentence."""
    page: bool = False
    """Shown on pages, not in text."""
    most: int | None = None
    """Rows that text shows."""
    when: bool = True
    """Whether people see it; it is recorded all the same."""
    columnwise: bool = False
    """In a document's record its columns are lists, beside the other keys, in place of a list of rows."""

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
    def is_shown(self) -> bool:
        """Whether it has anything for people."""
        return self.when and len(self.rows) > 0 and any(h.is_shown for h in self.columns)

    @property
    def cells(self) -> tuple[tuple[str, ...], ...]:
        """The values as text, row by row."""
        return tuple(tuple(self._cell(h, v, row) for h, v in zip(self.columns, row, strict=True)) for row in self.rows)

    def _cell(self, heading: Heading, value: Any, row: Sequence[Any]) -> str:
        if not heading.sigma:
            return heading.cell(value)
        error = row[[h.key for h in self.columns].index(heading.sigma)]
        return f"{value:.5g} {heading.without}".rstrip() if error is None else with_error(value, error)

    def shown(self, page: bool = False) -> "Table":
        """What people see of it, as `CellText`s: columns for people; in text, not those for pages, and few rows."""
        kept = [i for i, h in enumerate(self.columns) if h.is_shown and (page or not h.page)]
        heads = [replace(self.columns[i], format="", sigma="") for i in kept]
        cut = [0 if page else h.cut for h in heads]
        rows = [
            [CellText(cells[i], row[i], letters) for i, letters in zip(kept, cut, strict=True)]
            for cells, row in zip(self.cells, self.rows, strict=True)
        ]
        return replace(self, headings=heads, rows=rows[: None if page else self.most])

    @property
    def shades(self) -> tuple[tuple[float | None, ...], ...]:
        """Darkness of each cell, row by row; None for a cell without colour."""
        return tuple(
            tuple(None if h.shade is None else h.shade(v) for h, v in zip(self.columns, row, strict=True))
            for row in self.rows
        )

    def text(self) -> str:
        """Title, aligned columns, note."""
        shown = self.shown()
        left = len(self.rows) - len(shown.rows)
        lines = [self.title, aligned(shown.rows, tuple(h.title for h in shown.columns)), self.note]
        lines += [f"and {left} more"] if left else []
        return "\n".join(line for line in lines if line)

    def __str__(self) -> str:
        return self.text()

    def record(self) -> list[dict[str, Any]]:
        """One dictionary per row, values unchanged."""
        keys = [None if h.key is None else h.key or h.head for h in self.columns]
        return [{k: v for k, v in zip(keys, row, strict=True) if k is not None} for row in self.rows]

    def column_record(self) -> dict[str, list[Any] | None]:
        """One list per column; None for a column of which nothing is known."""
        keys = [None if h.key is None else h.key or h.head for h in self.columns]
        lists = {k: [row[i] for row in self.rows] for i, k in enumerate(keys) if k is not None}
        return {k: None if all(value is None for value in values) else values for k, values in lists.items()}


def with_error(value: float | None, error: float) -> str:
    """`value +- standard error`; "-" where the error is infinite: nothing is known.

    >>> with_error(2.0, 0.123), with_error(2.0, math.inf), with_error(2.0, math.nan)
    ('2 +- 0.12', '-', '2')
    """
    if value is None or math.isinf(error):
        return "-"
    return f"{value:.5g}" + ("" if math.isnan(error) else f" +- {error:.2g}")


def aligned(rows: Sequence[Sequence[str]], head: tuple[str, ...]) -> str:
    """Rows of text, aligned under a heading.

    >>> print(aligned([("1", "2.9")], ("joint", "b")))
    joint  b
    -----  ---
    1      2.9
    """
    widths = [max(len(r[i]) for r in (head, *rows)) for i in range(len(head))]
    lines = ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in (head, *rows)]
    return "\n".join([lines[0], "  ".join("-" * w for w in widths), *lines[1:]])


def log_line(text: str) -> str:
    """A line of a log that a foreign name can neither end nor turn into a command of a terminal or of GitHub.

    >>> log_line("arm.urdf: link x\\n::error::y"), log_line("::set-env::x")
    ('arm.urdf: link x\\\\n::error::y', '\\\\::set-env::x')
    """
    text = "".join(x if x.isprintable() else x.encode("unicode_escape").decode() for x in text)
    return ("\\" if text.lstrip().startswith("::") else "") + text.replace("##[", "#\\#[")


def json_text(record: Any) -> str:
    """A record as JSON text: arrays become lists, NaN and infinity null.

    >>> json_text({"x": (1.0, math.inf)})
    '{\\n  "x": [\\n    1.0,\\n    null\\n  ]\\n}'
    """
    return json.dumps(_plain(record), indent=2, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
