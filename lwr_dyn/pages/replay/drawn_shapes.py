"""The cylinders that a page draws of an arm: those of its file, but no two of them share a visible surface.

Where two cylinders have one surface, such as a guide and a housing of the same radius on one axis, a graphics card
shows now the one and now the other. Of such a pair one is drawn a little smaller. Files of an arm keep the cylinders as
they are.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arms.urdf.geometry import Primitive, primitives
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind, ends_of, joint_motion
from lwr_dyn.model.spatial import Pose

_NEAR, _SMALLER = 0.01, 0.03
"""Of the smaller radius: what counts as one surface (sides of 40 facets lie 0.003 apart), and how much is taken off."""
_ROUNDS = 12
_PARALLEL = 1e-6
_TRAVEL = 1.0
"""Of a sliding joint without limits [m]."""


def drawn_shapes(arm: Arm) -> tuple[Primitive, ...]:
    """The cylinders of all links, base and flange included, in the order of `primitives`.

    Base and flange keep their sizes, and so does the earlier one of two others.
    """
    shapes = list(primitives(arm))
    rank = sorted(range(len(shapes)), key=lambda k: (shapes[k].link not in ("base", "flange"), k))
    for _ in range(_ROUNDS):
        sides, ends = shared_surfaces(arm, shapes)
        if not (sides or ends):
            break
        for k in {max(pair, key=rank.index) for pair in sides}:
            shapes[k] = replace(shapes[k], radius=(1.0 - _SMALLER) * shapes[k].radius)
        for k in {max(pair, key=rank.index) for pair in ends}:
            less = min(2.0 * _SMALLER * shapes[k].radius, 0.2 * shapes[k].length)
            shapes[k] = replace(shapes[k], length=shapes[k].length - less)
    return tuple(shapes)


def shared_surfaces(arm: Arm, shapes: Sequence[Primitive]) -> tuple[set[tuple[int, int]], set[tuple[int, int]]]:
    """Pairs of shapes whose sides, and pairs whose ends, coincide at q = 0 or with one joint turned by a right angle.

    Sides count wherever sliding joints between the two can bring them together. Ends count where they look the same
    way: what looks the other way is inside the other cylinder.
    """
    radius, length = (np.array([getattr(shape, name) for shape in shapes]) for name in ("radius", "length"))
    near, slack = _NEAR * np.minimum(radius[:, None], radius), _travels(arm, shapes)
    sides, ends = np.zeros((2, len(shapes), len(shapes)), dtype=bool)
    for centre, axis in _placed(arm, shapes):
        apart = centre[None] - centre[:, None]
        along = np.einsum("ijk,ik->ij", apart, axis)
        off = np.linalg.norm(apart - along[..., None] * axis[:, None], axis=-1)
        parallel = np.abs(axis @ axis.T) > 1.0 - _PARALLEL
        overlap = np.abs(along) - slack < (length[:, None] + length) / 2.0
        sides |= parallel & (off < near) & (np.abs(radius[:, None] - radius) < near) & overlap
        meet = parallel & (off < radius[:, None] + radius)
        for way in (-1.0, 1.0):
            ends |= meet & (np.abs(along + way * (length - length[:, None]) / 2.0) < near)
    return _pairs(sides), _pairs(ends)


def _pairs(found: NDArray[np.bool_]) -> set[tuple[int, int]]:
    return {(int(i), int(j)) for i, j in np.argwhere(np.triu(found, 1))}


def _placed(arm: Arm, shapes: Sequence[Primitive]) -> Iterator[tuple[Array, Array]]:
    """Centres (k, 3) and axes (k, 3) of the shapes in the world, at some poses."""
    turns: list[Any] = [np.zeros(arm.n)]
    for i, joint in enumerate(arm.joints()):
        if joint.kind is JointKind.REVOLUTE:
            turns += [sign * np.pi / 2.0 * np.eye(arm.n)[i] for sign in (-1.0, 1.0)]
    first, last = ends_of(arm.installation)
    for q in turns:
        here, frames = Pose.identity(), {"base": first}
        for link, joint, value in zip(arm.chain.links, arm.joints(), q, strict=True):
            here = here @ joint.origin @ joint_motion(joint.kind, float(value))
            frames[link.link] = here
        frames["flange"] = here @ arm.flange() @ last
        poses = [frames[shape.link] @ shape.pose for shape in shapes]
        yield np.array([pose.position for pose in poses]), np.array([pose.rotation[:, 2] for pose in poses])


def _travels(arm: Arm, shapes: Sequence[Primitive]) -> Array:
    """How far sliding joints can move each shape against each other one, (k, k) [m]."""
    reached, upto = 0.0, {"base": 0.0}
    for link, joint in zip(arm.chain.links, arm.joints(), strict=True):
        if joint.kind is JointKind.PRISMATIC:
            low, up = joint.limits.lower, joint.limits.upper
            reached += _TRAVEL if low is None or up is None else max(abs(low), abs(up))
        upto[link.link] = reached
    at = np.array([upto.get(shape.link, reached) for shape in shapes])
    return np.asarray(np.abs(at[:, None] - at))
