"""A value that a file prints twice, once as a cell of a table and once on its own, and not the same."""

from __future__ import annotations

from collections.abc import Iterator

from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.roles import role_of
from lwr_dyn.audit.lint.sheet import Sheet, Table
from lwr_dyn.papers.printed_number import ROUND, PrintedNumber


def repeats(sheet: Sheet) -> Iterator[Finding]:
    """Cells (row label R, column C) against the value R of the table C."""
    alone = {(t.name.rsplit(".", 1)[-1], name): (t, c) for t in sheet.tables for name, c in t.values.items()}
    for table in sheet.tables:
        for column in table.columns:
            for i, label in enumerate(labels_of(table)):
                other = alone.get((column.name, label))
                a = column.numbers[i]
                b = other[1].numbers[0] if other else None
                if other and a and b and not _same(a, b):
                    yield _differs(sheet.file, table.place(i, column.name), f"{other[0].name}, {label}", a, b)


def labels_of(table: Table) -> tuple[str, ...]:
    """What the rows are called: said by the file, or in a column of labels that are no numbers."""
    if len(table.labels) == table.rows:
        return table.labels
    named = (c for c in table.columns if not c.numeric and role_of(c.name, table.declared.roles) == "label")
    found = next(named, None)
    return found.cells if found is not None else ()


def _same(a: PrintedNumber, b: PrintedNumber) -> bool:
    """Both can be the same value, rounded to the digits of each."""
    return abs(a.value - b.value) <= max(a.half, b.half) * (1.0 + ROUND)


def _differs(file: str, place: str, other: str, a: PrintedNumber, b: PrintedNumber) -> Finding:
    return Finding(
        "printed-twice", "error", "certain", file, place, (place, other), f"{a.text}, {b.text}", "one value in both",
        f"{place} prints {a.text}, {other} prints {b.text}: the same value twice, off by {a.value - b.value:+.3g}",
        {"difference": a.value - b.value},
    )  # fmt: skip
