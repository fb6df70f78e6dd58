"""Reads the columns of a data file: one row per joint, finite numbers, units of the right quantity, a source."""

import math
from functools import partial
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.fields import Fields
from lwr_dyn.arms.papers.schema import KINDS, PER_JOINT, TABLES, UNKNOWN, Column, ColumnRule
from lwr_dyn.arms.papers.units import UNITS, units_of
from lwr_dyn.foundation.errors import PaperError

LARGEST = 1e30
"""Limit of every number in its printed unit: no quantity of a robot is larger, and products stay finite."""


def read_columns(
    tables: dict[str, Any], n: int, touched: dict[str, dict[int, list[str]]], file: str
) -> dict[str, Column]:
    """All columns by path ("inertial.mass"); `touched` holds the errata per column and row. Raises `PaperError`."""
    columns = {}
    for table_name, table in tables.items():
        fields = Fields(table, file, table_name)
        for column_name, rule in TABLES[table_name].items():
            if column_name in table:
                name = f"{table_name}.{column_name}"
                column = _column(fields.take(column_name, dict), rule, n, touched.get(name, {}), file, name)
                columns[name] = column
            elif rule.required:
                raise PaperError(file, f"{table_name}.{column_name}", "missing", "a column")
        fields.refuse_unknown()
    return columns


def _column(
    table: dict[str, Any], rule: ColumnRule, n: int, touched: dict[int, list[str]], file: str, name: str
) -> Column:
    fields = Fields(table, file, name)
    values = fields.take("values", object)
    unit = fields.take("unit", object)
    where, kind = fields.take("where", str), fields.take_one_of("kind", KINDS)
    note = fields.take("note", str, default="")
    symbols = tuple(str(x) for x in fields.take("symbols", list, default=[]))
    sigma = fields.take("sigma", object, default=None)
    fields.refuse_unknown()
    count = n if rule.per_joint else 1
    rows = values if rule.per_joint else [values]
    if not isinstance(rows, list) or len(rows) != count:
        actual = f"{len(rows)} rows" if isinstance(rows, list) else repr(rows)
        raise PaperError(file, f"{name}.values", actual, f"{count} rows, one per joint")
    if symbols and len(symbols) != count:
        raise PaperError(file, f"{name}.symbols", f"{len(symbols)} entries", f"{count}, one per joint, or none")
    units = list(unit) if isinstance(unit, list) else [unit] * count
    if len(units) != count:
        raise PaperError(file, f"{name}.unit", f"{len(units)} units", f"one unit, or {count}, one per joint")
    for u in units:
        if not isinstance(u, str) or u not in UNITS or UNITS[u][0] not in rule.quantities:
            raise PaperError(file, f"{name}.unit", repr(u), ", ".join(units_of(*rule.quantities)))
    label = f"{name}.values"
    shape = tuple(n if size == PER_JOINT else size for size in rule.row)
    read = partial(_row_or_unknown if rule.may_be_unknown else _row, shape=shape, file=file)
    cells = tuple(read(r, field=f"{label}[{i}]" if rule.per_joint else label) for i, r in enumerate(rows))
    errata = {row: tuple(ids) for row, ids in touched.items() if row < count}
    given = sigma if rule.per_joint else [sigma]
    errors = () if sigma is None else _sigma(given, (count, *shape), file, f"{name}.sigma")
    return Column(name, cells, tuple(units), where, kind, note, symbols, errata, errors)


def _sigma(rows: Any, shape: tuple[int, ...], file: str, field: str) -> tuple[Any, ...]:
    table: tuple[Any, ...] = _row_or_unknown(rows, shape, file, field)
    if (np.array(table) < 0.0).any():
        raise PaperError(file, field, "a number below 0", "standard errors, in the unit of the values")
    return table


def _row_or_unknown(row: Any, shape: tuple[int, ...], file: str, field: str) -> Any:
    """`_row` where the word "unknown" stands for a number, a row or all rows: NaN each."""
    if row == UNKNOWN:
        return tuple(_row_or_unknown(row, shape[1:], file, field) for _ in range(shape[0])) if shape else math.nan
    if shape and isinstance(row, list) and len(row) == shape[0]:
        return tuple(_row_or_unknown(cell, shape[1:], file, f"{field}[{i}]") for i, cell in enumerate(row))
    return _row(row, shape, file, field)


def _row(row: Any, shape: tuple[int, ...], file: str, field: str) -> Any:
    """One row as nested tuples, after a check of its shape and its numbers."""
    if not shape:
        if isinstance(row, bool) or not isinstance(row, int | float):
            raise PaperError(file, field, repr(row), "a number")
        try:
            number = float(row)
        except OverflowError:
            raise PaperError(file, field, "a number of too many digits", f"a number below {LARGEST:g}") from None
        if not math.isfinite(number):
            raise PaperError(file, field, repr(row), "a finite number")
        if abs(number) > LARGEST:
            raise PaperError(file, field, repr(row), f"a number below {LARGEST:g}")
        return number
    if not isinstance(row, list) or len(row) != shape[0]:
        actual = f"{len(row)} entries" if isinstance(row, list) else repr(row)
        raise PaperError(file, field, actual, f"a list of {shape[0]}")
    return tuple(_row(cell, shape[1:], file, f"{field}[{i}]") for i, cell in enumerate(row))
