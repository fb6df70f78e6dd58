"""Rules of statics: efforts against the weight that the joints hold."""

from collections.abc import Iterable

import numpy as np

from lwr_dyn.checks.urdf.document import TURNING, UrdfDocument, UrdfFinding, link_poses
from lwr_dyn.checks.urdf.elements import JointElement
from lwr_dyn.checks.urdf.inertia_shape_rules import believed_masses
from lwr_dyn.foundation.arrays import Array

WEAK, STRONG = 0.6, 20000.0
"""Effort over the largest weight moment: good arms 0.8 to 1 312."""
UNLIKE = 30.0
UNKNOWN = 1e6
"""Effort [N m, N] from which it stands for "unknown"."""
_GRAVITY, _ARM = 9.81, 0.05
"""[m/s^2], [m]."""
_FEWEST = 2
_NO_LIMIT = 1e9
"""An effort from here on stands for none."""


def effort_against_weight(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The effort cannot hold the weight behind the joint, or could lift it thousands of times.

    The largest moment of the weight over 12 positions of the joints and any mounting, m g times the distance of the
    centre of the moved links from the axis; odd masses and centres are replaced by usual ones. Good arms: effort 0.8 to
    1 312 times that; of robots that always stand upright 4 of 28 joints 0.15 to 0.54 times. Warning below 0.6 (the
    joint may still hold the arm as it is mounted), and above 20 000 times the moment at a distance of at least 5 cm;
    1e6 and more stand for unknown.
    """
    poses = link_poses(document)
    for joint in document.joints:
        if joint.effort is None or not 0.0 < joint.effort < UNKNOWN:
            continue
        moment, least = largest_weight(document, joint, poses)
        weak, strong = joint.effort < WEAK * moment, joint.effort > STRONG * max(moment, least) > 0.0
        if weak or strong:
            unit = "N m" if joint.type in TURNING else "N"
            ratio = joint.effort / max(moment, 0.0 if weak else least)
            what = f"effort {joint.effort:.4g} {unit} is {ratio:.2g} times the weight that it holds"
            why = f"the links behind the joint weigh up to {moment:.3g} {unit}, any mounting"
            yield UrdfFinding(what, why, joint.place_of("limit"), joint.subject, "", "likely", link=joint.child)


def unlike_others(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The effort is 30 times the largest, or a thirtieth of the smallest, of all other joints of its type.

    Within a good arm the efforts of neighbours in size lie within a factor of 10. A single one far from all others
    points to its unit (N mm, kg cm).
    """
    for moving in (TURNING, ("prismatic",)):
        efforts = [(x, e) for x in document.joints if x.type in moving and 0.0 < (e := x.effort or 0.0) < _NO_LIMIT]
        for joint, effort in efforts if len(efforts) > _FEWEST else ():
            others = [other for its, other in efforts if its is not joint]
            if effort > UNLIKE * max(others) or effort < min(others) / UNLIKE:
                near = max(others) if effort > max(others) else min(others)
                what = f"effort {effort:.4g} is {effort / near:.2g} times that of the nearest other joint"
                why = f"the other {len(others)} joints of its type have {min(others):.4g} to {max(others):.4g}"
                yield UrdfFinding(what, why, joint.place_of("limit"), joint.subject, "", "likely", link=joint.child)


def largest_weight(document: UrdfDocument, joint: JointElement, poses: dict[str, Array]) -> tuple[float, float]:
    """The weight of all links behind a joint in any mounting: its largest moment [N m], and that at 5 cm.

    For sliding joints both are the weight [N].
    """
    masses, centres = _behind(document, joint.child, poses)
    length = 0.0 if joint.axis is None else float(np.linalg.norm(joint.axis))
    weight = sum(masses) * _GRAVITY
    if joint.axis is None or not length > 0.0 or not weight > 0.0 or joint.child not in poses:
        return 0.0, 0.0
    if joint.type not in TURNING:
        return (weight, weight) if joint.type == "prismatic" else (0.0, 0.0)
    frame = poses[joint.child]
    centre = np.einsum("k,kpi->pi", np.array(masses), np.array(centres)) / sum(masses)
    arm = centre - frame[:, :3, 3]
    axis = frame[:, :3, :3] @ (joint.axis / length)
    return weight * float(np.linalg.norm(np.cross(axis, arm), axis=1).max()), weight * _ARM


def _behind(document: UrdfDocument, child: str, poses: dict[str, Array]) -> tuple[list[float], list[Array]]:
    """Masses and centres (12, 3) of the links behind a joint, in the root's frame."""
    believed = believed_masses(document)
    masses, centres, waiting, seen = [], [], [child], set[str]()
    while waiting:
        name = waiting.pop()
        if name not in poses or name in seen:
            continue
        seen.add(name)
        waiting += [joint.child for joint in document.joints_from(name)]
        if name in believed:
            mass, com = believed[name]
            masses.append(mass)
            centres.append(poses[name][:, :3, :3] @ com + poses[name][:, :3, 3])
    return masses, centres
