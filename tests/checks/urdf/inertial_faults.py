"""Faults in the mass and the tensor of a usable `<inertial>`; an edit returns the size, None where nothing changes."""

import math
import xml.etree.ElementTree as ET

import numpy as np

from tests.checks.urdf.plant_site import (
    DIAGONAL,
    PlantSite,
    centre_of,
    number,
    tensor_cells,
    usable_inertial,
    write_tensor,
)

LEAST_RATIO = 1.01
LEAST_PRODUCT = 0.01
"""Of the middle diagonal: products below count as none."""


def tensor_times(site: PlantSite, factor: float) -> float | None:
    """The whole tensor in another power of ten; size: the factor."""
    write_tensor(site.inertial, tensor_cells(site.inertial) * factor)
    return factor


def mass_times(site: PlantSite, factor: float) -> float | None:
    """The mass in another unit; size: the factor."""
    mass = site.inertial.find("mass")
    mass.set("value", number(float(mass.get("value")) * factor))
    return factor


def diagonals_exchanged(site: PlantSite, first: str, second: str) -> float | None:
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


def row_order(site: PlantSite) -> float | None:
    """Data in the order ixx iyy izz ixy ixz iyz read as ixx ixy ixz iyy iyz izz."""
    write_tensor(site.inertial, tensor_cells(site.inertial)[[0, 3, 5, 1, 2, 4]])
    return 1.0


def products_permuted(site: PlantSite) -> float | None:
    """ixy, ixz, iyz in the order ixz, iyz, ixy; size: the largest product over the middle diagonal."""
    return _products(site, lambda xy, xz, yz: (xz, yz, xy))


def product_signs(site: PlantSite) -> float | None:
    """Positive integrals in place of the tensor's products; size: the largest product over the middle diagonal."""
    return _products(site, lambda xy, xz, yz: (-xy, -xz, -yz))


def _products(site: PlantSite, change) -> float | None:
    inertial = site.inertial
    cells = tensor_cells(inertial)
    middle = np.sort(cells[[0, 3, 5]])[1]
    before = cells[[1, 2, 4]]
    cells[[1, 2, 4]] = after = np.array(change(*before))
    write_tensor(inertial, cells)
    size = float(np.abs(before).max() / middle) if middle > 0.0 else 0.0
    return size if np.abs(after - before).max() > LEAST_PRODUCT * middle else None


def triangle(site: PlantSite) -> float | None:
    """The largest diagonal half as large again as the other two together; size: 1.5."""
    inertia = site.inertial.find("inertia")
    largest = max(DIAGONAL, key=lambda name: float(inertia.get(name)))
    rest = sum(float(inertia.get(name)) for name in DIAGONAL if name != largest)
    inertia.set(largest, number(1.5 * rest))
    return 1.5


def not_definite(site: PlantSite) -> float | None:
    """ixy above the geometric mean of ixx and iyy; size: the ratio."""
    inertia = site.inertial.find("inertia")
    inertia.set("ixy", number(1.2 * math.sqrt(abs(float(inertia.get("ixx")) * float(inertia.get("iyy"))))))
    return 1.2


def negative(site: PlantSite) -> float | None:
    """iyy negative."""
    inertia = site.inertial.find("inertia")
    inertia.set("iyy", number(-abs(float(inertia.get("iyy")))))
    return 1.0


def placeholder(site: PlantSite, mass: float, moment: float) -> float | None:
    """A mass and a diagonal tensor that somebody typed to make a program run."""
    site.inertial.find("mass").set("value", number(mass))
    write_tensor(site.inertial, np.array([moment, 0, 0, moment, 0, moment]))
    return 1.0


def massless(site: PlantSite) -> float | None:
    """Mass 0, the tensor kept."""
    site.inertial.find("mass").set("value", "0")
    return 1.0


def missing(site: PlantSite) -> float | None:
    """No `<inertial>`."""
    site.link.remove(site.inertial)
    return 1.0


def neighbours(site: PlantSite) -> float | None:
    """The `<inertial>` of the parent link, or of the next one; size: the ratio of the masses."""
    own, others = site.inertial, [site.parent, *_children(site)]
    other = next((x for x in map(usable_inertial, others) if x is not None), None)
    if other is None:
        return None
    masses = [float(x.find("mass").get("value")) for x in (own, other)]
    same = np.allclose(tensor_cells(own), tensor_cells(other)) and np.allclose(centre_of(own), centre_of(other))
    own.clear()
    own.extend(other)
    return None if same and ratio_of(*masses) is None else max(masses) / min(masses)


def _children(site: PlantSite) -> list[ET.Element]:
    """The links that joints carry from this link."""
    name = site.link.get("name")
    names = [j.find("child").get("link") for j in site.robot.findall("joint") if j.find("parent").get("link") == name]
    return [x for x in site.robot.findall("link") if x.get("name") in names]
