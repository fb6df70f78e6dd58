"""Poses of the links of a URDF for several positions of its joints; loops and broken trees are passed over."""

from functools import lru_cache

import numpy as np

from lwr_dyn.checks.urdf.document import UrdfDocument
from lwr_dyn.checks.urdf.elements import JointElement
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.spatial import turn_about

POSES = 12
"""Positions of the joints: all at 0, then drawn from their limits."""
TURNING, SLIDING = ("revolute", "continuous"), ("prismatic",)
_WIDEST = 2.0 * np.pi


@lru_cache(maxsize=4)
def link_poses(document: UrdfDocument) -> dict[str, Array]:
    """Pose of each link in its root, (12, 4, 4), the first at q = 0; without links behind an unreadable origin."""
    draws = np.random.default_rng(1).uniform(size=(POSES, max(len(document.joints), 1)))
    column = {joint.name: k for k, joint in enumerate(document.joints)}
    poses = {name: np.tile(np.eye(4), (POSES, 1, 1)) for name in document.roots}
    waiting = list(poses)
    while waiting:
        parent = waiting.pop()
        for joint in document.joints_from(parent):
            origin = joint.origin.pose
            if joint.child in poses or origin is None:
                continue
            poses[joint.child] = poses[parent] @ origin @ motion(joint, draws[:, column[joint.name]])
            waiting.append(joint.child)
    return poses


def motion(joint: JointElement, draws: Array) -> Array:
    """What a joint adds at positions drawn from its limits, the first at 0: (k, 4, 4) from draws of 0 to 1, (k,)."""
    out = np.tile(np.eye(4), (len(draws), 1, 1))
    length = 0.0 if joint.axis is None else float(np.linalg.norm(joint.axis))
    if joint.axis is None or not length > 0.0:
        return out
    axis, q = joint.axis / length, _positions(joint, draws)
    if joint.type in SLIDING:
        out[:, :3, 3] = q[:, None] * axis
    elif joint.type in TURNING:
        out[:, :3, :3] = turn_about(axis, q)
    return out


def _positions(joint: JointElement, draws: Array) -> Array:
    low, high = joint.lower, joint.upper
    if joint.type == "continuous" or low is None or high is None or not low < high:
        low, high = (-np.pi, np.pi) if joint.type in TURNING else (0.0, 0.0)
    if joint.type in TURNING:
        low, high = max(low, -_WIDEST), min(high, _WIDEST)
    out = low + draws * (high - low)
    out[0] = 0.0
    return out
