"""Arm -> MJCF text for MuJoCo: frames, bodies, limits and shapes of the URDF, and the armature, which a URDF lacks.

Orientations are `xyaxes` (two columns of the rotation matrix), so no angle is converted. Shapes collide with nothing
and have density 0, so `base` and `flange` weigh nothing; no inertia is made of their group either (MuJoCo below 3.3.7
refuses a body whose shapes weigh nothing, Drake one of mass 0). Each joint has a motor: Drake reads an armature only
with one. MuJoCo refuses a moving link of mass 0: such a link gets `TINY` of mass and moments. What a first link without
mass has about its own axis, all of it that moves anything on a base that stands, is in its joint's armature.
"""

from dataclasses import replace
from xml.sax.saxutils import quoteattr

import numpy as np

from lwr_dyn.arms.urdf.elements import comment, header, number, numbers
from lwr_dyn.arms.urdf.geometry import COLOURS, Primitive, primitives
from lwr_dyn.arms.urdf.model_files import weightless_links
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.arm import Arm, Joint
from lwr_dyn.model.chain import Body, JointKind, ends_of
from lwr_dyn.model.spatial import Pose

SPEEDS, UNKNOWN = "speed limits by joint [rad/s or m/s], which MJCF does not have: ", "unknown"
"""The start of a header line that is read back, and the word in it of a limit that is not known."""
TINY = 1e-9
"""[kg] and [kg m^2] of a link without mass: above MuJoCo's 1e-15, and below what a torque shows."""
_TYPES = {JointKind.REVOLUTE: "hinge", JointKind.PRISMATIC: "slide"}


def mjcf_text(arm: Arm) -> str:
    """The arm as MJCF text; raises `MissingDataError` for a link without mass whose moments MuJoCo cannot hold."""
    arm.require_dynamics()
    weightless, shapes = unheld_links(arm), primitives(arm)
    if weightless:
        raise MissingDataError(
            arm.name, f"masses of {', '.join(weightless)}", "MuJoCo, which refuses moments without a mass"
        )
    there, bare = arm.installation, arm.uninstalled()
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        *_header(replace(arm, layout=None)),
        f"<mujoco model={quoteattr(arm.name)}>",
    ]
    lines.append('  <compiler angle="radian" autolimits="true" inertiagrouprange="0 1"/>')
    lines.append(f'  <option gravity="{numbers(arm.chain.gravity)}"/>')
    lines += [
        "  <default>",
        '    <geom contype="0" conaffinity="0" group="2" density="0"/>',
        "  </default>",
        "  <asset>",
    ]
    lines += [f'    <material name="{name}" rgba="{numbers(rgba)}"/>' for name, rgba in COLOURS.items()]
    base = "" if there is None else f" {_pose(ends_of(there)[0])}"
    lines += ["  </asset>", "  <worldbody>", f'    <body name="base"{base}>', *_geoms(shapes, "base", 3)]
    rows = list(zip(bare.chain.links, bare.joints(), bare.bodies(), strict=True))
    for depth, (link, joint, body) in enumerate(rows, start=3):
        pad = "  " * depth
        lines.append(f"{pad}<body name={quoteattr(link.link)} {_pose(joint.origin)}>")
        lines += [_inertial(_standing(body), depth + 1)] if body is not None else []
        lines += [_joint(joint, depth + 1, _moved_moment(body)), *_geoms(shapes, link.link, depth + 1)]
    innermost = 3 + len(rows)
    lines.append(f'{"  " * innermost}<body name="flange" {_pose(bare.flange())}>')
    lines += _geoms(shapes, "flange", innermost + 1)
    if there is not None:
        lines.append(f'{"  " * (innermost + 1)}<site name="tool" {_pose(there.tool.frame)}/>')
    lines += [f"{'  ' * depth}</body>" for depth in range(innermost, 1, -1)]
    motors = ["  <actuator>", *(_motor(joint) for _, joint, _ in rows), "  </actuator>"]
    return "\n".join([*lines, "  </worldbody>", *motors, "</mujoco>"]) + "\n"


def unheld_links(arm: Arm) -> tuple[str, ...]:
    """The links without mass whose moments an MJCF cannot hold: all but a first one that turns on a base."""
    bodies = [link.body for link in arm.chain.links]
    first_turns = arm.chain.links[0].kind is JointKind.REVOLUTE
    return tuple(
        link.link
        for i, (link, body) in enumerate(zip(arm.chain.links, bodies, strict=True))
        if body is not None and body.mass == 0.0 and body.inertia_com.any() and not (i == 0 and first_turns)
    )


def _standing(body: Body) -> Body:
    """The body, or what stands in for one without mass."""
    return body if body.mass > 0.0 else Body(TINY, np.zeros(3), TINY * np.eye(3))


def _moved_moment(body: Body | None) -> float:
    """What a body without mass has about its joint's axis [kg m^2], which goes to the armature; 0 of any other."""
    return 0.0 if body is None or body.mass > 0.0 else float(body.inertia_com[2, 2])


def _header(arm: Arm) -> list[str]:
    """The URDF's header, with the differences of MJCF."""
    first, *rest, last = header(arm)
    rest = [
        x for x in rest if not any(word in x for word in ("provenance", "rotor inertia:", "stand-ins", "gravity in"))
    ]
    lines = (
        "the same numbers as in the .urdf, whose .provenance.json names their sources",
        "armature: k_r^2 I_m; limits that are not known are left out",
        f"{SPEEDS}{' '.join(UNKNOWN if x is None else number(x) for x in (y.velocity for y in arm.limits))}",
    )
    bare = [f"{name}: no mass, which MuJoCo refuses: {TINY:g} kg and kg m^2 stand in" for name in weightless_links(arm)]
    moved = _moved_moment(arm.bodies()[0])
    if moved:
        bare[0] += f"; its moment about its axis, {moved:g} kg m^2, is in the armature of {arm.joint_names[0]}"
    return [first, *rest, *(f"  {comment(x)}" for x in (*lines, *bare)), last]


def _pose(pose: Pose) -> str:
    text = f'pos="{numbers(pose.position)}"'
    if pose.is_identity():
        return text
    axes = numbers([*pose.rotation[:, 0], *pose.rotation[:, 1]])
    return f'{text} xyaxes="{axes}"'


def _inertial(body: Body, depth: int) -> str:
    tensor = body.inertia_com
    six = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]]
    attributes = f'pos="{numbers(body.com)}" mass="{number(body.mass)}" fullinertia="{numbers(six)}"'
    return f"{'  ' * depth}<inertial {attributes}/>"


def _joint(joint: Joint, depth: int, moved: float = 0.0) -> str:
    limits = joint.limits
    armature = (joint.armature or 0.0) + moved if moved else joint.armature
    given = {"armature": armature, "damping": limits.viscous, "frictionloss": limits.coulomb}
    text = [f'{name}="{number(value)}"' for name, value in given.items() if value is not None]
    if limits.lower is not None and limits.upper is not None:
        text.append(f'range="{number(limits.lower)} {number(limits.upper)}"')
    words = f'name={quoteattr(joint.name)} type="{_TYPES[joint.kind]}" axis="0 0 1"'
    return f"{'  ' * depth}<joint {' '.join([words, *text])}/>"


def _motor(joint: Joint) -> str:
    """A motor whose control is the joint's torque or force [N m or N], within the effort limit where it is known."""
    effort = joint.limits.effort
    limit = "" if effort is None else f' ctrlrange="{number(-effort)} {number(effort)}"'
    return f"    <motor name={quoteattr(f'{joint.name}_motor')} joint={quoteattr(joint.name)}{limit}/>"


def _geoms(shapes: tuple[Primitive, ...], link: str, depth: int) -> list[str]:
    out = []
    for shape in shapes:
        if shape.link == link:
            size = f'type="cylinder" size="{number(shape.radius)} {number(shape.length / 2)}"'
            out.append(f'{"  " * depth}<geom {size} {_pose(shape.pose)} material="{shape.colour}"/>')
    return out
