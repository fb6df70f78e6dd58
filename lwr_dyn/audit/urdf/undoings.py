"""Faults undone: each odd tensor or centre is tried as if one named slip had been made, and put right.

A slip is named only when putting it right brings the link much nearer to the hull of its own shapes.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.audit.urdf.elements import InertialElement, OriginElement
from lwr_dyn.audit.urdf.finding import inertia_text, number_text, vector_text
from lwr_dyn.audit.urdf.measures import MassPoint

_NAMES = ("ixx", "iyy", "izz")
_AXES = "xyz"
_ANGLES = ("roll", "pitch", "yaw")
_PRODUCTS = ((0, 1), (0, 2), (1, 2))


@dataclass(frozen=True, slots=True, eq=False)
class Undoing:
    """A link as it would be without one slip.

    Parameters
    ----------
    cause : str
        Names the slip for the whole file: "inertia about the joint instead of the centre of mass".
    says : str
        One clause: "iyy and izz look exchanged".
    point : MassPoint
        Mass, centre and inertia with the slip undone.
    instead : str
        The element to write.
    prior : float
        How much more the undoing must explain than the most usual slip does, in the same logarithmic measure.
    """

    cause: str
    says: str
    point: MassPoint
    instead: str
    prior: float = 0.0


def as_written(inertial: InertialElement) -> MassPoint | None:
    """Mass, centre and inertia of a complete inertial of mass above 0."""
    mass, com, inertia = inertial.mass, inertial.com, inertial.inertia
    if mass is None or com is None or inertia is None or not mass > 0.0:
        return None
    return MassPoint(mass, com, inertia)


def is_possible(inertia: Array) -> bool:
    """Whether a body can have this inertia: positive, and no moment above the sum of the other two (to 1 in 1000)."""
    values = np.linalg.eigvalsh(inertia)
    return bool(values[0] > 0.0 and values[2] <= 1.001 * (values[0] + values[1]))


def tensor_undoings(inertial: InertialElement) -> Iterator[Undoing]:
    """The inertia with each slip of the tensor undone; those that no body can have are left out."""
    point, tensor, rotation = as_written(inertial), inertial.tensor, inertial.origin.rotation
    if point is None or tensor is None or rotation is None:
        return
    for tried in (_swaps, _row_orders, _products, _powers):
        for cause, says, mended, prior in tried(tensor):
            inertia = rotation @ mended @ rotation.T
            if is_possible(inertia):
                yield Undoing(cause, says, MassPoint(point.mass, point.com, inertia), inertia_text(mended), prior)
    for cause, says, turned, prior in _turned(inertial.origin):
        mended_rotation = turned.rotation
        if mended_rotation is not None and is_possible(tensor) and turned.rpy is not None:
            inertia = mended_rotation @ tensor @ mended_rotation.T
            yield Undoing(cause, says, MassPoint(point.mass, point.com, inertia), _origin(point.com, turned.rpy), prior)
    yield from _about_joint(point, rotation)


def _swaps(tensor: Array) -> Iterator[tuple[str, str, Array, float]]:
    for a, b in _PRODUCTS:
        out = tensor.copy()
        out[a, a], out[b, b] = tensor[b, b], tensor[a, a]
        yield "two moments exchanged", f"{_NAMES[a]} and {_NAMES[b]} look exchanged", out, 0.0
    for order in ((1, 2, 0), (2, 0, 1)):
        out = tensor.copy()
        out[[0, 1, 2], [0, 1, 2]] = tensor.diagonal()[list(order)]
        yield "moments in another order", "ixx, iyy, izz look permuted", out, 0.3


def _six(tensor: Array) -> Array:
    return tensor[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]


def _tensor(xx: float, xy: float, xz: float, yy: float, yz: float, zz: float) -> Array:
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _row_orders(tensor: Array) -> Iterator[tuple[str, str, Array, float]]:
    one, two, three, four, five, six = _six(tensor)
    says = "the six numbers look written in another order"
    cause = "tensors written in another order"
    yield cause, f"{says} (ixx iyy izz ixy ixz iyz)", _tensor(one, four, five, two, six, three), 0.0
    yield cause, f"{says} (ixx iyy izz ixy iyz ixz)", _tensor(one, four, six, two, five, three), 0.1
    yield cause, f"{says} (ixx iyy izz iyz ixz ixy)", _tensor(one, six, five, two, four, three), 0.1
    # the values of ixx ixy ixz iyy iyz izz, read into ixx iyy izz ixy ixz iyz
    yield cause, f"{says} (by rows)", _tensor(one, four, six, two, three, five), 0.0
    yield cause, f"{says} (by rows)", _tensor(one, four, three, two, six, five), 0.1


def _products(tensor: Array) -> Iterator[tuple[str, str, Array, float]]:
    values = [tensor[at] for at in _PRODUCTS]
    if not any(values):
        return
    negative = 2.0 * np.diag(tensor.diagonal()) - tensor
    yield "products of inertia with the opposite sign", "the products of inertia have the opposite sign", negative, 0.0
    for axis in range(3):
        flip = np.where(np.arange(3) == axis, -1.0, 1.0)
        names = " and ".join(f"i{_AXES[a]}{_AXES[b]}" for a, b in _PRODUCTS if axis in (a, b))
        yield "inertia of the mirrored side", f"{names} look mirrored", tensor * np.outer(flip, flip), 0.2
    for order in list(permutations(range(3)))[1:]:
        out = np.diag(tensor.diagonal())
        for at, k in zip(_PRODUCTS, order, strict=True):
            out[at] = out[at[::-1]] = values[k]
        yield "products of inertia permuted", "ixy, ixz, iyz look permuted", out, 0.3


def _powers(tensor: Array) -> Iterator[tuple[str, str, Array, float]]:
    for power in (1, 2, 3, 4, 6, 9):
        for sign in (1, -1):
            factor = 10.0 ** (sign * power)
            word = "small" if sign > 0 else "large"
            cause = f"tensors 10^{power} too {word}"
            yield cause, f"the tensor looks 10^{power} too {word}", tensor * factor, 0.0


def _turned(origin: OriginElement) -> Iterator[tuple[str, str, OriginElement, float]]:
    rpy = origin.rpy
    if rpy is None:
        return

    def turned(angles: Array) -> OriginElement:
        return OriginElement(origin.place, origin.element, origin.xyz, angles)

    if np.abs(rpy).max() > 2.0 * np.pi:
        yield "rpy in degrees", "rpy of the inertial looks given in degrees", turned(np.deg2rad(rpy)), 0.0
    elif np.abs(rpy).max() > 0.0:
        yield "rpy without effect", "rpy of the inertial turns the tensor away from the body", turned(0.0 * rpy), 0.1
        yield "rpy with the opposite sign", "rpy of the inertial looks to have the opposite sign", turned(-rpy), 0.2
    for axis in range(3):
        for quarter in (90.0, -90.0):
            angles = rpy + np.deg2rad(quarter) * (np.arange(3) == axis)
            says = f"{_ANGLES[axis]} of the inertial looks {-quarter:+.0f} degrees off"
            yield "rpy a quarter turn off", says, turned(angles), 0.2


def _about_joint(point: MassPoint, rotation: Array) -> Iterator[Undoing]:
    arm = point.com
    inertia = point.inertia - point.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    if is_possible(inertia):
        yield Undoing(
            "inertia about the link frame instead of the centre of mass",
            "the tensor looks taken about the origin of the link, not about the centre of mass",
            MassPoint(point.mass, point.com, inertia), inertia_text(rotation.T @ inertia @ rotation),
        )  # fmt: skip


def _origin(com: Array, rpy: Array) -> str:
    return f'<origin xyz="{vector_text(com)}" rpy="{vector_text(rpy)}"/>'


def centre_undoings(inertial: InertialElement, in_parent: Array | None, in_base: Array | None) -> Iterator[Undoing]:
    """The centre of mass with each slip undone.

    Parameters
    ----------
    in_parent, in_base : (4, 4) array, optional
        Pose of the link in its parent and in the root at q = 0.
    """
    point, rpy = as_written(inertial), inertial.origin.rpy
    if point is None or rpy is None or not point.com.any():
        return
    com = point.com
    for cause, says, moved, prior in (*_scaled(com), *_frames(com, in_parent, in_base), *_reordered(com)):
        yield Undoing(cause, says, MassPoint(point.mass, moved, point.inertia), _origin(moved, rpy), prior)


def _scaled(com: Array) -> Iterator[tuple[str, str, Array, float]]:
    yield "centres of mass in mm", "the centre of mass looks given in mm", com / 1000.0, 0.0
    yield "centres of mass in cm", "the centre of mass looks given in cm", com / 100.0, 0.2
    yield "centres of mass 10 times too far", "the centre of mass looks 10 times too far", com / 10.0, 0.2


def _frames(com: Array, in_parent: Array | None, in_base: Array | None) -> Iterator[tuple[str, str, Array, float]]:
    frames = ("base", in_base, 0.0), ("parent", in_parent, 0.0)
    for name, pose, prior in frames:
        if pose is not None and not np.allclose(pose, np.eye(4)):
            moved = pose[:3, :3].T @ (com - pose[:3, 3])
            says = f"the centre of mass looks given in the {name} frame"
            yield f"centres of mass in the {name} frame", says, moved, prior


def _reordered(com: Array) -> Iterator[tuple[str, str, Array, float]]:
    for axis in range(3):
        flip = np.where(np.arange(3) == axis, -1.0, 1.0)
        if com[axis] != 0.0:
            cause, says = "signs of centres of mass", f"{_AXES[axis]} of the centre of mass has the opposite sign"
            yield cause, says, com * flip, 0.0
    for order in list(permutations(range(3)))[1:]:
        yield "axes of centres of mass", "x, y, z of the centre of mass look permuted", com[list(order)], 0.2


def mass_undoings(mass: float) -> Iterator[tuple[str, str, float, str]]:
    """The mass with each slip of its unit undone: cause, clause, mass [kg], the element to write."""
    for unit, size in (("g", 1e-3), ("lb", 0.45359237), ("10 kg", 10.0), ("0.1 kg", 0.1), ("t", 1000.0)):
        mended = mass * size
        yield f"masses in {unit}", f"the mass looks given in {unit}", mended, f'<mass value="{number_text(mended)}"/>'
