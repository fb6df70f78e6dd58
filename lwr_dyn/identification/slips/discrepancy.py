"""How far an arm may be from a table that has no slip: the covariance of its parameters about the table's.

A body whose pseudo-inertia is L exp(S) L^T, P = L L^T being the table's and S a random symmetric matrix of size delta,
is `delta` off. To first order

    cov(pi_a, pi_b) = delta^2 tr(A_a P A_b P),   pi_a = tr(A_a P)

which is delta^2 times the inverse Hessian of -log det P, and asks neither for axes nor for units.
"""

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.pseudo_inertia import pseudo_inertia_weights, pseudo_inertias
from lwr_dyn.identification.slips.printed_cells import PrintedCells

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
