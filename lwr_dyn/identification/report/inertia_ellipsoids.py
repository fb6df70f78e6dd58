"""The body of a link as the solid ellipsoid of one density that has its mass, centre of mass and inertia.

Of a pseudo-inertia P = [[S, h], [h^T, m]], S = integral of r r^T dm, a solid ellipsoid with semi-axes a has
S - h h^T / m = m / 5 R diag(a^2) R^T about its centre h / m, so its semi-axes are those of P, made visible: a body is
one that can be (P > 0) where all three are real.
"""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.pseudo_inertia import pseudo_inertias

ROUNDING = 1e-9
"""Of the largest moment: a second moment this far below 0 counts as 0, as of a plate or a rod."""


def central_moments(parameters: Array) -> tuple[float, Array, Array]:
    """Mass [kg], centre of mass (3,) [m] and S (3, 3) [kg m^2] about it, of ten parameters as in `INERTIAL`.

    >>> mass, com, moments = central_moments(np.array([2.0, 0.0, 0.0, 2.0, 3.0, 0.0, 0.0, 3.0, 0.0, 1.0]))
    >>> mass, com.tolist(), np.diag(moments).tolist()
    (2.0, [0.0, 0.0, 1.0], [0.5, 0.5, 0.5])
    """
    P = pseudo_inertias(parameters)
    mass, first = float(P[3, 3]), P[:3, 3]
    if mass == 0.0:
        return mass, np.zeros(3), P[:3, :3]
    return mass, first / mass, P[:3, :3] - np.outer(first, first) / mass


def semi_axes(parameters: Array) -> tuple[Array, Array] | None:
    """Semi-axes (3,) [m], ascending, along the columns of a rotation (3, 3); None for what no body can be."""
    mass, _, moments = central_moments(parameters)
    if not (mass > 0.0 and np.isfinite(moments).all()):
        return None
    squares, axes = np.linalg.eigh(moments)
    if squares[0] < -ROUNDING * abs(squares[2]):
        return None
    axes = axes * np.where(np.linalg.det(axes) < 0.0, -1.0, 1.0)
    return np.sqrt(5.0 / mass * np.maximum(squares, 0.0)), axes


def ellipsoid_matrix(parameters: Array) -> Array | None:
    """The image of the unit sphere in the link's frame, (4, 4); None for what no body can be.

    >>> ball = np.array([5.0, 0.0, 0.0, 5.0, 7.0, 0.0, 0.0, 7.0, 0.0, 2.0])
    >>> ellipsoid_matrix(ball).tolist()
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]]
    """
    found = semi_axes(parameters)
    if found is None:
        return None
    sizes, axes = found
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = axes * sizes, central_moments(parameters)[1]
    return out
