"""Any TOML file of numbers as a sheet: data files of robots, printed results, a user's own tables.

A list of numbers is a column, lists of one length in one table are its rows; lists of lists are vectors or square
matrices; a table with `values` is a column with its `unit`. Declarations stand under `lint` in the table:
`formula`, `ratio` and `symmetric` are lists of texts, `total`, `role` and `unit` are by column, `joints` is a text.
"""

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from lwr_dyn.checks.tables import sheet
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.foundation.fields import parse_toml
from lwr_dyn.model.printed_number import printed_number

AXES = "xyz"
SYMMETRIC_UNITS = ("kg m^2", "kg mm^2", "kg cm^2")
SYMMETRIC_WORDS = ("inertia", "tensor", "covariance", "gram")


def cell_text(value: Any) -> str | None:
    """A scalar as printed, None when it is none."""
    if isinstance(value, bool):
        return None
    return str(value) if isinstance(value, str | int | float) else None


def columns_of(
    name: str, raw: Any, path: str, unit: str, declared: sheet.Declared, matrices: list[sheet.SheetMatrix]
) -> Iterator[sheet.SheetColumn]:
    """The columns of a list: itself or its components, of matrices those on and above the diagonal.

    None for a list that is not of numbers; matrices are added to `matrices`.
    """
    rows = raw if isinstance(raw, list) else [raw]
    cells = [cell_text(x) for x in rows]
    if rows and all(c is not None for c in cells):
        yield sheet.SheetColumn(name, tuple(c or "" for c in cells), unit)
        return
    words = set(sheet.words_of(name)) & set(SYMMETRIC_WORDS)
    symmetric = name in declared.symmetric or unit in SYMMETRIC_UNITS or bool(words)
    matrix, cubes = _matrix(rows), [_matrix(x) if isinstance(x, list) else () for x in rows]
    if matrix:
        matrices.append(sheet.SheetMatrix(path, matrix, symmetric))
    width = max((len(x) for x in rows if isinstance(x, list)), default=0)
    if not 1 < width <= len(AXES):
        return
    yield from _vectors(name, rows, width, unit)
    if cubes[0] and all(len(m) == len(cubes[0]) for m in cubes):
        matrices += [sheet.SheetMatrix(f"{path}, row {r + 1}, ", m, symmetric) for r, m in enumerate(cubes)]
        for i, j in itertools.combinations_with_replacement(range(len(cubes[0])), 2):
            yield sheet.SheetColumn(f"{name}.{AXES[i]}{AXES[j]}", tuple(m[i][j] for m in cubes), unit, group=name)


def _vectors(name: str, rows: list[Any], width: int, unit: str) -> Iterator[sheet.SheetColumn]:
    """Components of a column of vectors; a row that is no vector ("-") is empty."""
    lists = [x if isinstance(x, list) and len(x) == width else ["-"] * width for x in rows]
    if any(cell_text(c) is None for row in lists for c in row):
        return
    for k in range(width):
        yield sheet.SheetColumn(f"{name}.{AXES[k]}", tuple(cell_text(row[k]) or "" for row in lists), unit, group=name)


def _matrix(rows: list[Any]) -> tuple[tuple[str, ...], ...]:
    """A square list of lists of cells, or nothing."""
    if len(rows) < 2 or not all(isinstance(x, list) and len(x) == len(rows) for x in rows):
        return ()
    cells = tuple(tuple(cell_text(c) or "" for c in row) for row in rows)
    return cells if any(printed_number(c) for row in cells for c in row) else ()


LISTS = ("formula", "ratio", "symmetric")
DECLARED = (*LISTS, "total", "role", "joints", "unit")
_CELL = re.compile(r"([\w.]+?)\.(\w+)\.values(?:\[(\d+)\])?.*")
PARTS = ("cells", "given")
"""Tables inside a table that hold its cells."""
NOT_CELLS = ("lint", "unit", "units", "schema", "rows", "errata", "needs")
_PRINTED_IN = re.compile(r"printed in ([^,;]+)")


class NumberText(str):
    """A number of the file as text, with all its digits."""

    __slots__ = ()


@dataclass(slots=True)
class SheetParts:
    """Tables, matrices and sentences collected from the file."""

    file: str
    tables: list[sheet.SheetTable] = field(default_factory=list)
    matrices: list[sheet.SheetMatrix] = field(default_factory=list)
    sentences: list[sheet.Sentence] = field(default_factory=list)
    errata: dict[str, str] = field(default_factory=dict)


def sheet_of_toml(text: str, file: str, joints: str = "") -> sheet.Sheet:
    """All tables, matrices and sentences of a TOML text; raises `TableError` for broken TOML and bad declarations.

    `joints` is the kind of the joints where the file does not state it: "revolute", "prismatic", or "" if unknown.

    >>> sheet_of_toml("[gains]\\nKp = [7310, 7270]\\nKd = [292.4, 290.8]", "x.toml").tables[0].columns[1].cells
    ('292.4', '290.8')
    """
    try:
        raw = parse_toml(text, file, parse_float=NumberText)
    except PaperError as fault:
        raise sheet.TableError(file, "TOML", str(fault.found), fault.allowed) from None
    parts = SheetParts(file)
    _walk(raw, "", parts, joints or _joints(raw))
    _masses(raw, parts)
    return sheet.Sheet(file, tuple(parts.tables), tuple(parts.matrices), tuple(parts.sentences), parts.errata)


def _joints(raw: Mapping[str, Any]) -> str:
    """The kind of the joints in a robot's file, if all have the same."""
    table = raw.get("joints")
    kinds = table.get("kinds") if isinstance(table, dict) else None
    same = {str(kind) for kind in kinds} if isinstance(kinds, list) else set()
    return same.pop() if len(same) == 1 else ""


def _walk(raw: Mapping[str, Any], name: str, parts: SheetParts, joints: str) -> None:
    declared, units = _declared(raw.get("lint", {}), f"{name or 'file'}.lint", parts.file, joints)
    where = str(raw.get("where", ""))
    columns: list[sheet.SheetColumn] = []
    values: dict[str, sheet.SheetColumn] = {}
    for key, value in _flat(raw):
        path = f"{name}.{key}" if name else key
        unit = units.get(key, "") or _unit_of_table(raw, key, value)
        if isinstance(value, dict) and "values" in value:
            columns += columns_of(key, value["values"], path, _unit(value), declared, parts.matrices)
            _sentences({k: v for k, v in value.items() if k != "unit"}, path, parts)
        elif isinstance(value, dict):
            _walk(value, path, parts, joints)
        elif isinstance(value, list) and value and all(isinstance(x, dict) for x in value):
            _records(value, path, parts, joints)
        elif isinstance(value, list):
            columns += columns_of(key, value, path, unit, declared, parts.matrices)
        elif cell_text(value) is not None:
            values[key] = sheet.SheetColumn(key, (cell_text(value) or "",), unit)
    _sentences(raw, name, parts)
    named = raw.get("rows")
    labels = tuple(str(x) for x in named) if isinstance(named, list) else ()
    _keep(sheet.SheetTable(name or "file", tuple(columns), values, where, declared, labels), parts)


def _flat(raw: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The entries of a table, and those of its parts that hold cells."""
    for key, value in raw.items():
        if key in PARTS and isinstance(value, dict) and "values" not in value:
            yield from value.items()
        elif key not in NOT_CELLS:
            yield key, value


def _keep(table: sheet.SheetTable, parts: SheetParts) -> None:
    """One table for each length of columns; single values stand beside each."""
    lengths = list(dict.fromkeys(len(c.cells) for c in table.columns))
    values = {**table.values, **{c.name: c for c in table.columns if len(c.cells) == 1}}
    for length in [n for n in lengths if n > 1] or ([0] if values else []):
        rows = tuple(c for c in table.columns if len(c.cells) == length)
        parts.tables.append(replace(table, columns=rows, values=values))


def _records(records: list[dict[str, Any]], path: str, parts: SheetParts, joints: str) -> None:
    """A list of tables: each by itself, and their single values as columns over the records."""
    for i, record in enumerate(records):
        label = record.get("name", record.get("id", i + 1))
        if path.rsplit(".", 1)[-1] == "erratum":  # corrected values are no table of the source
            _sentences(record, f"erratum {label}", parts)
            parts.errata.update(_patched(record, str(label)))
        else:
            _walk(record, f"{path}[{label}]", parts, joints)
    keys = dict.fromkeys(k for r in records for k in r)
    columns = [sheet.SheetColumn(k, tuple(cell_text(r.get(k, "-")) or "" for r in records)) for k in keys]
    numeric = [c for c in columns if c.numeric]
    if numeric and len(records) > 1:
        parts.tables.append(sheet.SheetTable(path, tuple(numeric)))


def _patched(record: Mapping[str, Any], label: str) -> Iterator[tuple[str, str]]:
    """The places, worded as in findings, that an erratum is about."""
    yield f"erratum {label}, ", label
    patches = record.get("patch", [])
    for patch in patches if isinstance(patches, list) else []:
        at = _CELL.fullmatch(str(patch.get("at", ""))) if isinstance(patch, dict) else None
        if at:
            table, name, row = at.groups()
            yield f"{table}.{name}", label
            yield f"{table}, row {int(row) + 1}, {name}" if row else f"{table}, row", label


def _sentences(raw: Mapping[str, Any], path: str, parts: SheetParts) -> None:
    for key, value in raw.items():
        if type(value) is str and printed_number(value) is None:
            parts.sentences.append(sheet.Sentence(f"{path}, {key}" if path else key, value))


def _unit(raw: Mapping[str, Any]) -> str:
    unit = raw.get("unit", "")
    units = set(map(str, unit)) if isinstance(unit, list) else {str(unit)}
    return units.pop() if len(units) == 1 else ""


def _unit_of_table(raw: Mapping[str, Any], key: str, value: Any) -> str:
    """The unit of a column: from the table's text ("printed in mm and mm/s"), by column, or one for all."""
    words = _PRINTED_IN.search(str(raw.get("where", "")))
    if words:
        listed = re.split(r"\s+and\s+", words.group(1).strip())
        rate = {"velocity", "vel", "speed"} & set(sheet.words_of(key))
        return next((u for u in listed if ("/s" in u) == bool(rate)), "")
    units = raw.get("units", raw.get("unit", ""))
    if isinstance(units, dict):
        return str(units.get(key, ""))
    return str(units) if isinstance(value, list) else ""  # a value beside a table is seldom in its unit


def _declared(raw: Any, path: str, file: str, joints: str) -> tuple[sheet.Declared, dict[str, str]]:
    """The declarations of a table, and its units by column."""
    if not isinstance(raw, dict):
        raise sheet.TableError(file, path, repr(raw), "a table")
    for key, value in raw.items():
        kind = list if key in LISTS else str if key == "joints" else dict
        if key not in DECLARED:
            raise sheet.TableError(file, f"{path}.{key}", "unknown", ", ".join(DECLARED))
        if not isinstance(value, kind):
            raise sheet.TableError(file, f"{path}.{key}", repr(value), f"a {'text' if kind is str else kind.__name__}")
    texts = {key: tuple(str(x) for x in raw.get(key, [])) for key in LISTS}
    maps = {key: {str(k): str(v) for k, v in raw.get(key, {}).items()} for key in ("total", "role", "unit")}
    declared = sheet.Declared(
        formulas=texts["formula"], ratios=texts["ratio"], symmetric=texts["symmetric"], totals=maps["total"],
        roles=maps["role"], joints=str(raw.get("joints", joints)),
    )  # fmt: skip
    return declared, maps["unit"]


def _masses(raw: Mapping[str, Any], parts: SheetParts) -> None:
    """A table of the masses of links and base in a robot's file, with the total of its data sheet."""
    tables = [raw.get(name, {}) for name in ("base", "inertial", "ratings")]
    columns = [table.get("mass", {}) for table in tables if isinstance(table, dict)]
    if len(columns) < 3 or not all(isinstance(c, dict) and "values" in c for c in columns):
        return
    base, links, total = (c["values"] for c in columns)
    cells = [cell_text(x) for x in (base, *(links if isinstance(links, list) else [links]))]
    text = cell_text(total)
    if all(c is not None for c in cells) and text is not None:
        masses = sheet.SheetColumn("mass", tuple(c or "" for c in cells), "kg")
        name = "base.mass and inertial.mass against ratings.mass"
        parts.tables.append(sheet.SheetTable(name, (masses,), declared=sheet.Declared(totals={"mass": text})))
