"""How often the true reading of scrambled tables is recovered, apart for tables whose evidence decides it or not."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.conventions.ranking import RankedReadings, rank_readings
from tests.checks.conventions.identifiable import open_choices
from tests.checks.conventions.scrambled_tables import ScrambledTable, same_arm, same_bodies, scrambled_table

OUTCOMES = ("recovered", "same arm", "named", "lost")
"""The same inertial parameters to the printed digits (and DH convention); others, but no motion of the arm differs;
others, with the truth among the readings that are left; the truth not among those."""


@dataclass(frozen=True, slots=True)
class Recovery:
    """Counts of outcomes where the evidence decides, and where it leaves another reading as good as the truth."""

    decided: Mapping[str, int]
    undecidable: Mapping[str, int]
    missed: tuple[int, ...]
    """Numbers of the tables that are decided and not recovered, or that left the truth out; see `numbered_table`."""

    @property
    def rate(self) -> float:
        """Share recovered of the tables that the evidence decides."""
        total = sum(self.decided.values())
        return self.decided["recovered"] / total if total else float("nan")

    @property
    def kept_or_recovered(self) -> float:
        """Share of the undecidable tables that are recovered, or whose truth is among the readings that are left."""
        total = sum(self.undecidable.values())
        return 1.0 - self.undecidable["lost"] / total if total else float("nan")

    def statement(self) -> str:
        """Both shares in one sentence."""
        sums = [sum(x.values()) for x in (self.decided, self.undecidable)]
        return (
            f"{self.decided['recovered']} of {sums[0]} decidable tables recovered ({self.rate:.1%}); of {sums[1]} more "
            f"that no evidence decides {self.undecidable['recovered']} recovered as the plainest reading, "
            f"{self.undecidable['same arm'] + self.undecidable['named']} with the truth named among those left, "
            f"{self.undecidable['lost']} lost"
        )


def numbered_table(number: int, seed: int) -> ScrambledTable:
    """Table `number` of a series."""
    return scrambled_table(np.random.default_rng([seed, number]))


def recovery(count: int, seed: int = 7) -> Recovery:
    """Counts over so many tables that `count` of them are decidable."""
    decided: Counter[str] = Counter({x: 0 for x in OUTCOMES})
    undecidable: Counter[str] = Counter({x: 0 for x in OUTCOMES})
    missed, number = [], 0
    while sum(decided.values()) < count:
        one = numbered_table(number, seed)
        found = outcome(one, rank_readings(one.table, one.evidence))
        clear = not open_choices(one)
        (decided if clear else undecidable)[found] += 1
        if found == "lost" or (clear and found != "recovered"):
            missed.append(number)
        number += 1
    return Recovery(dict(decided), dict(undecidable), tuple(missed))


def outcome(one: ScrambledTable, found: RankedReadings) -> str:
    """One of `OUTCOMES`."""
    best, truth = found.best, one.truth
    if best is None:
        return "lost"
    convention = best.reading.table.convention
    if convention is truth.table.convention and same_bodies(one.table, best.bodies, one.bodies):
        return "recovered"
    left = any(
        c.reading.table == truth.table
        and all(any(x in equal for equal in c.remaining[i]) for i, x in enumerate(truth.links))
        for c in found.both or found.physical
    )
    if not left:
        return "lost"
    return "same arm" if same_arm(one, best.bodies, convention) else "named"
