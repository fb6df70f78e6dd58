"""Reads the columns of a data file: one row per joint, finite numbers, units of the right quantity, a source."""

import math
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import KINDS, PER_JOINT, TABLES, UNITS, UNKNOWN, Column, ColumnRule, units_of
from lwr_dyn.foundation.fields import LARGEST, Fields


def read_columns(
    tables: dict[str, Any], n: int, touched: dict[str, dict[int, list[str]]], file: str
) -> dict[str, Column]:
    """All columns by path ("inertial.mass"); `touched` holds the errata per column and row. Raises `PaperError`."""
    columns = {}
    for table_name, table in tables.items():
        fields = Fields(table, file, table_name)
        for column_name, rule in TABLES[table_name].items():
            if column_name in table:
                column = fields.table(column_name)
                columns[column.path] = _column(column, rule, n, touched.get(column.path, {}))
            elif rule.required:
                raise fields.refuse(column_name, "missing", "a column")
        fields.refuse_unknown()
    return columns


def _column(fields: Fields, rule: ColumnRule, n: int, touched: dict[int, list[str]]) -> Column:
    values = fields.take("values", object)
    unit = fields.take("unit", object)
    where, kind = fields.text("where"), fields.choice("kind", KINDS)
    note = fields.text("note", default="")
    symbols = tuple(str(x) for x in fields.take("symbols", list, default=[]))
    sigma = fields.take("sigma", object, default=None)
    fields.refuse_unknown()
    count = n if rule.per_joint else 1
    rows = values if rule.per_joint else [values]
    if not isinstance(rows, list) or len(rows) != count:
        actual = f"{len(rows)} rows" if isinstance(rows, list) else repr(rows)
        raise fields.refuse("values", actual, f"{count} rows, one per joint")
    if symbols and len(symbols) != count:
        raise fields.refuse("symbols", f"{len(symbols)} entries", f"{count}, one per joint, or none")
    units = list(unit) if isinstance(unit, list) else [unit] * count
    if len(units) != count:
        raise fields.refuse("unit", f"{len(units)} units", f"one unit, or {count}, one per joint")
    for u in units:
        if not isinstance(u, str) or u not in UNITS or UNITS[u][0] not in rule.quantities:
            raise fields.refuse("unit", repr(u), ", ".join(units_of(*rule.quantities)))
    shape = tuple(n if size == PER_JOINT else size for size in rule.row)
    places = [f"values[{i}]" for i in range(count)] if rule.per_joint else ["values"]
    cells = tuple(_row(fields, *row, shape, rule.may_be_unknown) for row in zip(places, rows, strict=True))
    errata = {row: tuple(ids) for row, ids in touched.items() if row < count}
    given = sigma if rule.per_joint else [sigma]
    errors = () if sigma is None else _row(fields, "sigma", given, (count, *shape), may_be_unknown=True)
    if (np.array(errors) < 0.0).any():
        raise fields.refuse("sigma", "a number below 0", "standard errors, in the unit of the values")
    return Column(fields.path, cells, tuple(units), where, kind, note, symbols, errata, errors)


def _row(fields: Fields, place: str, row: Any, shape: tuple[int, ...], may_be_unknown: bool) -> Any:
    """A row as nested tuples of a shape; NaN where the word "unknown" stands for a number, a row or all rows."""
    if may_be_unknown and row == UNKNOWN:
        return tuple(_row(fields, place, row, shape[1:], True) for _ in range(shape[0])) if shape else math.nan
    if not shape:
        return _number(fields, place, row)
    if not isinstance(row, list) or len(row) != shape[0]:
        raise fields.refuse(
            place, f"{len(row)} entries" if isinstance(row, list) else repr(row), f"a list of {shape[0]}"
        )
    return tuple(_row(fields, f"{place}[{i}]", cell, shape[1:], may_be_unknown) for i, cell in enumerate(row))


def _number(fields: Fields, place: str, cell: Any) -> float:
    if isinstance(cell, bool) or not isinstance(cell, int | float):
        raise fields.refuse(place, repr(cell), "a number")
    if not math.isfinite(cell):
        raise fields.refuse(place, repr(cell), "a finite number")
    return fields.number_at(place, cell, f"a number below {LARGEST:g}")
