"""Faults in a usable `<inertial>`; an edit returns the size, None where nothing changes."""

import math
import xml.etree.ElementTree as ET

import numpy as np

from tests.checks.urdf import plant_site

LEAST_RATIO = 1.01
LEAST_PRODUCT = 0.01
"""Of the middle diagonal: products below count as none."""


def tensor_times(site: plant_site.PlantSite, factor: float) -> float | None:
    """The whole tensor in another power of ten; size: the factor."""
    plant_site.write_tensor(site.inertial, plant_site.tensor_cells(site.inertial) * factor)
    return factor


def mass_times(site: plant_site.PlantSite, factor: float) -> float | None:
    """The mass in another unit, or 0; size: the factor."""
    mass = site.inertial.find("mass")
    mass.set("value", plant_site.number(float(mass.get("value")) * factor))
    return factor or 1.0


def diagonals_exchanged(site: plant_site.PlantSite, first: str, second: str) -> float | None:
    """Two diagonals exchanged; size: their ratio."""
    inertia = site.inertial.find("inertia")
    a, b = inertia.get(first), inertia.get(second)
    inertia.set(first, b), inertia.set(second, a)
    return ratio_of(float(a), float(b))


def ratio_of(a: float, b: float) -> float | None:
    """The larger over the smaller of two moments; None where they are the same to 1 %, or not positive."""
    if min(a, b) <= 0.0:
        return None
    ratio = max(a, b) / min(a, b)
    return ratio if ratio >= LEAST_RATIO else None


def row_order(site: plant_site.PlantSite) -> float | None:
    """Data in the order ixx iyy izz ixy ixz iyz read as ixx ixy ixz iyy iyz izz."""
    plant_site.write_tensor(site.inertial, plant_site.tensor_cells(site.inertial)[[0, 3, 5, 1, 2, 4]])
    return 1.0


def products(site: plant_site.PlantSite, permuted: bool) -> float | None:
    """ixz, iyz, ixy for ixy, ixz, iyz, or positive integrals; size: the largest product over the middle diagonal."""
    cells = plant_site.tensor_cells(site.inertial)
    middle, before = np.sort(cells[[0, 3, 5]])[1], cells[[1, 2, 4]]
    cells[[1, 2, 4]] = after = before[[1, 2, 0]] if permuted else -before
    plant_site.write_tensor(site.inertial, cells)
    size = float(np.abs(before).max() / middle) if middle > 0.0 else 0.0
    return size if np.abs(after - before).max() > LEAST_PRODUCT * middle else None


def impossible(site: plant_site.PlantSite, how: str) -> float | None:
    """The largest diagonal 1.5 times the others together; ixy 1.2 times what its diagonals bear; iyy negative."""
    inertia = site.inertial.find("inertia")
    moments = {name: float(inertia.get(name)) for name in plant_site.DIAGONAL}
    largest = max(plant_site.DIAGONAL, key=lambda name: moments[name])
    name, value, size = {
        "triangle": (largest, 1.5 * sum(x for key, x in moments.items() if key != largest), 1.5),
        "not definite": ("ixy", 1.2 * math.sqrt(abs(moments["ixx"] * moments["iyy"])), 1.2),
        "negative": ("iyy", -abs(moments["iyy"]), 1.0),
    }[how]
    inertia.set(name, plant_site.number(value))
    return size


def placeholder(site: plant_site.PlantSite, mass: float, moment: float) -> float | None:
    """A mass and a diagonal tensor that somebody, or a program, wrote who has none."""
    inertial = site.inertial
    inertial.find("mass").set("value", plant_site.number(mass))
    plant_site.write_tensor(inertial, np.array([moment, 0, 0, moment, 0, moment]))
    return 1.0


def missing(site: plant_site.PlantSite) -> float | None:
    """No `<inertial>`."""
    site.link.remove(site.inertial)
    return 1.0


def neighbours(site: plant_site.PlantSite) -> float | None:
    """The `<inertial>` of the parent link, or of the next one; size: the ratio of the masses."""
    own, others = site.inertial, [site.parent, *_children(site)]
    other = next((x for x in map(plant_site.usable_inertial, others) if x is not None), None)
    if other is None:
        return None
    masses = [float(x.find("mass").get("value")) for x in (own, other)]
    same = np.allclose(plant_site.tensor_cells(own), plant_site.tensor_cells(other)) and np.allclose(
        plant_site.centre_of(own), plant_site.centre_of(other)
    )
    own.clear()
    own.extend(other)
    return None if same and ratio_of(*masses) is None else max(masses) / min(masses)


def _children(site: plant_site.PlantSite) -> list[ET.Element]:
    """The links that joints carry from this link."""
    name = site.link.get("name")
    names = [j.find("child").get("link") for j in site.robot.findall("joint") if j.find("parent").get("link") == name]
    return [x for x in site.robot.findall("link") if x.get("name") in names]


def centre(site: plant_site.PlantSite, change: str, factor: float = 1.0) -> float | None:
    """The centre as `moved` has it, or in the frame of the parent link; size: its shift in diameters."""
    return plant_site.moved(site, site.inertial, change, factor)


def angles_in_degrees(site: plant_site.PlantSite) -> float | None:
    """rpy of the tensor in degrees; size: the largest angle [rad]."""
    return plant_site.turned_in_degrees(site.inertial)


def angles_sign(site: plant_site.PlantSite) -> float | None:
    """rpy of the tensor turned the other way; size: the largest angle [rad], where half a turn is none."""
    angles = plant_site.angles_of(site.inertial)
    plant_site.write_origin(site.inertial, rpy=-angles)
    largest = float(np.where(np.abs(angles) > math.pi - 1e-3, 0.0, np.abs(angles)).max())
    return largest if largest > 1e-3 else None


def quarter_roll(site: plant_site.PlantSite) -> float | None:
    """90 degrees more about x; size: the ratio of iyy and izz, which it exchanges."""
    cells = plant_site.tensor_cells(site.inertial)
    plant_site.write_origin(site.inertial, rpy=np.add(plant_site.angles_of(site.inertial), [math.pi / 2, 0.0, 0.0]))
    return ratio_of(cells[3], cells[5])


def mirrored(site: plant_site.PlantSite) -> float | None:
    """The inertial of the other arm of a pair, y to -y; size: the shift of the centre in diameters."""
    inertial = site.inertial
    cells, com, angles = (
        plant_site.tensor_cells(inertial),
        plant_site.centre_of(inertial),
        plant_site.angles_of(inertial),
    )
    plant_site.write_tensor(inertial, cells * [1, -1, 1, 1, -1, 1])
    plant_site.write_origin(inertial, xyz=com * [1, -1, 1], rpy=angles * [-1, 1, -1])
    shift = 2.0 * abs(com[1]) / site.diameter
    seen = np.abs(cells[[1, 4]]).max() > LEAST_PRODUCT * np.sort(cells[[0, 3, 5]])[1]
    return float(shift) if shift > 1e-3 or seen else None


def about_joint(site: plant_site.PlantSite) -> float | None:
    """The tensor about the joint's frame; size: m c^2 over the largest diagonal."""
    inertial = site.inertial
    c, cells = plant_site.centre_of(inertial), plant_site.tensor_cells(inertial)
    mass, turn = float(inertial.find("mass").get("value")), plant_site.rotation(plant_site.angles_of(inertial))
    added = mass * (c @ c * np.eye(3) - np.outer(c, c))
    plant_site.write_tensor(inertial, cells + plant_site.cells_of(turn.T @ added @ turn))
    size = float(mass * (c @ c) / np.linalg.eigvalsh(plant_site.matrix_of(cells)).max())
    return size if size > LEAST_PRODUCT else None
