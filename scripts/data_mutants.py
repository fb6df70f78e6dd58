"""Every numeric cell of the papers' data files changed, one at a time: which changes a verdict notices, which not.

python scripts/data_mutants.py lwr4 --share 40
"""

from __future__ import annotations

import argparse
import random
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))  # for `tests`

from lwr_dyn.reproduction.papers import studies
from tests.reproduction.mutants import Mutant, Survey, mutants, survey

PIECES = 8
"""In which the mutants of a paper are handed to processes."""


def surveyed(paper: str, chosen: list[Mutant], processes: int) -> Survey:
    """The fates of the chosen mutants, on several processes."""
    pieces = [chosen[i::PIECES] for i in range(PIECES)]
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        parts = list(pool.map(survey, [paper] * PIECES, pieces))
    return Survey(tuple(fate for part in parts for fate in part.fates))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("papers", nargs="*", default=list(studies()), help=", ".join(studies()))
    parser.add_argument("--share", type=int, help="so many mutants a paper, drawn at random; all if not given")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    for paper in options.papers:
        chosen = list(mutants(paper))
        if options.share is not None:
            chosen = random.Random(0).sample(chosen, min(options.share, len(chosen)))
        result = surveyed(paper, chosen, options.processes)
        words = ", ".join(f"{count} {seen}" for seen, count in result.counts().items())
        print(f"{paper}: {len(chosen)} mutants, {result.share:.1%} seen ({words}); missed: {len(result.missed)}")
        for fate in result.missed:
            print(
                f"  MISSED {fate.mutant.place} ({fate.mutant.kind}): {fate.mover} moves by {fate.moved:.3g} last digits"
            )
        for column, (count, moved) in result.survivors().items():
            print(f"  not seen: {count:4d} of {column}; moves a number by {moved:.2g} of its last digits at most")


if __name__ == "__main__":
    main()
