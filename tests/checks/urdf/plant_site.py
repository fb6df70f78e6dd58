"""One moving link of a URDF, with the joint that carries it, in a tree of its own that a fault may change."""

import copy
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from lwr_dyn.checks.urdf.hulls import mesh_path

TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
DIAGONAL, PRODUCTS = ("ixx", "iyy", "izz"), ("ixy", "ixz", "iyz")
FIXED = ("fixed",)
CYCLE = [1, 2, 0]
LEAST_SHIFT = 1e-3
"""Of the link's diameter: an origin that moves by less has no fault."""


@dataclass(frozen=True, slots=True, eq=False)
class PlantSite:
    """Where a fault is planted: elements of a tree that belongs to this site."""

    robot: ET.Element
    link: ET.Element
    joint: ET.Element
    diameter: float
    """[m] Of the box about the link's shapes, as the file was before; 0 without shapes."""

    @property
    def inertial(self) -> ET.Element | None:
        """The `<inertial>` where mass, centre and tensor are numbers, and mass and tensor not zero."""
        return usable_inertial(self.link)

    @property
    def parent(self) -> ET.Element | None:
        """The link that the joint starts at."""
        name = self.joint.find("parent").get("link")
        return next((x for x in self.robot.iter("link") if x.get("name") == name), None)


def usable_inertial(link: ET.Element | None) -> ET.Element | None:
    """The `<inertial>` of a link; None where a part is missing, no number or zero."""
    inertial = None if link is None else link.find("inertial")
    if inertial is None or inertial.find("mass") is None or inertial.find("inertia") is None:
        return None
    try:
        mass, tensor = float(inertial.find("mass").get("value")), tensor_cells(inertial)
        centre_of(inertial), angles_of(inertial)
    except (TypeError, ValueError):
        return None
    return inertial if mass > 0.0 and any(tensor) else None


def tensor_cells(inertial: ET.Element) -> np.ndarray:
    """ixx, ixy, ixz, iyy, iyz, izz as written."""
    return np.array([float(inertial.find("inertia").get(name)) for name in TENSOR])


def write_tensor(inertial: ET.Element, cells: np.ndarray) -> None:
    """Write ixx, ixy, ixz, iyy, iyz, izz."""
    for name, value in zip(TENSOR, cells, strict=True):
        inertial.find("inertia").set(name, number(value))


def vector(element: ET.Element | None, name: str, default: str = "0 0 0") -> np.ndarray:
    """A vector of an attribute."""
    text = default if element is None else element.get(name, default)
    values = np.array([float(word) for word in text.split()])
    if values.shape != (3,):
        raise ValueError(text)
    return values


def centre_of(element: ET.Element) -> np.ndarray:
    """xyz of its `<origin>`."""
    return vector(element.find("origin"), "xyz")


def angles_of(element: ET.Element) -> np.ndarray:
    """rpy of its `<origin>`."""
    return vector(element.find("origin"), "rpy")


def write_origin(element: ET.Element, **values: np.ndarray) -> None:
    """Write xyz or rpy of its `<origin>`."""
    origin = element.find("origin")
    origin = ET.SubElement(element, "origin") if origin is None else origin
    for name, value in values.items():
        origin.set(name, " ".join(number(x) for x in value))


def moved(site: PlantSite, element: ET.Element, change: str, factor: float) -> float | None:
    """An `<origin>` in another unit, with the sign of its largest or second coordinate turned, its coordinates in
    another order, at zero, or in the frame of the parent link; size: its shift in diameters of the link."""
    before = centre_of(element)
    signs = np.where(np.arange(3) == np.argsort(-np.abs(before), kind="stable")[int(change == "second sign")], -1, 1)
    in_parent = centre_of(site.joint) + rotation(angles_of(site.joint)) @ before
    after = {"times": before * factor, "sign": before * signs, "second sign": before * signs, "axes": before[CYCLE],
             "lost": np.zeros(3), "in parent": in_parent}[change]  # fmt: skip
    write_origin(element, xyz=after)
    shift = float(np.linalg.norm(after - before)) / site.diameter
    return shift if shift > LEAST_SHIFT else None


def turned_in_degrees(element: ET.Element) -> float | None:
    """rpy of an `<origin>` in degrees; size: the largest angle [rad]."""
    angles = angles_of(element)
    write_origin(element, rpy=np.degrees(angles))
    largest = float(np.abs(angles).max())
    return largest if largest > 1e-3 else None


def number(value: float) -> str:
    """A number as a file holds it."""
    return f"{value:.9g}"


def rotation(angles: np.ndarray) -> np.ndarray:
    """The rotation of roll, pitch and yaw."""
    return Rotation.from_euler("xyz", angles).as_matrix()


def matrix_of(cells: np.ndarray) -> np.ndarray:
    """The symmetric matrix of ixx, ixy, ixz, iyy, iyz, izz."""
    xx, xy, xz, yy, yz, zz = cells
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def cells_of(matrix: np.ndarray) -> np.ndarray:
    """ixx, ixy, ixz, iyy, iyz, izz of a symmetric matrix."""
    return matrix[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]


def moving_joints(robot: ET.Element) -> list[ET.Element]:
    """The joints that move a link of the file, in the file's order."""
    names = {link.get("name") for link in robot.findall("link")}
    joints = [j for j in robot.findall("joint") if j.get("type") not in FIXED and j.find("child") is not None]
    return [j for j in joints if j.find("child").get("link") in names]


def sites(text: str, path: Path) -> Iterator["Sites"]:
    """For each moving link of a URDF, what makes fresh sites of it."""
    robot = ET.fromstring(text)
    for index, joint in enumerate(moving_joints(robot)):
        name = joint.find("child").get("link")
        link = next(x for x in robot.findall("link") if x.get("name") == name)
        yield Sites(robot, index, name, joint.get("name"), shape_diameter(link, path))


@dataclass(frozen=True, slots=True, eq=False)
class Sites:
    """The moving joint of this number, and the link that it carries."""

    robot: ET.Element
    index: int
    link: str
    joint: str
    diameter: float

    def fresh(self) -> PlantSite:
        """A site in a tree of its own."""
        robot = copy.deepcopy(self.robot)
        joint = moving_joints(robot)[self.index]
        link = next(x for x in robot.findall("link") if x.get("name") == self.link)
        return PlantSite(robot, link, joint, self.diameter)


def shape_diameter(link: ET.Element, path: Path) -> float:
    """[m] Diagonal of the box about all shapes of a link, in its axes; 0 where none can be read."""
    corners = [points for role in ("visual", "collision") for x in link.findall(role) for points in [_corners(x, path)]]
    points = [x for x in corners if len(x)]
    return float(np.linalg.norm(np.ptp(np.vstack(points), axis=0))) if points else 0.0


def _corners(shape: ET.Element, path: Path) -> np.ndarray:
    """(n, 3) corners of the box about a shape, in the link's axes [m]."""
    kinds = list(shape.find("geometry")) if shape.find("geometry") is not None else []
    if not kinds:
        return np.zeros((0, 3))
    try:
        box = _box(kinds[0], path)
        return box @ rotation(angles_of(shape)).T + centre_of(shape)
    except (TypeError, ValueError):
        return np.zeros((0, 3))


def _box(kind: ET.Element, path: Path) -> np.ndarray:
    """The eight corners of the box about a primitive or mesh."""
    half = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    if kind.tag == "mesh":
        file = mesh_path(kind.get("filename", ""), path).path
        low, up = mesh_bounds(file) if file else (np.zeros(3), np.zeros(3))
        corners = (half + 0.5) * (up - low) + low
        return (corners if file else corners[:0]) * vector(kind, "scale", "1 1 1")
    if kind.tag == "box":
        return half * vector(kind, "size")
    radius = float(kind.get("radius"))
    return half * [2 * radius, 2 * radius, float(kind.get("length", 2 * radius))]


@lru_cache(maxsize=4096)
def mesh_bounds(file: Path) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest coordinates of a mesh, in its own unit."""
    try:
        bounds = trimesh.load(str(file), process=False).bounds
    except Exception:  # a mesh that trimesh cannot read has no size; it raises what it likes
        bounds = None
    return (np.zeros(3), np.zeros(3)) if bounds is None else (bounds[0], bounds[1])
