"""Faults undone: each odd tensor or centre is tried as if one named slip had been made, and put right.

A slip is named only when putting it right brings the link much nearer to the hull of its own shapes.
S = (tr I / 2 E - I) / m is the covariance of the link's mass; H that of its solid hull. The eigenvalues of H^-1 S are 1
for a full body; those of 25 good arms lie between 0.15 and 2.8.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.checks.urdf.document import inertia_text, vector_text
from lwr_dyn.checks.urdf.elements import InertialElement
from lwr_dyn.checks.urdf.hulls import Hull, depth, directions, reach_along
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.spatial import from_rpy


@dataclass(frozen=True, slots=True, eq=False)
class MassPoint:
    """Mass [kg], centre (3,) [m] and inertia about it (3, 3) [kg m^2], both in the link's axes."""

    mass: float
    com: Array
    inertia: Array


def mass_covariance(inertia: Array, mass: float) -> Array:
    """Covariance of a body's mass, S = (tr I / 2 E - I) / m: (3, 3) array [m^2].

    >>> mass_covariance(np.diag([2.0, 3.0, 4.0]), 1.0).diagonal().tolist()
    [2.5, 1.5, 0.5]
    """
    half = np.trace(inertia, axis1=-2, axis2=-1)[..., None, None] / 2.0
    return np.asarray((half * np.eye(3) - inertia) / mass)


def spread_ratios(inertia: Array, mass: float, hull: Hull) -> Array:
    """The eigenvalues of H^-1 S, smallest first, (..., 3); below 0 for an inertia that no body has.

    `inertia` (..., 3, 3) [kg m^2] is about the centre of mass.
    """
    whiten = np.linalg.inv(np.linalg.cholesky(hull.covariance))
    return np.asarray(np.linalg.eigvalsh(whiten @ mass_covariance(inertia, mass) @ whiten.T), dtype=float)


def log_distance(ratios: Array) -> Array:
    """Length of the logarithms of `spread_ratios`, (...); ratios of 0 or less count as 1e-4."""
    return np.asarray(np.linalg.norm(np.log(np.maximum(ratios, 1e-4)), axis=-1))


def bound_ratio(body: MassPoint, hull: Hull) -> float:
    """Largest variance along a direction over its bound (max - c)(c - min); 0 where the centre is outside.

    No mass within the hull varies more about its centre than half of it at either end (Bhatia and Davis 2000). Tried
    are the principal axes and 600 directions.
    """
    covariance = mass_covariance(body.inertia, body.mass)
    ways = np.vstack([np.linalg.eigh(covariance)[1].T, directions()])
    back, forth = reach_along(hull, ways.T, body.com)
    values = np.einsum("ki,ij,kj->k", ways, covariance, ways)
    inside = (back > 0.0) & (forth > 0.0)
    return float(np.max(np.where(inside, values / np.where(inside, back * forth, 1.0), 0.0)))


def outside(com: Array, hull: Hull) -> float:
    """How far the centre lies outside the hull, over the hull's diameter; below 0 inside."""
    return depth(hull, com) / hull.diameter


def off_centre(com: Array, hull: Hull) -> float:
    """Distance of the centre from the hull's centroid in standard deviations of the hull: sqrt((c-g)' H^-1 (c-g))."""
    away = com - hull.centroid
    return math.sqrt(max(float(away @ np.linalg.solve(hull.covariance, away)), 0.0))


_NAMES = ("ixx", "iyy", "izz")
_AXES = "xyz"
_ANGLES = ("roll", "pitch", "yaw")
_PRODUCTS = ((0, 1), (0, 2), (1, 2))
_ABOUT_JOINT = "inertia about the link frame instead of the centre of mass"
_ROUNDED = 1.001
"""A triangle inequality that rounded numbers break by less than this is kept."""
_FAR = 3.0
"""[m] A centre further than this from its link is in mm, one beyond a tenth of it may be in cm."""
AXES_OF_BASE = "tensors in the axes of the base frame"
IN_BASE = "centres of mass in the base frame"


@dataclass(frozen=True, slots=True, eq=False)
class Undoing:
    """An inertial as it would be without one slip."""

    cause: str  # the slip for the whole file: "inertia about the link frame instead of the centre of mass"
    says: str  # one clause: "iyy and izz look exchanged"
    com: Array  # (3,) [m]
    rpy: Array  # (3,) [rad]
    tensor: Array  # (3, 3) [kg m^2], to be written: about the centre of mass, in the axes of rpy
    element: str  # to be written anew: inertia or origin; none where the undoing is not exact
    prior: float = 0.0
    """How much more this undoing must explain than an exchange of moments, by what it does on good arms."""

    @property
    def instead(self) -> str:
        """The element to write."""
        if self.element == "inertia":
            return inertia_text(self.tensor)
        if self.element != "origin":
            return ""
        return f'<origin xyz="{vector_text(self.com)}" rpy="{vector_text(self.rpy)}"/>'


def as_written(inertial: InertialElement) -> MassPoint | None:
    """Mass, centre and inertia of a complete inertial of mass above 0."""
    mass, com, inertia = inertial.mass, inertial.com, inertial.inertia
    if mass is None or com is None or inertia is None or not mass > 0.0:
        return None
    return MassPoint(mass, com, inertia)


def tensor_undoings(inertial: InertialElement, in_base: Array | None = None) -> list[Undoing]:
    """The inertial with each slip of its tensor undone, physical or not; `in_base` (4, 4) is its link at q = 0."""
    point, tensor, origin = as_written(inertial), inertial.tensor, inertial.origin
    rotation, rpy = origin.rotation, origin.rpy
    if point is None or tensor is None or rotation is None or rpy is None:
        return []
    com = point.com
    out = [
        Undoing(cause, says, com, rpy, mended, "inertia", prior)
        for tried in (_swaps, _row_orders, _products, _powers)
        for cause, says, mended, prior in tried(tensor)
    ]
    out += [Undoing(cause, says, com, turned, tensor, "origin", prior) for cause, says, turned, prior in _turned(rpy)]
    if in_base is not None and not np.allclose(in_base[:3, :3], np.eye(3)):
        turn = in_base[:3, :3] @ rotation
        says = "the tensor looks given in the axes of the base frame"
        out.append(Undoing(AXES_OF_BASE, says, com, rpy, turn.T @ point.inertia @ turn, "inertia", 0.1))
    about = rotation.T @ (point.inertia - point.mass * (com @ com * np.eye(3) - np.outer(com, com))) @ rotation
    says = f"{_ABOUT_JOINT[:7]} looks taken {_ABOUT_JOINT[8:]}"
    return [*out, Undoing(_ABOUT_JOINT, says, com, rpy, about, "inertia")]


def inertias(undoings: list[Undoing]) -> Array:
    """The inertias about the centre of mass in the axes of the link: (k, 3, 3) array."""
    rotations = np.array([from_rpy(u.rpy) for u in undoings])
    return np.asarray(rotations @ np.array([u.tensor for u in undoings]) @ rotations.swapaxes(1, 2))


def possible(inertia: Array) -> NDArray[np.bool_]:
    """Whether a body can have an inertia, (..., 3, 3): positive, the largest moment within the sum of the others."""
    values = np.linalg.eigvalsh(inertia)
    return np.asarray((values[..., 0] > 0.0) & (values[..., 2] <= _ROUNDED * (values[..., 0] + values[..., 1])))


def _swaps(tensor: Array) -> Iterator[tuple[str, str, Array, float]]:
    for a, b in _PRODUCTS:
        out = tensor.copy()
        out[a, a], out[b, b] = tensor[b, b], tensor[a, a]
        yield "two moments exchanged", f"{_NAMES[a]} and {_NAMES[b]} look exchanged", out, 0.0
    for order in ((1, 2, 0), (2, 0, 1)):
        out = tensor.copy()
        out[[0, 1, 2], [0, 1, 2]] = tensor.diagonal()[list(order)]
        yield "moments in another order", "ixx, iyy, izz look permuted", out, 0.3


_ROW_ORDERS = (
    ("ixx iyy izz ixy ixz iyz", (0, 3, 4, 1, 5, 2), 0.0),
    ("ixx iyy izz ixy iyz ixz", (0, 3, 5, 1, 4, 2), 0.1),
    ("ixx iyy izz iyz ixz ixy", (0, 5, 4, 1, 3, 2), 0.1),
    ("by rows", (0, 3, 5, 1, 2, 4), 0.0),
    ("by rows", (0, 3, 2, 1, 5, 4), 0.1),
)
"""An order in which the six numbers may have been written, which of those in the file are then ixx ixy ixz iyy iyz izz,
and the prior; by rows, they were read into ixx iyy izz ixy ixz iyz."""


def _row_orders(tensor: Array) -> Iterator[tuple[str, str, Array, float]]:
    six, places = tensor[np.triu_indices(3)], np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
    for name, order, prior in _ROW_ORDERS:
        says = f"the six numbers look written in another order ({name})"
        yield "tensors written in another order", says, six[list(order)][places], prior


def _products(tensor: Array) -> Iterator[tuple[str, str, Array, float]]:
    values = [tensor[at] for at in _PRODUCTS]
    if not any(values):
        return
    negative = 2.0 * np.diag(tensor.diagonal()) - tensor
    yield "products of inertia with the opposite sign", "the products of inertia have the opposite sign", negative, 0.75
    for axis in range(3):
        mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
        names = " and ".join(f"i{_AXES[a]}{_AXES[b]}" for a, b in _PRODUCTS if axis in (a, b))
        yield "inertia of the mirrored side", f"{names} look mirrored", tensor * np.outer(mirror, mirror), 0.8
    for order in list(permutations(range(3)))[1:]:
        out = np.diag(tensor.diagonal())
        for at, k in zip(_PRODUCTS, order, strict=True):
            out[at] = out[at[::-1]] = values[k]
        yield "products of inertia permuted", "ixy, ixz, iyz look permuted", out, 0.1


def _powers(tensor: Array) -> Iterator[tuple[str, str, Array, float]]:
    for power in (1, 2, 3, 4, 6, 9):
        for sign, word in ((1, "small"), (-1, "large")):
            off = f"{10**power} times too {word}"
            yield f"tensors {off}", f"the tensor looks {off}", tensor * 10.0 ** (sign * power), 0.0


def _turned(rpy: Array) -> Iterator[tuple[str, str, Array, float]]:
    if np.abs(rpy).max() > 2.0 * np.pi:
        yield "rpy in degrees", "rpy of the inertial looks given in degrees", np.deg2rad(rpy), 0.0
    elif np.abs(rpy).max() > 0.0:
        yield "rpy without effect", "rpy of the inertial turns the tensor away from the body", 0.0 * rpy, 0.1
        yield "rpy with the opposite sign", "rpy of the inertial looks to have the opposite sign", -rpy, 0.2
    for axis in range(3):
        for quarter in (90.0, -90.0):
            angles = rpy + np.deg2rad(quarter) * (np.arange(3) == axis)
            says = f"{_ANGLES[axis]} of the inertial looks {-quarter:+.0f} degrees off"
            yield "rpy a quarter turn off", says, angles, 0.2


def centre_undoings(inertial: InertialElement, in_parent: Array | None, in_base: Array | None) -> list[Undoing]:
    """The inertial with each slip of the centre undone, by poses (4, 4) of its link in its parent and root at q = 0."""
    com, rpy, tensor = inertial.com, inertial.origin.rpy, inertial.tensor
    if com is None or rpy is None or tensor is None or not com.any():
        return []
    tried = (*_frames(com, in_parent, in_base), *_scaled(com), *_reordered(com))
    return [Undoing(cause, says, moved, rpy, tensor, "origin", prior) for cause, says, moved, prior in tried]


def _scaled(com: Array) -> Iterator[tuple[str, str, Array, float]]:
    far = float(np.linalg.norm(com))
    if far > _FAR:
        yield "centres of mass in mm", "the centre of mass looks given in mm", com / 1000.0, 0.0
    if far > _FAR / 10.0:
        yield "centres of mass in cm", "the centre of mass looks given in cm", com / 100.0, 0.2
        yield "centres of mass 10 times too far", "the centre of mass looks 10 times too far", com / 10.0, 0.2


def _frames(com: Array, in_parent: Array | None, in_base: Array | None) -> Iterator[tuple[str, str, Array, float]]:
    for name, pose in (("base", in_base), ("parent", in_parent)):
        if pose is not None and not np.allclose(pose, np.eye(4)):
            moved = pose[:3, :3].T @ (com - pose[:3, 3])
            says = f"the centre of mass looks given in the {name} frame"
            yield f"centres of mass in the {name} frame", says, moved, 0.0


def _reordered(com: Array) -> Iterator[tuple[str, str, Array, float]]:
    for axis in range(3):
        flip = np.where(np.arange(3) == axis, -1.0, 1.0)
        if com[axis] != 0.0:
            cause, says = "signs of centres of mass", f"{_AXES[axis]} of the centre of mass has the opposite sign"
            yield cause, says, com * flip, 0.0
    for order in list(permutations(range(3)))[1:]:
        yield "axes of centres of mass", "x, y, z of the centre of mass look permuted", com[list(order)], 0.3
