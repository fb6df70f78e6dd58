"""Links and joints of a URDF, each number as written; what cannot be read is None and has a finding of its own."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.urdf.xml_tree import Place, XmlElement, numbers, scalar, vector
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.spatial import from_rpy

MOMENTS = ("ixx", "iyy", "izz")
TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
GEOMETRY: Mapping[str, tuple[str, ...]] = {
    "box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "capsule": ("radius", "length"),
    "mesh": (),
}  # fmt: skip
"""Kinds of shapes and the attributes that give their size."""


@dataclass(frozen=True, slots=True, eq=False)
class OriginElement:
    """`<origin>`: shift [m] and fixed-axis angles roll, pitch, yaw [rad]; zeros where it is not written."""

    place: Place
    element: XmlElement | None
    xyz: Array | None
    rpy: Array | None

    @property
    def rotation(self) -> Array | None:
        """The rotation, (3, 3)."""
        return None if self.rpy is None else from_rpy(self.rpy)

    @property
    def pose(self) -> Array | None:
        """The homogeneous matrix, (4, 4)."""
        rotation = self.rotation
        if rotation is None or self.xyz is None:
            return None
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = rotation, self.xyz
        return out


@dataclass(frozen=True, slots=True, eq=False)
class InertialElement:
    """`<inertial>`: mass [kg], centre of mass [m], tensor [kg m^2] about it."""

    place: Place
    element: XmlElement
    origin: OriginElement
    mass: float | None
    tensor: Array | None
    """As written, in the axes of its `<origin>`; (3, 3)."""
    mass_place: Place
    tensor_place: Place

    @property
    def com(self) -> Array | None:
        """Centre of mass in the link frame, (3,)."""
        return self.origin.xyz

    @property
    def inertia(self) -> Array | None:
        """The tensor about the centre of mass, in the axes of the link; (3, 3)."""
        rotation = self.origin.rotation
        if rotation is None or self.tensor is None:
            return None
        return np.asarray(rotation @ self.tensor @ rotation.T)

    @property
    def is_complete(self) -> bool:
        """Mass, centre and tensor can all be read."""
        return self.mass is not None and self.com is not None and self.inertia is not None

    @property
    def is_zero(self) -> bool:
        """Mass and tensor are written as 0: an element that stands for none."""
        return self.mass == 0.0 and self.tensor is not None and not self.tensor.any()


@dataclass(frozen=True, slots=True, eq=False)
class ShapeElement:
    """`<visual>` or `<collision>`."""

    role: str
    kind: str
    """Tag of the geometry; empty where there is none."""
    size: tuple[float, ...] | None
    """box: x y z; cylinder and capsule: radius, length; sphere: radius [m]; empty for a mesh."""
    mesh: str
    """File name of a mesh as written."""
    scale: Array | None
    origin: OriginElement
    geometry_place: Place


@dataclass(frozen=True, slots=True, eq=False)
class LinkElement:
    """`<link>`."""

    name: str
    place: Place
    element: XmlElement
    inertial: InertialElement | None
    shapes: tuple[ShapeElement, ...]

    @property
    def subject(self) -> str:
        """The link in words."""
        return f"link {self.name}"


@dataclass(frozen=True, slots=True, eq=False)
class JointElement:
    """`<joint>`: its ends, its axis as written (x where it is not), limits [rad, m, N m, N, rad/s, m/s]."""

    name: str
    place: Place
    element: XmlElement
    type: str
    parent: str
    child: str
    origin: OriginElement
    axis: Array | None
    limit: XmlElement | None
    lower: float | None
    upper: float | None
    effort: float | None
    velocity: float | None
    mimic: str | None
    """The joint that it follows."""

    @property
    def subject(self) -> str:
        """The joint in words."""
        return f"joint {self.name}"

    @property
    def moves(self) -> bool:
        """Whether its child can move in its parent."""
        return self.type != "fixed"

    def place_of(self, tag: str) -> Place:
        """The place of its first child of this tag, or its own."""
        child = self.element.child(tag)
        return self.place if child is None else child.place


def origin_of(element: XmlElement) -> OriginElement:
    """The `<origin>` of an element."""
    origin = element.child("origin")
    zero = (0.0, 0.0, 0.0)
    place = element.place if origin is None else origin.place
    return OriginElement(place, origin, vector(origin, "xyz", zero), vector(origin, "rpy", zero))


def link_of(element: XmlElement) -> LinkElement:
    """A link from its element."""
    inertial = element.child("inertial")
    shapes = [x for x in element.children if x.tag in ("visual", "collision")]
    read = None if inertial is None else _inertial(inertial)
    name = element.attributes.get("name", "")
    return LinkElement(name, element.place, element, read, tuple(map(_shape, shapes)))


def joint_of(element: XmlElement) -> JointElement:
    """A joint from its element."""
    limit, mimic = element.child("limit"), element.child("mimic")
    lower, upper, effort, velocity = (scalar(limit, name) for name in ("lower", "upper", "effort", "velocity"))
    parent, child = (x.attributes.get("link", "") if (x := element.child(tag)) else "" for tag in ("parent", "child"))
    return JointElement(
        element.attributes.get("name", ""), element.place, element, element.attributes.get("type", ""), parent, child,
        origin_of(element), vector(element.child("axis"), "xyz", (1.0, 0.0, 0.0)), limit, lower, upper, effort,
        velocity, None if mimic is None else mimic.attributes.get("joint", ""),
    )  # fmt: skip


def _inertial(element: XmlElement) -> InertialElement:
    mass, inertia = element.child("mass"), element.child("inertia")
    values = {name: scalar(inertia, name) for name in TENSOR}
    if inertia is not None:  # products that are not written are 0, as engines read them
        values |= {name: 0.0 for name in TENSOR if name not in MOMENTS and name not in inertia.attributes}
    xx, xy, xz, yy, yz, zz = values.values()
    tensor = None
    if None not in values.values():
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=float)
    places = [element.place if x is None else x.place for x in (mass, inertia)]
    return InertialElement(element.place, element, origin_of(element), scalar(mass, "value"), tensor, *places)


def _shape(element: XmlElement) -> ShapeElement:
    geometry = element.child("geometry")
    solid = next((x for x in geometry.children if x.tag in GEOMETRY), None) if geometry else None
    if solid is None:
        return ShapeElement(element.tag, "", None, "", None, origin_of(element), element.place)
    scale, mesh = vector(solid, "scale", (1.0, 1.0, 1.0)), solid.attributes.get("filename", "")
    return ShapeElement(element.tag, solid.tag, _size(solid), mesh, scale, origin_of(element), solid.place)


def _size(solid: XmlElement) -> tuple[float, ...] | None:
    if solid.tag == "box":
        values = numbers(solid.attributes.get("size"))
        return values if values is not None and len(values) == 3 else None
    read = [scalar(solid, name) for name in GEOMETRY[solid.tag]]
    return None if None in read else tuple(v for v in read if v is not None)
