"""Slips in the origin or axis of a joint, found by the bodies on both sides of it.

A right axis turns the child past its parent: the part of the child that lies inside the parent hardly changes. A right
origin lies in or near the parent; where another sign or order of its numbers puts it there, and the written one does
not, the written one is doubted.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations

import numpy as np

from lwr_dyn.checks.urdf.elements import JointElement
from lwr_dyn.checks.urdf.hulls import Hull, depth, directions, gap
from lwr_dyn.checks.urdf.tree_poses import TURNING
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.spatial import turn_about

_MOVED = 0.05
"""Of the child's diameter: an origin that moves by less stays as it is."""
_MEETS = 0.02
"""Gap over the larger diameter at which the bodies still meet."""
_PARALLEL = 0.999
_ANGLES = 8
_SHELLS = (1.0, 0.85, 0.6, 0.3)
_POINTS, _EVERY = 60, 4


@dataclass(frozen=True, slots=True, eq=False)
class JointSlip:
    """Another origin or axis, (3,), that fits the bodies better, and by how much."""

    says: str
    values: Array
    cut: float


def origin_slip(parent: Hull, child: Hull, pose: Array) -> JointSlip | None:
    """The sign or order of the origin that brings it nearest to the parent, in the parent's diameters.

    Only origins at which the bodies meet are tried.
    """
    written = depth(parent, pose[:3, 3]) / parent.diameter
    best: JointSlip | None = None
    for says, xyz in _other_origins(pose[:3, 3]) if written > 0.0 else ():
        moved = pose.copy()
        moved[:3, 3] = xyz
        cut = written - depth(parent, xyz) / parent.diameter
        far = np.linalg.norm(xyz - pose[:3, 3]) > _MOVED * child.diameter
        if far and cut > (best.cut if best else 0.0) and gap(parent, child, moved) < _MEETS * _larger(parent, child):
            best = JointSlip(says, xyz, cut)
    return best


def _larger(parent: Hull, child: Hull) -> float:
    return max(parent.diameter, child.diameter)


def _other_origins(xyz: Array) -> list[tuple[str, Array]]:
    flips = 1.0 - 2.0 * np.eye(3)
    signs = [(f"{'xyz'[k]} of its origin has the opposite sign", xyz * flips[k]) for k in range(3)]
    orders = [("x, y, z of its origin look permuted", xyz[list(order)]) for order in list(permutations(range(3)))[1:]]
    return signs + orders


def axis_slip(joint: JointElement, parent: Hull, child: Hull, pose: Array) -> JointSlip | None:
    """The axis of the joint's frame about which the child turns most freely past its parent.

    The cut is by how much less of the child changes from outside to inside the parent.
    """
    if joint.type not in TURNING or joint.axis is None or not joint.axis.any():
        return None
    low, high = (-np.pi, np.pi) if joint.type == "continuous" else (joint.lower, joint.upper)
    if low is None or high is None or not low < high:
        low, high = -np.pi, np.pi
    limits = (max(low, -np.pi), min(high, np.pi))
    written = _swept(parent, child, pose.tobytes(), tuple(joint.axis), limits)
    best: JointSlip | None = None
    for k in range(3) if written > 0.0 else ():
        axis = np.eye(3)[k]
        if abs(axis @ joint.axis) < np.linalg.norm(joint.axis) * _PARALLEL:
            cut = written - _swept(parent, child, pose.tobytes(), tuple(axis), limits)
            if cut > (best.cut if best else 0.0):
                best = JointSlip(f"about {'xyz'[k]} its child would turn freely past its parent", axis, cut)
    return best


@lru_cache(maxsize=8192)
def _swept(parent: Hull, child: Hull, pose_bytes: bytes, axis: tuple[float, ...], limits: tuple[float, float]) -> float:
    """Largest less smallest share of the child that is inside the parent, over positions of the joint."""
    pose: Array = np.frombuffer(pose_bytes).reshape(4, 4)
    normals, offsets = _faces(parent)
    q = np.concatenate([[0.0], np.linspace(*limits, _ANGLES)])
    turns = turn_about(np.array(axis) / np.linalg.norm(axis), q)
    placed = _filled(child) @ turns.swapaxes(1, 2) @ pose[:3, :3].T + pose[:3, 3]
    inside = ((placed @ normals.T) <= offsets).all(axis=2).mean(axis=1)
    return float(np.ptp(inside))


@lru_cache(maxsize=512)
def _faces(hull: Hull) -> tuple[Array, Array]:
    """A polytope of 150 faces about the hull: normals (k, 3) and offsets (k,)."""
    ways = directions()[::_EVERY]
    return ways, (hull.vertices @ ways.T).max(axis=0)


@lru_cache(maxsize=512)
def _filled(hull: Hull) -> Array:
    """Points that fill the hull in shells about its centroid, (k, 3)."""
    some = hull.vertices[:: max(1, len(hull.vertices) // _POINTS)] - hull.centroid
    return np.vstack([hull.centroid + shell * some for shell in _SHELLS])
