"""Every printed number judged: recomputed without errata, then with as few as it takes.

reproduced          recomputed to the printed digits from what is printed
after erratum       so with the errata named, and with no smaller set of them
differs             by D, with every set of errata that could matter
not reproducible    what it takes is not printed; what is missing is named
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lwr_dyn.errors import PaperError
from lwr_dyn.papers.reader import paper_of_tables
from lwr_dyn.papers.schema import Paper
from lwr_dyn.reproduction.case import PaperFormula
from lwr_dyn.reproduction.compare import VERDICTS, BlockComparer, Columns, ComparedNumber
from lwr_dyn.reproduction.results import Results, results_of_tables
from lwr_dyn.reproduction.rooms import room


@dataclass(frozen=True, slots=True, eq=False)
class Verdicts:
    """All numbers of a paper with their verdicts."""

    paper: str
    data: tuple[ComparedNumber, ...]

    def counts(self, derived: bool = False) -> dict[str, int]:
        """How many of the printed (or derived) numbers have which verdict."""
        found = Counter(j.verdict for j in self.data if j.block.derived == derived)
        return {verdict: found[verdict] for verdict in VERDICTS}

    def keys(self) -> dict[str, tuple[str, tuple[str, ...]]]:
        """PrintedCell -> verdict and errata: what a change of the data may turn."""
        return {j.cell.path: (j.verdict, j.errata) for j in self.data}


def compare_numbers(
    paper: str,
    tables: Mapping[str, Any] | None = None,
    results: Mapping[str, Any] | None = None,
    *,
    slow: bool = False,
    known: Mapping[str, Columns] | None = None,
    warm: bool | None = None,
) -> Verdicts:
    """BlockComparer every number of a paper.

    Parameters
    ----------
    paper : str
        One of `rooms.PAPERS`.
    tables, results : dict, optional
        Its data file and its `results.toml`, parsed; those of the package if not given. They are left as they are.
    slow : bool
        Also what needs simulations or algebra with letters.
    known : dict, optional
        ResultBlock -> columns of values that were computed elsewhere, under the default reading.
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
    judge = BlockComparer(table, printed, here.file, here.functions, own, tables is not None if warm is None else warm)
    data: list[ComparedNumber] = []
    for block in printed.blocks.values():
        function = here.functions.get(block.compute)
        if block.name in (known or {}) or function is None or slow or not function.slow:
            data += judge.block(block, (known or {}).get(block.name))
    return Verdicts(paper, tuple(data))


def check(results: Results, paper: Paper, functions: Mapping[str, PaperFormula]) -> None:
    """Raise `PaperError` when a function, an erratum or a reading that the results name does not exist."""
    known = [e.id for e in paper.errata]
    if results.paper != paper.name:
        raise PaperError(results.file, "paper", repr(results.paper), paper.name)
    for block in results.blocks.values():
        if block.compute and block.compute not in functions:
            raise PaperError(
                results.file,
                f"{block.name}.compute",
                f"no function {block.compute!r}",
                f"one of {', '.join(functions)}",
            )
        for unknown in [e for e in block.errata if e not in known]:
            raise PaperError(
                results.file, f"{block.name}.errata", f"no erratum {unknown!r}", f"one of {', '.join(known)}"
            )
        if block.reading and block.reading not in paper.readings:
            allowed = f"one of {', '.join(paper.readings)}"
            raise PaperError(results.file, f"{block.name}.reading", repr(block.reading), allowed)
