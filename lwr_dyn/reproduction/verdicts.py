"""Every printed number with its verdict: recomputed without errata, then with the fewest that explain it.

reproduced                  recomputed to the printed digits from what is printed
after erratum               so with the named errata, and with no smaller set of them
differs                     by D, with every set of errata that can affect it
under assumed conditions    something that it needs is not printed, is named, and was assumed; near or not
not reproducible            so, and nothing can be computed without it
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.reproduction.compare import VERDICTS, BlockComparer, Columns, ComparedNumber
from lwr_dyn.reproduction.paper_study import PaperStudy


@dataclass(frozen=True, slots=True, eq=False)
class Verdicts:
    """All numbers of a paper with their verdicts."""

    paper: str
    numbers: tuple[ComparedNumber, ...]

    def counts(self, derived: bool = False) -> dict[str, int]:
        """How many of the printed (or derived) numbers have which verdict."""
        counted = Counter(number.verdict for number in self.numbers if number.block.derived == derived)
        return {verdict: counted[verdict] for verdict in VERDICTS}

    def by_cell(self) -> dict[str, tuple[str, tuple[str, ...]]]:
        """Path of a cell -> its verdict and the errata that it takes."""
        return {number.cell.path: (number.verdict, number.errata) for number in self.numbers}


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
        Name of a block -> columns of values that were computed elsewhere, under the default reading.
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
