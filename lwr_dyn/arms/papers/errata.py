"""Applies the errata of a reading to the printed tables; a patch must state exactly what is printed in its cell."""

import re
from collections.abc import Iterable
from typing import Any

from lwr_dyn.arms.papers.schema import Erratum, Patch
from lwr_dyn.foundation.errors import PaperError

_STEP = re.compile(r"\.?([A-Za-z_0-9]+)|\[(\d+)\]")
_PATH = re.compile(r"[A-Za-z_0-9]+(\.[A-Za-z_0-9]+|\[\d+\])+")


def apply_errata(tables: dict[str, Any], errata: tuple[Erratum, ...], file: str) -> dict[str, dict[int, list[str]]]:
    """Patches the parsed tables in place.

    Returns
    -------
    dict
        Column path ("inertial.mass") -> row -> ids of the errata that touched it.

    Raises
    ------
    PaperError
        A patch names no cell, the file prints something else there, or two errata change one cell.
    """
    touched: dict[str, dict[int, list[str]]] = {}
    one_erratum_a_cell(errata, file)
    for erratum in errata:
        for patch in erratum.of_tables():
            apply_patch(tables, patch, erratum.id, file)
            column, row = _column_and_row(patch.at)
            for i in [row] if row is not None else range(64):  # all rows: no arm has more joints
                touched.setdefault(column, {}).setdefault(i, []).append(erratum.id)
    return touched


def apply_patch(tables: dict[str, Any], patch: Patch, erratum: str, file: str) -> None:
    """Replaces one printed cell; raises `PaperError` when the file prints something else there."""
    holder, key = _locate(tables, patch.at, f"erratum {erratum}", file)
    if holder[key] != patch.printed:
        raise PaperError(
            file, f"erratum {erratum}: {patch.at}", f"printed {holder[key]!r}", f"{patch.printed!r} as stated"
        )
    holder[key] = patch.read


def one_erratum_a_cell(errata: Iterable[Erratum], file: str) -> None:
    """Raise `PaperError` when two errata change one cell, or one changes a cell inside what the other changes."""
    cells = [(e.id, p.at) for e in errata for p in e.patches]
    for k, (erratum, at) in enumerate(cells):
        steps = _steps(at)
        for other, place in cells[:k]:
            size = min(len(steps), len(_steps(place)))
            if other != erratum and steps[:size] == _steps(place)[:size]:
                raise PaperError(
                    file, f"errata {other} and {erratum}", f"both read {at}", "one erratum of a reading a cell"
                )


def _steps(path: str) -> list[str | int]:
    return [name or int(index) for name, index in _STEP.findall(path)]


def _locate(tables: dict[str, Any], path: str, field: str, file: str) -> tuple[Any, Any]:
    """The container and the key of the cell that `path` names."""
    steps = _steps(path) if _PATH.fullmatch(path) else [""]
    holder: Any = None
    cell: Any = tables
    for step in steps:
        holder = cell
        known = step in holder if isinstance(holder, dict) else isinstance(holder, list) and step in range(len(holder))
        if not known:
            raise PaperError(file, field, f"no cell {path!r}", "a path such as inertial.mass.values[2]")
        cell = holder[step]
    return holder, steps[-1]


def _column_and_row(path: str) -> tuple[str, int | None]:
    """("inertial.mass", 2) of "inertial.mass.values[2][0]"; the row is None when the whole column is meant.

    >>> _column_and_row("inertial.inertia.about")
    ('inertial.inertia', None)
    """
    steps = _steps(path)
    column = ".".join(str(s) for s in steps[:2])
    row = steps[3] if len(steps) > 3 and isinstance(steps[3], int) else None
    return column, row
