"""How links may differ from a table, kind by kind: covariances of a link's ten parameters for a unit of each kind.

    shape    P = L exp(S) L^T, S random: the log-det geometry, which holds thin directions to their own thickness
    centre   the centre of mass moved by a length, alike in all directions, whatever the link's thickness
    tensor   second moments about the centre: their share, all together, and their axes turned
    mass     the mass beside the shape

A shell of which every direction is known to a share of its thickness would have its centre of mass known to a
millimetre where it is thin; a maker's table does not know that. Hence the kinds beside the shape. To first order, with
A_a the reader of a parameter (pi_a = tr(A_a P)) and Q the second moments that a kind moves,

    cov(pi_a, pi_b) = tr(A_a Q A_b Q)   (Wishart),   or the sum over directions D of D D^T

A centre moved by s adds m s^2 to second moments, and axes turned by a add a^2 of the long ones to the thin ones: both
are of second order, and the last two of `link_spreads`, so that a needle may become a bent needle.

References
----------
Lee, Wensing, Park, Geometric robot dynamic identification: a convex programming approach (2020), for the metric of
the shape.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.inertial_parameters import inertial_parameters, pseudo_inertia_weights, pseudo_inertias
from lwr_dyn.model.spatial import skew

_READERS = pseudo_inertia_weights(np.eye(len(INERTIAL)))
"""A (10, 4, 4): each inertial parameter as tr(A P)."""
CENTRE = 0.05
"""[m] By as much of this as of masses and tensors are centres of mass off, where one share is said for all kinds."""
MASS = 0.5
"""The same of masses beside the shape, which moves them too."""


@dataclass(frozen=True, slots=True)
class Scales:
    """How far links are expected off a table: shares, and a length [m] for centres of mass."""

    shape: float
    centre: float
    tensor: float
    mass: float
    rotor: float
    """Standard deviation of the log of a rotor's inertia that the table has."""

    @classmethod
    def of_deviation(cls, deviation: float) -> "Scales":
        """Of one share for all kinds: centres by as much of 5 cm, masses beside the shape by half of it."""
        return cls(deviation, CENTRE * deviation, deviation, MASS * deviation, deviation)


def link_spreads(links: Array) -> Array:
    """Covariances (n, 6, 10, 10) of links (n, 10): shape, centre, tensor, mass, and second order of centre and tensor.

    Parameters
    ----------
    links : (n, 10) array
        Inertial parameters about each link's frame [kg, kg m, kg m^2], with masses above 0.
    """
    return np.array([_of_link(link) for link in links])


def covariances(spreads: Array, scales: Scales, local: Array | None = None) -> Array:
    """Of links (n, 10, 10), with factors `local` (n, 4) on the variances of each link's shape, centre, tensor, mass."""
    squares = np.square([scales.shape, scales.centre, scales.tensor, scales.mass])
    squares = np.broadcast_to(squares, (len(spreads), 4)) if local is None else squares * local
    first = np.einsum("nk,nkab->nab", squares, spreads[:, :4])
    return np.asarray(first + np.einsum("nk,nkab->nab", squares[:, 1:3] ** 2, spreads[:, 4:]))


def _of_link(link: Array) -> Array:
    P = pseudo_inertias(link)
    m, c = P[3, 3], P[:3, 3] / P[3, 3]
    S = P[:3, :3] - m * np.outer(c, c)
    moved = [inertial_parameters(_block(m * (np.outer(e, c) + np.outer(c, e)), m * e)) for e in np.eye(3)]
    turned = [inertial_parameters(_block(W @ S - S @ W)) for W in map(skew, np.eye(3))]
    larger = inertial_parameters(_block(S))
    heavier = inertial_parameters(_block(m * np.outer(c, c), m * c, m))
    return np.array([
        _wishart(P), _outer(moved), _wishart(_block(S)) + _outer([*turned, larger]), _outer([heavier]),
        _wishart(_block(m * np.eye(3))), _wishart(_block(np.trace(S) * np.eye(3) - S)),
    ])  # fmt: skip


def _block(second: Array, first: Array | None = None, mass: float = 0.0) -> Array:
    """(4, 4) of second moments, first moment and mass."""
    out = np.zeros((4, 4))
    out[:3, :3], out[3, 3] = second, mass
    if first is not None:
        out[:3, 3] = out[3, :3] = first
    return out


def _wishart(Q: Array) -> Array:
    read = _READERS @ Q
    return np.asarray(np.einsum("aij,bji->ab", read, read))


def _outer(directions: Sequence[Array]) -> Array:
    D = np.array(directions)
    return np.asarray(D.T @ D)
