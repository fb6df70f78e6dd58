"""Default shapes of an arm without a drawing: cylinders along its joints.

A limb is a cylinder from a joint to the next joint at another place. A joint across its limb is a housing with an axle,
a joint along its limb a ring; the base is a pedestal, the flange a disc. The dynamics uses none of these numbers.
"""

from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.model.arm import Arm, DrawnCylinder, Joint
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.spatial import Pose, axis_to_z

_SAME_PLACE = 1e-6
"""Joint origins nearer than this [m] are at the same place."""
_DIGITS = 6
"""Decimals of a drawn length [m]."""

COLOURS = {"orange": (0.96, 0.45, 0.09, 1.0), "grey": (0.80, 0.81, 0.83, 1.0), "dark": (0.22, 0.23, 0.26, 1.0)}


@dataclass(frozen=True, slots=True, eq=False)
class Primitive:
    """A cylinder along z of its own pose, in a link's URDF frame; lengths [m], whole micrometres in `primitives`."""

    link: str
    pose: Pose
    radius: float
    length: float
    colour: str


def primitives(arm: Arm) -> tuple[Primitive, ...]:
    """The shapes of all links, base and flange included; the file's own cylinders if it lists any."""
    cylinders = arm.drawing.cylinders
    return tuple(map(_in_micrometres, map(_as_listed, cylinders) if cylinders else _derived(arm)))


def _in_micrometres(shape: Primitive) -> Primitive:
    """Without the digits that only rounding made: 0.10416, not 0.10415999999999999."""
    pose = Pose(shape.pose.rotation, np.round(shape.pose.position, _DIGITS))
    return replace(shape, pose=pose, radius=round(shape.radius, _DIGITS), length=round(shape.length, _DIGITS))


def _derived(arm: Arm) -> list[Primitive]:
    radii, joints = link_radii(arm), arm.joints()
    ends = [*(joint.origin.position for joint in joints[1:]), arm.flange().position]
    shapes = _base(arm, radii[0])
    for i, (joint, end) in enumerate(zip(joints, ends, strict=True)):
        link, radius = arm.chain.links[i].link, radii[i]
        if i > 0 and joint.kind is JointKind.REVOLUTE:
            shapes += _collar(link, end, radius) if _along_its_limb(joint, end) else _hinge(link, radius)
        limb = _limb(link, np.zeros(3), end, 0.86 * radius, "orange")
        if limb is not None:
            shapes.append(limb)
    disc = 0.12 * radii[-1]
    shapes.append(Primitive("flange", _at(0.0, 0.0, -disc / 2), 0.7 * radii[-1], disc, "dark"))
    return shapes


def _as_listed(cylinder: DrawnCylinder) -> Primitive:
    start, end = np.array(cylinder.start), np.array(cylinder.end)
    pose = Pose(axis_to_z(end - start), (start + end) / 2)
    return Primitive(cylinder.link, pose, cylinder.radius, float(np.linalg.norm(end - start)), cylinder.colour)


def _along_its_limb(joint: Joint, end: Array) -> bool:
    """Whether the joint axis is along its limb, or along the previous limb if it has none."""
    span, axis = end, np.array([0.0, 0.0, 1.0])
    if np.linalg.norm(end) < _SAME_PLACE:
        span, axis = joint.origin.position, joint.origin.rotation[:, 2]
    length = float(np.linalg.norm(span))
    return length >= _SAME_PLACE and float(np.linalg.norm(np.cross(axis, span))) < 1e-3 * length


def _hinge(link: str, radius: float) -> list[Primitive]:
    """A housing across the limbs, and an axle that is longer than it."""
    axle = Primitive(link, Pose.identity(), 0.66 * radius, 2.36 * radius, "dark")
    return [Primitive(link, Pose.identity(), radius, 2.2 * radius, "grey"), axle]


def _collar(link: str, end: Array, radius: float) -> list[Primitive]:
    """A ring around the limb beyond its hinge, if the limb is long enough."""
    length = float(np.linalg.norm(end))
    if length < 1.6 * radius:
        return []
    middle = 1.3 * radius / length * end
    return [Primitive(link, Pose(axis_to_z(end), middle), 0.93 * radius, 0.3 * radius, "dark")]


def link_radii(arm: Arm) -> tuple[float, ...]:
    """Radius of each link [m]: the file's own, or smaller the shorter the arm beyond the link."""
    if arm.drawing.radius:
        return arm.drawing.radius
    spans = [float(np.linalg.norm(j.origin.position)) for j in arm.joints()]
    spans.append(float(np.linalg.norm(arm.flange().position)))
    reach = max(sum(spans), 0.1)
    beyond = [sum(spans[i + 1 :]) for i in range(arm.n)]
    return tuple(reach * (0.045 + 0.03 * b / reach) for b in beyond)


def _base(arm: Arm, radius: float) -> list[Primitive]:
    """The pedestal, and a limb from the base to the first joint if that is at another place."""
    shapes = []
    height = arm.drawing.pedestal
    if height > 0.0:
        foot = 0.12 * height
        shapes.append(Primitive("base", _at(0.0, 0.0, foot / 2 - height), 1.6 * radius, foot, "dark"))
        column = height - foot
        shapes.append(Primitive("base", _at(0.0, 0.0, -column / 2), 1.05 * radius, column, "grey"))
    limb = _limb("base", np.zeros(3), arm.joints()[0].origin.position, radius, "grey")
    return shapes if limb is None else [*shapes, limb]


def _at(x: float, y: float, z: float) -> Pose:
    return Pose(np.eye(3), np.array([x, y, z]))


def _limb(link: str, start: Array, end: Array, radius: float, colour: str) -> Primitive | None:
    span = end - start
    length = float(np.linalg.norm(span))
    if length < _SAME_PLACE:
        return None
    return Primitive(
        link, Pose(axis_to_z(span), (start + end) / 2), min(radius, max(length, 0.3 * radius)), length, colour
    )
