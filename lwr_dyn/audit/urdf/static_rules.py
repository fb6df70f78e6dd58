"""Rules of statics: efforts against the weight that the joints hold."""

from collections.abc import Iterable

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.audit.urdf.document import UrdfDocument
from lwr_dyn.audit.urdf.elements import JointElement
from lwr_dyn.audit.urdf.finding import UrdfFinding
from lwr_dyn.audit.urdf.tree_poses import link_poses

WEAK, STRONG = 0.6, 2500.0
"""Effort over the largest weight moment: good arms 0.8 to 1 312."""
UNKNOWN = 1e6
"""Effort [N m, N] from which it stands for "unknown"."""
OFF_AXIS = 0.01
"""Distance [m] of the weight from the axis that is counted at least: a balanced last link holds no weight."""
_GRAVITY = 9.81
_TURNING = ("revolute", "continuous")


def effort_against_weight(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The effort cannot hold the weight behind the joint, or could lift it thousands of times.

    The largest moment of the weight over 12 positions of the joints and any mounting, m g times the distance of the
    centre of the moved links from the axis. Good arms: effort 0.8 to 1 312 times that. Warning below 0.6 (the joint
    may still hold the arm as it is mounted), above 2 500 (at least 1 cm from the axis); 1e6 and more stand for unknown.
    """
    poses = link_poses(document)
    for joint in document.joints:
        moment = largest_weight(document, joint, poses) if joint.effort and joint.effort > 0.0 else 0.0
        if joint.effort is None or moment <= 0.0 or joint.effort >= UNKNOWN:
            continue
        least = OFF_AXIS * _GRAVITY * sum(_behind(document, joint.child, poses)[0])
        if joint.effort >= WEAK * moment and joint.effort <= STRONG * max(moment, least):
            continue
        unit = "N m" if joint.type in _TURNING else "N"
        ratio = joint.effort / moment
        what = f"effort {joint.effort:.4g} {unit} is {ratio:.2g} times the weight that it holds"
        why = f"the links behind the joint weigh up to {moment:.3g} {unit}, any mounting"
        yield UrdfFinding(what, why, joint.place_of("limit"), joint.subject, "", "likely", link=joint.child)


def largest_weight(document: UrdfDocument, joint: JointElement, poses: dict[str, Array]) -> float:
    """Largest moment [N m] (for sliding joints: force [N]) of the weight of all links behind a joint, any mounting."""
    masses, centres = _behind(document, joint.child, poses)
    length = 0.0 if joint.axis is None else float(np.linalg.norm(joint.axis))
    total = sum(masses)
    if joint.axis is None or not length > 0.0 or not total > 0.0 or joint.child not in poses:
        return 0.0
    if joint.type not in _TURNING:
        return total * _GRAVITY if joint.type == "prismatic" else 0.0
    frame = poses[joint.child]
    centre = np.einsum("k,kpi->pi", np.array(masses), np.array(centres)) / total
    arm = centre - frame[:, :3, 3]
    axis = frame[:, :3, :3] @ (joint.axis / length)
    return float(total * _GRAVITY * np.linalg.norm(np.cross(axis, arm), axis=1).max())


def _behind(document: UrdfDocument, child: str, poses: dict[str, Array]) -> tuple[list[float], list[Array]]:
    """Masses and centres (12, 3) of the links behind a joint, in the root's frame."""
    masses, centres, waiting, seen = [], [], [child], set[str]()
    while waiting:
        name = waiting.pop()
        link = document.link(name)
        if link is None or name not in poses or name in seen:
            continue
        seen.add(name)
        waiting += [joint.child for joint in document.joints_from(name)]
        inertial = link.inertial
        if inertial is not None and inertial.com is not None and inertial.mass and inertial.mass > 0.0:
            masses.append(inertial.mass)
            centres.append(poses[name][:, :3, :3] @ inertial.com + poses[name][:, :3, 3])
    return masses, centres
