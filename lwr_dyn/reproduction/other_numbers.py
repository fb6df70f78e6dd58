"""A case with other numbers of the same kind: what a recomputed value does then shows what it rests on.

Zeros, +-1 and right angles are the form of the arm and stay; tensors stay symmetric.
"""

import random
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from lwr_dyn.model.printed_number import printed_number
from lwr_dyn.reproduction.case import PaperCase

LEAST, MOST = 0.03, 0.08
"""A number is changed by at least and at most this share of it."""
NO_DATA = ("document", "joints", "erratum", "reading", "lint")
"""Parts of a data file without numbers that a formula takes."""
FORM = ("dh.", "poses.")
"""Tables whose right angles are the form of the arm."""
TENSORS = ("inertial.inertia.values", "base.inertia.values")
Other = Callable[[str, float], float]
"""(path, number) -> the number in its place."""


def with_other_numbers(case: PaperCase, draw: int) -> PaperCase:
    """The case with every number of tables and results replaced, by set `draw`."""
    other = _drawn(draw)
    blocks = {
        name: replace(block, printed=_changed(dict(block.printed), f"results.{name}", other))
        for name, block in case.results.blocks.items()
    }
    return replace(case, tables=_tables(case, other), results=replace(case.results, blocks=blocks))


def with_other_cells(case: PaperCase, block: str) -> PaperCase:
    """The case with every cell of one block of results replaced, and nothing else."""
    own = case.block(block)
    columns = {cell.column for cell in own.cells}
    cells = {name: _changed(x, name, _drawn(0)) if name in columns else x for name, x in own.printed.items()}
    blocks = {**case.results.blocks, block: replace(own, printed=cells)}
    return replace(case, results=replace(case.results, blocks=blocks))


def with_other_letters(case: PaperCase, turned: bool) -> PaperCase:
    """The case with another letter for each symbol of the DH table; `turned`: its right angles by half a turn."""
    if "dh" not in case.tables:
        return case
    dh = dict(case.tables["dh"])
    for name in ("alpha", "theta_offset"):
        if turned and name in dh:
            dh[name] = {**dh[name], "values": [x - 180 if x > 0 else x + 180 if x else 0 for x in dh[name]["values"]]}
    for name, column in dh.items():
        if isinstance(column, Mapping) and "symbols" in column:
            dh[name] = {**column, "symbols": [f"{letter}_other" if letter else "" for letter in column["symbols"]]}
    return replace(case, tables={**case.tables, "dh": dh})


def letters_of(case: PaperCase) -> list[str]:
    """The symbols of the DH table, in the order of the file."""
    columns = (column for column in case.tables.get("dh", {}).values() if isinstance(column, Mapping))
    return [letter for column in columns for letter in column.get("symbols", ())]


def numbers_of(case: PaperCase) -> dict[str, float]:
    """Path -> value of every number but 0 and +-1 of the tables and of the results, as errata name them."""
    found: dict[str, float] = {}

    def note(path: str, value: float) -> float:
        return found.setdefault(path, value)

    _tables(case, note)
    for name, block in case.results.blocks.items():
        _changed(dict(block.printed), f"results.{name}", note)
    return found


def _drawn(draw: int) -> Other:
    def other(path: str, value: float) -> float:
        chance = random.Random(f"{path} {draw}")
        return value * (1.0 + chance.choice((1, -1)) * chance.uniform(LEAST, MOST))

    return other


def _tables(case: PaperCase, other: Other) -> dict[str, Any]:
    return {name: x if name in NO_DATA else _changed(x, name, other) for name, x in case.tables.items()}


def _changed(raw: Any, path: str, other: Other) -> Any:
    """Parsed TOML with its numbers, and its texts that are numbers, replaced."""
    if isinstance(raw, Mapping):
        if raw.get("unit") == "deg" and path.startswith(FORM):
            return {**raw, "values": _changed(raw["values"], f"{path}.values", _but_right_angles(other))}
        return {key: x if key in ("unit", "symbols") else _changed(x, f"{path}.{key}", other) for key, x in raw.items()}
    if isinstance(raw, list):
        tensor = path.startswith(TENSORS) and path.count("[") == 2
        names = [f"{path}[{i}]" for i in range(len(raw))]
        if tensor:  # one number for both places of a product
            head, _, row = path.rpartition("[")
            names = [f"{head}[{min(int(row[:-1]), i)}][{max(int(row[:-1]), i)}]" for i in range(len(raw))]
        return [_changed(x, name, other) for x, name in zip(raw, names, strict=True)]
    return _other_number(raw, path, other)


def _but_right_angles(other: Other) -> Other:
    return lambda path, value: value if value % 90.0 == 0.0 else other(path, value)


def _other_number(raw: Any, path: str, other: Other) -> Any:
    if isinstance(raw, str):
        number = printed_number(raw)
        return raw if number is None or number.value in (0.0, 1.0, -1.0) else repr(other(path, number.value))
    if isinstance(raw, bool) or not isinstance(raw, int | float) or raw in (0, 1, -1):
        return raw
    return other(path, float(raw))
