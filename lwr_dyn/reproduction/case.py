"""A case: one paper's tables and printed results under one set of errata, from which formulas recompute numbers."""

import copy
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.errata import apply_errata, apply_patch
from lwr_dyn.arms.papers.reader import paper_of_tables
from lwr_dyn.arms.papers.schema import Erratum, Paper
from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.results import ResultBlock, Results, results_of_tables


@dataclass(frozen=True, slots=True)
class ComparedExpression:
    """A printed expression beside ours: ours as text, and whether both are the same for all values of the symbols."""

    text: str
    same: bool


Value = float | ComparedExpression | None
"""Of one cell, in its printed unit; None without a value."""


@dataclass(frozen=True, eq=False)
class PaperCase:
    """A paper's tables and results with exactly the errata `applied`; paper and arm are built when first used."""

    tables: Mapping[str, Any]
    results: Results
    file: str
    applied: frozenset[str]
    from_known_maxima: bool = False
    """Global searches only look where they ended for the package's own tables: for comparing hundreds of tables."""

    @cached_property
    def paper(self) -> Paper:
        """The data file as read; raises `PaperError` when it cannot be without some erratum."""
        return paper_of_tables(dict(self.tables), self.file, errata_read=())

    @cached_property
    def arm(self) -> Arm:
        """The arm; raises as `paper`."""
        return arm_from_paper(self.paper)

    @cached_property
    def geometry(self) -> Paper:
        """The data file without its masses and rotors; raises as `paper`."""
        return paper_of_tables(self.bare, self.file, errata_read=())

    @property
    def bare(self) -> dict[str, Any]:
        """The tables without masses and rotors."""
        return {name: table for name, table in self.tables.items() if name not in ("inertial", "rotors")}

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.tables["joints"]["kinds"])

    def values(self, table: str, column: str) -> list[Any]:
        """A column's values as printed, errata applied."""
        return list(self.tables[table][column]["values"])

    def block(self, name: str) -> ResultBlock:
        """A block of the results."""
        return self.results.blocks[name]

    @property
    def printed(self) -> dict[str, Mapping[str, Any]]:
        """Block -> its cells and the values printed beside them, by name."""
        return {name: block.printed for name, block in self.results.blocks.items()}

    def numbers(self, block: str, name: str) -> list[float]:
        """A printed column, or a list that is printed beside it, as numbers."""
        return [float(x) for x in self.results.blocks[block].printed[name]]


BASES = COMPUTED, STRUCTURAL, REPEATED = ("computed", "structural", "repeated in print")
"""What a recomputed number rests on, see `basis`."""
Recompute = Callable[[PaperCase, ResultBlock], Mapping[str, Any]]
"""Column -> a value per cell, nested as the cells are; the first line of its docstring is its formula in words."""


@dataclass(frozen=True, slots=True)
class PaperFormula:
    """A function that recomputes the numbers of a block."""

    function: Recompute
    slow: bool = False
    """Takes a simulation or symbolic algebra: left out where hundreds of tables are compared."""
    basis: str = ""
    """What its numbers rest on, where the experiment of `basis` cannot tell: simulations, algebra with letters, inputs
    outside the data file, counts and places that may be 1."""

    @property
    def formula(self) -> str:
        """The first line of its docstring: what it computes."""
        return (self.function.__doc__ or "").strip().splitlines()[0]


def formulas(*functions: Recompute, slow: bool = False, basis: str = "") -> dict[str, PaperFormula]:
    """Functions by their names, the `compute` of `results.toml`; `basis` as in `PaperFormula`."""
    return {function.__name__: PaperFormula(function, slow, basis) for function in functions}


@dataclass(frozen=True, eq=False)
class PaperData:
    """A paper's data file and printed results as they stand; cases of them are computed with chosen errata."""

    tables: Mapping[str, Any]
    """The data file as parsed."""
    results: Results
    file: str
    """Name of the data file, for messages."""

    @cached_property
    def paper(self) -> Paper:
        """The data file as read under its default reading; raises `PaperError`."""
        return paper_of_tables(dict(self.tables), self.file)

    @property
    def errata(self) -> tuple[Erratum, ...]:
        """Every erratum that the data file names; raises `PaperError`."""
        return self.paper.errata

    def case(self, *errata: str, from_known_maxima: bool = False) -> PaperCase:
        """The case with exactly these errata (ids); raises `PaperError` when a patch finds another printed value."""
        applied = [e for e in self.errata if e.id in errata]
        tables = copy.deepcopy(dict(self.tables))
        apply_errata(tables, tuple(applied), self.file)
        ids = frozenset(e.id for e in applied)
        return PaperCase(tables, patched_results(self.results, applied), self.file, ids, from_known_maxima)

    def reading(self, name: str = "", *more: str) -> PaperCase:
        """The case of a reading (the default one if not named) and of further errata."""
        read = self.paper.readings[name] if name else self.paper.reading
        return self.case(*read.errata, *more)


def patched_results(results: Results, applied: Collection[Erratum]) -> Results:
    """The printed results with errata applied; raises `PaperError` when a patch finds another printed value."""
    if not any(e.of_results() for e in applied):
        return results
    raw = copy.deepcopy(dict(results.raw))
    blocks = {name: block for name, block in raw.items() if isinstance(block, dict)}
    printed = {name: block.get("given", {}) | block["cells"] for name, block in blocks.items()}
    for erratum in applied:
        for patch in erratum.of_results():
            apply_patch({"results": printed}, patch, erratum.id, results.file)
    for name, block in blocks.items():
        for part in (block["cells"], block.get("given", {})):
            part |= {key: printed[name][key] for key in part}
    return results_of_tables(raw, results.file)
