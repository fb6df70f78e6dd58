"""Default shapes of an arm without a drawing: cylinders along its joints.

A limb is a cylinder from a joint to the next joint at another place. A joint across its limb is a housing with an axle,
a joint along its limb a ring. What slides has a rod that stays in its guide, or runs on a rail. The base stands on a
column or a plate, the flange is a disc. The dynamics uses none of these numbers.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm, Joint
from lwr_dyn.model.chain import JointKind, ends_of
from lwr_dyn.model.file_layout import DrawnCylinder
from lwr_dyn.model.spatial import Pose, axis_to_z

_SAME_PLACE = 1e-6
"""Joint origins nearer than this [m] are at the same place."""
_ALIGNED = 0.2
"""Sine of the angle up to which a limb counts as along an axis: an elbow with an offset leaves the axis a little."""
_TRAVEL = 40.0
"""Longest travel that is drawn, to each side, in radii: some files give a mobile base 1000 km."""
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
    shapes = list(map(_as_listed, cylinders) if cylinders else _derived(arm.uninstalled()))
    if arm.installation is not None:
        end = arm.installation.tool.frame.position
        tool = _limb("flange", np.zeros(3), end, 0.3 * link_radii(arm.uninstalled())[-1], "dark")
        shapes += [] if tool is None else [tool]
    return tuple(map(_in_micrometres, shapes))


def _in_micrometres(shape: Primitive) -> Primitive:
    """Without the digits that only rounding made: 0.10416, not 0.10415999999999999."""
    pose = Pose(shape.pose.rotation, np.round(shape.pose.position, _DIGITS))
    return replace(shape, pose=pose, radius=round(shape.radius, _DIGITS), length=round(shape.length, _DIGITS))


def floor_height(arm: Arm) -> float:
    """Height of the floor in the first frame of the chain [m]: the lowest point of what is drawn for the base.

    Where the base is not upright the floor is that of the world, and with no height given below the arm's reach.
    """
    mount, _ = ends_of(arm.installation)
    if mount.rotation[2, 2] < 0.9:
        spans = [*(joint.origin.position for joint in arm.joints()[1:]), arm.flange().position]
        return 0.0 if mount.position[2] > 0.0 else float(mount.position[2] - np.linalg.norm(spans, axis=1).sum())
    return min((_lowest(mount @ shape.pose, shape) for shape in primitives(arm) if shape.link == "base"), default=0.0)


def stand_foot(arm: Arm) -> Array:
    """Where the stand of the base ends, in the world [m]: below the base, along its own vertical."""
    mount, _ = ends_of(arm.installation)
    lowest = min((_lowest(shape.pose, shape) for shape in primitives(arm) if shape.link == "base"), default=0.0)
    return mount.position + lowest * mount.rotation[:, 2]


def _derived(arm: Arm) -> list[Primitive]:
    radii, joints = link_radii(arm), arm.joints()
    ends = [*(joint.origin.position for joint in joints[1:]), arm.flange().position]
    names = ["base", *(link.link for link in arm.chain.links)]
    rails = _on_rails(joints)
    shapes: list[Primitive] = []
    for i, (joint, end) in enumerate(zip(joints, ends, strict=True)):
        if joint.kind is JointKind.PRISMATIC:
            shapes += _slide(joint, names[i], names[i + 1], radii[i], rails[i])
        else:
            shapes += _turn(joint, names[i + 1], end, radii[i], first=i == 0)
        limb = _limb(names[i + 1], np.zeros(3), end, 0.86 * radii[i], "orange")
        if limb is not None:
            shapes.append(limb)
    disc = 0.12 * radii[-1]
    flange = Primitive("flange", _at(0.0, 0.0, -disc / 2), 0.7 * radii[-1], disc, "dark")
    return [*_base(arm, radii[0], shapes), *shapes, flange]


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
    return length >= _SAME_PLACE and float(np.linalg.norm(np.cross(axis, span))) < _ALIGNED * length


def _turn(joint: Joint, link: str, end: Array, radius: float, first: bool) -> list[Primitive]:
    """A hinge, a ring, or at a bend without a hinge a housing that closes it."""
    if not first and not _along_its_limb(joint, end):
        return _hinge(link, radius)
    before = joint.origin.rotation.T @ joint.origin.position
    lengths = float(np.linalg.norm(before)) * float(np.linalg.norm(end))
    bent = float(np.linalg.norm(np.cross(before, end))) > _ALIGNED * lengths > 0.0
    housing = [Primitive(link, Pose.identity(), radius, 2.0 * radius, "grey")] if bent else []
    return housing + ([] if first else _collar(link, end, radius))


def _on_rails(joints: Sequence[Joint]) -> list[bool]:
    """Whether a sliding joint runs on a rail of the link before: where its direction is fixed and not downward."""
    out, turned, axes = [], np.eye(3), list[Array]()
    for joint in joints:
        turned = turned @ joint.origin.rotation
        axis = turned[:, 2]
        fixed = all(float(np.linalg.norm(np.cross(axis, other))) < 1e-3 for other in axes)
        out.append(fixed and axis[2] > -0.5)
        axes += [axis] if joint.kind is JointKind.REVOLUTE else []
    return out


def _slide(joint: Joint, before: str, link: str, radius: float, on_rail: bool) -> list[Primitive]:
    """Carriage and rail, or guide and rod; either is as long as the travel, so no gap opens (up to `_TRAVEL`)."""
    low, up = (0.0 if joint.limits.lower is None else joint.limits.lower), joint.limits.upper
    up = low + 4.0 * radius if up is None else up
    low, up = max(low, -_TRAVEL * radius), min(up, _TRAVEL * radius)
    long, middle = up - low, _at(0.0, 0.0, (low + up) / 2)
    bar = joint.origin @ middle if on_rail else middle.inverse()
    rod = [Primitive(before if on_rail else link, bar, 0.5 * radius, long, "grey")] if long > _SAME_PLACE else []
    if on_rail:
        return [*rod, Primitive(link, Pose.identity(), radius, 1.4 * radius, "dark")]
    return [Primitive(before, joint.origin, radius, 1.6 * radius, "dark"), *rod]


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


def _base(arm: Arm, radius: float, links: Sequence[Primitive]) -> list[Primitive]:
    """Column and plate, and a limb to the first joint if that is at another place.

    The column is as high as the file's pedestal, or else just high enough for what turns about the base's origin.
    """
    given = arm.drawing.pedestal
    height = given if given > 0.0 else 1.15 * _below_base(arm, radius, links)
    foot = 0.12 * given if given > 0.0 else 0.3 * radius
    if height <= 0.0:
        shapes = [Primitive("base", _at(0.0, 0.0, foot / 2), 1.6 * radius, foot, "dark")]
    else:
        height = max(height, 2.0 * foot)
        column = height - foot
        shapes = [
            Primitive("base", _at(0.0, 0.0, foot / 2 - height), 1.6 * radius, foot, "dark"),
            Primitive("base", _at(0.0, 0.0, -column / 2), 1.05 * radius, column, "grey"),
        ]
    limb = _limb("base", np.zeros(3), arm.joints()[0].origin.position, radius, "grey")
    return shapes if limb is None else [*shapes, limb]


def _below_base(arm: Arm, radius: float, links: Sequence[Primitive]) -> float:
    """How far the shapes of the links at the base's origin reach below it at q = 0 [m]."""
    here, frames = Pose.identity(), {"base": Pose.identity()}
    for link, joint in zip(arm.chain.links, arm.joints(), strict=True):
        here = here @ joint.origin
        frames[link.link] = here
    near = {name for name, frame in frames.items() if float(np.linalg.norm(frame.position)) < 2.0 * radius}
    low = [_lowest(frames[shape.link] @ shape.pose, shape) for shape in links if shape.link in near]
    return max([0.0, *(-height for height in low)])


def _lowest(pose: Pose, shape: Primitive) -> float:
    """Lowest point of a cylinder at a pose in the base [m]."""
    upright = min(abs(float(pose.rotation[2, 2])), 1.0)
    return float(pose.position[2]) - upright * shape.length / 2 - math.sqrt(1.0 - upright**2) * shape.radius


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
