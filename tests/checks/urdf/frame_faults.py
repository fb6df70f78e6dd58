"""Faults in the frame of a usable `<inertial>`: its centre, its angles, the point that the tensor is about.

Each edit returns the size of the fault, None where it would change nothing.
"""

import math

import numpy as np

from tests.checks.urdf.inertial_faults import LEAST_PRODUCT, ratio_of
from tests.checks.urdf.plant_site import (
    PlantSite,
    angles_of,
    cells_of,
    centre_of,
    matrix_of,
    rotation,
    tensor_cells,
    write_origin,
    write_tensor,
)

LEAST_SHIFT = 1e-3
"""Of the diameter: a centre that moves by less has no fault."""
_CYCLE = [1, 2, 0]


def centre_times(site: PlantSite, factor: float) -> float | None:
    """The centre in another unit; size: its shift in diameters."""
    return _moved(site, centre_of(site.inertial) * factor)


def centre_sign(site: PlantSite, rank: int) -> float | None:
    """The sign of the largest (0) or second (1) coordinate of the centre; size: its shift in diameters."""
    centre = centre_of(site.inertial)
    centre[np.argsort(-np.abs(centre), kind="stable")[rank]] *= -1
    return _moved(site, centre)


def centre_axes(site: PlantSite) -> float | None:
    """The coordinates of the centre in another order; size: its shift in diameters."""
    return _moved(site, centre_of(site.inertial)[_CYCLE])


def centre_in_parent(site: PlantSite) -> float | None:
    """The centre in the frame of the parent link; size: its shift in diameters."""
    turn = rotation(angles_of(site.joint))
    return _moved(site, centre_of(site.joint) + turn @ centre_of(site.inertial))


def _moved(site: PlantSite, centre: np.ndarray) -> float | None:
    shift = float(np.linalg.norm(centre - centre_of(site.inertial))) / site.diameter
    write_origin(site.inertial, xyz=centre)
    return shift if shift > LEAST_SHIFT else None


def angles_in_degrees(site: PlantSite) -> float | None:
    """rpy of the tensor in degrees; size: the largest angle [rad]."""
    angles = angles_of(site.inertial)
    write_origin(site.inertial, rpy=np.degrees(angles))
    return _turned(angles)


def angles_sign(site: PlantSite) -> float | None:
    """rpy of the tensor turned the other way; size: the largest angle [rad]."""
    angles = angles_of(site.inertial)
    write_origin(site.inertial, rpy=-angles)
    half_turns = np.abs(angles) > math.pi - 1e-3
    return _turned(np.where(half_turns, 0.0, angles))


def _turned(angles: np.ndarray) -> float | None:
    largest = float(np.abs(angles).max())
    return largest if largest > 1e-3 else None


def quarter_roll(site: PlantSite) -> float | None:
    """90 degrees more about x; size: the ratio of iyy and izz, which it exchanges."""
    inertial = site.inertial
    cells = tensor_cells(inertial)
    write_origin(inertial, rpy=np.add(angles_of(inertial), [math.pi / 2, 0.0, 0.0]))
    return ratio_of(cells[3], cells[5])


def mirrored(site: PlantSite) -> float | None:
    """The inertial of the other arm of a pair, y to -y; size: the shift of the centre in diameters."""
    inertial = site.inertial
    cells, centre, angles = tensor_cells(inertial), centre_of(inertial), angles_of(inertial)
    write_tensor(inertial, cells * [1, -1, 1, 1, -1, 1])
    write_origin(inertial, xyz=centre * [1, -1, 1], rpy=angles * [-1, 1, -1])
    shift = 2.0 * abs(centre[1]) / site.diameter
    products = np.abs(cells[[1, 4]]).max() > LEAST_PRODUCT * np.sort(cells[[0, 3, 5]])[1]
    return float(shift) if shift > LEAST_SHIFT or products else None


def about_joint(site: PlantSite) -> float | None:
    """The tensor about the joint's frame; size: m c^2 over the largest diagonal."""
    inertial = site.inertial
    c, cells = centre_of(inertial), tensor_cells(inertial)
    mass, turn = float(inertial.find("mass").get("value")), rotation(angles_of(inertial))
    added = mass * (c @ c * np.eye(3) - np.outer(c, c))
    write_tensor(inertial, cells + cells_of(turn.T @ added @ turn))
    size = float(mass * (c @ c) / np.linalg.eigvalsh(matrix_of(cells)).max())
    return size if size > LEAST_PRODUCT else None
