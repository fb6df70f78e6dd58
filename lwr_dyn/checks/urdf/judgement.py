"""Each link's inertial held against the convex hull of its own shapes, with the slip that explains what is odd.

One judgement serves all rules of mass, centre and inertia, so that one fault is named once.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lwr_dyn.checks.urdf import undoings
from lwr_dyn.checks.urdf.document import UrdfDocument, link_poses
from lwr_dyn.checks.urdf.elements import InertialElement, LinkElement, ShapeElement
from lwr_dyn.checks.urdf.hulls import Hull, MeshPointsError, directions, mesh_path, mesh_points, solid_hull
from lwr_dyn.checks.urdf.undoings import MassPoint, Undoing
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
    """A link with the hulls of its shapes; a hull is None where no shape with a volume can be read."""

    link: LinkElement
    visual: Hull | None
    collision: Hull | None
    hull: Hull | None  # of both together; of the more plausible one where their units differ
    unread: tuple[tuple[ShapeElement, str], ...]  # mesh files that are there and cannot be read, with the reason
    whole: bool = True  # every mesh was read; else the hull may be smaller than the body

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


USUAL_DENSITY = 800.0
"""[kg/m^3] Where a file's own median does not lie between 100 and 5 000."""
_WHOLE_FILE, _ODD = 3, 0.02
"""Links that must tell of the base frame before a file is said to use it."""
_LIGHT = 0.05
"""[kg] Links below this do not count for the median: dummies and frames."""

NOTED, NAMED = 0.6, 0.8
"""A slip is noted, and named, that shortens the distance of the logarithms by this and its prior. On 145 good links:
an exchange of moments at most 0.55, rpy 0.67 (prior 0.2), about the link frame 0.23 (one 0.93), signs of products 1.5
(prior 0.75)."""

LARGER, LESS = 4.0, 0.5
"""Volume of a link with those fixed to it over its own, and their mass over its own, where its body is drawn there."""
_USUAL_REST = 1.8
"""A slip explains a tensor when no more distance than this is left: 98 of 100 good links have at most 1.7."""
CENTRE_NAMED = 0.55
"""As `NAMED`, for the centre's distance in standard deviations: signs at most 0.34, order 0.71 (prior 0.3)."""


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """A link with mass and hull, and what the hull says of them."""

    body: LinkBody
    inertial: InertialElement
    hull: Hull
    point: MassPoint
    density: float  # mass over the volume of the hull [kg/m^3]
    usual: float  # median of the file's links [kg/m^3]
    ratios: Array  # (3,), eigenvalues of H^-1 S
    spread: float  # mean logarithm of the ratios
    bound: float  # variance over its hard bound
    outside: float  # of the centre, over the diameter
    off: float  # of the centre, in standard deviations
    usual_spread: float = 0.0  # the file's median
    tensor_slip: Undoing | None = None  # whose undoing explains the tensor
    cut: float = 0.0  # by how much that shortens the distance, its prior taken off
    centre_slip: Undoing | None = None  # whose undoing explains the centre
    welded: Hull | None = None  # of the link with those fixed to it, where its body is drawn there


@lru_cache(maxsize=4)
def judgements(document: UrdfDocument) -> tuple[Judgement, ...]:
    """The judgement of every link that has a mass above 0, a readable inertial and a hull."""
    found = [x for body in bodies_of(document).values() if (x := _measured(body)) is not None]
    density = float(np.median([x.density for x in found if x.point.mass > _LIGHT] or [USUAL_DENSITY]))
    usual = density if 100.0 < density < 5000.0 else USUAL_DENSITY
    spread = float(np.median([x.spread for x in found] or [0.0]))
    found = [replace(x, usual=usual, usual_spread=spread, welded=_welded(x, document)) for x in found]
    explained = [_explained(x, document) for x in found]
    return tuple(_base_frame(explained, document))


def _measured(body: LinkBody) -> Judgement | None:
    inertial, hull = body.link.inertial, body.hull
    point = undoings.as_written(inertial) if inertial is not None else None
    if inertial is None or hull is None or point is None:
        return None
    ratios = undoings.spread_ratios(point.inertia, point.mass, hull)
    return Judgement(
        body, inertial, hull, point, point.mass / hull.volume, USUAL_DENSITY, ratios,
        float(np.log(np.maximum(ratios, 1e-12)).mean()), undoings.bound_ratio(point, hull),
        undoings.outside(point.com, hull), undoings.off_centre(point.com, hull),
    )  # fmt: skip


def _welded(found: Judgement, document: UrdfDocument) -> Hull | None:
    """The hull of a link and those fixed to it, in its frame; None unless most of the body is drawn at those.

    That is so where the hull is four times as large as the link's own, and those links have less than half its mass.
    """
    name, poses, bodies = found.body.link.name, link_poses(document), bodies_of(document)
    others = [x for x in document.carried_by(name, through_moving=False) if x != name and x in poses]
    drawn = [(x, hull) for x in others if x in bodies and (hull := bodies[x].hull) is not None]
    if name not in poses or not drawn or document.mass_beyond(name, through_moving=False) > LESS * found.point.mass:
        return None
    points, from_root = [found.hull.vertices], np.linalg.inv(poses[name][0])
    for other, hull in drawn:
        pose = from_root @ poses[other][0]
        points.append(hull.vertices @ pose[:3, :3].T + pose[:3, 3])
    whole = solid_hull(np.vstack(points))
    return whole if whole is not None and whole.volume > LARGER * found.hull.volume else None


def _explained(found: Judgement, document: UrdfDocument) -> Judgement:
    slip, cut = _tensor_slip(found, _frames(found.body.link.name, document)[1])
    return replace(found, tensor_slip=slip, cut=cut, centre_slip=_centre_slip(found, document))


def _tensor_slip(found: Judgement, in_base: Array | None) -> tuple[Undoing | None, float]:
    """The undoing that shortens the distance most, to one that is usual, and by how much, its prior taken off."""
    before = float(undoings.log_distance(found.ratios))
    tried = undoings.tensor_undoings(found.inertial, in_base) if before > NOTED else []
    if not tried:
        return None, 0.0
    mended = undoings.inertias(tried)
    after = undoings.log_distance(undoings.spread_ratios(mended, found.point.mass, found.hull))
    cuts = before - after - np.array([u.prior for u in tried])
    gains = np.where(undoings.possible(mended) & (after < _USUAL_REST), cuts, 0.0)
    best = int(np.argmax(gains))
    return (tried[best], float(gains[best])) if gains[best] > 0.0 else (None, 0.0)


def _centre_slip(found: Judgement, document: UrdfDocument) -> Undoing | None:
    """The undoing that brings the centre back into the hull and nearest to its centroid."""
    best, nearest = None, found.off - CENTRE_NAMED
    tried = undoings.centre_undoings(found.inertial, *_frames(found.body.link.name, document)) if nearest > 0.0 else []
    for undoing in tried:
        off = undoings.off_centre(undoing.com, found.hull) + undoing.prior
        if off < nearest and undoings.outside(undoing.com, found.hull) < 0.0:
            best, nearest = undoing, off
    return best


def _frames(name: str, document: UrdfDocument) -> tuple[Array | None, Array | None]:
    joint, poses = document.joint_into(name), link_poses(document)
    return (joint.origin.pose if joint else None), (poses[name][0] if name in poses else None)


def _base_frame(found: list[Judgement], document: UrdfDocument) -> list[Judgement]:
    """The centres of a whole file in the base frame: most odd ones come at least 1.5 times as near when put there.

    The slip then leads on every odd link, also where the file took the numbers from an arm of another size, so that no
    centre lies inside; such links get no text to write.
    """
    odd = [x for x in found if x.outside > _ODD and x.body.link.name in document.moved]
    moved = {x.body.link.name: _into_base(x, document) for x in odd}
    off = [(x.off, undoings.off_centre(u.com, x.hull)) for x in odd if (u := moved[x.body.link.name])]
    nearer = sum(before > 1.5 * after for before, after in off)
    if nearer < max(_WHOLE_FILE, 0.75 * len(odd)):
        return found
    named = [replace(x, centre_slip=moved.get(x.body.link.name) or x.centre_slip) for x in found]
    return [_with_axes_of_base(x, document) for x in named]


def _with_axes_of_base(found: Judgement, document: UrdfDocument) -> Judgement:
    """The tensor's slip too laid to the base frame, where that explains it as well as the best."""
    if found.tensor_slip is None:
        return found
    in_base = _frames(found.body.link.name, document)[1]
    tried = undoings.tensor_undoings(found.inertial, in_base)
    undoing = next((u for u in tried if u.cause == undoings.AXES_OF_BASE), None)
    if undoing is None:
        return found
    ratios = undoings.spread_ratios(undoings.inertias([undoing])[0], found.point.mass, found.hull)
    cut = float(undoings.log_distance(found.ratios) - undoings.log_distance(ratios))
    if cut < found.cut - 0.1:
        return found
    return replace(found, tensor_slip=replace(undoing, cause=undoings.IN_BASE, prior=0.0), cut=cut)


def _into_base(found: Judgement, document: UrdfDocument) -> Undoing | None:
    tried = undoings.centre_undoings(found.inertial, *_frames(found.body.link.name, document))
    undoing = next((u for u in tried if u.cause == undoings.IN_BASE), None)
    if undoing is not None and undoings.outside(undoing.com, found.hull) > _ODD:
        return replace(undoing, element="")
    return undoing
