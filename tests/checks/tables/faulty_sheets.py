"""Correct tables with one fault each: the share of the faults that the rules find, and the false alarms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from lwr_dyn.checks.tables.rules import lint
from lwr_dyn.checks.tables.sheet import Sheet, SheetTable
from lwr_dyn.model.printed_number import printed_number
from tests.checks.tables.random_tables import correct_sheet, negated

DIGITS = "0123456789"


@dataclass(frozen=True, slots=True)
class FaultySheet:
    """A sheet with one fault, the cells that have it, and the rules that may find it."""

    sheet: Sheet
    cells: frozenset[str]
    rules: tuple[str, ...]

    @property
    def is_found(self) -> bool:
        """A finding that counts names one of the cells and is of the right rule."""
        return any(f.counts and f.rule in self.rules and self.cells & set(f.cells) for f in lint(self.sheet))


def _table(sheet: Sheet, name: str) -> SheetTable:
    return next(t for t in sheet.tables if t.name == name)


def _faulty(sheet: Sheet, name: str, cells: dict[tuple[str, int], str], *rules: str) -> FaultySheet:
    """The sheet with some cells of a table printed differently."""
    table = _table(sheet, name)
    columns = tuple(
        replace(c, cells=tuple(cells.get((c.name, i), x) for i, x in enumerate(c.cells))) for c in table.columns
    )
    changed = replace(sheet, tables=tuple(replace(t, columns=columns) if t is table else t for t in sheet.tables))
    return FaultySheet(changed, frozenset(table.place(i, c) for c, i in cells), rules)


def _scaled(text: str, power: int) -> str:
    """The text with its point moved, no digit gained or lost."""
    number = printed_number(text)
    if number is None or not number.value:
        return text
    decimals = len(text.partition(".")[2])
    return f"{number.value * 10.0**power:.{max(decimals - power, 0)}f}"


def _other_digit(rng: Generator, text: str) -> str:
    """The text with one of its leading two digits changed."""
    places = [i for i, ch in enumerate(text) if ch in "123456789"][:2]
    if not places:
        return text
    at = int(rng.choice(places))
    return text[:at] + str(rng.choice([d for d in DIGITS[1:] if d != text[at]])) + text[at + 1 :]


def _transposed(rng: Generator, text: str) -> str:
    places = [i for i in range(len(text) - 1) if text[i].isdigit() and text[i + 1].isdigit() and text[i] != text[i + 1]]
    if not places:
        return text
    i = int(rng.choice(places))
    return text[:i] + text[i + 1] + text[i] + text[i + 2 :]


def _mean(rng: Generator, sheet: Sheet) -> FaultySheet:
    table, stem = _table(sheet, "errors"), str(rng.choice(["position error", "velocity error"]))
    name = f"{stem} average"
    i = int(rng.integers(table.rows))
    text = next(c for c in table.columns if c.name == name).cells[i]
    return _faulty(sheet, "errors", {(name, i): _scaled(text, 1)}, "mean-outside", "column-order")


def _order(rng: Generator, sheet: Sheet) -> FaultySheet:
    table, stem = _table(sheet, "errors"), str(rng.choice(["position error", "velocity error"]))
    columns = [c for c in table.columns if c.name.startswith(stem)]
    turn = [0, 1, 2]
    while turn == [0, 1, 2]:
        turn = list(rng.permutation(3))
    first = int(rng.integers(0, table.rows - 1))
    last = int(rng.integers(first + 2, table.rows + 1))
    cells = {(columns[k].name, i): columns[turn[k]].cells[i] for k in range(3) for i in range(first, last)}
    return _faulty(sheet, "errors", cells, "column-order", "mean-outside")


def _swap(rng: Generator, sheet: Sheet) -> FaultySheet | None:
    table = _table(sheet, "gains")
    places = [(c, i) for c in table.columns[1:] for i in range(table.rows)]
    one, other = (places[k] for k in rng.choice(len(places), 2, replace=False))
    a, b = one[0].cells[one[1]], other[0].cells[other[1]]
    cells = {(one[0].name, one[1]): b, (other[0].name, other[1]): a}
    return None if a == b else _faulty(sheet, "gains", cells, "swapped")


def _power(rng: Generator, sheet: Sheet) -> FaultySheet:
    table = _table(sheet, "gains")
    chosen, i = table.columns[int(rng.integers(1, 3))], int(rng.integers(table.rows))
    text = _scaled(chosen.cells[i], int(rng.choice([-2, -1, 1, 2])))
    return _faulty(sheet, "gains", {(chosen.name, i): text}, "power-of-ten")


def _copy(rng: Generator, sheet: Sheet) -> FaultySheet | None:
    table = _table(sheet, "links")
    chosen, i = table.columns[int(rng.integers(3))], int(rng.integers(table.rows - 1))
    value, below = (abs(n.value) if (n := chosen.numbers[k]) else 0.0 for k in (i, i + 1))
    if value in (0.0, below):
        return None
    text = chosen.cells[i] + (str(rng.integers(1, 10)) if rng.random() < 0.5 else "")
    return _faulty(sheet, "links", {(chosen.name, i + 1): text}, "copied", "one-digit")


def _shift(rng: Generator, sheet: Sheet) -> FaultySheet | None:
    table, step = _table(sheet, "frames"), int(rng.choice([-1, 1]))
    new = {c.name: ((*c.cells[1:], "-") if step == 1 else ("-", *c.cells[:-1])) for c in table.columns}
    sizes = {x for c in _table(sheet, "dh").columns for x in c.cells if x != "0"}
    if len(sizes) < 4:  # too few lengths to decide
        return None
    cells = {(name, i): text for name, texts in new.items() for i, text in enumerate(texts)}
    faulty = _faulty(sheet, "frames", cells, "rows-shifted")
    return replace(faulty, cells=frozenset({"frames.r", "dh.d"}))


def _total(rng: Generator, sheet: Sheet) -> FaultySheet:
    table, i = _table(sheet, "masses"), int(rng.integers(_table(sheet, "masses").rows))
    text = table.columns[0].cells[i]
    fault = _transposed(rng, text) if rng.random() < 0.5 else _scaled(text, int(rng.choice([-1, 1])))
    return _faulty(sheet, "masses", {("mass", i): fault}, "total")


def _asymmetry(rng: Generator, sheet: Sheet) -> FaultySheet:
    k, (i, j) = int(rng.integers(len(sheet.matrices))), ((0, 1), (0, 2), (1, 2))[int(rng.integers(3))]
    matrix = sheet.matrices[k]
    text = matrix.cells[j][i]
    fault = (negated(text), _other_digit(rng, text), _scaled(text, 1))[int(rng.integers(3))]
    rows = [list(row) for row in matrix.cells]
    rows[j][i] = fault
    cells = tuple(tuple(row) for row in rows)
    matrices = tuple(replace(m, cells=cells) if m is matrix else m for m in sheet.matrices)
    return FaultySheet(
        replace(sheet, matrices=matrices), frozenset({f"{matrix.name}[{i + 1},{j + 1}]"}), ("not-symmetric",)
    )


def _unit(rng: Generator, sheet: Sheet) -> FaultySheet:
    name = str(rng.choice(["errors", "masses", "limits"]))
    wrong = {"errors": ("mm", "mm/s"), "masses": ("mm", "kg m^2"), "limits": ("kg", "mm")}[name]
    table = _table(sheet, name)
    k = int(rng.integers(len(table.columns))) if name != "limits" else 2
    old = table.columns[k]
    columns = tuple(replace(c, unit=str(rng.choice(wrong))) if c is old else c for c in table.columns)
    tables = tuple(replace(t, columns=columns) if t is table else t for t in sheet.tables)
    return FaultySheet(replace(sheet, tables=tables), frozenset({f"{name}, {old.name}"}), ("unit",))


def _sentence(rng: Generator, sheet: Sheet) -> FaultySheet:
    k = int(rng.integers(len(sheet.sentences)))
    sentence = sheet.sentences[k]
    left, _, right = sentence.text.rpartition("= ")
    result = right.split()[0]
    fault = _scaled(result, int(rng.choice([-2, -1, 1, 2]))) if rng.random() < 0.5 else _other_digit(rng, result)
    changed = replace(sentence, text=f"{left}= {fault} here")
    statements = tuple(changed if s is sentence else s for s in sheet.sentences)
    rules = ("power-of-ten", "arithmetic", "sign")
    return FaultySheet(replace(sheet, sentences=statements), frozenset({sentence.place}), rules)


FAULTS: dict[str, Callable[[Generator, Sheet], FaultySheet | None]] = {
    "mean times ten": _mean,
    "columns of a block in another order": _order,
    "two gains exchanged": _swap,
    "a gain off by a power of ten": _power,
    "a neighbour copied": _copy,
    "rows shifted by one": _shift,
    "a mass with digits exchanged or times ten": _total,
    "a tensor not symmetric": _asymmetry,
    "a unit of another quantity": _unit,
    "a wrong result in a sentence": _sentence,
}
"""Kind of fault -> what puts one into a sheet; None where it would change no digit."""


def faulty_sheet(rng: Generator, fault: str) -> FaultySheet | None:
    """A correct sheet with a fault of a kind of `FAULTS`; None when it would change no digit."""
    sheet = correct_sheet(rng)
    faulty = FAULTS[fault](rng, sheet)
    return None if faulty is None or faulty.sheet == sheet else faulty


def false_alarms(count: int, seed: int = 0) -> tuple[str, ...]:
    """The findings that count in so many correct sheets: there should be none."""
    rng = np.random.default_rng(seed)
    return tuple(f.line() for _ in range(count) for f in lint(correct_sheet(rng)) if f.counts)


def detection(fault: str, count: int, seed: int = 0) -> float:
    """Share of so many faults of a kind that is found."""
    rng = np.random.default_rng(seed)
    sheets = [s for _ in range(count) if (s := faulty_sheet(rng, fault)) is not None]
    return sum(s.is_found for s in sheets) / len(sheets)
