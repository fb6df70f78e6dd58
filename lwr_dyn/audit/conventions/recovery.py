"""How often the resolver finds the truth of scrambled tables, counted by what the evidence can tell at all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lwr_dyn.audit.conventions.decidable import open_choices
from lwr_dyn.audit.conventions.resolve import Resolution, resolve
from lwr_dyn.audit.conventions.trials import Trial, same_arm, same_bodies, trial

OUTCOMES = ("recovered", "same arm", "named", "lost")
"""The same inertia parameters to the printed digits (and DH convention); others, but no motion of the arm can show it;
others, with the truth among the readings that the resolver says are left; the truth not even among those."""


@dataclass(frozen=True, slots=True)
class Recovery:
    """Counts of outcomes where the evidence decides, and where it leaves another reading as good as the truth."""

    decided: Mapping[str, int]
    undecidable: Mapping[str, int]
    missed: tuple[int, ...]
    """Numbers of the trials that were decided and not recovered, or left the truth out: `numbered_trial` gives them."""

    @property
    def rate(self) -> float:
        """Share recovered of the tables that the evidence decides."""
        total = sum(self.decided.values())
        return self.decided["recovered"] / total if total else float("nan")

    @property
    def honest(self) -> float:
        """Share of the undecidable tables that are recovered, or whose truth is among the readings said to be left."""
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


def numbered_trial(number: int, seed: int) -> Trial:
    """Trial `number` of a series."""
    return trial(np.random.default_rng([seed, number]))


def recovery(count: int, seed: int = 7) -> Recovery:
    """Trials until `count` of them are decidable.

    >>> recovery(2, seed=1).decided["recovered"]
    2
    """
    decided: Counter[str] = Counter({x: 0 for x in OUTCOMES})
    undecidable: Counter[str] = Counter({x: 0 for x in OUTCOMES})
    missed, number = [], 0
    while sum(decided.values()) < count:
        one = numbered_trial(number, seed)
        found = outcome(one, resolve(one.table, one.evidence))
        clear = not open_choices(one)
        (decided if clear else undecidable)[found] += 1
        if found == "lost" or (clear and found != "recovered"):
            missed.append(number)
        number += 1
    return Recovery(dict(decided), dict(undecidable), tuple(missed))


def outcome(one: Trial, found: Resolution) -> str:
    """One of `OUTCOMES`."""
    best, truth = found.best, one.truth
    if best is None:
        return "lost"
    convention = best.reading.table.convention
    if convention is truth.table.convention and same_bodies(one.table, best.bodies, one.bodies):
        return "recovered"
    left = any(
        c.reading.table == truth.table and all(c.leaves_open(i, x) for i, x in enumerate(truth.links))
        for c in found.both or found.physical
    )
    if not left:
        return "lost"
    return "same arm" if same_arm(one, best.bodies, convention) else "named"
