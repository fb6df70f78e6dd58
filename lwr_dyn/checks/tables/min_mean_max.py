"""A mean outside its extremes, a maximum below its minimum, and the order of the columns in which they would fit."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn, SheetTable, role_of, stem_of
from lwr_dyn.model.printed_number import PrintedNumber

STATISTICS = ("mean", "mean_abs", "max", "min", "rms")
MEANS = ("signed", "absolute")
"""The column "mean" is of the values, or of their absolute values."""
Row = dict[str, PrintedNumber]
"""Statistic -> number."""
LEAST_BLOCK = 5
"""Rows of a block out of order before its ranges are compared with others: few rows fit by accident."""
ALIKE, LEAST_GAIN = 0.9, 0.4
"""Rank correlation that a moved block has to reach, and how far above the unmoved one."""


@dataclass(frozen=True, slots=True)
class StatisticColumns:
    """Columns of one table that are statistics of the same thing: statistic -> column, in the order printed."""

    table: SheetTable
    stem: str
    columns: dict[str, SheetColumn]

    @property
    def name(self) -> str:
        """The table, and of what the statistics are."""
        return f"{self.table.name}{', ' + self.stem if self.stem else ''}"

    def row(self, i: int, order: Sequence[str] | None = None) -> Row | None:
        """The numbers of a row by statistic, its cells taken in another order if given; None where one is missing."""
        numbers = [c.numbers[i] for c in self.columns.values()]
        row = {role: n for role, n in zip(order or tuple(self.columns), numbers, strict=True) if n is not None}
        return row if len(row) == len(numbers) else None

    def range(self, i: int, order: Sequence[str] | None = None) -> float:
        """Maximum minus minimum of a row, NaN where a number is missing."""
        row = self.row(i, order)
        return row["max"].value - row["min"].value if row else float("nan")

    def places(self, rows: Sequence[int]) -> tuple[str, ...]:
        """The cells of some rows."""
        return tuple(self.table.place(i, c.name) for i in rows for c in self.columns.values())

    def text(self, rows: Sequence[int]) -> str:
        """Some rows as printed."""
        texts = [", ".join(f"{role} {c.cells[i]}" for role, c in self.columns.items()) for i in rows]
        return "; ".join(texts)


def statistic_columns(table: SheetTable) -> Iterator[StatisticColumns]:
    """Columns grouped by what they are statistics of; groups without a maximum and a minimum are left out."""
    groups: dict[tuple[str, ...], dict[str, SheetColumn]] = {}
    for column in table.columns:
        role = role_of(column.name, table.declared.roles)
        if role in STATISTICS:
            groups.setdefault(stem_of(column.name), {}).setdefault(role, column)
    for stem, columns in groups.items():
        if {"max", "min"} <= set(columns):
            yield StatisticColumns(table, " ".join(stem), columns)


def ordered(row: Row) -> bool:
    """The maximum is not below the minimum."""
    return row["max"].value + row["max"].half >= row["min"].value - row["min"].half


def signed_mean(row: Row) -> bool:
    """The mean lies between the extremes."""
    mean = row["mean"]
    low, high = row["min"].value - row["min"].half, row["max"].value + row["max"].half
    return low <= mean.value + mean.half and mean.value - mean.half <= high


def absolute_mean(row: Row, role: str = "mean") -> bool:
    """The mean can be one of absolute values: from 0 (or the extreme nearer to it) to the larger |extreme|."""
    mean, low, high = row[role], row["min"], row["max"]
    slack = mean.half + max(low.half, high.half)
    largest = max(abs(low.value), abs(high.value))
    smallest = max(0.0, low.value, -high.value)
    return smallest - slack <= mean.value <= largest + slack


def is_possible(row: Row, kind: str) -> bool:
    """All numbers of the row can be statistics of the same values, the mean of one of the kinds `MEANS`."""
    return ordered(row) and _mean_fits(row, kind) and all(absolute_mean(row, r) for r in _absolute(row))


def _mean_fits(row: Row, kind: str) -> bool:
    return "mean" not in row or (signed_mean(row) if kind == "signed" else absolute_mean(row))


def _absolute(row: Row) -> list[str]:
    return [role for role in ("mean_abs", "rms") if role in row]


def min_mean_max(sheet: Sheet) -> Iterator[Finding]:
    """Rules 1 and 2: rows whose statistics contradict each other, under both kinds of mean and all column orders."""
    for table in sheet.tables:
        for group in statistic_columns(table):
            yield from _examined(group)


def _examined(group: StatisticColumns) -> Iterator[Finding]:
    rows = {i: row for i in range(group.table.rows) if (row := group.row(i)) is not None}
    wrong = {kind: [i for i, row in rows.items() if not is_possible(row, kind)] for kind in MEANS}
    kind = min(wrong, key=lambda k: len(wrong[k]))
    bad = wrong[kind]
    if kind == "absolute" and wrong["signed"] and "mean" in group.columns:
        yield _note(group, [i for i in wrong["signed"] if i not in bad])
    if not bad:
        return
    orders = other_orders(group, bad)
    if orders and len(bad) > 1:
        yield _permuted(group, bad, orders)
        yield from _moved_block(group, bad, orders[0])
    else:
        for i in bad:
            yield _outside(group, i, rows[i], kind)


def other_orders(group: StatisticColumns, rows: Sequence[int]) -> list[tuple[str, ...]]:
    """The other orders of the columns in which all of these rows are possible."""
    orders = []
    for order in itertools.islice(itertools.permutations(group.columns), 1, None):  # the first is as printed
        read = [group.row(i, order) for i in rows]
        if any(all(r is not None and is_possible(r, kind) for r in read) for kind in MEANS):
            orders.append(order)
    return orders


def _moved_block(group: StatisticColumns, rows: Sequence[int], order: tuple[str, ...]) -> Iterator[Finding]:
    """Rule 6 on a block that is out of order already: moved a row, its ranges follow those of another group."""
    ranges = [group.range(i, order) for i in rows]
    if len(rows) < LEAST_BLOCK or rows[-1] - rows[0] + 1 != len(rows):
        return
    for other in (g for g in statistic_columns(group.table) if g.stem != group.stem):
        straight = rank_correlation(ranges, [other.range(i) for i in rows])
        for step, word in ((-1, "up"), (1, "down")):
            if rows[0] + step < 0 or rows[-1] + step >= group.table.rows:
                continue
            moved = rank_correlation(ranges, [other.range(i + step) for i in rows])
            if moved >= ALIKE > straight + LEAST_GAIN:
                yield Finding(
                    "rows-shifted", "warning", "possible", group.places(rows), group.text(rows),
                    f"the block moved one row {word}",
                    f"{rows_text(rows)}: moved one row {word}, their ranges rank as those of {other.name} do "
                    f"(rank correlation {moved:.2f}, as printed {straight:.2f})",
                    {"moved": moved, "as_printed": straight, "shift": step}, f"{group.name}, {rows_text(rows)}",
                )  # fmt: skip


def rank_correlation(a: Sequence[float], b: Sequence[float]) -> float:
    """Spearman's rank correlation (SciPy's takes seconds to import).

    >>> rank_correlation([1.0, 5.0, 9.0], [0.2, 0.3, 7.0]), rank_correlation([1.0, 2.0, 3.0], [3.0, 2.0, 1.0])
    (1.0, -1.0)
    """
    ranks = [np.argsort(np.argsort(x)) for x in (a, b)]
    n = len(a)
    return float(1.0 - 6.0 * ((ranks[0] - ranks[1]) ** 2).sum() / (n * (n * n - 1.0)))


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


def _note(group: StatisticColumns, rows: Sequence[int]) -> Finding:
    sentence = f"{rows_text(rows)} fit only as means of absolute values (a signed mean would lie outside [min, max])"
    return Finding(
        "mean-kind", "note", "certain", group.places(rows), group.text(rows[:1]), "mean of absolute values", sentence,
        where=group.name,
    )  # fmt: skip


def _permuted(group: StatisticColumns, rows: Sequence[int], orders: list[tuple[str, ...]]) -> Finding:
    head = ", ".join(group.columns)
    listed = _listed(orders)
    below = [i for i in rows if not ordered(group.row(i) or {})]
    fault = f"maximum below minimum in {rows_text(below)}" if below else "means outside their extremes"
    sentence = f"{rows_text(rows)}: {fault}; headed ({head}), their cells fit in the order {listed}"
    return Finding(
        "column-order", "error", "certain", group.places(rows), group.text(rows), f"cells in the order {listed}",
        sentence, {"heading": list(group.columns), "orders": [list(o) for o in orders], "rows": [i + 1 for i in rows]},
        f"{group.name}, {rows_text(rows)}",
    )  # fmt: skip


def _listed(orders: list[tuple[str, ...]]) -> str:
    return " or ".join(f"({', '.join(o)})" for o in orders)


def _outside(group: StatisticColumns, i: int, row: Row, kind: str) -> Finding:
    orders = other_orders(group, [i])
    also = f"; it fits in the order {_listed(orders)}" if orders else ""
    rule, column = ("mean-outside", "mean") if ordered(row) else ("column-order", "max")
    column = column if column in group.columns else "max"
    return Finding(
        rule, "error", "certain", group.places([i]), group.text([i]),
        f"another order of the cells: {orders}" if orders else "a wrong cell in this row",
        _fault(row, kind) + also, {role: n.value for role, n in row.items()},
        group.table.place(i, group.columns[column].name),
    )  # fmt: skip


def _fault(row: Row, kind: str) -> str:
    """Why a row is impossible."""
    span = f"numbers between {row['min'].text} and {row['max'].text}"
    if not ordered(row):
        return f"maximum {row['max'].text} is below minimum {row['min'].text}"
    if not _mean_fits(row, "signed") and not _mean_fits(row, "absolute"):
        return f"mean {row['mean'].text} can be neither the signed mean nor the mean of absolute values of {span}"
    if not _mean_fits(row, kind):
        return f"mean {row['mean'].text} cannot be the {kind} mean of {span}, which all other rows print"
    role = next(r for r in _absolute(row) if not absolute_mean(row, r))
    return f"{role} {row[role].text} is impossible for {span}"
