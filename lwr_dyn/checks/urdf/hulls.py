"""Convex hulls of bodies: volume, centroid and covariance of the solid hull, and distances to it.

A hull of about 600 support directions loses 0.4 to 3 % of the volume of a round body and nothing of a box. The
covariance H of the solid hull is what an inertia is held against: for a full body of even density the covariance
of the mass is H itself.
"""

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from lwr_dyn.foundation.arrays import Array

_DIRECTIONS = 574
_CHUNK = 8192
"""Points that are multiplied with all directions at once: 20 MB."""
_FLAT = 1e-9
"""Volume over diameter^3 below which a body is a sheet or a line, without a covariance to compare with."""


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """A solid convex body.

    Parameters
    ----------
    vertices : (k, 3) array [m]
    planes : (f, 4) array
        Outward unit normal n and offset d of each face [m]: n . x + d <= 0 inside.
    volume : float [m^3]
    centroid : (3,) array [m]
    covariance : (3, 3) array [m^2]
        Mean of (x - centroid)(x - centroid)' over the volume.
    diameter : float [m]
        The largest width.
    """

    vertices: Array
    planes: Array
    volume: float
    centroid: Array
    covariance: Array
    diameter: float


@cache
def directions() -> Array:
    """About 600 unit vectors, even on the sphere, with axes, edges and corners of the cube: (600, 3) array."""
    k = np.arange(_DIRECTIONS) + 0.5
    z, turn = 1.0 - 2.0 * k / _DIRECTIONS, np.pi * (1.0 + 5.0**0.5) * k
    even = np.column_stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z])
    grid = np.array(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3)).reshape(3, -1).T
    cube = grid[np.abs(grid).sum(axis=1) > 0.0]
    return np.vstack([cube / np.linalg.norm(cube, axis=1)[:, None], even])


def support_points(points: Array) -> Array:
    """The points that are outermost in one of the `directions`: (k, 3) array, k <= 600.

    Parameters
    ----------
    points : (n, 3) array [m]
        Points that are not finite are passed over.
    """
    points = np.asarray(points, dtype=float)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) <= len(directions()):
        return np.unique(points, axis=0)
    kept = points
    while len(kept) > len(directions()):  # support points of the chunks, then of what they left
        chunks = [kept[k : k + _CHUNK] for k in range(0, len(kept), _CHUNK)]
        kept = np.vstack([chunk[np.unique((chunk @ directions().T).argmax(axis=0))] for chunk in chunks])
        if len(chunks) == 1:
            break
    return kept


def solid_hull(points: Array) -> Hull | None:
    """The convex hull of points, (n, 3) array [m]; None for a sheet, a line or fewer than four points."""
    if len(points) < 4:
        return None
    from scipy.spatial import ConvexHull, QhullError  # most files have no mesh, and the linter starts without SciPy

    try:
        found = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    vertices = points[found.vertices]
    diameter = float(np.ptp(vertices @ directions().T, axis=0).max())
    if not found.volume > _FLAT * diameter**3:
        return None
    middle = vertices.mean(axis=0)
    corners = points[found.simplices] - middle
    parts = np.abs(np.linalg.det(corners)) / 6.0  # tetrahedra from the middle to each face
    volume = float(parts.sum())
    sums = corners.sum(axis=1)
    shift = parts @ sums / (4.0 * volume)
    second = (np.einsum("f,fki,fkj->ij", parts, corners, corners) + np.einsum("f,fi,fj->ij", parts, sums, sums)) / (
        20.0 * volume
    )
    return Hull(vertices, found.equations, volume, middle + shift, second - np.outer(shift, shift), diameter)


def depth(hull: Hull, point: Array) -> float:
    """Signed distance [m] of a point from the hull's faces: below 0 inside, outside at least this far away."""
    return float((hull.planes[:, :3] @ point + hull.planes[:, 3]).max())


def gap(one: Hull, other: Hull, pose: Array) -> float:
    """Distance [m] between two hulls along the best of the directions; at most the true one, 0 where they meet.

    Parameters
    ----------
    pose : (4, 4) array
        Of the other hull's frame in the frame of the first.
    """
    if depth(one, pose[:3, 3]) <= 0.0 and depth(other, np.zeros(3)) <= 0.0:  # the joint lies inside both
        return 0.0
    return _gap(one, other, pose.tobytes())


@lru_cache(maxsize=4096)
def _gap(one: Hull, other: Hull, pose_bytes: bytes) -> float:
    """`gap`, kept for the neighbours that two files have in common."""
    pose: Array = np.frombuffer(pose_bytes).reshape(4, 4)
    moved = other.vertices @ pose[:3, :3].T + pose[:3, 3]
    between = moved.mean(axis=0) - one.vertices.mean(axis=0)
    length = float(np.linalg.norm(between))
    ways = np.vstack([directions(), between[None] / length]) if length > 0.0 else directions()
    apart = (moved @ ways.T).min(axis=0) - (one.vertices @ ways.T).max(axis=0)
    return float(max(apart.max(), 0.0))


def reach_along(hull: Hull, axes: Array, origin: Array) -> tuple[Array, Array]:
    """How far the hull reaches from a point, back and forth along axes (the columns of (3, k)): two (k,) arrays [m]."""
    along = (hull.vertices - origin) @ axes
    return -along.min(axis=0), along.max(axis=0)
