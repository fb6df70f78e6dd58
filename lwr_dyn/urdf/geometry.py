"""What an arm looks like when nobody drew it: primitives along its joints that a person recognises as an arm.

A housing (cylinder) lies along the axis of each turning joint, a limb (cylinder) runs from a joint to the next one that
is elsewhere, a pedestal stands under the base, a disc is the flange. No number of it enters the dynamics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lwr_dyn.arm import Arm
from lwr_dyn.arrays import Array
from lwr_dyn.dh import JointKind
from lwr_dyn.spatial import Pose, axis_to_z

_MERGED = 1e-6
"""Joint origins nearer than this [m] are one place."""

COLOURS = {"orange": (0.96, 0.45, 0.09, 1.0), "grey": (0.80, 0.81, 0.83, 1.0), "dark": (0.22, 0.23, 0.26, 1.0)}


@dataclass(frozen=True, slots=True, eq=False)
class Primitive:
    """A cylinder along z of its own pose, in a link's URDF frame; lengths [m]."""

    link: str
    pose: Pose
    radius: float
    length: float
    colour: str


def primitives(arm: Arm) -> tuple[Primitive, ...]:
    """The shapes of all links, base and flange included."""
    radii = link_radii(arm)
    joints = arm.joints()
    ends = [*(joint.origin for joint in joints[1:]), arm.flange()]
    shapes = _base(arm, radii[0])
    for i, (joint, end) in enumerate(zip(joints, ends, strict=True)):
        link, radius = arm.chain.links[i].link, radii[i]
        colour = "orange" if i % 2 == 0 else "grey"
        if joint.kind is JointKind.REVOLUTE and i > 0:
            shapes.append(Primitive(link, Pose.identity(), radius, 2.4 * radius, "dark"))
        limb = _limb(link, np.zeros(3), end.position, 0.86 * radius, colour)
        if limb is not None:
            shapes.append(limb)
    tip, disc = arm.flange(), 0.12 * radii[-1]
    shapes.append(Primitive("flange", Pose(np.eye(3), np.array([0.0, 0.0, -disc / 2])), 0.7 * radii[-1], disc, "dark"))
    del tip
    return tuple(shapes)


def link_radii(arm: Arm) -> tuple[float, ...]:
    """Radius of each link [m]: the file's own, or tapering with what hangs behind it."""
    if arm.drawing.radius:
        return arm.drawing.radius
    spans = [float(np.linalg.norm(j.origin.position)) for j in arm.joints()]
    spans.append(float(np.linalg.norm(arm.flange().position)))
    reach = max(sum(spans), 0.1)
    behind = [sum(spans[i + 1 :]) for i in range(arm.n)]
    return tuple(reach * (0.045 + 0.03 * b / reach) for b in behind)


def _base(arm: Arm, radius: float) -> list[Primitive]:
    """The pedestal, and a limb from the base to the first joint where that is elsewhere."""
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
    if length < _MERGED:
        return None
    return Primitive(link, Pose(axis_to_z(span), (start + end) / 2), min(radius, max(length, 0.3 * radius)), length, colour)
