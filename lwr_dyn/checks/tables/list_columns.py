"""Lists of a data file as columns: numbers, components of vectors and of square matrices."""

from collections.abc import Iterator
from typing import Any

from lwr_dyn.checks.tables.roles import words_of
from lwr_dyn.checks.tables.sheet import Declared, SheetColumn, SheetMatrix
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
    name: str, raw: Any, path: str, unit: str, declared: Declared, matrices: list[SheetMatrix]
) -> Iterator[SheetColumn]:
    """The columns of a list: itself or its components; none for a list that is not of numbers."""
    rows = raw if isinstance(raw, list) else [raw]
    cells = [cell_text(x) for x in rows]
    if rows and all(c is not None for c in cells):
        yield SheetColumn(name, tuple(c or "" for c in cells), unit)
        return
    matrix = _matrix(rows)
    if matrix:
        matrices.append(SheetMatrix(path, matrix, _symmetric(name, unit, declared)))
    width = max((len(x) for x in rows if isinstance(x, list)), default=0)
    if 1 < width <= len(AXES):
        yield from _vectors(name, rows, width, unit)
        yield from _tensors(name, rows, path, unit, declared, matrices)


def _vectors(name: str, rows: list[Any], width: int, unit: str) -> Iterator[SheetColumn]:
    """Components of a column of vectors; a row that is no vector ("-") is empty."""
    lists = [x if isinstance(x, list) and len(x) == width else ["-"] * width for x in rows]
    if any(cell_text(c) is None for row in lists for c in row):
        return
    for k in range(width):
        yield SheetColumn(f"{name}.{AXES[k]}", tuple(cell_text(row[k]) or "" for row in lists), unit, group=name)


def _tensors(
    name: str, rows: list[Any], path: str, unit: str, declared: Declared, matrices: list[SheetMatrix]
) -> Iterator[SheetColumn]:
    """Entries on and above the diagonal of a column of matrices, and the matrices themselves."""
    cubes = [_matrix(x) if isinstance(x, list) else () for x in rows]
    size = len(cubes[0]) if cubes else 0
    if not size or any(len(m) != size for m in cubes):
        return
    for r, cells in enumerate(cubes):
        matrices.append(SheetMatrix(f"{path}, row {r + 1}, ", cells, _symmetric(name, unit, declared)))
    for i in range(size):
        for j in range(i, size):
            yield SheetColumn(f"{name}.{AXES[i]}{AXES[j]}", tuple(m[i][j] for m in cubes), unit, group=name)


def _matrix(rows: list[Any]) -> tuple[tuple[str, ...], ...]:
    """A square list of lists of cells, or nothing."""
    if len(rows) < 2 or not all(isinstance(x, list) and len(x) == len(rows) for x in rows):
        return ()
    cells = tuple(tuple(cell_text(c) or "" for c in row) for row in rows)
    return cells if any(printed_number(c) for row in cells for c in row) else ()


def _symmetric(name: str, unit: str, declared: Declared) -> bool:
    return name in declared.symmetric or unit in SYMMETRIC_UNITS or bool(set(words_of(name)) & set(SYMMETRIC_WORDS))
