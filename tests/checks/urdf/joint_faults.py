"""Faults in a `<joint>`, and of spelling, names, numbers and files; an edit returns the size, None where it is none."""

import copy
import xml.etree.ElementTree as ET

import numpy as np
from scipy.spatial.transform import Rotation

from tests.checks.urdf import plant_site

LEAST_TURN = 0.01
"""[rad]"""
BOUNDED, TURNS_OR_SLIDES = ("revolute", "prismatic"), ("revolute", "continuous", "prismatic")


def limit_times(site: plant_site.PlantSite, names: list[str], factor: float) -> float | None:
    """Limits in another unit, or 0; size: the factor."""
    limit = site.joint.find("limit")
    values = [] if limit is None else [_number(limit.get(name)) for name in names]
    if None in values or not any(values):
        return None
    for name, value in zip(names, values, strict=True):
        limit.set(name, plant_site.number(value * factor))
    return factor or 1.0


def _number(text: str | None) -> float | None:
    try:
        return float(text)
    except (TypeError, ValueError):
        return None


def _limits(site: plant_site.PlantSite) -> tuple[float, float] | None:
    """lower < upper of a joint that has them."""
    limit = site.joint.find("limit")
    if site.joint.get("type") not in BOUNDED or limit is None:
        return None
    lower, upper = _number(limit.get("lower")), _number(limit.get("upper"))
    return (lower, upper) if lower is not None and upper is not None and lower < upper else None


def positions(site: plant_site.PlantSite, kind: str, factor: float) -> float | None:
    """lower and upper of a joint of this kind in another unit; size: the range as written [rad, m]."""
    limits = _limits(site)
    if limits is None or site.joint.get("type") != kind:
        return None
    done = limit_times(site, ["lower", "upper"], factor)
    return None if done is None else (limits[1] - limits[0]) * factor


def range_changed(site: plant_site.PlantSite, exchanged: bool) -> float | None:
    """lower and upper exchanged, or both the upper."""
    if (limits := _limits(site)) is None:
        return None
    limit = site.joint.find("limit")
    upper = limit.get("upper")
    if exchanged:
        limit.set("upper", plant_site.number(limits[0]))
    limit.set("lower", plant_site.number(limits[1]) if exchanged else upper)
    return 1.0


def origin(site: plant_site.PlantSite, change: str, factor: float = 1.0) -> float | None:
    """The joint's origin as `moved` has it; size: its shift in diameters of the link."""
    return plant_site.moved(site, site.joint, change, factor)


def origin_angles_in_degrees(site: plant_site.PlantSite) -> float | None:
    """rpy of the joint's origin in degrees; size: the largest angle [rad]."""
    return plant_site.turned_in_degrees(site.joint)


def origin_angles_of_quaternion(site: plant_site.PlantSite) -> float | None:
    """x, y, z of the quaternion of the joint's origin in place of roll, pitch, yaw; size: the angle [rad]."""
    turn = Rotation.from_euler("xyz", plant_site.angles_of(site.joint))
    if turn.magnitude() < LEAST_TURN:
        return None
    plant_site.write_origin(site.joint, rpy=turn.as_quat(canonical=True)[:3])
    return float(turn.magnitude())


def loss_negative(site: plant_site.PlantSite, name: str) -> float | None:
    """Damping or friction below 0."""
    dynamics = site.joint.find("dynamics")
    if dynamics is None:
        dynamics = ET.SubElement(site.joint, "dynamics")
    dynamics.set(name, "-0.5")
    return 0.5


def axis(site: plant_site.PlantSite, change: str) -> float | None:
    """The axis reversed, permuted, not a unit vector, or zero."""
    element = site.joint.find("axis")
    if element is None or site.joint.get("type") not in TURNS_OR_SLIDES:
        return None
    before = plant_site.vector(element, "xyz", "1 0 0")
    across = before[plant_site.CYCLE]
    after = {"reversed": -before, "permuted": across, "not unit": before + across, "zero": 0 * before}[change]
    element.set("xyz", " ".join(plant_site.number(x) for x in after))
    return None if np.allclose(before, after) else 1.0


def _element(site: plant_site.PlantSite, path: str) -> ET.Element | None:
    """`inertial/mass` and `inertial` of the link, `limit` of the joint; None where the inertial is not usable."""
    if path.startswith("inertial"):
        return site.inertial if path == "inertial" or site.inertial is None else site.inertial.find(path[9:])
    return site.joint.find(path)


def mesh(site: plant_site.PlantSite, factor: float = 0.0) -> float | None:
    """The link's meshes in another unit; size: the factor; for 0 the first one's file is not there."""
    meshes = [x for role in ("visual", "collision") for shape in site.link.findall(role) for x in shape.iter("mesh")]
    for one in meshes if factor else ():
        one.set("scale", " ".join(plant_site.number(x) for x in plant_site.vector(one, "scale", "1 1 1") * factor))
    for one in meshes[:1] if not factor else ():
        stem, dot, ending = one.get("filename").rpartition(".")
        one.set("filename", f"{stem}_gone{dot}{ending}")
    return factor or 1.0 if meshes else None


def spoilt(site: plant_site.PlantSite, how: str) -> float | None:
    """A joint without the limits that it needs, of an unknown parent, fixed with limits; a link or joint twice."""
    joint, limit = site.joint, site.joint.find("limit")
    others = [j.get("name") for j in plant_site.moving_joints(site.robot) if j is not joint]
    if how == "no limit" and joint.get("type") in BOUNDED and limit is not None:
        joint.remove(limit)
    elif how == "parent unknown":
        joint.find("parent").set("link", joint.find("parent").get("link") + "_gone")
    elif how == "fixed" and limit is not None:
        joint.set("type", "fixed")
    elif how == "link twice":
        site.robot.append(copy.deepcopy(site.link))
    elif how == "joint twice" and others:
        joint.set("name", others[-1])
    else:
        return None
    return 1.0


def misspelt(site: plant_site.PlantSite, path: str, written: str, name: str = "") -> float | None:
    """A tag or an attribute with a slip of the keyboard, or nan in its place, as a program wrote it."""
    element = _element(site, path)
    if element is None or (not name and path == "limit" and site.joint.get("type") == "continuous"):
        return None
    if written == "nan":
        element.set(name, "nan")
    elif not name:
        element.tag = written
    elif element.get(name) is None:
        return None
    else:
        attributes = {written if key == name else key: value for key, value in element.items()}
        element.attrib.clear()
        element.attrib.update(attributes)
    return 1.0
