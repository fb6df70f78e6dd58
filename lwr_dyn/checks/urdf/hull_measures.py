"""A link's mass, centre and inertia held against the hull of its shapes.

S = (tr I / 2 E - I) / m is the covariance of the link's mass; H that of its solid hull. The eigenvalues of H^-1 S are 1
for a full body; those of 25 good arms lie between 0.15 and 2.8.
"""

import math
from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.urdf.hulls import Hull, depth, directions, reach_along
from lwr_dyn.foundation.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class MassPoint:
    """Mass [kg], centre (3,) [m] and inertia about it (3, 3) [kg m^2], both in the link's axes."""

    mass: float
    com: Array
    inertia: Array


def mass_covariance(inertia: Array, mass: float) -> Array:
    """Covariance of a body's mass, S = (tr I / 2 E - I) / m: (3, 3) array [m^2].

    >>> mass_covariance(np.diag([2.0, 3.0, 4.0]), 1.0).diagonal().tolist()
    [2.5, 1.5, 0.5]
    """
    half = np.trace(inertia, axis1=-2, axis2=-1)[..., None, None] / 2.0
    return np.asarray((half * np.eye(3) - inertia) / mass)


def spread_ratios(inertia: Array, mass: float, hull: Hull) -> Array:
    """The eigenvalues of H^-1 S, smallest first: (..., 3) array; below 0 for an inertia that no body has.

    Parameters
    ----------
    inertia : (..., 3, 3) array [kg m^2]
        About the centre of mass.
    mass : float [kg]
    hull : Hull
    """
    whiten = np.linalg.inv(np.linalg.cholesky(hull.covariance))
    return np.asarray(np.linalg.eigvalsh(whiten @ mass_covariance(inertia, mass) @ whiten.T), dtype=float)


def log_distance(ratios: Array) -> Array:
    """Length of the logarithms of `spread_ratios`, (...); ratios of 0 or less count as 1e-4."""
    return np.asarray(np.linalg.norm(np.log(np.maximum(ratios, 1e-4)), axis=-1))


def bound_ratio(body: MassPoint, hull: Hull) -> float:
    """Largest variance along a direction over its bound (max - c)(c - min); 0 where the centre is outside.

    No mass within the hull varies more about its centre than half of it at either end (Bhatia and Davis 2000). Tried
    are the principal axes and 600 directions.
    """
    covariance = mass_covariance(body.inertia, body.mass)
    ways = np.vstack([np.linalg.eigh(covariance)[1].T, directions()])
    back, forth = reach_along(hull, ways.T, body.com)
    values = np.einsum("ki,ij,kj->k", ways, covariance, ways)
    inside = (back > 0.0) & (forth > 0.0)
    return float(np.max(np.where(inside, values / np.where(inside, back * forth, 1.0), 0.0)))


def outside(com: Array, hull: Hull) -> float:
    """How far the centre lies outside the hull, over the hull's diameter; below 0 inside."""
    return depth(hull, com) / hull.diameter


def off_centre(com: Array, hull: Hull) -> float:
    """Distance of the centre from the hull's centroid in standard deviations of the hull: sqrt((c-g)' H^-1 (c-g))."""
    away = com - hull.centroid
    return math.sqrt(max(float(away @ np.linalg.solve(hull.covariance, away)), 0.0))
