"""Slips of a table traced by a log: the fewest repairs with which the table meets it, and what have the same effect.

The search goes step by step, from several tables at once, the promising repairs judged in full. Where one factor on all
bodies meets the log too, the arm may be heavier than its table, or the torques are off, and no cell is wrong; a search
for slips would still blame the cell that bends the table the right way.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from operator import attrgetter

import numpy as np

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips import hypotheses, printed_cells
from lwr_dyn.identification.slips.hypotheses import Hypothesis, Key, LargestPull, freed_repair
from lwr_dyn.identification.slips.printed_cells import Cell, PrintedCells, ShownCells
from lwr_dyn.identification.slips.repairs import Repair, exchanges, of_cells, of_columns, possible, repeats
from lwr_dyn.model.arm import Arm

_evidence = attrgetter("evidence")
LARGEST = 3.0
"""Factor, or its inverse, beyond which it is a unit, which is a slip."""


def common_factor(printed: Hypothesis) -> float | None:
    """The factor of all masses and tensors with which the table as printed meets a log; None where none does.

    To first order in the discrepancy, which is taken at the table as printed.
    """
    log, values = printed.log, printed.table.values.copy()
    values[:, printed_cells.MASS] *= 2.0
    values[:, printed_cells.TENSOR] *= 2.0
    left = printed.whitened(log.misfit(printed.table))
    change = printed.whitened(log.misfit(printed.table.with_values(values))) - left  # of one table more
    best = -float(change @ left) / float(change @ change)
    factor, chi2 = 1.0 + best, float(np.square(left + best * change).sum())
    return factor if 1.0 / LARGEST < factor < LARGEST and chi2 <= log.limit(1) else None


WIDTH = 8
"""Hypotheses that each further repair starts from: half of them the likeliest, half those without a free value."""
LOOKED_AT = 50
"""Repairs that are judged with their own discrepancy, of those that leave the least chi^2 with the former table's."""
SLIP = 3.0
"""A cell of any other value is a slip when it changes by more than this many times the arm's own deviation, as a share
of the largest number of its kind in its link; the arm itself may differ by less. A neighbour's copy is always one."""


def steps(printed: Hypothesis, shown: ShownCells, most: int) -> Iterator[tuple[Hypothesis, ...]]:
    """The hypotheses of one repair, of two, ... until one fits well, or one more repair makes none likelier."""
    beam, likeliest = [printed], np.inf
    for _ in range(most):
        found = each_once(hypotheses.repaired(h, repair) for h in beam for repair in _promising(h, shown))
        if not found:
            return
        yield found
        fitting = [h for h in found if h.fits]
        if found[0].evidence > likeliest or (fitting and not _hope(fitting[0])):
            return
        likeliest = found[0].evidence if fitting else likeliest
        beam = _beam(found)


def each_once(several: Iterable[Hypothesis]) -> tuple[Hypothesis, ...]:
    """The likeliest first, those with the same repairs once."""
    kept: dict[frozenset[Key], Hypothesis] = {}
    for hypothesis in sorted(several, key=_evidence):
        kept.setdefault(frozenset(hypothesis.keys), hypothesis)
    return tuple(kept.values())


def _beam(found: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The likeliest, the likeliest without free values, and the likeliest of each way to read all tensors."""
    stated = [h for h in found if all(r.kind != "value" for r in h.repairs)]
    ways: dict[tuple[bool, bool], Hypothesis] = {}
    for h in stated:
        ways.setdefault((bool(h.table.about_origin.all()), bool(h.table.integral.sum() > h.table.n // 2)), h)
    return list(dict.fromkeys([*_unlike(found, WIDTH // 2), *_unlike(stated, WIDTH // 2), *ways.values()]))


def _unlike(found: Sequence[Hypothesis], count: int) -> list[Hypothesis]:
    """The likeliest that the log can tell from each other."""
    kept: list[Hypothesis] = []
    for one in found:
        if len(kept) < count and not any(abs(h.chi2 - one.chi2) < 1.0 > abs(h.evidence - one.evidence) for h in kept):
            kept.append(one)
    return kept


def _hope(at: Hypothesis) -> bool:
    """Whether some repair more leaves so much less chi^2 that it may be worth it."""
    return bool(_looked_through(at)[1].min() < at.chi2 - 2.0 * np.log(min(hypotheses.WAYS.values())))


def _looked_through(at: Hypothesis) -> tuple[list[Repair], Array]:
    """Every stated repair of a table, and chi^2 with it while the discrepancy stays that of the table."""
    every = (*of_cells(at.table), *of_columns(at.table), *exchanges(at.table))
    parameters = printed_cells.stacked_parameters([r.table for r in every])
    changed = (parameters != at.table.parameters()).any(axis=1)
    kept = [i for i, r in enumerate(every) if changed[i] and possible(r.table, at.table)]
    misfits = parameters[kept] @ at.log.K.T - at.log.y
    return [every[i] for i in kept], np.square(at.whitened(misfits.T)).sum(axis=0)


def are_slips(hypothesis: Hypothesis, printed: PrintedCells) -> bool:
    """Whether every freed cell has changed by more than the arm itself may differ."""
    steps, deviation = hypothesis.table.values - printed.values, hypothesis.log.deviation
    return all(abs(steps[c]) > _least_slip(printed, c, deviation) for c in hypothesis.freed)


def _least_slip(table: PrintedCells, cell: Cell, deviation: float) -> float:
    if repeats(table, cell):
        return 0.0
    return SLIP * deviation * float(np.abs(table.values[cell.link, printed_cells.COLUMNS[cell.column]]).max())


def _promising(at: Hypothesis, shown: ShownCells) -> Iterable[Repair]:
    """The repairs that leave the least chi^2 while the discrepancy stays that of the table before."""
    repairs, chi2 = _looked_through(at)
    ways = [i for i, r in enumerate(repairs) if r.kind == "convention"]
    order = list(dict.fromkeys([*np.argsort(chi2, kind="stable")[:LOOKED_AT], *ways]))
    cells = [c for c in shown.visible if c not in at.freed]
    free = hypotheses.free_cells(at, cells)
    printed = np.array([at.table.value(c) for c in cells])
    least = np.array([_least_slip(at.table, c, at.log.deviation) for c in cells])
    left = np.where(np.abs(free.step) > least, free.chi2, np.inf)
    likely = [i for i in np.argsort(left, kind="stable")[: LOOKED_AT // 2] if np.isfinite(left[i])]
    values = [freed_repair(at.table, cells[i], float(printed[i] + free.step[i])) for i in likely]
    return [*(repairs[i] for i in order), *values]


DEVIATION = 0.05
"""How far an arm is from a right table of it, unless said otherwise."""
CLOSER = (0.02, 0.01, 0.005)
"""Smaller deviations with which the table that a search ends with is held against the log once more."""
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
    pull: LargestPull
    """Of the cell of the table as printed that is furthest off, if it alone is."""
    closer: float | None = None
    """The largest of `CLOSER` with which the table that this ends with would not meet the log: there is more to find,
    if the arm is so near to a right table. None if that table meets the log with all of them."""
    common_factor: float | None = None
    """Of all masses and tensors, with which the table as printed meets the log too: then no cell need be wrong."""

    @property
    def fits(self) -> bool:
        """Whether the table meets the log as printed: as a whole, and in every cell."""
        return self.printed.chi2 <= self.limit and self.pull.within

    @property
    def sure(self) -> tuple[Repair, ...]:
        """Repairs that every explanation has."""
        others = [set(e.keys) for e in self.explanations]
        return tuple(r for e in self.explanations[:1] for r, key in e.keyed if all(key in keys for keys in others))

    @property
    def cells(self) -> tuple[Cell, ...]:
        """Every cell that some explanation touches."""
        return tuple(dict.fromkeys(c for e in self.explanations for r in e.repairs for c in r.cells))


def trace_slips(
    information: Information, source: Paper | Arm, *, deviation: float = DEVIATION, most: int = MOST
) -> SlipReport:  # fmt: skip
    """The slips of a table that a log shows.

    Repairs are tried one after the other, each on the likeliest tables of the step before, until a table fits; the
    answer holds the explanations with the fewest repairs, none of which makes a link that no body can be. A stated slip
    (a sign, an exchange) is likelier than a cell of just any value, which is tried too.

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
    return trace_cells(information, printed_cells.printed_cells(source), deviation=deviation, most=most)


def trace_cells(
    information: Information, table: PrintedCells, *, deviation: float = DEVIATION, most: int = MOST
) -> SlipReport:  # fmt: skip
    """`trace_slips` of a table that has been read."""
    printed = hypotheses.as_printed(hypotheses.log_evidence(information, table, checked_deviation(deviation)), table)
    shown = printed_cells.shown_cells(information, table)
    tried = [printed]
    if not printed.fits:
        for found in steps(printed, shown, most):
            tried += found
    tried = [h for h in tried if not h.repairs or h.possible(table)]
    meeting = sorted((h for h in tried if h.repairs and h.fits and are_slips(h, table)), key=_evidence)
    likely = [_without_idle(printed, h) for h in meeting if h.evidence <= meeting[0].evidence + DOUBT][:SAID]
    tables = {h.table.about_origin.tobytes(): h.table for h in likely}
    same = {key: printed_cells.shown_cells(information, each) for key, each in tables.items()}
    partners = [p for h in likely for p in _partners(printed, h, same[h.table.about_origin.tobytes()])]
    every = each_once([*likely, *partners])
    believed = [h for h in every if h.evidence <= every[0].evidence + DOUBT and h.possible(table) and h.fits]
    plain: list[Hypothesis] = []
    for h in sorted(believed, key=_order):
        if not any(_says_less(h, other) for other in plain):
            plain.append(h)
    explained = tuple(_with_values(h, table) for h in sorted(plain, key=_evidence))
    if explained:
        shown = printed_cells.shown_cells(information, explained[0].table)
    factor, pull = None if printed.fits else common_factor(printed), hypotheses.largest_pull(printed)
    nearest, limit = min(tried, key=_evidence), printed.log.limit()
    best = explained[0].table if explained else table
    nearer = _closer(information, best, deviation) if explained or printed.fits else None
    return SlipReport(printed, explained, nearest, shown, limit, deviation, pull, nearer, factor)


def _closer(information: Information, table: PrintedCells, deviation: float) -> float | None:
    for share in CLOSER:
        if share < deviation:
            at = hypotheses.as_printed(hypotheses.log_evidence(information, table, share), table)
            if not at.fits:
                return share
    return None


def _says_less(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether one explanation frees a cell that the other, likelier one states, or says the same of the same cells."""
    if len(one.repairs) != len(other.repairs):
        return False
    if len(one.freed) != len(other.freed):
        return len(one.freed) > len(other.freed) and one.cells == other.cells
    same = np.linalg.norm(one.log.misfit(one.table) - one.log.misfit(other.table)) < SAME
    return bool(same and (other.cells <= one.cells or one.cells <= other.cells))


def _order(hypothesis: Hypothesis) -> tuple[int, float]:
    """Stated slips before free values, the likeliest first, of fewer cells where as likely."""
    return len(hypothesis.freed), hypothesis.evidence + A_CELL * sum(len(r.cells) for r in hypothesis.repairs)


def _with_values(hypothesis: Hypothesis, printed: PrintedCells) -> Hypothesis:
    """The hypothesis that says the values its freed cells have at the end."""
    said = tuple(
        freed_repair(printed, r.cells[0], hypothesis.table.value(r.cells[0])) if r.kind in hypotheses.FREED else r
        for r in hypothesis.repairs
    )
    return replace(hypothesis, repairs=said)


def checked_deviation(deviation: float) -> float:
    """A deviation from 0 to 1; else raises `OptionError`."""
    if not (isfinite(deviation) and 0.0 <= deviation < 1.0):
        raise OptionError("deviation", deviation, "a share from 0 to below 1, such as 0.05 for 5 %")
    return deviation


def _redone(printed: Hypothesis, changes: Iterable[Callable[[PrintedCells], Repair]]) -> Hypothesis:
    for change in changes:
        printed = hypotheses.repaired(printed, change(printed.table))
    return printed


def _without_idle(printed: Hypothesis, hypothesis: Hypothesis) -> Hypothesis:
    """The hypothesis without repairs that make it no likelier."""
    changes = [r.again for r in hypothesis.repairs]
    for k in range(len(changes) if len(changes) > 1 else 0):
        fewer = _redone(printed, changes[:k] + changes[k + 1 :])
        if fewer.evidence < hypothesis.evidence:
            return _without_idle(printed, fewer)
    return hypothesis


def _partners(printed: Hypothesis, hypothesis: Hypothesis, shown: ShownCells) -> Iterator[Hypothesis]:
    """The hypothesis with a freed cell's place taken by a cell that no motion distinguishes from it."""
    changes = [r.again for r in hypothesis.repairs]
    for k, repair in enumerate(hypothesis.repairs):
        for cell in shown.like(repair.cells[0]) if repair.kind in hypotheses.FREED else ():
            if cell not in repair.cells:

                def free(table: PrintedCells, cell: Cell = cell) -> Repair:
                    return freed_repair(table, cell, table.value(cell))

                yield _redone(printed, [*changes[:k], free, *changes[k + 1 :]])
