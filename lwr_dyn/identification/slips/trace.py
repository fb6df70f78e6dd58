"""Slips of a table traced by a log: the fewest repairs with which the table meets it, and what have the same effect."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips.common_factor import common_factor
from lwr_dyn.identification.slips.hypotheses import FREED, Hypothesis, as_printed, freed_repair, repaired
from lwr_dyn.identification.slips.log_evidence import LogEvidence, log_evidence
from lwr_dyn.identification.slips.printed_cells import Cell, PrintedCells, printed_cells
from lwr_dyn.identification.slips.repairs import Repair
from lwr_dyn.identification.slips.search import are_slips, each_once, fits, steps
from lwr_dyn.identification.slips.shown_cells import ShownCells, shown_cells
from lwr_dyn.model.arm import Arm

DEVIATION = 0.05
"""How far an arm is from a right table of it, unless said otherwise."""
MOST = 8
"""Repairs of one table that are looked for together."""
SAID = 12
"""Explanations that are looked at to the end."""
SAME = 0.1
"""Of two tables whose difference the log shows by less, in sigma, it says the same."""
A_CELL = 0.01
"""In -2 log p: of explanations that are as likely, the one that touches fewer cells comes first."""
DOUBT = 2.0 * np.log(100.0)
"""An explanation that is a hundred times less likely than the best is not one."""


@dataclass(frozen=True, slots=True, eq=False)
class SlipReport:
    """What a log says of the slips of a table."""

    printed: Hypothesis
    """The table as printed."""
    explanations: tuple[Hypothesis, ...]
    """With the fewest repairs, the likeliest first; empty where the table fits as printed, or nothing found does."""
    nearest: Hypothesis
    """The likeliest table of all that were tried."""
    shown: ShownCells
    """What a motion can show of the likeliest explanation's table (of the table as printed, if there is none)."""
    limit: float
    """Largest chi^2 of a table that fits."""
    deviation: float
    common_factor: float | None = None
    """Of all masses and tensors, with which the table as printed meets the log too: then no cell need be wrong."""

    @property
    def fits(self) -> bool:
        """Whether the table meets the log as printed."""
        return self.printed.chi2 <= self.limit

    @property
    def sure(self) -> tuple[Repair, ...]:
        """Repairs that every explanation has."""
        if not self.explanations:
            return ()
        common = set.intersection(*(set(e.keys) for e in self.explanations))
        first = self.explanations[0]
        return tuple(r for r, key in zip(first.repairs, first.keys, strict=True) if key in common)

    @property
    def alternatives(self) -> tuple[tuple[Repair, ...], ...]:
        """What each explanation has beside `sure`, the likeliest first: the log cannot say which of them is right.

        Empty where there is one explanation only.
        """
        if len(self.explanations) < 2:
            return ()
        common = set.intersection(*(set(e.keys) for e in self.explanations))
        return tuple(
            tuple(r for r, key in zip(e.repairs, e.keys, strict=True) if key not in common) for e in self.explanations
        )

    @property
    def cells(self) -> tuple[Cell, ...]:
        """Every cell that some explanation touches."""
        return tuple(dict.fromkeys(c for e in self.explanations for r in e.repairs for c in r.cells))


def trace_slips(
    information: Information, source: Paper | Arm, *, deviation: float = DEVIATION, most: int = MOST
) -> SlipReport:  # fmt: skip
    """The slips of a table that a log shows.

    Repairs are tried one after the other, each on the likeliest tables of the step before, until a table fits; the
    answer holds the explanations with the fewest repairs. A stated slip (a sign, an exchange) is likelier than a cell
    of just any value, which is tried too.

    Parameters
    ----------
    information : Information
        What the log says of the base parameters of the arm's geometry.
    source : Paper or Arm
        The table: a paper under its reading, or an arm whose bodies are taken as printed.
    deviation : float
        How far the arm itself may be from a right table, as a share (0.05: 5 %).
    most : int
        Repairs of one table, at most.

    Raises
    ------
    OptionError
        A deviation outside 0 to 1, or a source without inertias.
    """
    return trace_cells(information, printed_cells(source), deviation=deviation, most=most)


def trace_cells(
    information: Information, table: PrintedCells, *, deviation: float = DEVIATION, most: int = MOST
) -> SlipReport:  # fmt: skip
    """`trace_slips` of a table that has been read."""
    evidence = log_evidence(information, table, checked_deviation(deviation))
    printed = as_printed(evidence, table)
    shown = shown_cells(information, table)
    tried: list[Hypothesis] = [printed]
    if printed.chi2 > evidence.limit():
        for found in steps(evidence, printed, shown, most):
            tried += found
    best = min(tried, key=lambda h: h.evidence)
    meeting = [h for h in tried if h.repairs and fits(evidence, h) and are_slips(evidence, table, h)]
    fitting = sorted(meeting, key=lambda h: h.evidence)
    near = [h for h in fitting if h.evidence <= fitting[0].evidence + DOUBT][:SAID]
    likely = [_without_idle(evidence, printed, h) for h in near]
    seen = {h.table.about_origin.tobytes(): h.table for h in likely}
    same = {key: shown_cells(information, each) for key, each in seen.items()}
    partners = [p for h in likely for p in _partners(evidence, printed, h, same[h.table.about_origin.tobytes()])]
    every = each_once([*likely, *partners])
    believed = [h for h in every if fits(evidence, h) and h.evidence <= every[0].evidence + DOUBT]
    plain: list[Hypothesis] = []
    for h in sorted(believed, key=_order):
        if not any(_says_less(evidence, h, other) for other in plain):
            plain.append(h)
    explained = tuple(_with_values(h, table) for h in sorted(plain, key=lambda h: h.evidence))
    if explained:
        shown = shown_cells(information, explained[0].table)
    limit = evidence.limit()
    factor = None if printed.chi2 <= limit else common_factor(evidence, printed)
    return SlipReport(printed, explained, best, shown, limit, deviation, factor)


def _says_less(evidence: LogEvidence, one: Hypothesis, other: Hypothesis) -> bool:
    """Whether one explanation frees a cell that the other, likelier one states, or says the same of the same cells."""
    if len(one.repairs) != len(other.repairs):
        return False
    if len(one.freed) != len(other.freed):
        return len(one.freed) > len(other.freed) and _cells(one) == _cells(other)
    same = np.linalg.norm(evidence.misfit(one.table) - evidence.misfit(other.table)) < SAME
    return bool(same and (_cells(other) <= _cells(one) or _cells(one) <= _cells(other)))


def _order(hypothesis: Hypothesis) -> tuple[int, float]:
    """Stated slips before free values, the likeliest first, of fewer cells where as likely."""
    return len(hypothesis.freed), hypothesis.evidence + A_CELL * sum(len(r.cells) for r in hypothesis.repairs)


def _cells(hypothesis: Hypothesis) -> set[Cell]:
    return {c for r in hypothesis.repairs for c in r.cells}


def _with_values(hypothesis: Hypothesis, printed: PrintedCells) -> Hypothesis:
    """The hypothesis that says the values its freed cells have at the end."""
    said = tuple(
        freed_repair(printed, r.cells[0], hypothesis.table.value(r.cells[0])) if r.kind in FREED else r
        for r in hypothesis.repairs
    )
    return replace(hypothesis, repairs=said)


def checked_deviation(deviation: float) -> float:
    """A deviation from 0 to 1; else raises `OptionError`."""
    if not (isfinite(deviation) and 0.0 <= deviation < 1.0):
        raise OptionError("deviation", deviation, "a share from 0 to below 1, such as 0.05 for 5 %")
    return deviation


def _without_idle(evidence: LogEvidence, printed: Hypothesis, hypothesis: Hypothesis) -> Hypothesis:
    """The hypothesis without repairs that make it no likelier."""
    for k in range(len(hypothesis.repairs)):
        if len(hypothesis.repairs) == 1:
            break
        rest, table = [r for i, r in enumerate(hypothesis.repairs) if i != k], printed
        for repair in rest:
            table = repaired(evidence, table, repair.again(table.table))
        if table.evidence < hypothesis.evidence:
            return _without_idle(evidence, printed, table)
    return hypothesis


def _partners(
    evidence: LogEvidence, printed: Hypothesis, hypothesis: Hypothesis, shown: ShownCells
) -> Iterator[Hypothesis]:  # fmt: skip
    """The hypothesis with a freed cell's place taken by a cell that no motion distinguishes from it."""
    for k, repair in enumerate(hypothesis.repairs):
        others = [c for c in shown.like(repair.cells[0]) if c not in repair.cells] if repair.kind in FREED else []
        for cell in others:
            table = printed
            for i, each in enumerate(hypothesis.repairs):
                free = freed_repair(table.table, cell, table.table.value(cell)) if i == k else None
                table = repaired(evidence, table, free or each.again(table.table))
            yield table
