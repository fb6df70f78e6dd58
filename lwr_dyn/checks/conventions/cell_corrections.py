"""Single wrong cells, where no reading of a table gives the published numbers.

A wrong cell is fitted to the first number that fails, from the flange inward, and to nothing else: whether the numbers
of the joints before it then follow is the test of the correction.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from lwr_dyn.checks.conventions.candidates import fewest_exceptions
from lwr_dyn.checks.conventions.evidence import Evidence
from lwr_dyn.checks.conventions.hypotheses import TableHypothesis, other_ends
from lwr_dyn.checks.conventions.printed_table import CHOICES, CellChange, LinkChoice, PrintedTable, link_options
from lwr_dyn.checks.conventions.search import SearchResult, allowances, fit_numbers
from lwr_dyn.foundation.arrays import Array

GRID = 401
"""Points at which the failing number is computed over a cell's range; its roots are then refined."""
MOST_PARTIAL = 8
"""Sets of options of the links beyond the failing joint that are tried."""
MOST_BEYOND = 3
"""Options of a link beyond the failing one that are tried, of those that no number distinguishes."""
Cell = tuple[str, int, int]
"""Column, link and entry, as in `CellChange`."""


@dataclass(frozen=True, slots=True)
class CellCorrection:
    """A cell with the value fitted to one number, and how many others then follow."""

    cell: CellChange
    fitted_to: str
    low: float
    high: float
    """Range of the value that gives that number to its printed digits."""
    followed: int
    """Numbers of joints nearer the base that are then right: all of them."""
    repeats: str
    """A neighbouring cell of the same column that the printed one repeats; empty where there is none."""
    feasible: bool
    """Every link can be a body with it."""
    exceptions: int
    """Links that are then read otherwise than the rest, in the plainest reading that fits."""

    @property
    def order(self) -> tuple[int, bool, bool, bool, float]:
        """Key of the order of `cell_corrections`, the likeliest first."""
        printed, value = self.cell.printed, self.cell.value
        change = abs(value - printed) / max(abs(printed), abs(value))
        return (self.exceptions, not self.repeats, not self.feasible, value * printed < 0.0, change)


def cell_corrections(
    evidence: Evidence, hypotheses: Sequence[TableHypothesis], searches: Sequence[SearchResult]
) -> tuple[CellCorrection, ...]:
    """Single cells that let some reading give every number, the likeliest first.

    Those that need the fewest exceptions come first, then those whose printed value repeats a neighbour, then those
    that leave every link a body, then the sign that is printed, then the smallest change.
    """
    deepest = max(s.matched for s in searches)
    corrections: dict[tuple[str, float], CellCorrection] = {}
    for hypothesis, search in zip(hypotheses, searches, strict=True):
        if search.matched < deepest or search.sets:
            continue
        for cell, low, high in _roots(hypothesis, search):
            key = (cell.name, round(cell.value, 7))
            if key not in corrections:
                correction = _tried(evidence, hypothesis, search, cell, low, high)
                if correction is not None:
                    corrections[key] = correction
    return tuple(sorted(corrections.values(), key=lambda c: c.order))


def _tried(
    evidence: Evidence, hypothesis: TableHypothesis, search: SearchResult, cell: CellChange, low: float, high: float
) -> CellCorrection | None:
    changed = hypothesis.with_cell(cell, evidence)
    again = fit_numbers(changed.rows, changed.options, changed.everything)
    if not again.sets:
        return None
    feasible = any(all(set(a) & set(b) for a, b in zip(sets, changed.feasible, strict=True)) for sets in again.sets)
    return CellCorrection(
        cell=cell, fitted_to=evidence.outermost_first[search.failed[0]].name, low=low, high=high,
        followed=len(evidence.numbers) - search.matched - len(search.failed),
        repeats=repeated_neighbour(hypothesis.table, cell), feasible=feasible,
        exceptions=min(fewest_exceptions(changed, sets) for sets in again.sets),
    )  # fmt: skip


def repeated_neighbour(table: PrintedTable, cell: CellChange) -> str:
    """A cell of a neighbouring row that prints the same digits but for the last; empty where there is none."""
    if cell.column == "mass" or cell.printed == 0.0:
        return ""
    step = table.com_step if cell.column == "com" else table.inertia_step
    for j in (cell.link + 1, cell.link - 1):
        if 0 <= j < table.n and abs(table.cell(cell.column, j, cell.entry) - cell.printed) <= 10 * step:
            return CellChange(cell.column, j, cell.entry, 0.0, 0.0).name
    return ""


def _roots(h: TableHypothesis, search: SearchResult) -> Iterator[tuple[CellChange, float, float]]:
    """Every cell of the failing link and those beyond it, with the values that give the failing number."""
    number = search.failed[0]
    joint = h.rows.joint[number]
    allowed = float(allowances(h.rows, h.options)[number])
    rows = h.rows.coefficients[h.rows.start[number] : h.rows.start[number + 1]]
    wanted = float(h.rows.value[number])
    adds = rows[:, joint] @ h.options[joint].parameters.T
    _, distinct = np.unique(np.round(adds / allowed, 3), axis=1, return_index=True)
    for sets in search.partial[:MOST_PARTIAL]:
        beyond = np.array([h.options[joint + 1 + k].parameters[o[0]] for k, o in enumerate(sets)]).reshape(-1, 10)
        terms = np.einsum("rlp,lp->rl", rows[:, joint + 1 :], beyond)
        for cell, choice in itertools.product(_cells(joint), CHOICES):
            yield from _cell_roots(h, rows[:, joint], terms.sum(axis=1) - wanted, allowed, cell, choice)
        for k, options in enumerate(sets):
            link = joint + 1 + k
            rest = np.delete(terms, k, axis=1).sum(axis=1)
            choices = [h.options[link].choices[o][0] for o in options[:MOST_BEYOND]]
            for o, choice, cell in itertools.product(distinct, choices, _cells(link)):
                yield from _cell_roots(h, rows[:, link], rest + adds[:, o] - wanted, allowed, cell, choice)


def _cells(link: int) -> list[Cell]:
    return [*(("com", link, k) for k in range(3)), *(("inertia", link, k) for k in range(6)), ("mass", link, 0)]


def _cell_roots(
    h: TableHypothesis, rows: Array, fixed: Array, allowed: float, cell: Cell, choice: LinkChoice
) -> Iterator[tuple[CellChange, float, float]]:
    """Values of a cell at which the largest of `fixed` plus the link's contribution is 0, with their ranges."""
    column, link, entry = cell
    low, high = _range(h.table, column, link, entry)
    nodes = np.array([low, (low + high) / 2, high])
    end = other_ends(h.table, h.choice.convention)[link]
    tables = [h.table.with_cell(column, link, entry, x) for x in nodes]
    samples = np.array([link_options(t, link, h.choice, end, (choice,)).parameters[0] for t in tables])
    bend = np.linalg.solve(np.vander(nodes, 3), samples)  # parameters are quadratic in any one cell

    def gap(x: Array) -> Array:
        largest: Array = (fixed[:, None] + rows @ (np.vander(x, 3) @ bend).T).max(axis=0)
        return largest

    x = np.linspace(low, high, GRID)
    value = gap(x)
    for k in np.flatnonzero(value[:-1] * value[1:] < 0.0):
        root: float = brentq(lambda v: gap(np.array([v]))[0], x[k], x[k + 1], xtol=1e-15)
        half = float(abs(allowed / (value[k + 1] - value[k]) * (x[k + 1] - x[k])))
        least, most = root - half, root + half
        yield CellChange(column, link, entry, h.table.cell(*cell), shortest_between(least, most)), least, most


def shortest_between(low: float, high: float) -> float:
    """The number of fewest decimals in a range.

    >>> shortest_between(-0.02386, -0.02372)
    -0.0238
    """
    for digits in range(16):
        rounded = round((low + high) / 2, digits)
        if low <= rounded <= high:
            return rounded
    return (low + high) / 2


def _range(table: PrintedTable, column: str, link: int, entry: int) -> tuple[float, float]:
    """Bounds of a cell: coms within twice the farthest, moments up to twice the largest, masses up to threefold."""
    if column == "com":
        far = 2.0 * float(np.abs(table.com).max())
        return -far, far
    if column == "mass":
        return 0.0, 3.0 * float(table.mass[link])
    largest = 2.0 * float(np.abs(table.inertia[link]).max())
    return (0.0 if entry < 3 else -largest), largest
