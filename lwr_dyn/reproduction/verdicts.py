"""Every printed number judged: recomputed without errata, then with as few as it takes.

    reproduced          recomputed to the printed digits from what is printed
    after erratum       so with the errata named, and with no smaller set of them
    differs             by D, with every set of errata that could matter
    not reproducible    what it takes is not printed; what is missing is named
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from lwr_dyn.errors import LwrDynError, PaperError
from lwr_dyn.papers.reader import paper_of_tables
from lwr_dyn.papers.schema import Erratum, Paper
from lwr_dyn.reproduction.case import Case, Recompute, Symbolic, Value, case_of
from lwr_dyn.reproduction.printed import agrees, last_digit
from lwr_dyn.reproduction.results import Block, Cell, Results, results_of_tables
from lwr_dyn.reproduction.rooms import room

REPRODUCED, AFTER, DIFFERS, NOT = VERDICTS = ("reproduced", "after erratum", "differs", "not reproducible")
Columns = Mapping[str, Any]
_TOGETHER = 4
"""At most so many errata are tried together."""


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """One number with its verdict."""

    block: Block
    cell: Cell
    verdict: str
    errata: tuple[str, ...] = ()
    """Without which it is not reproduced."""
    value: Value = None
    """Recomputed with those errata, in the printed unit."""
    missing: tuple[str, ...] = ()
    formula: str = ""

    @property
    def miss(self) -> float | None:
        """Recomputed less printed, in the printed unit; of a figure, how far outside its range."""
        if self.value is None or isinstance(self.value, Symbolic):
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
        value = self.value.text if isinstance(self.value, Symbolic) else self.value
        return {
            "cell": self.cell.path, "where": self.block.where, "row": self.cell.row, "column": self.cell.column,
            "printed": self.cell.printed, "unit": self.cell.unit, "derived": self.block.derived, "value": value,
            "verdict": self.verdict, "errata": list(self.errata), "miss": self.miss, "last_digits": self.digits,
            "missing": list(self.missing), "computed_by": self.block.compute,
        }  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """All numbers of a paper with their verdicts."""

    paper: str
    data: tuple[Judged, ...]

    def counts(self, derived: bool = False) -> dict[str, int]:
        """How many of the printed (or derived) numbers have which verdict."""
        found = Counter(j.verdict for j in self.data if j.block.derived == derived)
        return {verdict: found[verdict] for verdict in VERDICTS}

    def keys(self) -> dict[str, tuple[str, tuple[str, ...]]]:
        """Cell -> verdict and errata: what a change of the data may turn."""
        return {j.cell.path: (j.verdict, j.errata) for j in self.data}


def judged(
    paper: str,
    tables: Mapping[str, Any] | None = None,
    results: Mapping[str, Any] | None = None,
    *,
    slow: bool = False,
    known: Mapping[str, Columns] | None = None,
    warm: bool | None = None,
) -> Judgement:
    """Judge every number of a paper.

    Parameters
    ----------
    paper : str
        One of `rooms.PAPERS`.
    tables, results : dict, optional
        Its data file and its `results.toml`, parsed; those of the package if not given. They are left as they are.
    slow : bool
        Also what needs simulations or algebra with letters.
    known : dict, optional
        Block -> columns of values that were computed elsewhere, under the default reading.
    warm : bool, optional
        Let global searches start where they ended for the package's own tables; so, if not given, when `tables` are.

    Raises
    ------
    PaperError
        Bad data: a function that does not exist, an unknown erratum, a breach of either schema.
    """
    here = room(paper)
    printed = here.results if results is None else results_of_tables(results, here.results.file)
    table = here.tables if tables is None else tables
    own = paper_of_tables(dict(table), here.file)
    check(printed, own, here.functions)
    judge = _Judge(table, printed, here.file, here.functions, own, tables is not None if warm is None else warm)
    data: list[Judged] = []
    for block in printed.blocks.values():
        function = here.functions.get(block.compute)
        if block.name in (known or {}) or function is None or slow or not function.slow:
            data += judge.block(block, (known or {}).get(block.name))
    return Judgement(paper, tuple(data))


def check(results: Results, paper: Paper, functions: Mapping[str, Recompute]) -> None:
    """Raise `PaperError` when a function, an erratum or a reading that the results name does not exist."""
    known = [e.id for e in paper.errata]
    if results.paper != paper.name:
        raise PaperError(results.file, "paper", repr(results.paper), paper.name)
    for block in results.blocks.values():
        if block.compute and block.compute not in functions:
            raise PaperError(
                results.file, f"{block.name}.compute", f"no function {block.compute!r}", f"one of {', '.join(functions)}"
            )
        for unknown in [e for e in block.errata if e not in known]:
            raise PaperError(results.file, f"{block.name}.errata", f"no erratum {unknown!r}", f"one of {', '.join(known)}")
        if block.reading and block.reading not in paper.readings:
            allowed = f"one of {', '.join(paper.readings)}"
            raise PaperError(results.file, f"{block.name}.reading", repr(block.reading), allowed)


class _Judge:
    """Judges block by block; each set of errata is read once, each block computed once under it."""

    def __init__(
        self, tables: Mapping[str, Any], results: Results, file: str, functions: Mapping[str, Recompute], own: Paper,
        warm: bool,
    ) -> None:  # fmt: skip
        self._tables, self._results, self._file, self._functions = tables, results, file, functions
        self._own, self._warm = own, warm
        self._cases: dict[frozenset[str], Case | None] = {}
        self._values: dict[tuple[str, frozenset[str]], dict[str, tuple[str, Value]]] = {}

    def block(self, block: Block, known: Columns | None) -> Iterator[Judged]:
        """All cells of a block."""
        own = frozenset(self._own.reading.errata)
        if known is not None:
            self._values[block.name, own] = _by_path(block, known)
        formula = self._functions[block.compute].formula if block.compute else ""
        missing = tuple(need for need in block.needs if not _printed(need, self._own))
        if missing or block.derived or known is not None:
            read = frozenset(self._own.readings[block.reading].errata) if block.reading else own
            for cell in block.cells:
                printed, value = self._value(block, cell, read) if block.compute else (cell.printed, None)
                verdict = NOT if missing else REPRODUCED if agree(cell, printed, value) else DIFFERS
                yield Judged(block, cell, verdict, (), value, missing, formula)
            return
        for cell in block.cells:
            yield self._searched(block, cell, formula)

    def _searched(self, block: Block, cell: Cell, formula: str) -> Judged:
        for applied in _subsets(self._candidates(block)):
            printed, value = self._value(block, cell, applied)
            if agree(cell, printed, value):
                ids = tuple(e.id for e in self._own.errata if e.id in applied)
                return Judged(block, cell, AFTER if ids else REPRODUCED, ids, value, (), formula)
        _, value = self._value(block, cell, frozenset(self._own.reading.errata))
        return Judged(block, cell, DIFFERS, (), value, (), formula)

    def _candidates(self, block: Block) -> list[str]:
        """Errata that could matter to a block: of the default reading, of its own list, and those that patch it."""
        start = f"results.{block.name}."

        def counts(e: Erratum) -> bool:
            patches = any(p.at.startswith(start) for p in e.patches)
            return patches or e.id in block.errata or e.id in self._own.reading.errata

        return [e.id for e in self._own.errata if counts(e)]

    def _value(self, block: Block, cell: Cell, applied: frozenset[str]) -> tuple[str, Value]:
        """What is printed in a cell once some errata are applied, and the value recomputed with them."""
        key = (block.name, applied)
        if key not in self._values:
            self._values[key] = self._computed(block, applied)
        return self._values[key].get(cell.path, (cell.printed, None))

    def _computed(self, block: Block, applied: frozenset[str]) -> dict[str, tuple[str, Value]]:
        case = self._case(applied)
        if case is None:
            return {}
        here = case.block(block.name)
        try:
            return _by_path(here, self._functions[block.compute].function(case, here))
        except (LwrDynError, ArithmeticError, ValueError):
            return {}  # these tables give no value: no arm, no solution

    def _case(self, applied: frozenset[str]) -> Case | None:
        if applied not in self._cases:
            try:
                errata = [e for e in self._own.errata if e.id in applied]
                self._cases[applied] = case_of(self._tables, self._results, self._file, errata, self._warm)
            except PaperError:
                self._cases[applied] = None  # two of them read one cell
        return self._cases[applied]


def agree(cell: Cell, printed: str, value: Value) -> bool:
    """A value is what is printed: to the digits, within the range of a figure, or as an expression."""
    if value is None:
        return False
    if isinstance(value, Symbolic):
        return value.same
    if cell.span is not None:
        return float(cell.span[0]) <= value <= float(cell.span[1])
    return bool(value == value) and abs(value) < float("inf") and agrees(printed, value)


def _by_path(block: Block, columns: Columns) -> dict[str, tuple[str, Value]]:
    out: dict[str, tuple[str, Value]] = {}
    for column in dict.fromkeys(cell.column for cell in block.cells):
        cells = [c for c in block.cells if c.column == column]
        values = list(_flat(columns[column]))
        if len(values) != len(cells):
            raise ValueError(f"{block.name}.{column}: {len(values)} values for {len(cells)} cells")
        out |= {c.path: (c.printed, _plain(v)) for c, v in zip(cells, values, strict=True)}
    return out


def _plain(value: Any) -> Value:
    return value if value is None or isinstance(value, Symbolic) else float(value)


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


