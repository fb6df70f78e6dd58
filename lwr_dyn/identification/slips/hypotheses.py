"""A table with repairs, judged by a log: chi^2, and the evidence that weighs a free value against a stated slip.

    -2 log p = r^T V^-1 r + log det V + 2 ln(COUNT) (repairs + bodies that cannot be)
    V = 1 + K Sigma K^T + sum s^2 u u^T over freed cells

u is the change of r per unit of a freed cell and s the size that its quantity has in the table; chi^2 itself has the
freed cells at their best values.

How far an arm may be from a table that has no slip: the covariance of its parameters about the table's.

A body whose pseudo-inertia is L exp(S) L^T, P = L L^T being the table's and S a random symmetric matrix of size delta,
is `delta` off. To first order

    cov(pi_a, pi_b) = delta^2 tr(A_a P A_b P),   pi_a = tr(A_a P)

which is delta^2 times the inverse Hessian of -log det P, and asks neither for axes nor for units.

What a log says of the cells of a table: the misfit of any table, friction and unknown parameters left free.

With R^T R the precision of the base parameters beta that the log gave, and R in the coordinates in which friction has
no part, a table with parameters pi misses the log by r = K pi - y, whose covariance is the identity (the noise) plus
K Sigma K^T (`discrepancy`). chi^2 = r^T V^-1 r has as many degrees of freedom as K has directions.

Which cells of a table a motion can show: none at all, only with others, or alone. Geometry decides, not the log.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy import stats
from scipy.linalg import qr

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.bodies.possible_bodies import pseudo_inertia_weights, pseudo_inertias
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips.printed_cells import COM, MASS, ROTOR, TENSOR, Cell, PrintedCells
from lwr_dyn.identification.slips.repairs import (
    AXES,
    COLUMN,
    CONVENTION,
    COPY,
    POWERS_APART,
    UNIT,
    VALUE,
    Repair,
    repeats,
)

_READERS = pseudo_inertia_weights(np.eye(len(INERTIAL)))
"""A (10, 4, 4): each inertial parameter as tr(A P)."""


def link_discrepancies(table: PrintedCells) -> Array:
    """Covariance of each link's ten parameters and armature about the table's, for delta = 1: (n, 11, 11) [SI].

    Where a table's body cannot be (a slip can do that), the magnitudes of its pseudo-inertia's eigenvalues are taken.

    References
    ----------
    Lee, Wensing, Park, Geometric robot dynamic identification: a convex programming approach (2020), for the metric.
    """
    parameters = table.parameters()
    P = table_pseudo_inertias(table)
    values, vectors = np.linalg.eigh(P)
    if (values < 0.0).any():
        P = np.einsum("nij,nj,nkj->nik", vectors, np.abs(values), vectors)
    read = np.einsum("aij,njk->naik", _READERS, P)
    out = np.zeros((table.n, 11, 11))
    out[:, :10, :10] = np.einsum("naij,nbji->nab", read, read)
    out[:, 10, 10] = parameters[10 * table.n :] ** 2
    return out


def table_pseudo_inertias(table: PrintedCells) -> Array:
    """P (n, 4, 4) of each link about its frame [SI]."""
    return pseudo_inertias(table.parameters()[: 10 * table.n].reshape(table.n, 10))


RANK = 1e-9
"""Share of the largest singular value below which a direction is not there."""
CONFIDENCE = 0.999
"""A table whose chi^2 is beyond this share of its distribution does not fit."""


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

    def parts(self, table: PrintedCells, like: PrintedCells | None = None, known: Array | None = None) -> Array:
        """Each link's part of the discrepancy's covariance, delta^2 K Sigma K^T: (n, r, r).

        `known` are those of the table `like`; the parts of links that are the same in both are taken from there.
        """
        n = table.n
        if self.deviation == 0.0:
            return np.zeros((n, self.directions, self.directions))
        out = np.empty((n, self.directions, self.directions)) if known is None else known.copy()
        changed = np.arange(n) if like is None else table.changed_links(like)
        spread = link_discrepancies(table)
        for i in changed:
            K = self.K[:, table.link_columns(i)]
            out[i] = self.deviation**2 * (K @ spread[i] @ K.T)
        return out

    def limit(self, freed: int = 0) -> float:
        """The largest chi^2 of a table that fits, with that many cells freed."""
        return float(stats.chi2.ppf(CONFIDENCE, max(self.directions - freed, 1)))


def log_evidence(information: Information, table: PrintedCells, deviation: float) -> LogEvidence:
    """The evidence of a log, in the columns of `PrintedCells.parameters`; friction and open parameters are free."""
    columns, n = information.columns, table.n
    own = np.concatenate([np.arange(10 * n), np.asarray(columns.rotor_indices, dtype=np.intp)])
    R, grouping = information.factor, information.base.grouping
    opened = np.concatenate([table.open_parameters[:, :10].ravel(), table.open_parameters[:, 10]])
    free = np.concatenate([np.setdiff1d(np.arange(grouping.shape[1]), own), own[opened]])
    blocked = _complement(R @ grouping[:, free])
    K, y = blocked @ R @ grouping[:, own], blocked @ R @ information.values
    K[:, opened] = 0.0
    seen = _range(K)
    return LogEvidence(seen.T @ K, seen.T @ y, deviation)


def _complement(A: Array) -> Array:
    """Rows that span what the columns of A (m, k) do not, (m - rank, m)."""
    norms = np.linalg.norm(A, axis=0)
    scaled = A[:, norms > 0.0] / norms[norms > 0.0]
    Q, R, _ = qr(scaled, pivoting=True)
    sizes = np.abs(np.diag(R))
    return np.asarray(Q[:, int(np.sum(sizes > RANK * sizes.max(initial=0.0))) :].T)


def _range(K: Array) -> Array:
    """Columns that span those of K (m, p), each scaled to length 1 first: (m, rank)."""
    norms = np.linalg.norm(K, axis=0)
    left, sizes, _ = np.linalg.svd(K[:, norms > 0.0] / norms[norms > 0.0], full_matrices=False)
    return np.asarray(left[:, sizes > RANK * sizes[0]])


COUNT = 500.0
"""How many repairs a table has, by order of magnitude: what a repair, or a body that cannot be, must win."""
WAYS = {CONVENTION: 20.0, COLUMN: 50.0, AXES: 60.0, COPY: 80.0, POWERS_APART: 5000.0, UNIT: 5000.0}
"""The same for kinds that have fewer, or happen less."""
POSSIBLE = -0.01
"""Least eigenvalue of a body's pseudo-inertia, scaled to a diagonal of 1, that printed digits may leave."""
FREED = (COPY, VALUE)
"""Kinds of repairs whose value is the log's."""
Key = tuple[tuple[Cell, ...], str]


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """Repairs of a table (none: as printed), the table with them, and how it meets the log."""

    repairs: tuple[Repair, ...]
    table: PrintedCells
    freed: tuple[Cell, ...]
    """Cells whose values are the log's."""
    chi2: float
    evidence: float
    """-2 log p up to a constant: the smallest is the likeliest."""
    parts: Array = field(repr=False)
    """Each link's part of the discrepancy, (n, r, r)."""

    @property
    def keys(self) -> tuple[Key, ...]:
        """One a repair; the value of a freed cell is not part of it."""
        return tuple((r.cells, "freed" if r.kind in FREED else r.text) for r in self.repairs)


def as_printed(evidence: LogEvidence, table: PrintedCells) -> Hypothesis:
    """The table without repairs."""
    parts = evidence.parts(table)
    chi2, weight, _ = _judged(evidence, table, parts, ())
    return Hypothesis((), table, (), chi2, weight, parts)


def repaired(evidence: LogEvidence, before: Hypothesis, repair: Repair) -> Hypothesis:
    """A hypothesis with one repair more; cells that were freed take their best values anew."""
    freed = (*before.freed, *repair.cells) if repair.kind in FREED else before.freed
    table, parts = repair.table, evidence.parts(repair.table, before.table, before.parts)
    chi2, weight, table = _judged(evidence, table, parts, freed)
    repairs = (*before.repairs, repair)
    weight += 2.0 * sum(np.log(WAYS.get(r.kind, COUNT)) for r in repairs)
    return Hypothesis(repairs, table, freed, chi2, weight, parts)


def _judged(
    evidence: LogEvidence, table: PrintedCells, parts: Array, freed: Sequence[Cell]
) -> tuple[float, float, PrintedCells]:
    """chi^2, -2 log p without the repairs' count, and the table with the freed cells at their best values."""
    L = np.linalg.cholesky(np.eye(evidence.directions) + parts.sum(axis=0))
    weight = 2.0 * float(np.log(np.diag(L)).sum())
    for _ in range(2 if freed else 0):  # the centre of mass enters squared
        U = np.linalg.solve(L, evidence.K @ table.derivatives(freed))
        best = -np.linalg.lstsq(U, np.linalg.solve(L, evidence.misfit(table)), rcond=None)[0]
        values = table.values.copy()
        for cell, step in zip(freed, best, strict=True):
            values[cell] += step
        table = table.with_values(values)
    if freed:
        sizes = np.array([typical_size(table, c) for c in freed])
        weight += float(np.linalg.slogdet(np.eye(len(freed)) + (U * sizes).T @ (U * sizes))[1])
    left = np.linalg.solve(L, evidence.misfit(table))
    chi2 = float(left @ left)
    weight += 2.0 * np.log(COUNT) * impossible_bodies(table)
    return chi2, chi2 + weight, table


def typical_size(table: PrintedCells, cell: Cell) -> float:
    """Root mean square of the printed numbers of a cell's quantity [SI]."""
    for part in (slice(MASS, MASS + 1), COM, TENSOR, slice(ROTOR, ROTOR + 1)):
        if part.start <= cell.quantity < part.stop:
            values = table.values[:, part][table.known[:, part]]
            return float(np.sqrt(np.mean(np.square(values)))) or 1.0
    raise AssertionError(cell)


def impossible_bodies(table: PrintedCells) -> int:
    """How many links no body can have, beyond what rounding of printed digits explains."""
    P = table_pseudo_inertias(table)
    diagonal = np.einsum("nii->ni", P)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    least = np.linalg.eigvalsh(P * scale[:, :, None] * scale[:, None, :])[:, 0]
    return int(np.sum((least < POSSIBLE) | (diagonal < 0.0).any(axis=1)))


@dataclass(frozen=True, slots=True, eq=False)
class FreeCells:
    """What would follow if one cell alone had another value; arrays have an entry a cell."""

    cells: tuple[Cell, ...]
    step: Array
    """To the best value [SI]."""
    sigma: Array
    """Of that value, the arm's own discrepancy in it; infinite where no motion shows the cell."""
    chi2: Array
    """That is left."""


def free_cells(evidence: LogEvidence, at: Hypothesis, cells: Sequence[Cell]) -> FreeCells:
    """Each cell freed alone, to first order."""
    L = np.linalg.cholesky(np.eye(evidence.directions) + at.parts.sum(axis=0))
    r = np.linalg.solve(L, evidence.misfit(at.table))
    kept = [c for c in at.freed if c not in cells]
    U = np.linalg.solve(L, evidence.K @ at.table.derivatives(cells))
    if kept:
        Q = np.linalg.qr(np.linalg.solve(L, evidence.K @ at.table.derivatives(kept)))[0]
        U = U - Q @ (Q.T @ U)
    length = np.linalg.norm(U, axis=0)
    size = np.array([typical_size(at.table, c) for c in cells])
    shown = length * size > SHOWN
    safe = np.where(shown, length, 1.0)
    along = np.where(shown, U.T @ r / safe, 0.0)
    return FreeCells(
        tuple(cells), -along / safe, np.where(shown, 1.0 / safe, np.inf), float(r @ r) - np.square(along)
    )  # fmt: skip


SHOWN = 1e-6
"""In sigma: a cell whose typical size moves the log by less is shown by no motion."""


def freed_repair(table: PrintedCells, cell: Cell, value: float) -> Repair:
    """A cell with the log's value; `COPY` where the printed one repeats its neighbour."""
    other = repeats(table, cell)
    kind, why = (VALUE, "") if other is None else (COPY, f", which repeats {other.name}")
    text = f"{cell.name} = {table.shown(cell, value)}, printed {table.shown(cell)}{why}"
    return Repair(kind, (cell,), text, table.with_cell(cell, value), partial(freed_repair, cell=cell, value=value))


NOTHING = 1e-9
"""Share of the largest change of a base parameter below which there is none."""
ALONG = 1e-9
"""Two changes of the base parameters with 1 - |cosine| below this are one."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownCells:
    """The cells of a table by what the torques of any motion can tell of them."""

    hidden: tuple[Cell, ...]
    """Shown by no motion."""
    together: tuple[tuple[Cell, ...], ...]
    """Cells with one effect: a change of one is a change of another."""
    alone: tuple[Cell, ...]

    @property
    def visible(self) -> tuple[Cell, ...]:
        """Those that some motion shows, in the order of the table."""
        return tuple(sorted((*self.alone, *(c for group in self.together for c in group))))

    def like(self, cell: Cell) -> tuple[Cell, ...]:
        """The cells that cannot be distinguished from this one, itself among them."""
        return next((group for group in self.together if cell in group), (cell,))


def shown_cells(information: Information, table: PrintedCells) -> ShownCells:
    """The cells of a table, sorted by what the base parameters of the geometry see of them."""
    columns, n = information.columns, table.n
    own = np.concatenate([np.arange(10 * n), np.asarray(columns.rotor_indices, dtype=np.intp)])
    effect = _in_sizes(information.base.grouping[:, own], table)
    lengths = np.linalg.norm(effect, axis=0)
    seen = lengths > NOTHING * lengths.max(initial=0.0)
    unit = effect[:, seen] / lengths[seen]
    cosine = np.abs(unit.T @ unit)
    cells = [c for c, s in zip(table.cells, seen, strict=True) if s]
    groups: list[tuple[Cell, ...]] = []
    left = list(range(len(cells)))
    while left:
        group = [j for j in left if 1.0 - cosine[left[0], j] < ALONG]
        groups.append(tuple(cells[j] for j in group))
        left = [j for j in left if j not in group]
    return ShownCells(
        hidden=tuple(c for c, s in zip(table.cells, seen, strict=True) if not s),
        together=tuple(g for g in groups if len(g) > 1),
        alone=tuple(g[0] for g in groups if len(g) == 1),
    )


def _in_sizes(grouping: Array, table: PrintedCells) -> Array:
    """Change of the base parameters per typical size of each cell, the parameters in units of their own size."""
    changes = table.derivatives(table.cells) * np.array([typical_size(table, c) for c in table.cells])
    effect = grouping @ changes
    scale = np.abs(effect).max(axis=1)
    return np.asarray(effect[scale > 0.0] / scale[scale > 0.0, None])
