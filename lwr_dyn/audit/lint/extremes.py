"""A mean outside its extremes, a maximum below its minimum, and the order of columns that would make them fit."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.roles import role_of, stem_of
from lwr_dyn.audit.lint.sheet import Column, Sheet, Table
from lwr_dyn.papers.printed_number import PrintedNumber

FIGURES = ("mean", "mean_abs", "max", "min", "rms")
Row = dict[str, PrintedNumber]
LEAST_BLOCK = 5
"""Rows of a block out of order before its ranges are compared with others: few rows fit by accident."""
ALIKE, LEAST_GAIN = 0.9, 0.4
"""Rank correlation that a moved block has to reach, and how far above the unmoved one."""


@dataclass(frozen=True, slots=True)
class Family:
    """Columns of one table that are figures of the same thing: role -> column, in the order printed."""

    table: Table
    stem: str
    columns: dict[str, Column]

    def row(self, i: int, order: Sequence[str] | None = None) -> Row | None:
        """The numbers of a row by role, the cells taken in another order of roles if given."""
        numbers = [c.numbers[i] for c in self.columns.values()]
        roles = order or tuple(self.columns)
        found = {role: n for role, n in zip(roles, numbers, strict=True) if n is not None}
        return found if len(found) == len(roles) else None


def families(table: Table) -> Iterator[Family]:
    """Columns grouped by what they are figures of; groups without a maximum and a minimum are left out."""
    groups: dict[tuple[str, ...], dict[str, Column]] = {}
    for column in table.columns:
        role = role_of(column.name, table.declared.roles)
        if role in FIGURES:
            groups.setdefault(stem_of(column.name), {}).setdefault(role, column)
    for stem, columns in groups.items():
        if len(columns) >= 2 and {"max", "min"} <= set(columns):
            yield Family(table, " ".join(stem), columns)


def ordered(row: Row) -> bool:
    """The maximum is not below the minimum."""
    return row["max"].value + row["max"].half >= row["min"].value - row["min"].half


def signed_mean(row: Row) -> bool:
    """The mean lies between the extremes."""
    mean = row["mean"]
    low, high = row["min"].value - row["min"].half, row["max"].value + row["max"].half
    return low <= mean.value + mean.half and mean.value - mean.half <= high


def absolute_mean(row: Row, role: str = "mean") -> bool:
    """The mean can be one of absolute values: from nought (or the extreme nearer to it) to the larger |extreme|."""
    mean, low, high = row[role], row["min"], row["max"]
    slack = mean.half + max(low.half, high.half)
    largest = max(abs(low.value), abs(high.value))
    smallest = max(0.0, low.value, -high.value)
    return smallest - slack <= mean.value <= largest + slack


def figures_fit(row: Row, kind: str) -> bool:
    """Everything the row prints can be figures of the same numbers, the mean of `kind` "signed" or "absolute"."""
    if not ordered(row):
        return False
    if "mean" in row and not (signed_mean(row) if kind == "signed" else absolute_mean(row)):
        return False
    return all(absolute_mean(row, role) for role in ("mean_abs", "rms") if role in row)


def extremes(sheet: Sheet) -> Iterator[Finding]:
    """Rules 1 and 2: rows whose figures contradict each other, tried with both kinds of mean and all column orders."""
    for table in sheet.tables:
        for family in families(table):
            yield from _family(sheet.file, family)


def _family(file: str, family: Family) -> Iterator[Finding]:
    rows = {i: row for i in range(family.table.rows) if (row := family.row(i)) is not None}
    wrong = {kind: [i for i, row in rows.items() if not figures_fit(row, kind)] for kind in ("signed", "absolute")}
    kind = min(wrong, key=lambda k: len(wrong[k]))
    bad = wrong[kind]
    if kind == "absolute" and wrong["signed"] and "mean" in family.columns:
        yield _note(file, family, [i for i in wrong["signed"] if i not in bad], kind)
    if not bad:
        return
    orders = other_orders(family, bad)
    if orders and len(bad) > 1:
        yield _permuted(file, family, bad, orders)
        yield from _moved_block(file, family, bad, orders[0])
    else:
        for i in bad:
            yield _outside(file, family, i, rows[i], kind)


def other_orders(family: Family, rows: Sequence[int]) -> list[tuple[str, ...]]:
    """The orders of the columns in which all of these rows fit."""
    roles = tuple(family.columns)
    found = []
    for order in itertools.permutations(roles):
        read = [family.row(i, order) for i in rows]
        for kind in ("signed", "absolute"):
            if order != roles and order not in found and all(r is not None and figures_fit(r, kind) for r in read):
                found.append(order)
    return found


def _moved_block(file: str, family: Family, rows: Sequence[int], order: tuple[str, ...]) -> Iterator[Finding]:
    """Rule 6 on a block that is out of order already: moved a row, its ranges follow those of the table's others."""
    ranges = [_range(family, i, order) for i in rows]
    if len(rows) < LEAST_BLOCK or rows[-1] - rows[0] + 1 != len(rows):
        return
    for other in (f for f in families(family.table) if f.stem != family.stem):
        straight = rank_correlation(ranges, [_range(other, i) for i in rows])
        for step, word in ((-1, "up"), (1, "down")):
            if rows[0] + step < 0 or rows[-1] + step >= family.table.rows:
                continue
            moved = rank_correlation(ranges, [_range(other, i + step) for i in rows])
            if moved >= ALIKE > straight + LEAST_GAIN:
                yield Finding(
                    "rows-shifted", "warning", "possible", file, f"{_of(family)}, {rows_text(rows)}",
                    _cells(family, rows), "; ".join(_text(family, i) for i in rows), f"the block moved one row {word}",
                    f"{rows_text(rows)}: moved one row {word}, their ranges rank as those of {_of(other)} do "
                    f"(rank correlation {moved:.2f}, as printed {straight:.2f})",
                    {"moved": moved, "as_printed": straight, "shift": step},
                )  # fmt: skip


def _range(family: Family, i: int, order: tuple[str, ...] | None = None) -> float:
    row = family.row(i, order)
    return row["max"].value - row["min"].value if row else float("nan")


def rank_correlation(a: Sequence[float], b: Sequence[float]) -> float:
    """Spearman's: 1 when both rise and fall together, 0 when they know nothing of each other.

    >>> rank_correlation([1.0, 5.0, 9.0], [0.2, 0.3, 7.0]), rank_correlation([1.0, 2.0, 3.0], [3.0, 2.0, 1.0])
    (1.0, -1.0)
    """
    places = [[sorted(x).index(v) for v in x] for x in (a, b)]
    n = len(a)
    apart = sum((p - q) * (p - q) for p, q in zip(*places, strict=True))
    return float(1.0 - 6.0 * apart / (n * (n * n - 1.0)))


def _cells(family: Family, rows: Sequence[int]) -> tuple[str, ...]:
    return tuple(family.table.place(i, c.name) for i in rows for c in family.columns.values())


def _text(family: Family, i: int) -> str:
    return ", ".join(f"{role} {column.cells[i]}" for role, column in family.columns.items())


def _of(family: Family) -> str:
    return f"{family.table.name}{', ' + family.stem if family.stem else ''}"


def rows_text(rows: Sequence[int]) -> str:
    """Rows counted from 1: "row 3" or "rows 2 to 6" or "rows 1, 4".

    >>> rows_text([1, 2, 3]), rows_text([0, 3])
    ('rows 2 to 4', 'rows 1, 4')
    """
    if len(rows) == 1:
        return f"row {rows[0] + 1}"
    if list(rows) == list(range(rows[0], rows[-1] + 1)):
        return f"rows {rows[0] + 1} to {rows[-1] + 1}"
    return "rows " + ", ".join(str(i + 1) for i in rows)


def _note(file: str, family: Family, rows: Sequence[int], kind: str) -> Finding:
    sentence = f"{rows_text(rows)} fit only as means of absolute values (a signed mean would lie outside [min, max])"
    return Finding(
        "mean-kind", "note", "certain", file, _of(family), _cells(family, rows), _text(family, rows[0]) if rows else "",
        "mean of absolute values", sentence,
    )  # fmt: skip


def _permuted(file: str, family: Family, rows: Sequence[int], orders: list[tuple[str, ...]]) -> Finding:
    head = ", ".join(family.columns)
    said = " or ".join(f"({', '.join(o)})" for o in orders)
    below = [i for i in rows if not ordered(family.row(i) or {})]
    fault = f"maximum below minimum in {rows_text(below)}" if below else "means outside their extremes"
    sentence = f"{rows_text(rows)}: {fault}; headed ({head}), their cells fit in the order {said}"
    return Finding(
        "column-order", "error", "certain", file, f"{_of(family)}, {rows_text(rows)}", _cells(family, rows),
        "; ".join(_text(family, i) for i in rows), f"cells in the order {said}", sentence,
        {"heading": list(family.columns), "orders": [list(o) for o in orders], "rows": [i + 1 for i in rows]},
    )  # fmt: skip


def _outside(file: str, family: Family, i: int, row: Row, kind: str) -> Finding:
    orders = other_orders(family, [i])
    also = f"; it fits in the order {' or '.join('(' + ', '.join(o) + ')' for o in orders)}" if orders else ""
    rule, column = ("mean-outside", "mean") if ordered(row) else ("column-order", "max")
    column = column if column in family.columns else "max"
    return Finding(
        rule, "error", "certain", file, family.table.place(i, family.columns[column].name), _cells(family, [i]),
        _text(family, i), f"another order of the cells: {orders}" if orders else "a wrong cell in this row",
        _fault(row, kind) + also, {role: n.value for role, n in row.items()},
    )  # fmt: skip


def _fault(row: Row, kind: str) -> str:
    """Why a row cannot be."""
    span = f"numbers between {row['min'].text} and {row['max'].text}"
    if not ordered(row):
        return f"maximum {row['max'].text} is below minimum {row['min'].text}"
    if "mean" in row and not absolute_mean(row) and not signed_mean(row):
        return f"mean {row['mean'].text} can be neither the signed mean nor the mean of absolute values of {span}"
    if "mean" in row and not (signed_mean(row) if kind == "signed" else absolute_mean(row)):
        return f"mean {row['mean'].text} cannot be the {kind} mean of {span}, which all other rows print"
    role = next((r for r in ("mean_abs", "rms") if r in row and not absolute_mean(row, r)), "mean")
    return f"{role} {row[role].text} is impossible for {span}"
