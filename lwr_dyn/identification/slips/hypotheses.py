"""A table with repairs, judged by a log: chi^2, and the evidence that weighs a free value against a stated slip.

With R^T R the precision of the base parameters beta that the log gave, and R in the coordinates in which friction and
unknown parameters have no part, a table with parameters pi misses the log by r = K pi - y, whose covariance is the
identity (the noise) plus K Sigma K^T (`link_discrepancies`). chi^2 = r^T V^-1 r has as many degrees of freedom as K has
directions; freed cells are at their best values in it. A table fits where chi^2 is within chance, and the pull of every
cell, which is how many sigmas off it is if it alone is off, is within that of the largest of so many (Bonferroni): one
cell 6 sigma off is lost in a chi^2 of 50 directions.

    -2 log p = r^T V^-1 r + log det V + 2 ln(COUNT) (repairs + bodies that cannot be)
    V = 1 + K Sigma K^T + sum s^2 u u^T over freed cells

u is the change of r per unit of a freed cell and s the size that its quantity has in the table.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.linalg import qr

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips.printed_cells import Cell, PrintedCells, link_discrepancies
from lwr_dyn.identification.slips.repairs import Repair, SlipKind, repeats

RANK = 1e-9
"""Share of the largest singular value below which a direction is not there."""
CONFIDENCE = 0.999
"""A table whose chi^2, or whose largest pull, is beyond this share of its distribution does not fit."""
COUNT = 500.0
"""How many repairs a table has, by order of magnitude: what a repair, or a body that cannot be, must win."""
WAYS: Mapping[SlipKind, float] = {
    "convention": 20.0, "column": 50.0, "axes": 60.0, "copy": 80.0, "two powers of ten": 5000.0, "unit": 5000.0,
}  # fmt: skip
"""The same for kinds that have fewer, or happen less."""
POSSIBLE = -0.01
"""Least eigenvalue of a body's pseudo-inertia, scaled to a diagonal of 1, that printed digits may leave."""
FREED = ("copy", "value")
"""Kinds of repairs whose value is the log's."""
SHOWN = 1e-6
"""In sigma: a cell whose typical size moves the log by less is shown by no motion."""

Key = tuple[tuple[Cell, ...], str]


@dataclass(frozen=True, slots=True, eq=False)
class LogEvidence:
    """K (r, 11 n) and y (r,), whitened: the noise of K pi - y is 1 in every direction; `deviation` as `trace_slips`."""

    K: Array
    y: Array
    deviation: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "K", "y")

    @property
    def directions(self) -> int:
        """Degrees of freedom of chi^2."""
        return len(self.y)

    def misfit(self, table: PrintedCells) -> Array:
        """r = K pi - y, (r,)."""
        return np.asarray(self.K @ table.parameters() - self.y)

    def limit(self, freed: int = 0) -> float:
        """The largest chi^2 of a table that fits, with that many cells freed."""
        return float(stats.chi2.ppf(CONFIDENCE, max(self.directions - freed, 1)))


def log_evidence(information: Information, table: PrintedCells, deviation: float) -> LogEvidence:
    """The evidence of a log, in the columns of `PrintedCells.parameters`; friction and open parameters are free."""
    own = information.columns.table_indices
    R, grouping = information.factor, information.base.grouping
    opened = np.concatenate([table.open_parameters[:, :10].ravel(), table.open_parameters[:, 10]])
    free = np.concatenate([np.setdiff1d(np.arange(grouping.shape[1]), own), own[opened]])
    blocked = _complement(R @ grouping[:, free])
    K, y = blocked @ R @ grouping[:, own], blocked @ R @ information.values
    K[:, opened] = 0.0
    left, sizes, _ = np.linalg.svd(_unit_columns(K), full_matrices=False)
    seen = left[:, sizes > RANK * sizes[0]]
    return LogEvidence(seen.T @ K, seen.T @ y, deviation)


def _complement(A: Array) -> Array:
    """Rows that span what the columns of A (m, k) do not, (m - rank, m)."""
    Q, R, _ = qr(_unit_columns(A), pivoting=True)
    sizes = np.abs(np.diag(R))
    return np.asarray(Q[:, int(np.sum(sizes > RANK * sizes.max(initial=0.0))) :].T)


def _unit_columns(A: Array) -> Array:
    """The columns that are not 0, scaled to length 1."""
    norms = np.linalg.norm(A, axis=0)
    return np.asarray(A[:, norms > 0.0] / norms[norms > 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """Repairs of a table (none: as printed), the table with them, and how it meets the log."""

    log: LogEvidence = field(repr=False)
    repairs: tuple[Repair, ...]
    table: PrintedCells
    freed: tuple[Cell, ...]
    """Cells whose values are the log's."""
    chi2: float
    evidence: float
    """-2 log p up to a constant: the smallest is the likeliest."""
    parts: Array = field(repr=False)
    """Each link's part of the discrepancy's covariance, K Sigma K^T: (n, r, r)."""

    @property
    def keys(self) -> tuple[Key, ...]:
        """One a repair; the value of a freed cell is not part of it."""
        return tuple((r.cells, "freed" if r.kind in FREED else r.text) for r in self.repairs)

    @property
    def keyed(self) -> Iterable[tuple[Repair, Key]]:
        """Each repair with its key."""
        return zip(self.repairs, self.keys, strict=True)

    @property
    def cells(self) -> set[Cell]:
        """Those that the repairs touch."""
        return {c for r in self.repairs for c in r.cells}

    @property
    def fits(self) -> bool:
        """Whether the table with the repairs meets the log: as a whole, and in every cell."""
        return self.chi2 <= self.log.limit(len(self.freed)) and largest_pull(self).within

    def possible(self, printed: PrintedCells) -> bool:
        """Whether bodies have what the repairs say of links: of those that are some as printed, and of each touched.

        A slip of a whole column may leave a link that is no body, as printed, as it is.
        """
        bad = impossible_links(self.table)
        alone = {c.link for r in self.repairs if len({c.link for c in r.cells}) < printed.n for c in r.cells}
        made = bad & ~impossible_links(printed)
        return not (made.any() or any(bad[i] for i in alone))

    def whitened(self, misfits: Array) -> Array:
        """Misfits (r, ...) that the discrepancy makes white too."""
        return np.asarray(np.linalg.solve(_root(self.parts), misfits))


def as_printed(log: LogEvidence, table: PrintedCells) -> Hypothesis:
    """The table without repairs."""
    nothing = np.zeros((table.n, log.directions, log.directions))
    return _judged(log, (), table, (), _with_parts(log, table, nothing, range(table.n)))


def repaired(before: Hypothesis, repair: Repair) -> Hypothesis:
    """A hypothesis with one repair more; cells that were freed take their best values anew."""
    freed = (*before.freed, *repair.cells) if repair.kind in FREED else before.freed
    parts = _with_parts(before.log, repair.table, before.parts, repair.table.changed_links(before.table))
    return _judged(before.log, (*before.repairs, repair), repair.table, freed, parts)


def _with_parts(log: LogEvidence, table: PrintedCells, parts: Array, links: Iterable[int]) -> Array:
    """The parts with those of some links taken from the table."""
    if log.deviation == 0.0:
        return parts
    out, chosen = parts.copy(), list(links)
    for i, spread in zip(chosen, link_discrepancies(table, log.deviation, chosen), strict=True):
        K = log.K[:, [*range(10 * i, 10 * i + 10), 10 * table.n + i]]
        out[i] = K @ spread @ K.T
    return out


def _root(parts: Array) -> Array:
    """L (r, r) with L L^T = 1 + K Sigma K^T."""
    return np.linalg.cholesky(np.eye(parts.shape[1]) + parts.sum(axis=0))


def _judged(
    log: LogEvidence, repairs: tuple[Repair, ...], table: PrintedCells, freed: tuple[Cell, ...], parts: Array
) -> Hypothesis:
    """The hypothesis, its freed cells at their best values."""
    L = _root(parts)
    weight = 2.0 * float(np.log(np.diag(L)).sum())
    for _ in range(2 if freed else 0):  # the centre of mass enters squared
        U = np.linalg.solve(L, log.K @ table.derivatives(freed))
        values = table.values.copy()
        step = np.linalg.lstsq(U, np.linalg.solve(L, log.misfit(table)), rcond=None)[0]
        np.subtract.at(values, tuple(np.transpose(freed)), step)
        table = table.with_values(values)
    if freed:
        sized = U * table.typical_sizes(freed)
        weight += float(np.linalg.slogdet(np.eye(len(freed)) + sized.T @ sized)[1])
    left = np.linalg.solve(L, log.misfit(table))
    chi2 = float(left @ left)
    weight += 2.0 * np.log(COUNT) * float(impossible_links(table).sum())
    ways = 2.0 * sum(np.log(WAYS.get(r.kind, COUNT)) for r in repairs)
    return Hypothesis(log, repairs, table, freed, chi2, chi2 + weight + ways, parts)


def impossible_links(table: PrintedCells) -> NDArray[np.bool_]:
    """Which links no body can have, beyond what rounding of printed digits explains, (n,)."""
    P = table.pseudo_inertias()
    diagonal = np.einsum("nii->ni", P)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    least = np.linalg.eigvalsh(P * scale[:, :, None] * scale[:, None, :])[:, 0]
    return np.asarray((least < POSSIBLE) | (diagonal < 0.0).any(axis=1))


class FreeCells(NamedTuple):
    """What would follow if one cell alone had another value; arrays have an entry a cell."""

    step: Array
    """To the best value [SI]."""
    sigma: Array
    """Of that value, the arm's own discrepancy in it; infinite where no motion shows the cell."""
    chi2: Array
    """That is left."""


def free_cells(at: Hypothesis, cells: Sequence[Cell]) -> FreeCells:
    """Each cell freed alone, to first order."""
    r, U = at.whitened(at.log.misfit(at.table)), at.whitened(at.log.K @ at.table.derivatives(cells))
    kept = [c for c in at.freed if c not in cells]
    if kept:
        Q = np.linalg.qr(at.whitened(at.log.K @ at.table.derivatives(kept)))[0]
        U = U - Q @ (Q.T @ U)
    length = np.linalg.norm(U, axis=0)
    shown = length * at.table.typical_sizes(cells) > SHOWN
    safe = np.where(shown, length, 1.0)
    along = np.where(shown, U.T @ r / safe, 0.0)
    return FreeCells(-along / safe, np.where(shown, 1.0 / safe, np.inf), float(r @ r) - np.square(along))


class LargestPull(NamedTuple):
    """Of the cell that is furthest off."""

    sigmas: float
    limit: float
    """The most that chance gives in any of the cells (Bonferroni)."""
    cell: Cell | None
    """None where no motion shows any."""

    @property
    def within(self) -> bool:
        """Whether chance explains it."""
        return self.sigmas <= self.limit


def largest_pull(at: Hypothesis) -> LargestPull:
    """Sigmas by which the cell that is furthest off is off, each alone; freed cells do not count.

    References
    ----------
    Dunn, Multiple comparisons among means (1961), for the limit of the largest of several.
    """
    cells = [c for c in at.table.cells if c not in at.freed]
    free = free_cells(at, cells)
    seen = np.isfinite(free.sigma)
    if not seen.any():
        return LargestPull(0.0, np.inf, None)
    pulls = np.where(seen, np.abs(free.step) / free.sigma, 0.0)
    worst = int(np.argmax(pulls))
    limit = stats.norm.isf(0.5 * (1.0 - CONFIDENCE) / np.count_nonzero(seen))
    return LargestPull(float(pulls[worst]), float(limit), cells[worst])


def freed_repair(table: PrintedCells, cell: Cell, value: float) -> Repair:
    """A cell with the log's value; a copy where the printed one repeats its neighbour."""
    other = repeats(table, cell)
    why = "" if other is None else f", which repeats {other.name}"
    text = f"{cell.name} = {table.shown(cell, value)}, printed {table.shown(cell)}{why}"
    again = partial(freed_repair, cell=cell, value=value)
    return Repair("copy" if other else "value", (cell,), text, table.with_cell(cell, value), again)
