"""Every printed number with its verdict: recomputed without errata, then with the fewest that explain it.

reproduced                  recomputed to the printed digits from what is printed
after erratum               so with the named errata, and with no smaller set of them
differs                     by D, with every set of errata that can affect it
under assumed conditions    something that it needs is not printed, is named, and was assumed; near or not
not reproducible            so, and nothing can be computed without it

Printed expressions are compared by value: both sides at the same arbitrary values of their symbols.
"""

import itertools
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import lru_cache
from typing import Annotated, Any, TypedDict

from lwr_dyn.arms.papers.schema import Erratum
from lwr_dyn.checks.tables import arithmetic
from lwr_dyn.foundation.errors import LwrDynError, OptionError, PaperError
from lwr_dyn.model.printed_number import agrees, last_digit
from lwr_dyn.reproduction.case import BASES, REPEATED, STRUCTURAL, ComparedExpression, PaperCase, PaperFormula, Value
from lwr_dyn.reproduction.paper_study import PaperStudy
from lwr_dyn.reproduction.papers import PrintedCell, ResultBlock

VERDICTS = REPRODUCED, AFTER, DIFFERS, ASSUMED, NOT = (
    "reproduced", "after erratum", "differs", "under assumed conditions", "not reproducible",
)  # fmt: skip

NEAR = 0.15
"""Under assumed conditions a value is near that misses print by at most this share of the range printed in its row."""

Columns = Mapping[str, Any]

_TOGETHER = 4
"""The largest number of errata that are tried together."""


class NumberRecord(TypedDict):
    """`ComparedNumber.to_json`."""

    cell: Annotated[str, "Its path, as errata name it."]
    where: Annotated[str, "Place in the paper."]
    row: str
    column: str
    printed: Annotated[str, "Digit for digit."]
    unit: str
    derived: Annotated[bool, "Stated by lwr_dyn, not printed by the paper."]
    value: Annotated[
        float | str | None, "Recomputed, in the printed unit; an expression is text; null without a value."
    ]
    verdict: Annotated[str, f"One of: {', '.join(VERDICTS)}."]
    basis: Annotated[str | None, f"What the value rests on: {', '.join(BASES)}; null where only assumptions give it."]
    outcome: Annotated[str, "The class in which it is counted: verdict, or basis where it agrees and is not computed."]
    near: Annotated[bool | None, "Under assumed conditions: whether the value is near what is printed."]
    errata: Annotated[list[str], "The fewest with which it is reproduced."]
    miss: Annotated[float | None, "Recomputed less printed; of a figure, how far outside its range."]
    last_digits: Annotated[float | None, "The miss in units of the last printed digit."]
    missing: Annotated[list[str], "What it needs and the paper does not print."]
    computed_by: Annotated[str, "Name of the formula."]


@dataclass(frozen=True, slots=True, eq=False)
class ComparedNumber:
    """One number with its verdict."""

    block: ResultBlock
    cell: PrintedCell
    verdict: str
    errata: tuple[str, ...] = ()
    """The fewest with which it is reproduced."""
    value: Value = None
    """Recomputed with those errata, in the printed unit."""
    missing: tuple[str, ...] = ()
    """What it needs and the paper does not print."""
    formula: str = ""
    applied: tuple[str, ...] = ()
    """The errata that the tables behind `value` were read with."""
    basis: str = ""
    """What the value rests on, one of `BASES`; empty where that was not asked for or only assumptions give it."""

    @property
    def outcome(self) -> str:
        """The class in which it is counted: its verdict, or its basis where it agrees and is not computed."""
        agreeing = self.verdict in (REPRODUCED, AFTER)
        return self.basis if agreeing and self.basis in (STRUCTURAL, REPEATED) else self.verdict

    @property
    def near(self) -> bool | None:
        """Whether a value under assumed conditions is near what is printed; None with another verdict.

        Near is: within half the last digit, or in the range of a figure, or at most `NEAR` of the row's range away.
        """
        if self.verdict != ASSUMED:
            return None
        if agree(self.cell, self.cell.printed, self.value):
            return True
        row = [float(c.printed) for c in self.block.range_cells(self.cell)]
        return bool(row) and self.miss is not None and abs(self.miss) <= NEAR * (max(row) - min(row))

    @property
    def miss(self) -> float | None:
        """Recomputed less printed, in the printed unit; of a figure, how far outside its range."""
        if self.value is None or isinstance(self.value, ComparedExpression):
            return None
        if self.cell.span is not None:
            least, most = (float(x) for x in self.cell.span)
            return self.value - min(max(self.value, least), most)
        return float(Decimal(self.value) - Decimal(self.cell.printed))

    @property
    def digits(self) -> float | None:
        """The miss in units of the last printed digit."""
        return None if self.miss is None else self.miss / float(last_digit(self.cell.printed))

    def to_json(self) -> NumberRecord:
        """As JSON values."""
        value = self.value.text if isinstance(self.value, ComparedExpression) else self.value
        return {
            "cell": self.cell.path, "where": self.block.where, "row": self.cell.row, "column": self.cell.column,
            "printed": self.cell.printed, "unit": self.cell.unit, "derived": self.block.derived, "value": value,
            "verdict": self.verdict, "basis": self.basis or None, "outcome": self.outcome, "near": self.near,
            "errata": list(self.errata), "miss": self.miss, "last_digits": self.digits, "missing": list(self.missing),
            "computed_by": self.block.compute,
        }  # fmt: skip


class BlockComparer:
    """Compares block by block; each set of errata is read once, each block computed once under it."""

    def __init__(self, study: PaperStudy, from_known_maxima: bool) -> None:
        self._data, self._formulas, self._own = study.data, study.formulas, study.data.paper
        self._printed = {name for name, column in self._own.columns.items() if column.kind == "printed"}
        self._from_known_maxima = from_known_maxima
        self._cases: dict[frozenset[str], PaperCase | None] = {}
        self._values: dict[tuple[str, frozenset[str]], dict[str, tuple[str, Value]]] = {}

    def block(self, block: ResultBlock, known: Columns | None) -> Iterator[ComparedNumber]:
        """All cells of a block."""
        own = frozenset(self._own.reading.errata)
        if known is not None:
            self._values[block.name, own] = _by_path(block, known)
        formula = self._formulas[block.compute].formula if block.compute else ""
        missing = tuple(need for need in block.needs if need not in self._printed)
        if missing or block.derived or known is not None:
            read = frozenset(self._own.readings[block.reading].errata) if block.reading else own
            for cell in block.cells:
                printed, value = self._value(block, cell, read) if block.compute else (cell.printed, None)
                verdict = REPRODUCED if agree(cell, printed, value) else DIFFERS
                if missing:
                    verdict = NOT if value is None else ASSUMED
                yield ComparedNumber(block, cell, verdict, (), value, missing, formula, tuple(read))
            return
        together = block.cells if block.form == "figure" else ()
        for cell in block.cells:
            yield self._searched(block, cell, together or (cell,), formula)

    def _searched(
        self, block: ResultBlock, cell: PrintedCell, together: Sequence[PrintedCell], formula: str
    ) -> ComparedNumber:
        """With the fewest errata under which it agrees; the cells of a figure together, for it shows one thing."""
        candidates = self._candidates(block)
        sizes = range(min(len(candidates), _TOGETHER) + 1)  # smallest first, in the file's order
        for applied in (frozenset(one) for size in sizes for one in itertools.combinations(candidates, size)):
            if all(agree(each, *self._value(block, each, applied)) for each in together):
                _, value = self._value(block, cell, applied)
                ids = tuple(e.id for e in self._own.errata if e.id in applied)
                return ComparedNumber(block, cell, AFTER if ids else REPRODUCED, ids, value, (), formula, ids)
        if len(together) > 1:
            return self._searched(block, cell, (cell,), formula)
        own = tuple(self._own.reading.errata)
        _, value = self._value(block, cell, frozenset(own))
        return ComparedNumber(block, cell, DIFFERS, (), value, (), formula, own)

    def _candidates(self, block: ResultBlock) -> list[str]:
        """Errata that can affect a block: of the reading of the results, of its own list, and those that patch it."""
        start = f"results.{block.name}."

        def affects(e: Erratum) -> bool:
            patches = any(p.at.startswith(start) for p in e.patches)
            return patches or e.id in block.errata or e.id in self._own.reading.errata

        return [e.id for e in self._own.errata if affects(e)]

    def _value(self, block: ResultBlock, cell: PrintedCell, applied: frozenset[str]) -> tuple[str, Value]:
        """The printed text of a cell with errata applied, and the value recomputed with them."""
        key = (block.name, applied)
        if key not in self._values:
            case = self._case(applied)
            self._values[key] = {} if case is None else recomputed(self._formulas, case, block.name)
        return self._values[key].get(cell.path, (cell.printed, None))

    def _case(self, applied: frozenset[str]) -> PaperCase | None:
        if applied not in self._cases:
            try:
                self._cases[applied] = self._data.case(*applied, from_known_maxima=self._from_known_maxima)
            except PaperError:
                self._cases[applied] = None  # two of them read one cell
        return self._cases[applied]


def recomputed(known: Mapping[str, PaperFormula], case: PaperCase, name: str) -> dict[str, tuple[str, Value]]:
    """Path of each cell of a block -> its printed text and its value in a case; empty where there is no value."""
    block = case.block(name)
    try:
        return _by_path(block, known[block.compute].function(case, block))
    except (LwrDynError, ArithmeticError, ValueError):
        return {}  # these tables give no value: no arm, no solution


def agree(cell: PrintedCell, printed: str, value: Value) -> bool:
    """Whether a value is the printed one: to the digits, within the range of a figure, or as an expression."""
    if value is None:
        return False
    if isinstance(value, ComparedExpression):
        return value.same
    if cell.span is not None:
        return float(cell.span[0]) <= value <= float(cell.span[1])
    return bool(value == value) and abs(value) < float("inf") and agrees(printed, value, cell.step)


def _by_path(block: ResultBlock, columns: Columns) -> dict[str, tuple[str, Value]]:
    out: dict[str, tuple[str, Value]] = {}
    for column in dict.fromkeys(cell.column for cell in block.cells):
        cells = [c for c in block.cells if c.column == column]
        values = list(_flat(columns[column]))
        if len(values) != len(cells):
            raise ValueError(f"{block.name}.{column}: {len(values)} values for {len(cells)} cells")
        plain = [v if v is None or isinstance(v, ComparedExpression) else float(v) for v in values]
        out |= {c.path: (c.printed, v) for c, v in zip(cells, plain, strict=True)}
    return out


def _flat(values: Any) -> Iterator[Any]:
    for value in values:
        if isinstance(value, Sequence) or hasattr(value, "__len__"):
            yield from value
        else:
            yield value


@dataclass(frozen=True, slots=True, eq=False)
class Verdicts:
    """All numbers of a paper with their verdicts."""

    paper: str
    numbers: tuple[ComparedNumber, ...]

    def counts(self, derived: bool = False) -> dict[str, int]:
        """How many of the printed (or derived) numbers have which verdict."""
        counted = Counter(number.verdict for number in self.numbers if number.block.derived == derived)
        return {verdict: counted[verdict] for verdict in VERDICTS}


def compare_numbers(
    study: PaperStudy,
    *,
    slow: bool = False,
    known: Mapping[str, Columns] | None = None,
    from_known_maxima: bool = False,
) -> Verdicts:
    """Compare every number of a paper.

    Parameters
    ----------
    study : PaperStudy
        See `paper_study`, and `PaperStudy.with_data` for changed data.
    slow : bool
        Also what needs simulations or algebra with letters.
    known : dict, optional
        Name of a block -> columns of values that were computed elsewhere, under the reading of the results.
    from_known_maxima : bool
        Global searches only look where they ended for the package's own tables: quick, for slightly changed tables.

    Raises
    ------
    PaperError
        Bad data: a formula that does not exist, an unknown erratum, a breach of either schema.
    """
    comparer, known = BlockComparer(study, from_known_maxima), known or {}
    numbers: list[ComparedNumber] = []
    check_names(study)
    for block in study.data.results.blocks.values():
        formula = study.formulas.get(block.compute)
        if block.name in known or formula is None or slow or not formula.slow:
            numbers += comparer.block(block, known.get(block.name))
    return Verdicts(study.name, tuple(numbers))


def check_names(study: PaperStudy) -> None:
    """Raise `PaperError` when a formula, an erratum or a reading that the results name does not exist."""
    results, paper = study.data.results, study.data.paper
    if results.paper != paper.name:
        raise PaperError(results.file, "paper", repr(results.paper), paper.name)
    known = {"compute": (*study.formulas,), "errata": tuple(e.id for e in paper.errata), "reading": (*paper.readings,)}
    kinds = {"compute": "no function ", "errata": "no erratum ", "reading": ""}
    for block in results.blocks.values():
        named = {"compute": (block.compute,), "errata": block.errata, "reading": (block.reading,)}
        for field, names in named.items():
            for name in (name for name in names if name and name not in known[field]):
                fault, allowed = f"{kinds[field]}{name!r}", f"one of {', '.join(known[field])}"
                raise PaperError(results.file, f"{block.name}.{field}", fault, allowed)


SAME = 1e-9
"""Two expressions of sines, products and sums that agree at two random points to this agree everywhere: the chance of
another case is negligible."""
LONGEST = 100_000
"""Characters of an expression: matrix entries are long."""
FUNCTIONS = ("cos", "sin", "sqrt")


@lru_cache(maxsize=4096)
def value_of(text: str, draw: int) -> float:
    """An expression at one draw of its symbols' values; C1 and S1 are cosine and sine of q1. No code is run.

    Raises
    ------
    OptionError
        Anything but numbers, symbols, + - * / **, cos, sin and sqrt, or an expression without a value.

    >>> round(value_of("cos(q1)**2 + S1**2", 0), 12)
    1.0
    """
    tree = arithmetic.parsed(text, LONGEST, FUNCTIONS)
    names = list(arithmetic.names_in(tree)) if tree else []
    value = arithmetic.value_of(tree, {name: _letter(name, draw) for name in names})
    if math.isnan(value) or any("." in name for name in names):
        raise OptionError("expression", repr(text), "numbers, letters, + - * / **, cos, sin, sqrt: -a1*C1 or cos(q1)")
    return value


def _letter(name: str, draw: int) -> float:
    """The value of a symbol: arbitrary, but always the same one; pi is itself, C3 and S3 belong to q3."""
    if name == "pi":
        return math.pi
    if name[0] in "CS" and name[1:].isdigit():
        angle = _letter(f"q{name[1:]}", draw)
        return math.cos(angle) if name[0] == "C" else math.sin(angle)
    seed = sum((k + 3) * ord(c) for k, c in enumerate(name)) + 101 * draw
    return 0.5 + (seed * 0.6180339887498949) % 1.0


def same(printed: str, ours: str) -> bool:
    """Both expressions have one value at two draws of their symbols."""
    return all(abs(value_of(printed, k) - value_of(ours, k)) <= SAME for k in (0, 1))


def compared(printed: Iterable[Sequence[str]], ours: Iterable[Sequence[object]]) -> list[list[ComparedExpression]]:
    """A printed matrix of expressions beside ours, entry by entry."""
    rows = zip(printed, ours, strict=True)
    return [[ComparedExpression(str(x), same(p, str(x))) for p, x in zip(*row, strict=True)] for row in rows]
