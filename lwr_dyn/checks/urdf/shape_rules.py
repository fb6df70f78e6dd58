"""Rules of the shapes: files that are not there or cannot be read, scales, sizes, units; bodies that do not meet.

A right axis turns the child past its parent: the part of the child that lies inside the parent hardly changes. A right
origin lies in or near the parent; where another sign or order of its numbers puts it there, and the written one does
not, the written one is doubted.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations
from pathlib import Path

import numpy as np

from lwr_dyn.arms.urdf.elements import DRAWN_HERE
from lwr_dyn.checks.urdf.document import SLIDING, TURNING, FindingSeverity, UrdfDocument, UrdfFinding, vector_text
from lwr_dyn.checks.urdf.elements import JointElement, LinkElement, ShapeElement
from lwr_dyn.checks.urdf.hulls import OTHER_FORMAT, REMOTE, Hull, depth, directions, gap, mesh_path
from lwr_dyn.checks.urdf.inertia_shape_rules import misscaled
from lwr_dyn.checks.urdf.judgement import bodies_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.number_text import number_text
from lwr_dyn.model.spatial import turn_about


def _shapes(document: UrdfDocument) -> Iterator[tuple[LinkElement, ShapeElement]]:
    for link in document.links:
        for shape in link.shapes:
            yield link, shape


def meshes_missing(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A mesh whose file is not there though its folder or package is: loaders refuse the file or draw nothing, and
    contacts are missed. Upper and lower case count. A mesh on the web is not fetched: a note.
    """
    for link, shape in _shapes(document):
        if shape.kind != "mesh" or not shape.mesh:
            continue
        if shape.mesh.startswith(REMOTE):
            what, why = f"the mesh {shape.mesh} is on the web", "it is not fetched, so the link is judged without it"
            yield UrdfFinding(what, why, shape.geometry_place, link.subject, cause="meshes on the web", severity="note")
            continue
        found = mesh_path(shape.mesh, document.path)
        if found.path is None and (not found.package_missing or found.package_missing in _packages_here(document)):
            expected = f"looked for {found.expected}" if found.expected else "a name that no file has"
            near = next((x for x in _beside(found.expected) if x.lower() == shape.mesh.rpartition("/")[2].lower()), "")
            instead = shape.mesh.rpartition("/")[0] + "/" + near if near else ""
            yield UrdfFinding(
                f"the mesh {shape.mesh} is not there", expected, shape.geometry_place, link.subject, instead,
                cause="mesh files are not there",
            )  # fmt: skip


@lru_cache(maxsize=4)
def _packages_here(document: UrdfDocument) -> frozenset[str]:
    """Packages of which a mesh was found: their folder has another name, and is above the file."""
    meshes = {shape.mesh for _, shape in _shapes(document) if "://" in shape.mesh}
    found = {mesh for mesh in meshes if mesh_path(mesh, document.path).path is not None}
    return frozenset(mesh.partition("://")[2].partition("/")[0] for mesh in found)


def _beside(path: object) -> list[str]:
    """Names of the files beside a path."""
    try:
        return [x.name for x in Path(str(path)).parent.iterdir()] if path is not None else []
    except OSError:
        return []


def packages_missing(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The package of a mesh (`package://NAME/...`) is on this machine neither above the file nor in ROS_PACKAGE_PATH or
    AMENT_PREFIX_PATH. The links drawn with it are judged without their shapes. One note for each package.
    """
    said: set[str] = set()
    for link, shape in _shapes(document):
        package = mesh_path(shape.mesh, document.path).package_missing if shape.kind == "mesh" and shape.mesh else ""
        if package and package not in said and package not in _packages_here(document):
            said.add(package)
            count = sum(s.mesh.partition("://")[2].startswith(f"{package}/") for _, s in _shapes(document))
            yield UrdfFinding(
                f"the package {package} is not on this machine", f"{count} meshes come from it", shape.geometry_place,
                link.subject, f"put the folder {package} above or beside the file, or into ROS_PACKAGE_PATH",
            )  # fmt: skip


def mesh_scales(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A mesh scale with a 0, which makes the shape flat; one that differs between the axes by 100 or more, or is
    negative on one or three axes (a mirror image), is a note.
    """
    for link, shape in _shapes(document):
        if shape.kind != "mesh" or shape.scale is None:
            continue
        sizes, what = np.abs(shape.scale), f"a mesh scale of {vector_text(shape.scale)}"
        place, subject = shape.geometry_place, link.subject
        if not sizes.all():
            yield UrdfFinding("a mesh scale of 0", "the shape has no volume", place, subject)
        elif sizes.max() >= 100.0 * sizes.min():
            yield UrdfFinding(what, "the axes differ 100-fold or more", place, subject, severity="warning")
        elif np.prod(shape.scale) < 0.0:
            yield UrdfFinding(what, "the shape is a mirror image", place, subject, severity="note")


def shape_sizes(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A box, cylinder or sphere with a length of 0 or less. A cylinder of length 0 or a sphere of radius 0 is a
    stand-in of exporters: a note where all of its lengths are 0 or more.
    """
    for link, shape in _shapes(document):
        smallest = min(shape.size, default=1.0) if shape.size is not None else 1.0
        if smallest <= 0.0:
            yield UrdfFinding(
                f"a {shape.kind} with a length of {number_text(smallest)} m",
                "no body has it" if smallest < 0.0 else "the shape has no volume", shape.geometry_place, link.subject,
                severity=None if smallest < 0.0 else "note",
            )  # fmt: skip


_MOVED = 0.05
"""Of the child's diameter: an origin that moves by less stays as it is."""
_MEETS = 0.02
"""Gap over the larger diameter at which the bodies still meet."""
_PARALLEL = 0.999
_ANGLES = 8
_SHELLS = (1.0, 0.85, 0.6, 0.3)
_POINTS, _EVERY = 60, 4


@dataclass(frozen=True, slots=True, eq=False)
class JointSlip:
    """Another origin or axis, (3,), that fits the bodies better, and by how much."""

    says: str
    values: Array
    cut: float


def origin_slip(parent: Hull, child: Hull, pose: Array) -> JointSlip | None:
    """The sign or order of the origin that brings it nearest to the parent, in the parent's diameters.

    Only origins at which the bodies meet are tried.
    """
    written = depth(parent, pose[:3, 3]) / parent.diameter
    best: JointSlip | None = None
    for says, xyz in _other_origins(pose[:3, 3]) if written > 0.0 else ():
        moved = pose.copy()
        moved[:3, 3] = xyz
        cut = written - depth(parent, xyz) / parent.diameter
        far = np.linalg.norm(xyz - pose[:3, 3]) > _MOVED * child.diameter
        apart = _MEETS * max(parent.diameter, child.diameter)
        if far and cut > (best.cut if best else 0.0) and gap(parent, child, moved) < apart:
            best = JointSlip(says, xyz, cut)
    return best


def _other_origins(xyz: Array) -> list[tuple[str, Array]]:
    flips = 1.0 - 2.0 * np.eye(3)
    signs = [(f"{'xyz'[k]} of its origin has the opposite sign", xyz * flips[k]) for k in range(3)]
    orders = [("x, y, z of its origin look permuted", xyz[list(order)]) for order in list(permutations(range(3)))[1:]]
    return signs + orders


def axis_slip(joint: JointElement, parent: Hull, child: Hull, pose: Array) -> JointSlip | None:
    """The axis of the joint's frame about which the child turns most freely past its parent.

    The cut is by how much less of the child changes from outside to inside the parent.
    """
    if joint.type not in TURNING or joint.axis is None or not joint.axis.any():
        return None
    low, high = (-np.pi, np.pi) if joint.type == "continuous" else (joint.lower, joint.upper)
    if low is None or high is None or not low < high:
        low, high = -np.pi, np.pi
    limits = (max(low, -np.pi), min(high, np.pi))
    written = _swept(parent, child, pose.tobytes(), tuple(joint.axis), limits)
    best: JointSlip | None = None
    for k in range(3) if written > 0.0 else ():
        axis = np.eye(3)[k]
        if abs(axis @ joint.axis) < np.linalg.norm(joint.axis) * _PARALLEL:
            cut = written - _swept(parent, child, pose.tobytes(), tuple(axis), limits)
            if cut > (best.cut if best else 0.0):
                best = JointSlip(f"about {'xyz'[k]} its child would turn freely past its parent", axis, cut)
    return best


@lru_cache(maxsize=8192)
def _swept(parent: Hull, child: Hull, pose_bytes: bytes, axis: tuple[float, ...], limits: tuple[float, float]) -> float:
    """Largest less smallest share of the child that is inside the parent, over positions of the joint."""
    pose: Array = np.frombuffer(pose_bytes).reshape(4, 4)
    normals, offsets = _faces(parent)
    q = np.concatenate([[0.0], np.linspace(*limits, _ANGLES)])
    turns = turn_about(np.array(axis) / np.linalg.norm(axis), q)
    placed = _filled(child) @ turns.swapaxes(1, 2) @ pose[:3, :3].T + pose[:3, 3]
    inside = ((placed @ normals.T) <= offsets).all(axis=2).mean(axis=1)
    return float(np.ptp(inside))


@lru_cache(maxsize=512)
def _faces(hull: Hull) -> tuple[Array, Array]:
    """A polytope of 150 faces about the hull: normals (k, 3) and offsets (k,)."""
    ways = directions()[::_EVERY]
    return ways, (hull.vertices @ ways.T).max(axis=0)


@lru_cache(maxsize=512)
def _filled(hull: Hull) -> Array:
    """Points that fill the hull in shells about its centroid, (k, 3)."""
    some = hull.vertices[:: max(1, len(hull.vertices) // _POINTS)] - hull.centroid
    return np.vstack([hull.centroid + shell * some for shell in _SHELLS])


APART = 0.065
"""Gap between neighbours, and distance of a joint from both, over the larger diameter: 0.061 and 0.060 on good arms."""
NEARER, FREER, _NAMED = 0.42, 0.3, 0.1
DEEPER = 0.1
"""Diameters of the parent by which an axis as written must go deeper through it to speak for the origin."""
_ALONG, _STEPS = 2.0, 81
"""Diameters of the parent to either side of the origin, and points, along which an axis is followed."""


def mesh_unreadable(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """A mesh file is there and cannot be read as what its ending says.

    STL, OBJ and DAE are read; other formats get a note, and their links are judged without that shape. Programs that
    load a damaged file show nothing in its place or stop; export the mesh again.
    """
    for body in bodies_of(document).values():
        for shape, reason in body.unread:
            what = f"the mesh {shape.mesh} cannot be read"
            severity: FindingSeverity | None = "note" if reason.startswith(OTHER_FORMAT) else None
            instead = "" if severity else "export it again"
            place, link = shape.geometry_place, body.link
            yield UrdfFinding(what, reason, place, link.subject, instead, severity=severity, link=link.name)


def shapes_differ(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """Visual and collision shapes of a link differ 8-fold in volume and 2-fold in diameter: one is in another unit.

    Collision shapes are simplified, but on good arms rarely by more than a factor of 3 in volume. A DAE states its unit
    in the file (`<unit meter="0.001"/>`); an STL has none, so a scale is written in the URDF.
    """
    for body in bodies_of(document).values():
        if body.units_differ and body.visual and body.collision:
            wide = body.visual.diameter / body.collision.diameter
            what = f"its visual shapes have {body.ratio:.3g} times the volume of its collision shapes"
            why = f"diameters {body.visual.diameter:.3g} m and {body.collision.diameter:.3g} m, {wide:.3g} times"
            first = body.link.shapes[0]
            yield UrdfFinding(
                what, why, first.geometry_place, body.link.subject, "both in metres (scale)", "likely",
                "visual and collision shapes in different units", link=body.link.name,
            )  # fmt: skip


def bodies_apart(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """At q = 0 the bodies on both sides of a joint do not meet.

    Good arms have at most 0.010 diameters between the hulls of neighbours (one 0.046), those of other makers 0.021. A
    gap of more than 0.065 points to the origin of the joint or of a shape: in mm, with a sign or an axis exchanged. A
    sign or order that brings the joint 0.1 diameters of the parent nearer to it is named, with the text to write. Where
    a mesh of either body could not be read it is a note: the body may be larger.
    """
    for joint, parent, child, pose in _neighbours(document):
        apart = gap(parent, child, pose) / max(parent.diameter, child.diameter)
        if apart > APART:
            what = f"its bodies {joint.parent} and {joint.child} lie {apart:.2g} diameters apart"
            why = "at q = 0; bodies that a joint holds together meet there"
            yield _at_origin(document, joint, what, why, origin_slip(parent, child, pose))


def joint_off_bodies(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The origin of a joint lies outside both bodies that it holds together.

    On good arms it lies at most 0.041 diameters outside, on those of other makers 0.029. More than 0.065 outside both
    points to the origin of the joint or of a shape. Of a slide only the direction counts, so it is left alone.
    """
    for joint, parent, child, pose in _neighbours(document):
        off = 0.0 if joint.type in SLIDING else _off_both(parent, child, pose)
        if off > APART:
            what = f"its origin lies {off:.2g} diameters outside both {joint.parent} and {joint.child}"
            why = "a joint's axis goes through the bodies that it holds"
            yield _at_origin(document, joint, what, why, origin_slip(parent, child, pose))


def _off_both(parent: Hull, child: Hull, pose: Array) -> float:
    return min(depth(parent, pose[:3, 3]) / parent.diameter, depth(child, np.zeros(3)) / child.diameter)


def origins_doubted(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The origin of a joint with another sign, or its numbers in another order, lies much nearer to the parent.

    Tried are the three signs and five orders at which the bodies still meet. On 147 good joints the best of them comes
    at most 0.34 diameters of the parent nearer; of 122 of other makers the four fingers of one robot 0.56, wrongly.
    Warning above 0.42, with the text to write. Where on its axis the origin of a turning joint lies does not matter: a
    note where the axis as written goes 0.1 diameters deeper through the parent than it would with the other origin.
    """
    for joint, parent, child, pose in _neighbours(document):
        apart = gap(parent, child, pose) / max(parent.diameter, child.diameter)
        slip = origin_slip(parent, child, pose) if apart <= APART and _off_both(parent, child, pose) <= APART else None
        if slip is not None and slip.cut > NEARER:
            on_axis = _axis_deeper(joint, parent, pose, slip.values) > DEEPER
            yield _at_origin(document, joint, "its origin lies far from its parent", "at q = 0", slip, on_axis)


def _axis_deeper(joint: JointElement, parent: Hull, pose: Array, other: Array) -> float:
    """By how much [diameters] deeper a turning joint's axis goes through the parent than from another origin, (3,)."""
    if joint.type not in TURNING or joint.axis is None or not joint.axis.any():
        return 0.0
    axis = pose[:3, :3] @ joint.axis / np.linalg.norm(joint.axis)
    steps = np.linspace(-_ALONG, _ALONG, _STEPS)[:, None] * parent.diameter * axis
    written, moved = (
        float((parent.planes[:, :3] @ (xyz + steps).T + parent.planes[:, 3:]).max(axis=0).min())
        for xyz in (pose[:3, 3], other)
    )
    return (moved - written) / parent.diameter


def axes_doubted(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """A turn about the axis takes much of the child into its parent, a turn about another axis of the frame does not.

    Measured is the share of points of the child's hull inside the parent's hull over the range of the joint. About
    another axis it changes by at most 0.29 less on 146 of 147 good joints. A note from 0.3 less on, with the axis to
    write, where at most a third of the file's joints come half as far: simple arms are drawn through themselves.
    """
    slips = [(joint, axis_slip(joint, parent, child, pose)) for joint, parent, child, pose in _neighbours(document)]
    through = sum(slip is not None and slip.cut > FREER / 2.0 for _, slip in slips)
    for joint, slip in slips if 3 * through <= len(slips) else ():
        if slip is not None and slip.cut > FREER:
            what = f"the axis turns {joint.child} into {joint.parent}: {slip.says}"
            why = f"{slip.cut:.2g} of the child's hull less would go into the parent's"
            instead = f'<axis xyz="{vector_text(slip.values)}"/>'
            yield UrdfFinding(what, why, joint.place_of("axis"), joint.subject, instead, "possible", link=joint.child)


def _at_origin(
    document: UrdfDocument, joint: JointElement, what: str, why: str, slip: JointSlip | None, noted: bool = False
) -> UrdfFinding:
    instead = ""
    bodies = bodies_of(document)
    whole = bodies[joint.parent].whole and bodies[joint.child].whole
    severity: FindingSeverity | None = None if whole and not noted else "note"
    if slip is not None and slip.cut > _NAMED and joint.origin.rpy is not None:
        what = f"{slip.says}: {what}"
        why = f"{why}; with it put right the joint lies {slip.cut:.2g} diameters of {joint.parent} nearer to that"
        instead = f'<origin xyz="{vector_text(slip.values)}" rpy="{vector_text(joint.origin.rpy)}"/>'
    return UrdfFinding(what, why, joint.origin.place, joint.subject, instead, "likely", "", severity, joint.child)


def _neighbours(document: UrdfDocument) -> Iterable[tuple[JointElement, Hull, Hull, Array]]:
    """The turning or sliding joints with a hull on both sides, and the child's pose in the parent at q = 0.

    Without those of links whose shapes are in another unit: that is said of the shapes.
    """
    bodies, off = bodies_of(document), misscaled(document)
    for joint in document.joints:
        if {joint.parent, joint.child} & off:
            continue
        parent, child, pose = bodies.get(joint.parent), bodies.get(joint.child), joint.origin.pose
        if joint.moves and pose is not None and parent and child and parent.hull and child.hull:
            yield joint, parent.hull, child.hull, pose


def remarks(document: UrdfDocument) -> Iterable[str]:
    """What cannot be judged because links have no shapes."""
    if document.is_drawn_here:
        yield f"shapes {DRAWN_HERE}: mass, centre and inertia are not held against them"
        return
    bodies = bodies_of(document)
    heavy = [x for x in bodies.values() if x.link.name in document.moved and x.link.inertial and x.link.inertial.mass]
    unseen = [x.link.name for x in heavy if x.hull is None]
    if heavy and len(unseen) == len(heavy):
        yield "no shapes: a third of the faults cannot be seen (mass, centre and inertia against the body)"
    elif unseen:
        yield f"no shapes with a volume: {', '.join(unseen)}; there a third of the faults cannot be seen"
