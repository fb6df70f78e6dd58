"""The search for repairs: step by step, from several tables at once, the promising ones judged in full."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.slips.exchanges import exchanges
from lwr_dyn.identification.slips.hypotheses import WAYS, Hypothesis, Key, free_cells, freed_repair, repaired
from lwr_dyn.identification.slips.log_evidence import LogEvidence
from lwr_dyn.identification.slips.printed_cells import Cell, PrintedCells, stacked_parameters
from lwr_dyn.identification.slips.repairs import (
    COLUMNS,
    CONVENTION,
    VALUE,
    Repair,
    of_cells,
    of_columns,
    possible,
    repeats,
)
from lwr_dyn.identification.slips.shown_cells import ShownCells

WIDTH = 8
"""Hypotheses that each further repair starts from: half of them the likeliest, half those without a free value."""
LOOKED_AT = 50
"""Repairs that are judged with their own discrepancy, of those that leave the least chi^2 with the former table's."""
SLIP = 3.0
"""A cell of any other value is a slip when it changes by more than this many times the arm's own deviation, as a share
of the largest number of its kind in its link; the arm itself may differ by less. A neighbour's copy is always one."""


def steps(
    evidence: LogEvidence, printed: Hypothesis, shown: ShownCells, most: int
) -> Iterator[list[Hypothesis]]:  # fmt: skip
    """The hypotheses of one repair, of two, ... until one fits well, or one more repair makes none likelier."""
    beam, likeliest = [printed], np.inf
    for _ in range(most):
        found = _next(evidence, beam, shown)
        if not found:
            return
        yield found
        fitting = [h for h in found if fits(evidence, h)]
        if found[0].evidence > likeliest or (fitting and not _hope(evidence, fitting[0])):
            return
        likeliest = found[0].evidence if fitting else likeliest
        beam = _beam(found)


def fits(evidence: LogEvidence, hypothesis: Hypothesis) -> bool:
    """Whether a table with its repairs meets the log."""
    return hypothesis.chi2 <= evidence.limit(len(hypothesis.freed))


def each_once(hypotheses: Iterable[Hypothesis]) -> tuple[Hypothesis, ...]:
    """The likeliest first, those with the same repairs once."""
    kept: dict[frozenset[Key], Hypothesis] = {}
    for hypothesis in sorted(hypotheses, key=lambda h: h.evidence):
        kept.setdefault(frozenset(hypothesis.keys), hypothesis)
    return tuple(kept.values())


def _beam(found: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The likeliest, the likeliest without free values, and the likeliest of each way to read all tensors."""
    stated = [h for h in found if all(r.kind != VALUE for r in h.repairs)]
    ways: dict[tuple[bool, bool], Hypothesis] = {}
    for h in stated:
        ways.setdefault((bool(h.table.about_origin.all()), bool(h.table.integral.sum() > h.table.n // 2)), h)
    return list(dict.fromkeys([*_unlike(found, WIDTH // 2), *_unlike(stated, WIDTH // 2), *ways.values()]))


def _unlike(found: Sequence[Hypothesis], count: int) -> list[Hypothesis]:
    """The likeliest that the log can tell from each other."""
    kept: list[Hypothesis] = []
    for hypothesis in found:
        if not any(abs(h.chi2 - hypothesis.chi2) < 1.0 > abs(h.evidence - hypothesis.evidence) for h in kept):
            kept.append(hypothesis)
        if len(kept) == count:
            break
    return kept


def _next(evidence: LogEvidence, beam: Sequence[Hypothesis], shown: ShownCells) -> list[Hypothesis]:
    """Every hypothesis of the beam with one repair more, the likeliest first, each once."""
    return list(each_once(repaired(evidence, h, repair) for h in beam for repair in _promising(evidence, h, shown)))


def _hope(evidence: LogEvidence, at: Hypothesis) -> bool:
    """Whether some repair more leaves so much less chi^2 that it may be worth it."""
    return bool(_looked_through(evidence, at)[1].min() < at.chi2 - 2.0 * np.log(min(WAYS.values())))


def _looked_through(evidence: LogEvidence, at: Hypothesis) -> tuple[list[Repair], Array]:
    """Every stated repair of a table, and chi^2 with it while the discrepancy stays that of the table."""
    every = (*of_cells(at.table), *of_columns(at.table), *exchanges(at.table))
    parameters = stacked_parameters([r.table for r in every])
    changed = (parameters != at.table.parameters()).any(axis=1)
    kept = [i for i, r in enumerate(every) if changed[i] and possible(r.table, at.table)]
    L = np.linalg.cholesky(np.eye(evidence.directions) + at.parts.sum(axis=0))
    misfits = parameters[kept] @ evidence.K.T - evidence.y
    return [every[i] for i in kept], np.square(np.linalg.solve(L, misfits.T)).sum(axis=0)


def are_slips(evidence: LogEvidence, printed: PrintedCells, hypothesis: Hypothesis) -> bool:
    """Whether every freed cell has changed by more than the arm itself may differ."""
    steps = hypothesis.table.values - printed.values
    return all(abs(steps[c]) > _least_slip(evidence, printed, c) for c in hypothesis.freed)


def _least_slip(evidence: LogEvidence, table: PrintedCells, cell: Cell) -> float:
    if repeats(table, cell):
        return 0.0
    part = next(p for p in COLUMNS.values() if p.start <= cell.quantity < p.stop)
    return SLIP * evidence.deviation * float(np.abs(table.values[cell.link, part]).max())


def _promising(evidence: LogEvidence, at: Hypothesis, shown: ShownCells) -> Iterable[Repair]:
    """The repairs that leave the least chi^2 while the discrepancy stays that of the table before."""
    repairs, chi2 = _looked_through(evidence, at)
    ways = [i for i, r in enumerate(repairs) if r.kind == CONVENTION]
    order = list(dict.fromkeys([*np.argsort(chi2, kind="stable")[:LOOKED_AT], *ways]))
    cells = [c for c in shown.visible if c not in at.freed]
    free = free_cells(evidence, at, cells)
    printed = np.array([at.table.value(c) for c in cells])
    least = np.array([_least_slip(evidence, at.table, c) for c in cells])
    left = np.where(np.abs(free.step) > least, free.chi2, np.inf)
    likely = [i for i in np.argsort(left, kind="stable")[: LOOKED_AT // 2] if np.isfinite(left[i])]
    values = [freed_repair(at.table, cells[i], float(printed[i] + free.step[i])) for i in likely]
    return [*(repairs[i] for i in order), *values]
