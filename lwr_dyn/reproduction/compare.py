"""One block of printed numbers against the recomputed ones, under as few errata as it takes."""

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from lwr_dyn.audit.printed_number import agrees, last_digit
from lwr_dyn.errors import LwrDynError, PaperError
from lwr_dyn.papers.schema import Erratum, Paper
from lwr_dyn.reproduction.case import ComparedExpression, PaperCase, Value
from lwr_dyn.reproduction.paper_study import PaperStudy
from lwr_dyn.reproduction.results import PrintedCell, ResultBlock

REPRODUCED, AFTER, DIFFERS, NOT = VERDICTS = ("reproduced", "after erratum", "differs", "not reproducible")
Columns = Mapping[str, Any]
_TOGETHER = 4
"""The largest number of errata that are tried together."""


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
    formula: str = ""

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

    def to_json(self) -> dict[str, Any]:
        """As JSON values."""
        value = self.value.text if isinstance(self.value, ComparedExpression) else self.value
        return {
            "cell": self.cell.path, "where": self.block.where, "row": self.cell.row, "column": self.cell.column,
            "printed": self.cell.printed, "unit": self.cell.unit, "derived": self.block.derived, "value": value,
            "verdict": self.verdict, "errata": list(self.errata), "miss": self.miss, "last_digits": self.digits,
            "missing": list(self.missing), "computed_by": self.block.compute,
        }  # fmt: skip


class BlockComparer:
    """Compares block by block; each set of errata is read once, each block computed once under it."""

    def __init__(self, study: PaperStudy, from_known_maxima: bool) -> None:
        self._data, self._formulas, self._own = study.data, study.formulas, study.data.paper
        self._from_known_maxima = from_known_maxima
        self._cases: dict[frozenset[str], PaperCase | None] = {}
        self._values: dict[tuple[str, frozenset[str]], dict[str, tuple[str, Value]]] = {}

    def block(self, block: ResultBlock, known: Columns | None) -> Iterator[ComparedNumber]:
        """All cells of a block."""
        own = frozenset(self._own.reading.errata)
        if known is not None:
            self._values[block.name, own] = _by_path(block, known)
        formula = self._formulas[block.compute].formula if block.compute else ""
        missing = tuple(need for need in block.needs if not _printed(need, self._own))
        if missing or block.derived or known is not None:
            read = frozenset(self._own.readings[block.reading].errata) if block.reading else own
            for cell in block.cells:
                printed, value = self._value(block, cell, read) if block.compute else (cell.printed, None)
                verdict = NOT if missing else REPRODUCED if agree(cell, printed, value) else DIFFERS
                yield ComparedNumber(block, cell, verdict, (), value, missing, formula)
            return
        for cell in block.cells:
            yield self._searched(block, cell, formula)

    def _searched(self, block: ResultBlock, cell: PrintedCell, formula: str) -> ComparedNumber:
        for applied in _subsets(self._candidates(block)):
            printed, value = self._value(block, cell, applied)
            if agree(cell, printed, value):
                ids = tuple(e.id for e in self._own.errata if e.id in applied)
                return ComparedNumber(block, cell, AFTER if ids else REPRODUCED, ids, value, (), formula)
        _, value = self._value(block, cell, frozenset(self._own.reading.errata))
        return ComparedNumber(block, cell, DIFFERS, (), value, (), formula)

    def _candidates(self, block: ResultBlock) -> list[str]:
        """Errata that can affect a block: of the default reading, of its own list, and those that patch it."""
        start = f"results.{block.name}."

        def affects(e: Erratum) -> bool:
            patches = any(p.at.startswith(start) for p in e.patches)
            return patches or e.id in block.errata or e.id in self._own.reading.errata

        return [e.id for e in self._own.errata if affects(e)]

    def _value(self, block: ResultBlock, cell: PrintedCell, applied: frozenset[str]) -> tuple[str, Value]:
        """The printed text of a cell with errata applied, and the value recomputed with them."""
        key = (block.name, applied)
        if key not in self._values:
            self._values[key] = self._computed(block, applied)
        return self._values[key].get(cell.path, (cell.printed, None))

    def _computed(self, block: ResultBlock, applied: frozenset[str]) -> dict[str, tuple[str, Value]]:
        case = self._case(applied)
        if case is None:
            return {}
        patched = case.block(block.name)
        try:
            return _by_path(patched, self._formulas[block.compute].function(case, patched))
        except (LwrDynError, ArithmeticError, ValueError):
            return {}  # these tables give no value: no arm, no solution

    def _case(self, applied: frozenset[str]) -> PaperCase | None:
        if applied not in self._cases:
            try:
                self._cases[applied] = self._data.case(*applied, from_known_maxima=self._from_known_maxima)
            except PaperError:
                self._cases[applied] = None  # two of them read one cell
        return self._cases[applied]


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
        out |= {c.path: (c.printed, _plain(v)) for c, v in zip(cells, values, strict=True)}
    return out


def _plain(value: Any) -> Value:
    return value if value is None or isinstance(value, ComparedExpression) else float(value)


def _flat(values: Any) -> Iterator[Any]:
    for value in values:
        if isinstance(value, Sequence) or hasattr(value, "__len__"):
            yield from value
        else:
            yield value


def _subsets(ids: Collection[str]) -> Iterator[frozenset[str]]:
    """Smallest first, in the file's order."""
    for size in range(min(len(ids), _TOGETHER) + 1):
        yield from (frozenset(chosen) for chosen in itertools.combinations(ids, size))


def _printed(need: str, paper: Paper) -> bool:
    column = paper.columns.get(need)
    return column is not None and column.kind == "printed"
