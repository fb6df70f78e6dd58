"""What each link of a URDF looks like: the convex hull of its own shapes, in the link's frame."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lwr_dyn.checks.urdf.document import UrdfDocument
from lwr_dyn.checks.urdf.elements import LinkElement, ShapeElement
from lwr_dyn.checks.urdf.hulls import Hull, directions, solid_hull
from lwr_dyn.checks.urdf.mesh_paths import mesh_path
from lwr_dyn.checks.urdf.meshes import MeshPointsError, mesh_points
from lwr_dyn.foundation.arrays import Array

DIFFERS, WIDER = 8.0, 2.0
"""Volumes and diameters of visual and collision that are further apart than this are in different units."""
_PLAUSIBLE = 800.0
"""[kg/m^3] Middle of the density of arms' hulls: where the two roles differ, the nearer one is judged."""
_SIDES = 64


class Piece(NamedTuple):
    """One shape as the key of a hull: what it is, its scale and where it stands."""

    kind: str
    size: tuple[float, ...]
    path: str
    digest: str
    scale: tuple[float, ...]
    pose: bytes


@dataclass(frozen=True, slots=True, eq=False)
class LinkBody:
    """A link with the hulls of its shapes; a hull is None where no shape with a volume can be read.

    Parameters
    ----------
    visual, collision : Hull or None
    hull : Hull or None
        Of both together; of the more plausible one where their units differ.
    unread : tuple of (ShapeElement, str)
        Mesh files that are there and cannot be read, with the reason.
    whole : bool
        Whether every mesh was read; without one the hull may be smaller than the body.
    """

    link: LinkElement
    visual: Hull | None
    collision: Hull | None
    hull: Hull | None
    unread: tuple[tuple[ShapeElement, str], ...]
    whole: bool = True

    @property
    def ratio(self) -> float:
        """Volume of the visual hull over that of the collision hull; 1 where one is missing."""
        return self.visual.volume / self.collision.volume if self.visual and self.collision else 1.0

    @property
    def units_differ(self) -> bool:
        """Whether the two differ as two units do: in volume and in diameter."""
        wide = self.visual.diameter / self.collision.diameter if self.visual and self.collision else 1.0
        return not 1.0 / DIFFERS < self.ratio < DIFFERS and not 1.0 / WIDER < wide < WIDER


@lru_cache(maxsize=4)
def bodies_of(document: UrdfDocument) -> Mapping[str, LinkBody]:
    """The body of each link by name; without shapes where they are drawings of this package."""
    if document.is_drawn_here:
        return {link.name: LinkBody(link, None, None, None, ()) for link in document.links if link.name}
    return {link.name: _body(link, document.path) for link in document.links if link.name}


def _body(link: LinkElement, path: Path) -> LinkBody:
    pieces: dict[str, list[Piece]] = {"visual": [], "collision": []}
    unread, partial = [], set()
    for shape in link.shapes:
        try:
            pieces[shape.role] += _piece(shape, path)
        except MeshPointsError as fault:
            partial.add(shape.role)
            unread.append((shape, str(fault)))
        except FileNotFoundError:
            partial.add(shape.role)
    for role in partial:  # half a body is no body to judge by
        pieces[role] = []
    visual, collision = (_hull(tuple(pieces[role])) for role in ("visual", "collision"))
    both = tuple(dict.fromkeys(pieces["visual"] + pieces["collision"]))
    body = LinkBody(link, visual, collision, None, tuple(unread))
    mass = link.inertial.mass if link.inertial else None
    hull = _nearer(body, mass or 1.0) if body.units_differ else _hull(both)
    return LinkBody(link, visual, collision, hull, tuple(unread), not partial)


def _nearer(body: LinkBody, mass: float) -> Hull | None:
    hulls = [hull for hull in (body.visual, body.collision) if hull]
    return min(hulls, key=lambda hull: abs(np.log(abs(mass) / hull.volume / _PLAUSIBLE)))


def _piece(shape: ShapeElement, path: Path) -> Iterable[Piece]:
    pose = shape.origin.pose
    if pose is None:
        return
    if shape.kind != "mesh":
        if shape.size and min(shape.size) > 0.0:
            yield Piece(shape.kind, shape.size, "", "", (1.0, 1.0, 1.0), pose.tobytes())
        return
    found = mesh_path(shape.mesh, path).path if shape.mesh else None
    if found is None:
        raise FileNotFoundError(shape.mesh)
    if shape.scale is not None:
        points = mesh_points(found)
        yield Piece("mesh", (), str(found), points.digest, tuple(shape.scale), pose.tobytes())


@lru_cache(maxsize=8192)
def _hull(pieces: tuple[Piece, ...]) -> Hull | None:
    """The hull of shapes together; kept, since most links of two files that are compared are the same."""
    return solid_hull(np.vstack([_placed(piece) for piece in pieces])) if pieces else None


def _placed(piece: Piece) -> Array:
    points = mesh_points(Path(piece.path)).points if piece.kind == "mesh" else primitive_points(piece.kind, piece.size)
    pose: Array = np.frombuffer(piece.pose).reshape(4, 4)
    return np.asarray((points * np.array(piece.scale)) @ pose[:3, :3].T + pose[:3, 3])


def primitive_points(kind: str, size: tuple[float, ...]) -> Array:
    """Points whose hull has the volume of a box, cylinder, sphere or capsule in its own frame: (k, 3) array [m]."""
    if kind == "box":
        corners = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
        return np.asarray(corners * np.array(size))
    ball = _ball()
    if kind == "sphere":
        return ball * size[0]
    radius, length = size
    if kind == "capsule":
        return _ends(ball * radius, length)
    turn = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    wide = radius * np.sqrt(2.0 * np.pi / (_SIDES * np.sin(2.0 * np.pi / _SIDES)))  # a polygon of the circle's area
    ring = np.column_stack([wide * np.cos(turn), wide * np.sin(turn), np.zeros(_SIDES)])
    return _ends(ring, length)


def _ends(points: Array, length: float) -> Array:
    half = np.array([0.0, 0.0, length / 2.0])
    return np.vstack([points - half, points + half])


@lru_cache(maxsize=1)
def _ball() -> Array:
    """Points whose hull has the volume of the unit sphere."""
    hull = solid_hull(directions())
    return directions() * (4.0 / 3.0 * np.pi / hull.volume) ** (1.0 / 3.0) if hull else directions()
