"""Faults in a `<joint>`; each edit returns the size of the fault, None where it would change nothing."""

import math
import xml.etree.ElementTree as ET

import numpy as np
from scipy.spatial.transform import Rotation

from tests.checks.urdf.plant_site import PlantSite, angles_of, centre_of, number, vector, write_origin

LEAST_TURN = 0.01
"""[rad]"""
LEAST_SHIFT = 1e-3
"""Of the link's diameter."""
_CYCLE = [1, 2, 0]


def limit_times(site: PlantSite, names: list[str], factor: float) -> float | None:
    """Limits in another unit; size: the factor."""
    limit = site.joint.find("limit")
    values = [] if limit is None else [_number(limit.get(name)) for name in names]
    if None in values or not any(values):
        return None
    for name, value in zip(names, values, strict=True):
        limit.set(name, number(value * factor))
    return factor


def _number(text: str | None) -> float | None:
    try:
        return float(text)
    except (TypeError, ValueError):
        return None


def positions_in_degrees(site: PlantSite) -> float | None:
    """lower and upper in degrees; size: the range as written [rad]."""
    if site.joint.get("type") != "revolute":
        return None
    limits = _limits(site)
    done = limit_times(site, ["lower", "upper"], 180.0 / math.pi)
    return None if done is None or limits is None else (limits[1] - limits[0]) * done


def range_closed(site: PlantSite) -> float | None:
    """lower equal to upper."""
    if _limits(site) is None:
        return None
    limit = site.joint.find("limit")
    limit.set("lower", limit.get("upper"))
    return 1.0


def range_exchanged(site: PlantSite) -> float | None:
    """lower and upper exchanged."""
    if (limits := _limits(site)) is None:
        return None
    limit = site.joint.find("limit")
    limit.set("lower", number(limits[1])), limit.set("upper", number(limits[0]))
    return 1.0


def _limits(site: PlantSite) -> tuple[float, float] | None:
    """lower < upper of a joint that has them."""
    limit = site.joint.find("limit")
    if site.joint.get("type") not in ("revolute", "prismatic") or limit is None:
        return None
    lower, upper = _number(limit.get("lower")), _number(limit.get("upper"))
    return (lower, upper) if lower is not None and upper is not None and lower < upper else None


def limit_missing(site: PlantSite) -> float | None:
    """No `<limit>` at a joint that needs one."""
    limit = site.joint.find("limit")
    if site.joint.get("type") not in ("revolute", "prismatic") or limit is None:
        return None
    site.joint.remove(limit)
    return 1.0


def limit_zero(site: PlantSite, name: str) -> float | None:
    """Effort or velocity 0."""
    limit = site.joint.find("limit")
    if limit is None or not _number(limit.get(name)):
        return None
    limit.set(name, "0")
    return 1.0


def origin_times(site: PlantSite, factor: float) -> float | None:
    """The joint's origin in another unit; size: its shift in diameters of the link."""
    return _moved(site, centre_of(site.joint) * factor)


def origin_sign(site: PlantSite) -> float | None:
    """The sign of the largest coordinate of the origin; size: its shift in diameters of the link."""
    origin = centre_of(site.joint)
    origin[np.argmax(np.abs(origin))] *= -1
    return _moved(site, origin)


def origin_axes(site: PlantSite) -> float | None:
    """The coordinates of the origin in another order; size: its shift in diameters of the link."""
    return _moved(site, centre_of(site.joint)[_CYCLE])


def origin_lost(site: PlantSite) -> float | None:
    """The origin at the parent's frame; size: its shift in diameters of the link."""
    return _moved(site, np.zeros(3))


def _moved(site: PlantSite, origin: np.ndarray) -> float | None:
    shift = float(np.linalg.norm(origin - centre_of(site.joint))) / site.diameter
    write_origin(site.joint, xyz=origin)
    return shift if shift > LEAST_SHIFT else None


def origin_angles_in_degrees(site: PlantSite) -> float | None:
    """rpy of the joint's origin in degrees; size: the largest angle [rad]."""
    angles = angles_of(site.joint)
    write_origin(site.joint, rpy=np.degrees(angles))
    largest = float(np.abs(angles).max())
    return largest if largest > 1e-3 else None


def origin_angles_of_quaternion(site: PlantSite) -> float | None:
    """x, y, z of the quaternion of the joint's origin in place of roll, pitch, yaw; size: the angle [rad]."""
    turn = Rotation.from_euler("xyz", angles_of(site.joint))
    if turn.magnitude() < LEAST_TURN:
        return None
    write_origin(site.joint, rpy=turn.as_quat(canonical=True)[:3])
    return float(turn.magnitude())


def loss_negative(site: PlantSite, name: str) -> float | None:
    """Damping or friction below 0."""
    dynamics = site.joint.find("dynamics")
    if dynamics is None:
        dynamics = ET.SubElement(site.joint, "dynamics")
    dynamics.set(name, "-0.5")
    return 0.5


def travel_times(site: PlantSite, factor: float) -> float | None:
    """The position limits of a slide in another unit; size: its travel as written [m]."""
    limits = _limits(site)
    if limits is None or site.joint.get("type") != "prismatic":
        return None
    limit_times(site, ["lower", "upper"], factor)
    return (limits[1] - limits[0]) * factor


def axis(site: PlantSite, change: str) -> float | None:
    """The axis reversed, permuted, not a unit vector, or zero."""
    element = site.joint.find("axis")
    if element is None or site.joint.get("type") not in ("revolute", "continuous", "prismatic"):
        return None
    before = vector(element, "xyz", "1 0 0")
    across = before[_CYCLE]
    after = {"reversed": -before, "permuted": across, "not unit": before + across, "zero": 0 * before}[change]
    element.set("xyz", " ".join(number(x) for x in after))
    return None if np.allclose(before, after) else 1.0


def parent_unknown(site: PlantSite) -> float | None:
    """A parent that is no link of the file."""
    parent = site.joint.find("parent")
    parent.set("link", parent.get("link") + "_gone")
    return 1.0


def made_fixed(site: PlantSite) -> float | None:
    """type="fixed" while the limits stay."""
    if site.joint.find("limit") is None:
        return None
    site.joint.set("type", "fixed")
    return 1.0
