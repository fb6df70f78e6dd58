"""Arm -> URDF text, together with the source of every number in it.

The text is deterministic; floats are written by repr, which is read back bit-exact. Inertials are about the centre of
mass with rpy 0. A required number that is unknown is written as a placeholder and marked.

`base` and `flange` have an `<inertial>` of mass 0 and inertia 0: a link without one weighs 1 kg in PyBullet, and as
much as its shapes in MuJoCo. Pinocchio, MuJoCo, Drake, PyBullet and yourdfpy take the zeros without a word. In ROS,
`kdl_parser` warns about any root link with an `<inertial>` and ignores it, which changes nothing here. To sdformat
(Gazebo) mass 0 is no `<inertial>`: it merges `flange` into the last link, but leaves out `base` and all that hangs on
it, with or without the zeros; for Gazebo give `base` a mass of your own.
"""

import math
from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

from lwr_dyn.model.arm import Arm, Joint
from lwr_dyn.model.chain import Body, ChainLink
from lwr_dyn.model.spatial import Pose, to_rpy
from lwr_dyn.urdf.geometry import COLOURS, Primitive, primitives
from lwr_dyn.urdf.xml_text import header, numbers

UNKNOWN_POSITION = 2 * math.pi
"""Placeholder for an unknown position limit [rad or m]."""
UNKNOWN_LARGE = 1e9
"""Placeholder for an unknown effort or velocity."""
PLACEHOLDERS = {
    "lower": -UNKNOWN_POSITION,
    "upper": UNKNOWN_POSITION,
    "effort": UNKNOWN_LARGE,
    "velocity": UNKNOWN_LARGE,
}
DRAKE = "https://drake.mit.edu/"
ENDS = ("base", "flange")
"""The first and the last link, which carry shapes and no mass."""

DRAWN, UNKNOWN, CHOICE, WEIGHTLESS = "drawn", "unknown", "by choice", "weightless"
"""Words for numbers without a cell: a shape, a placeholder, a frame that is placed by choice, a frame without mass."""


@dataclass(frozen=True, slots=True)
class Attribute:
    """One numeric attribute: its numbers, and the arm's quantities that they come from, or a word instead."""

    written: tuple[float, ...]
    quantities: tuple[str, ...] = ()
    word: str = ""


@dataclass(slots=True)
class SourcedText:
    """Lines of a URDF, and its numeric attributes by path."""

    text: list[str] = field(default_factory=list)
    attributes: dict[str, Attribute] = field(default_factory=dict)

    def line(self, depth: int, xml: str) -> None:
        """A line without numbers."""
        self.text.append("  " * depth + xml)

    def numbers(self, depth: int, tag: str, path: str, **attributes: Attribute) -> None:
        """An element with numeric attributes only; `path` is its parent's."""
        text = " ".join(f'{name}="{numbers(attribute.written)}"' for name, attribute in attributes.items())
        self.line(depth, f"<{tag} {text}/>")
        for name, attribute in attributes.items():
            self.attributes[f"{path}/{tag}/@{name}"] = attribute


def urdf_text(arm: Arm) -> str:
    """The arm as URDF text; the same arm gives the same bytes."""
    return "\n".join(urdf_with_sources(arm).text) + "\n"


def urdf_with_sources(arm: Arm) -> SourcedText:
    """The URDF's lines and the source of every numeric attribute."""
    out = SourcedText()
    out.line(0, '<?xml version="1.0" encoding="utf-8"?>')
    for line in header(arm):
        out.line(0, line)
    out.line(0, f'<robot name={quoteattr(arm.name)} xmlns:drake="{DRAKE}">')
    for name, rgba in COLOURS.items():
        out.line(1, f'<material name="{name}">')
        out.numbers(2, "color", f"/robot/material[@name='{name}']", rgba=Attribute(rgba, word=DRAWN))
        out.line(1, "</material>")
    shapes = primitives(arm)
    _link(out, "base", shapes)
    parent, placed = "base", _placed_by(arm)
    turned = any(not link.after.is_identity() for link in arm.chain.links)
    for k, (link, joint, body) in enumerate(zip(arm.chain.links, arm.joints(), arm.bodies(), strict=True)):
        _link(out, link.link, shapes, body, (f"{link.joint}.after",) if turned else ())
        _joint(out, joint, parent, link.link, placed[k])
        _transmission(out, link)
        parent = link.link
    _link(out, "flange", shapes)
    fixed = "flange_joint" + "_" * (arm.joint_names.count("flange_joint"))
    out.line(1, f'<joint name="{fixed}" type="fixed">')
    _origin(out, f"/robot/joint[@name='{fixed}']", arm.flange(), placed[-1])
    out.line(2, f"<parent link={quoteattr(parent)}/>")
    out.line(2, '<child link="flange"/>')
    out.line(1, "</joint>")
    out.line(0, "</robot>")
    return out


def _placed_by(arm: Arm) -> list[tuple[str, ...]]:
    """For each joint and the flange, the parts of DH rows that place it: origin_i = after_{i-1} @ before_i.

    In standard DH that is the previous row only, in modified DH parts of both rows; joint 1 of a standard table is in
    the base by choice of frame 0.
    """
    links = arm.chain.links
    two_sided = any(not link.before.is_identity() for link in links)
    before = [(f"{link.joint}.before",) if two_sided else () for link in links]
    after = [(), *((f"{link.joint}.after",) for link in links)]
    flange = ("flange",) if arm.sources.get("flange") or not arm.chain.flange.is_identity() else ()
    return [(*a, *b) for a, b in zip(after, [*before, flange], strict=True)]


def _origin(
    out: SourcedText, path: str, pose: Pose, quantities: tuple[str, ...], word: str = CHOICE, depth: int = 2
) -> None:
    word = "" if quantities else word
    xyz, rpy = (Attribute(tuple(map(float, v)), quantities, word) for v in (pose.position, to_rpy(pose.rotation)))
    out.numbers(depth, "origin", path, xyz=xyz, rpy=rpy)


def _link(
    out: SourcedText,
    name: str,
    shapes: tuple[Primitive, ...],
    body: Body | None = None,
    frame: tuple[str, ...] = (),
) -> None:
    path = f"/robot/link[@name='{name}']"
    out.line(1, f"<link name={quoteattr(name)}>")
    if name in ENDS:
        _weightless(out, f"{path}/inertial")
    elif body is not None:
        _inertial(out, f"{path}/inertial", name, body, frame)
    for tag in ("visual", "collision"):
        mine = [s for s in shapes if s.link == name]
        for k, shape in enumerate(mine, start=1):
            _shape(out, tag, shape, f"{path}/{tag}[{k}]")
    out.line(1, "</link>")


def _inertial(out: SourcedText, path: str, name: str, body: Body, frame: tuple[str, ...]) -> None:
    """`frame` lists the quantities that move the paper's frame of the link to the URDF's."""
    com = Attribute(tuple(map(float, body.com)), (f"{name}.com", *frame))
    mass = Attribute((float(body.mass),), (f"{name}.mass",))
    quantities = (f"{name}.inertia", *frame)
    _mass_elements(out, path, com, mass, {k: Attribute((v,), quantities) for k, v in _moments(body).items()})


def _weightless(out: SourcedText, path: str) -> None:
    zero = Attribute((0.0,), word=WEIGHTLESS)
    moments = dict.fromkeys(_moments(Body.massless()), zero)
    _mass_elements(out, path, Attribute((0.0, 0.0, 0.0), word=WEIGHTLESS), zero, moments)


def _moments(body: Body) -> dict[str, float]:
    return {f"i{'xyz'[r]}{'xyz'[c]}": float(body.inertia_com[r, c]) for r in range(3) for c in range(r, 3)}


def _mass_elements(out: SourcedText, path: str, com: Attribute, mass: Attribute, moments: dict[str, Attribute]) -> None:
    out.line(2, "<inertial>")
    out.numbers(3, "origin", path, xyz=com, rpy=Attribute((0.0, 0.0, 0.0), word=CHOICE))
    out.numbers(3, "mass", path, value=mass)
    out.numbers(3, "inertia", path, **moments)
    out.line(2, "</inertial>")


def _shape(out: SourcedText, tag: str, shape: Primitive, path: str) -> None:
    out.line(2, f"<{tag}>")
    _origin(out, path, shape.pose, (), DRAWN, depth=3)
    out.line(3, "<geometry>")
    sizes = {
        "radius": Attribute((shape.radius,), word=DRAWN),
        "length": Attribute((shape.length,), word=DRAWN),
    }
    out.numbers(4, "cylinder", f"{path}/geometry", **sizes)
    out.line(3, "</geometry>")
    if tag == "visual":
        out.line(3, f'<material name="{shape.colour}"/>')
    out.line(2, f"</{tag}>")


def _joint(out: SourcedText, joint: Joint, parent: str, child: str, placed: tuple[str, ...]) -> None:
    path, limits = f"/robot/joint[@name='{joint.name}']", joint.limits
    out.line(1, f'<joint name={quoteattr(joint.name)} type="{joint.kind.value}">')
    _origin(out, path, joint.origin, placed)
    out.line(2, f"<parent link={quoteattr(parent)}/>")
    out.line(2, f"<child link={quoteattr(child)}/>")
    out.numbers(2, "axis", path, xyz=Attribute((0.0, 0.0, 1.0), word=CHOICE))
    cells = {}
    for name, placeholder in PLACEHOLDERS.items():
        value = getattr(limits, name)
        unknown = Attribute((placeholder,), word=UNKNOWN)
        cells[name] = unknown if value is None else Attribute((value,), (f"{joint.name}.{name}",))
    out.numbers(2, "limit", path, **cells)
    friction = {"damping": ("viscous", limits.viscous), "friction": ("coulomb", limits.coulomb)}
    known = {tag: Attribute((v,), (f"{joint.name}.{name}",)) for tag, (name, v) in friction.items() if v is not None}
    if known:
        out.numbers(2, "dynamics", path, **known)
    out.line(1, "</joint>")


def _transmission(out: SourcedText, link: ChainLink) -> None:
    """The joint's motor, which Drake needs for an actuator, and its rotor in the tags that Drake reads."""
    rotor, joint = link.rotor, link.joint
    path = f"/robot/transmission[@name='{joint}_transmission']/actuator"
    out.line(1, f"<transmission name={quoteattr(f'{joint}_transmission')}>")
    out.line(2, "<type>transmission_interface/SimpleTransmission</type>")
    out.line(2, f"<joint name={quoteattr(joint)}/>")
    out.line(2, f"<actuator name={quoteattr(f'{joint}_motor')}" + ("/>" if rotor is None else ">"))
    if rotor is not None:
        ratio = Attribute((rotor.gear_ratio,), (), UNKNOWN) if rotor.reflected else None
        ratio = ratio or Attribute((rotor.gear_ratio,), (f"{joint}.gear_ratio",))
        out.numbers(3, "drake:gear_ratio", path, value=ratio)
        out.numbers(3, "drake:rotor_inertia", path, value=Attribute((rotor.inertia,), (f"{joint}.rotor_inertia",)))
        out.line(2, "</actuator>")
    out.line(1, "</transmission>")
