"""What a log says of the cells of a table: the misfit of any table, friction and unknown parameters left free.

With R^T R the precision of the base parameters beta that the log gave, and R in the coordinates in which friction has
no part, a table with parameters pi misses the log by r = K pi - y, whose covariance is the identity (the noise) plus
K Sigma K^T (`discrepancy`). chi^2 = r^T V^-1 r has as many degrees of freedom as K has directions.
"""

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.linalg import qr

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips.discrepancy import link_discrepancies
from lwr_dyn.identification.slips.printed_cells import PrintedCells

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
