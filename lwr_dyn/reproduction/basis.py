"""What a recomputed number rests on, found by an experiment: all numbers of the paper are replaced by other ones.

computed      it moves, and not as one number alone does: the formula works
structural    a 0 or +-1, or an entry such as cos(q1), that stays whatever the numbers are
repeated      compared with print, not computed: it is one number of the data in this or another unit, or an earlier
              result once more, or a count or a place that does not move with the numbers, or what an erratum that it
              takes was fitted to

Zeros, +-1 and right angles are the form of the arm and stay; tensors stay symmetric. An entry with letters also gets
other letters, and right angles turned by half a turn: "-sin(q1)" has its sign from a printed angle and counts as
computed.
"""

import random
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import RESULT, RUN
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.printed_number import last_digit, printed_number
from lwr_dyn.reproduction.case import COMPUTED, REPEATED, STRUCTURAL, ComparedExpression, PaperCase, Value
from lwr_dyn.reproduction.compare import ASSUMED, NOT, ComparedNumber, Verdicts, recomputed
from lwr_dyn.reproduction.paper_study import PaperStudy

LEAST, MOST = 0.03, 0.08
"""A number is changed by at least and at most this share of it."""

NO_DATA = ("document", "source", "joints", "erratum", "reading", "lint", RESULT, RUN)
"""Parts of a data file without numbers that a formula takes, or with those that are in the results as well."""

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
    _tables(case, found.setdefault)
    for name, block in case.results.blocks.items():
        _changed(dict(block.printed), f"results.{name}", found.setdefault)
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


DRAWS = 2
"""Sets of other numbers."""

STILL = 1e-3
"""Share of its last printed digit that rounding may move a number by."""

SAME = 1e-9
"""Relative difference of two numbers that are one."""

UNITS = np.array([sign * factor for sign in (1, -1) for factor in (1.0, 1e3, 1e-3, 180.0 / pi, pi / 180.0)])
"""Factors between a number and the same number in another unit or counted the other way."""


@dataclass(frozen=True, slots=True, eq=False)
class _Variants:
    """A case as it is, with other numbers, and with other letters; its numbers in the first ones, and its letters."""

    numbers: tuple[PaperCase, ...]
    letters: tuple[PaperCase, ...]
    data: Array
    """(1 + DRAWS, m)"""
    names: frozenset[tuple[str, ...]]

    @classmethod
    def of(cls, case: PaperCase) -> "_Variants":
        """Of a case, with errata applied."""
        numbers = (case, *(with_other_numbers(case, draw) for draw in range(DRAWS)))
        letters = (case, *(with_other_letters(case, turned) for turned in (False, True)))
        found = [numbers_of(each) for each in numbers]
        data = np.array([[each[path] for path in found[0]] for each in found])
        names = zip(*(letters_of(each) for each in letters), strict=True)
        return cls(numbers, letters, data, frozenset(names))


def with_bases(study: PaperStudy, verdicts: Verdicts) -> Verdicts:
    """The same verdicts, each number with its basis."""
    found = bases(study, verdicts.numbers)
    return Verdicts(verdicts.paper, tuple(replace(n, basis=found.get(n.cell.path, "")) for n in verdicts.numbers))


def bases(study: PaperStudy, numbers: Sequence[ComparedNumber]) -> dict[str, str]:
    """Path of a cell -> what its recomputed value rests on; none for those that only assumed conditions give.

    A formula that takes a simulation or algebra with letters states its basis itself (`PaperFormula.basis`).
    """
    found: dict[str, str] = {}
    seen: set[tuple[float, ...]] = set()
    variants: dict[frozenset[str], _Variants] = {}
    trials: dict[tuple[str, frozenset[str]], Mapping[str, list[Value]]] = {}
    for number in sorted(numbers, key=lambda n: n.block.derived):  # what is printed comes first
        formula = study.formulas.get(number.block.compute)
        if number.verdict in (ASSUMED, NOT) or formula is None:
            continue
        if stated := formula.basis or (REPEATED if number.cell.path in _fitted(study, number.applied) else ""):
            found[number.cell.path] = stated
            continue
        applied = frozenset(number.applied)
        if applied not in variants:
            variants[applied] = _Variants.of(study.data.case(*applied, from_known_maxima=True))
        key = number.block.name, applied
        if key not in trials:
            trials[key] = _trials(study, variants[applied], number)
        values = trials[key][number.cell.path]
        found[number.cell.path] = _basis(number, values, variants[applied], seen)
    return found


def _fitted(study: PaperStudy, applied: Collection[str]) -> set[str]:
    """The cells that values of these errata were fitted to."""
    return {at for e in study.data.errata if e.id in applied for patch in e.patches for at in patch.fitted_to}


def _trials(study: PaperStudy, cases: _Variants, number: ComparedNumber) -> dict[str, list[Value]]:
    """Path of each cell of a block -> its value in each case."""
    changed = cases.letters if isinstance(number.value, ComparedExpression) else cases.numbers
    columns = [recomputed(study.formulas, case, number.block.name) for case in changed]
    return {cell.path: [values.get(cell.path, ("", None))[1] for values in columns] for cell in number.block.cells}


def _basis(number: ComparedNumber, values: Sequence[Value], cases: _Variants, seen: set[tuple[float, ...]]) -> str:
    if isinstance(values[0], ComparedExpression):
        return _of_expression([x.text if isinstance(x, ComparedExpression) else "" for x in values], cases)
    if any(x is None or isinstance(x, ComparedExpression) for x in values):
        return COMPUTED  # with other numbers there is no solution
    trial = np.array(values, dtype=np.float64)
    still = STILL * float(last_digit(number.cell.printed))
    if np.ptp(trial) <= still:
        return STRUCTURAL if min(abs(trial[0] - x) for x in (0.0, 1.0, -1.0)) <= still else REPEATED
    alike = np.abs(trial[:, None, None] - cases.data[:, :, None] * UNITS) <= SAME * np.abs(trial)[:, None, None]
    key = tuple(float(f"{x:.9g}") for x in trial)
    again = key in seen
    seen.add(key)
    return REPEATED if again or bool(alike.all(axis=0).any()) else COMPUTED


def _of_expression(texts: Sequence[str], cases: _Variants) -> str:
    if tuple(texts) in cases.names:
        return REPEATED
    if texts[0] == texts[1] and (texts[0] in ("0", "1", "-1") or texts[0] == texts[2]):
        return STRUCTURAL
    return COMPUTED
