"""How far an arm may be from a table that has no slip: the covariance of its parameters about the table's.

A body whose pseudo-inertia is L exp(S) L^T, P = L L^T being the table's and S a random symmetric matrix of size delta,
is `delta` off. To first order

    cov(pi_a, pi_b) = delta^2 tr(A_a P A_b P),   pi_a = tr(A_a P)

which is delta^2 times the inverse Hessian of -log det P, and asks neither for axes nor for units.
"""

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.identification.slips.printed_cells import PrintedCells

_UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def _readers() -> Array:
    """A (10, 4, 4): each inertial parameter as tr(A P)."""
    out = np.zeros((10, 4, 4))
    out[0, 3, 3] = 1.0
    for a in range(3):
        out[1 + a, a, 3] = out[1 + a, 3, a] = 0.5
    for k, (a, b) in enumerate(_UPPER, start=4):
        if a == b:
            for c in {0, 1, 2} - {a}:
                out[k, c, c] = 1.0
        else:
            out[k, a, b] = out[k, b, a] = -0.5
    return out


_READERS = _readers()


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
    parameters = table.parameters()[: 10 * table.n].reshape(table.n, 10)
    m, mx, my, mz, xx, xy, xz, yy, yz, zz = np.moveaxis(parameters, -1, 0)
    half = (xx + yy + zz) / 2.0
    rows = ((half - xx, -xy, -xz, mx), (-xy, half - yy, -yz, my), (-xz, -yz, half - zz, mz), (mx, my, mz, m))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
