"""A reading = the printed tables with its errata applied; each patch must find what it says is printed."""

from __future__ import annotations

import re
from typing import Any

from lwr_dyn.errors import PaperError
from lwr_dyn.papers.schema import Erratum

_STEP = re.compile(r"\.?([a-z_0-9]+)|\[(\d+)\]")
_PATH = re.compile(r"[a-z_0-9]+(\.[a-z_0-9]+|\[\d+\])+")


def apply_errata(tables: dict[str, Any], errata: tuple[Erratum, ...], file: str) -> dict[str, dict[int, list[str]]]:
    """Patch the parsed tables in place.

    Returns
    -------
    dict
        Column path ("inertial.mass") -> row -> ids of the errata that touched it.

    Raises
    ------
    PaperError
        A patch points nowhere, or the file prints something else there.
    """
    touched: dict[str, dict[int, list[str]]] = {}
    for erratum in errata:
        for patch in erratum.patches:
            holder, key = _locate(tables, patch.at, f"erratum {erratum.id}", file)
            if holder[key] != patch.printed:
                field, allowed = f"erratum {erratum.id}: {patch.at}", f"{patch.printed!r} as stated"
                raise PaperError(file, field, f"printed {holder[key]!r}", allowed)
            holder[key] = patch.read
            column, row = _column_and_row(patch.at)
            for i in [row] if row is not None else range(64):
                touched.setdefault(column, {}).setdefault(i, []).append(erratum.id)
    return touched


def _steps(path: str) -> list[str | int]:
    return [name or int(index) for name, index in _STEP.findall(path)]


def _locate(tables: dict[str, Any], path: str, field: str, file: str) -> tuple[Any, Any]:
    """The container and the key of the cell that `path` names."""
    if not _PATH.fullmatch(path):
        raise PaperError(file, field, f"no cell {path!r}", "a path such as inertial.mass.values[2]")
    holder: Any = tables
    steps = _steps(path)
    for step in steps[:-1]:
        try:
            holder = holder[step]
        except (KeyError, IndexError, TypeError):
            raise PaperError(file, field, f"no cell {path!r}", "a path such as inertial.mass.values[2]") from None
    known = isinstance(holder, list) and isinstance(steps[-1], int) and steps[-1] < len(holder)
    if not (known or (isinstance(holder, dict) and steps[-1] in holder)):
        raise PaperError(file, field, f"no cell {path!r}", "a path such as inertial.mass.values[2]")
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
