"""A table with repairs, judged by a log: chi^2, and the evidence that weighs a free value against a stated slip.

    -2 log p = r^T V^-1 r + log det V + 2 ln(COUNT) (repairs + bodies that cannot be)
    V = 1 + K Sigma K^T + sum s^2 u u^T over freed cells

u is the change of r per unit of a freed cell and s the size that its quantity has in the table; chi^2 itself has the
freed cells at their best values.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.slips.discrepancy import table_pseudo_inertias
from lwr_dyn.identification.slips.log_evidence import LogEvidence
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
