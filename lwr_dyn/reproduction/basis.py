"""What a recomputed number rests on, found by an experiment: all numbers of the paper are replaced by other ones.

computed      it moves, and not as one number alone does: the formula works
structural    a 0 or +-1, or an entry such as cos(q1), that stays whatever the numbers are
repeated      compared with print, not computed: it is one number of the data in this or another unit, or an earlier
              result once more, or a count or a place that does not move with the numbers, or what an erratum that it
              takes was fitted to

Zeros and right angles are the form of the arm and stay. An entry with letters also gets other letters, and right
angles turned by half a turn: "-sin(q1)" has its sign from a printed angle and counts as computed.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.printed_number import last_digit
from lwr_dyn.reproduction.case import COMPUTED, REPEATED, STRUCTURAL, ComparedExpression, PaperCase, Value
from lwr_dyn.reproduction.compare import ASSUMED, NOT, ComparedNumber, recomputed
from lwr_dyn.reproduction.other_numbers import letters_of, numbers_of, with_other_letters, with_other_numbers
from lwr_dyn.reproduction.paper_study import PaperStudy
from lwr_dyn.reproduction.verdicts import Verdicts

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
    symbolic = isinstance(number.value, ComparedExpression)
    columns = [
        recomputed(study.formulas, case, number.block.name) for case in (cases.letters if symbolic else cases.numbers)
    ]
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
