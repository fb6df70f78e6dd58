"""Arm -> URDF text, and the trail of every number in it: the same walk writes both.

Text is deterministic and floats are written by repr, which is read back bit-exact. Inertials stand about the centre of
mass with rpy 0. A compulsory number that is unknown is written as a stand-in and marked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

from lwr_dyn.model.arm import Arm, Joint
from lwr_dyn.model.chain import Body, ChainLink
from lwr_dyn.model.feasibility import unphysical_links
from lwr_dyn.model.spatial import Pose, to_rpy
from lwr_dyn.urdf.beyond import ONE_SIDED
from lwr_dyn.urdf.geometry import COLOURS, Primitive, primitives
from lwr_dyn.urdf.xml_text import comment, numbers

UNKNOWN_POSITION = 2 * math.pi
"""Stand-in for an unknown position limit [rad or m]."""
UNKNOWN_LARGE = 1e9
"""Stand-in for an unknown effort or velocity."""
PLACEHOLDERS = {
    "lower": -UNKNOWN_POSITION,
    "upper": UNKNOWN_POSITION,
    "effort": UNKNOWN_LARGE,
    "velocity": UNKNOWN_LARGE,
}
WRITTEN_BY = "written by lwr_dyn"
UNKNOWN_LIMITS = "unknown, written as stand-ins: "
ESTIMATED = "estimated, not measured: "
GRAVITY = "gravity in the base frame [m/s^2], which a URDF cannot hold: "
REFLECTED = "rotor inertia as the joint feels it; gear ratios are stand-ins of 1: "
"""Openings of header lines that `urdf.reader` reads back."""
DRAKE = "https://drake.mit.edu/"

DRAWN, UNKNOWN, CHOICE = "drawn", "unknown", "by choice"
"""What is said of a number that no cell gives: a shape, a stand-in, a frame placed where it is convenient."""


@dataclass(frozen=True, slots=True)
class Attribute:
    """One numeric attribute: its numbers, and the arm's quantities they are made from or a word in their place."""

    written: tuple[float, ...]
    quantities: tuple[str, ...] = ()
    word: str = ""


@dataclass(slots=True)
class SourcedText:
    """The text of a URDF, and attribute path -> source of every number in it."""

    text: list[str] = field(default_factory=list)
    attributes: dict[str, Attribute] = field(default_factory=dict)

    def line(self, depth: int, xml: str) -> None:
        """A line without numbers."""
        self.text.append("  " * depth + xml)

    def numbers(self, depth: int, tag: str, path: str, **attributes: Attribute) -> None:
        """An element that holds nothing but numbers; `path` is its parent's."""
        text = " ".join(f'{name}="{numbers(attribute.written)}"' for name, attribute in attributes.items())
        self.line(depth, f"<{tag} {text}/>")
        for name, attribute in attributes.items():
            self.attributes[f"{path}/{tag}/@{name}"] = attribute


def urdf_text(arm: Arm) -> str:
    """The arm as URDF text; the same arm gives the same bytes."""
    return "\n".join(urdf_with_sources(arm).text) + "\n"


def urdf_with_sources(arm: Arm) -> SourcedText:
    """The lines of the URDF and, for every numeric attribute, what it is made from."""
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


def header(arm: Arm) -> list[str]:
    """The comment on top: what the file is, from where, under which reading, what is unknown or drawn."""
    unknown = [f"{name} {x}" for name, x in unknown_limits(arm)]
    lines = [
        f"{arm.title}; robot {arm.name}, reading {arm.reading}",
        f"{WRITTEN_BY}; do not edit: change the data file and write again",
        f"errata applied: {', '.join(arm.errata) or 'none'}",
        f"source file sha256: {arm.digest or 'none'}",
        f"{GRAVITY}{numbers(arm.chain.gravity)}",
        "inertials: about the centre of mass, axes of the link frame; every number's source is in the .provenance.json",
        f"inertias that no body can have: {', '.join(unphysical_links(arm.chain)) or 'none'}",
        *(f"{ESTIMATED}{line}" for line in estimates(arm)),
        "rotor inertia: not part of the links' inertials; see the .srdf, the drake: tags and the MJCF .xml",
        f"{UNKNOWN_LIMITS}{', '.join(unknown) or 'nothing'}",
        "visual and collision shapes: drawn by lwr_dyn, not from the source",
    ]
    reflected = [link.joint for link in arm.chain.links if link.rotor is not None and link.rotor.reflected]
    if reflected:
        lines.insert(-1, f"{REFLECTED}{', '.join(reflected)}")
    if arm.friction:
        lines.insert(-1, ONE_SIDED)
    return ["<!--", *(f"  {comment(x)}" for x in lines), "-->"]


def estimates(arm: Arm) -> list[str]:
    """What of the links' inertials the source does not give and was estimated, and how: one line per method."""
    found: dict[str, dict[str, list[str]]] = {}
    for quantity, cells in arm.sources.items():
        link, _, part = quantity.rpartition(".")
        for cell in cells:
            if cell.kind == "estimated" and link:
                found.setdefault(cell.where, {}).setdefault(part, []).append(link)
    return [
        "; ".join(f"{part} of {', '.join(links)}" for part, links in parts.items()) + f" (how: {where})"
        for where, parts in found.items()
    ]


def unknown_limits(arm: Arm) -> list[tuple[str, str]]:
    """(joint, limit) pairs that the source does not give and a URDF must have."""
    names = ("lower", "upper", "velocity", "effort")
    return [(joint.name, x) for joint in arm.joints() for x in names if getattr(joint.limits, x) is None]


def _placed_by(arm: Arm) -> list[tuple[str, ...]]:
    """For each joint and then the flange, whose DH rows place it: origin_i = after_{i-1} @ before_i.

    In standard DH that is the row before alone, in modified DH parts of both; joint 1 of a standard table stands in the
    base by choice of frame 0.
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
    if body is not None:
        _inertial(out, f"{path}/inertial", name, body, frame)
    for tag in ("visual", "collision"):
        mine = [s for s in shapes if s.link == name]
        for k, shape in enumerate(mine, start=1):
            _shape(out, tag, shape, f"{path}/{tag}[{k}]")
    out.line(1, "</link>")


def _inertial(out: SourcedText, path: str, name: str, body: Body, frame: tuple[str, ...]) -> None:
    """`frame` is what turns and shifts the paper's frame of the link into the URDF's."""
    out.line(2, "<inertial>")
    com = Attribute(tuple(map(float, body.com)), (f"{name}.com", *frame))
    out.numbers(3, "origin", path, xyz=com, rpy=Attribute((0.0, 0.0, 0.0), word=CHOICE))
    out.numbers(3, "mass", path, value=Attribute((float(body.mass),), (f"{name}.mass",)))
    cells = {f"i{'xyz'[r]}{'xyz'[c]}": float(body.inertia_com[r, c]) for r in range(3) for c in range(r, 3)}
    made_from = (f"{name}.inertia", *frame)
    out.numbers(3, "inertia", path, **{key: Attribute((value,), made_from) for key, value in cells.items()})
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
    for name, stand_in in PLACEHOLDERS.items():
        value = getattr(limits, name)
        unknown = Attribute((stand_in,), word=UNKNOWN)
        cells[name] = unknown if value is None else Attribute((value,), (f"{joint.name}.{name}",))
    out.numbers(2, "limit", path, **cells)
    friction = {"damping": ("viscous", limits.viscous), "friction": ("coulomb", limits.coulomb)}
    known = {tag: Attribute((v,), (f"{joint.name}.{name}",)) for tag, (name, v) in friction.items() if v is not None}
    if known:
        out.numbers(2, "dynamics", path, **known)
    out.line(1, "</joint>")


def _transmission(out: SourcedText, link: ChainLink) -> None:
    """Rotor inertia for Drake, which reads it only here."""
    rotor, joint = link.rotor, link.joint
    if rotor is None:
        return
    path = f"/robot/transmission[@name='{joint}_transmission']/actuator"
    out.line(1, f"<transmission name={quoteattr(f'{joint}_transmission')}>")
    out.line(2, "<type>transmission_interface/SimpleTransmission</type>")
    out.line(2, f"<joint name={quoteattr(joint)}/>")
    out.line(2, f"<actuator name={quoteattr(f'{joint}_motor')}>")
    ratio = (f"{joint}.gear_ratio",), ""
    stand_in = (), UNKNOWN
    out.numbers(
        3,
        "drake:gear_ratio",
        path,
        value=Attribute((rotor.gear_ratio,), *(stand_in if rotor.reflected else ratio)),
    )
    out.numbers(3, "drake:rotor_inertia", path, value=Attribute((rotor.inertia,), (f"{joint}.rotor_inertia",)))
    out.line(2, "</actuator>")
    out.line(1, "</transmission>")
