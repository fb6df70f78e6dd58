"""Arm -> URDF text, and the trail of every number in it: the same walk writes both.

Text is deterministic and floats are written by repr, which is read back bit-exact. Inertials stand about the centre of
mass with rpy 0. A compulsory number that is unknown is written as a stand-in and marked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from xml.sax.saxutils import escape, quoteattr

from lwr_dyn.arm import Arm, Joint
from lwr_dyn.arrays import Array
from lwr_dyn.chain import Body
from lwr_dyn.dh import JointKind
from lwr_dyn.spatial import Pose, to_rpy
from lwr_dyn.urdf.geometry import COLOURS, Primitive, primitives

UNKNOWN_POSITION = 2 * math.pi
"""Stand-in for an unknown position limit [rad or m]."""
UNKNOWN_LARGE = 1e9
"""Stand-in for an unknown effort or velocity."""
DRAKE = "https://drake.mit.edu/"


@dataclass(slots=True)
class Trail:
    """Attribute path -> the quantity of the arm it writes, or a word in brackets for numbers that are drawn or stand-ins."""

    text: list[str] = field(default_factory=list)
    quantities: dict[str, str] = field(default_factory=dict)

    def line(self, depth: int, xml: str, path: str = "", **attributes: str) -> None:
        """One line of XML; `attributes` maps attribute names to quantities."""
        self.text.append("  " * depth + xml)
        for name, quantity in attributes.items():
            self.quantities[f"{path}/@{name}"] = quantity


def urdf_text(arm: Arm) -> str:
    """The arm as URDF text; the same arm gives the same bytes."""
    return "\n".join(urdf_trail(arm).text) + "\n"


def urdf_trail(arm: Arm) -> Trail:
    """The lines of the URDF and, for every numeric attribute, the quantity it writes."""
    out = Trail()
    out.line(0, '<?xml version="1.0" encoding="utf-8"?>')
    for line in header(arm):
        out.line(0, line)
    out.line(0, f'<robot name={quoteattr(arm.name)} xmlns:drake="{DRAKE}">')
    for name, rgba in COLOURS.items():
        out.line(1, f'<material name="{name}">')
        path = f"/robot/material[@name='{name}']/color"
        out.line(2, f'<color rgba="{numbers(rgba)}"/>', path, rgba="(drawn)")
        out.line(1, "</material>")
    shapes = primitives(arm)
    _link(out, "base", None, shapes)
    parent = "base"
    for link, joint, body in zip(arm.chain.links, arm.joints(), arm.bodies(), strict=True):
        _link(out, link.link, body, shapes)
        _joint(out, joint, parent, link.link)
        _transmission(out, arm, joint)
        parent = link.link
    _link(out, "flange", None, shapes)
    out.line(1, '<joint name="flange_joint" type="fixed">')
    _origin(out, 2, arm.flange(), "/robot/joint[@name='flange_joint']/origin", f"{arm.joint_names[-1]}.dh+flange")
    out.line(2, f'<parent link="{parent}"/>')
    out.line(2, '<child link="flange"/>')
    out.line(1, "</joint>")
    out.line(0, "</robot>")
    return out


def header(arm: Arm) -> list[str]:
    """The comment on top: what the file is, from where, under which reading, what is unknown or drawn."""
    unknown = [f"{name} {x}" for name, x in unknown_limits(arm)]
    lines = [
        f"{arm.title}; robot {arm.name}, reading {arm.reading}",
        "written by lwr_dyn; do not edit: change the data file and write again",
        f"errata applied: {', '.join(arm.errata) or 'none'}",
        f"source file sha256: {arm.digest or 'none'}",
        "inertials: about the centre of mass, axes of the link frame; every number's source is in the .provenance.json",
        "rotor inertia: not part of the links' inertials; see the .srdf, the drake: tags and the MJCF .xml",
        f"unknown, written as stand-ins: {', '.join(unknown) or 'nothing'}",
        "visual and collision shapes: drawn by lwr_dyn, not from the source",
    ]
    return ["<!--", *(f"  {escape(x).replace('--', '- -')}" for x in lines), "-->"]


def unknown_limits(arm: Arm) -> list[tuple[str, str]]:
    """(joint, limit) pairs that the source does not give and a URDF must have."""
    found = []
    for joint in arm.joints():
        for name in ("lower", "upper", "velocity", "effort"):
            if getattr(joint.limits, name) is None:
                found.append((joint.name, name))
    return found


def number(x: float) -> str:
    """repr without a negative zero.

    >>> number(-0.0), number(0.1)
    ('0.0', '0.1')
    """
    return repr(float(x) + 0.0)


def numbers(values: Array | tuple[float, ...]) -> str:
    """Numbers separated by blanks."""
    return " ".join(number(v) for v in values)


def _origin(out: Trail, depth: int, pose: Pose, path: str, quantity: str) -> None:
    xyz, rpy = numbers(pose.position), numbers(to_rpy(pose.rotation))
    out.line(depth, f'<origin xyz="{xyz}" rpy="{rpy}"/>', path, xyz=quantity, rpy=quantity)


def _link(out: Trail, name: str, body: Body | None, shapes: tuple[Primitive, ...]) -> None:
    path = f"/robot/link[@name='{name}']"
    out.line(1, f'<link name="{name}">')
    if body is not None:
        at = f"{path}/inertial"
        out.line(2, "<inertial>")
        com = numbers(body.com)
        out.line(3, f'<origin xyz="{com}" rpy="0 0 0"/>', f"{at}/origin", xyz=f"{name}.com", rpy="(zero by choice)")
        out.line(3, f'<mass value="{number(body.mass)}"/>', f"{at}/mass", value=f"{name}.mass")
        cells = {f"i{'xyz'[r]}{'xyz'[c]}": body.inertia_com[r, c] for r in range(3) for c in range(r, 3)}
        text = " ".join(f'{key}="{number(value)}"' for key, value in cells.items())
        out.line(3, f"<inertia {text}/>", f"{at}/inertia", **dict.fromkeys(cells, f"{name}.inertia"))
        out.line(2, "</inertial>")
    for tag in ("visual", "collision"):
        mine = [s for s in shapes if s.link == name]
        for k, shape in enumerate(mine, start=1):
            _shape(out, tag, shape, f"{path}/{tag}[{k}]")
    out.line(1, "</link>")


def _shape(out: Trail, tag: str, shape: Primitive, path: str) -> None:
    out.line(2, f"<{tag}>")
    _origin(out, 3, shape.pose, f"{path}/origin", "(drawn)")
    cylinder = f'<cylinder radius="{number(shape.radius)}" length="{number(shape.length)}"/>'
    at = f"{path}/geometry/cylinder"
    out.line(3, f"<geometry>{cylinder}</geometry>", at, radius="(drawn)", length="(drawn)")
    if tag == "visual":
        out.line(3, f'<material name="{shape.colour}"/>')
    out.line(2, f"</{tag}>")


def _joint(out: Trail, joint: Joint, parent: str, child: str) -> None:
    path, limits = f"/robot/joint[@name='{joint.name}']", joint.limits
    out.line(1, f'<joint name="{joint.name}" type="{joint.kind.value}">')
    _origin(out, 2, joint.origin, f"{path}/origin", f"{joint.name}.dh")
    out.line(2, f'<parent link="{parent}"/>')
    out.line(2, f'<child link="{child}"/>')
    out.line(2, '<axis xyz="0 0 1"/>', f"{path}/axis", xyz="(z by choice)")
    stand_ins = {"lower": -UNKNOWN_POSITION, "upper": UNKNOWN_POSITION, "effort": UNKNOWN_LARGE, "velocity": UNKNOWN_LARGE}
    text, quantities = [], {}
    for name, stand_in in stand_ins.items():
        value = getattr(limits, name)
        text.append(f'{name}="{number(stand_in if value is None else value)}"')
        quantities[name] = "(unknown)" if value is None else f"{joint.name}.{name}"
    out.line(2, f"<limit {' '.join(text)}/>", f"{path}/limit", **quantities)
    known = {"damping": ("viscous", limits.viscous), "friction": ("coulomb", limits.coulomb)}
    given = {tag: (name, value) for tag, (name, value) in known.items() if value is not None}
    if given:
        text = [f'{tag}="{number(value)}"' for tag, (_, value) in given.items()]
        trail = {tag: f"{joint.name}.{name}" for tag, (name, _) in given.items()}
        out.line(2, f"<dynamics {' '.join(text)}/>", f"{path}/dynamics", **trail)
    out.line(1, "</joint>")


def _transmission(out: Trail, arm: Arm, joint: Joint) -> None:
    """Rotor inertia for Drake, which reads it only here."""
    rotor = next(link.rotor for link in arm.chain.links if link.joint == joint.name)
    if rotor is None or joint.kind is not JointKind.REVOLUTE:
        return
    path = f"/robot/transmission[@name='{joint.name}_transmission']/actuator"
    quantity = f"{joint.name}.armature"
    out.line(1, f'<transmission name="{joint.name}_transmission">')
    out.line(2, "<type>transmission_interface/SimpleTransmission</type>")
    out.line(2, f'<joint name="{joint.name}"/>')
    out.line(2, f'<actuator name="{joint.name}_motor">')
    for tag, value in (("gear_ratio", rotor.gear_ratio), ("rotor_inertia", rotor.inertia)):
        out.line(3, f'<drake:{tag} value="{number(value)}"/>', f"{path}/drake:{tag}", value=quantity)
    out.line(2, "</actuator>")
    out.line(1, "</transmission>")
