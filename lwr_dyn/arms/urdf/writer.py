"""Arm -> URDF text, together with the source of every number in it.

The text is deterministic; floats are written by repr, which is read back bit-exact. Inertials are about the centre of
mass with rpy 0. A required number that is unknown is written as a placeholder and marked.

`base` and `flange` have an `<inertial>` of mass 0 and inertia 0: a link without one weighs 1 kg in PyBullet, and as
much as its shapes in MuJoCo. Pinocchio, MuJoCo, Drake, PyBullet and yourdfpy take the zeros without a word. In ROS,
`kdl_parser` warns about any root link with an `<inertial>` and ignores it, which changes nothing here. To sdformat
(Gazebo) mass 0 is no `<inertial>`: it merges `flange` into the last link, but leaves out `base` and all that hangs on
it, with or without the zeros; for Gazebo give `base` a mass of your own.

An arm from a foreign URDF is written in the file's own links, frames and axes: `continuous` joints, tip and tool
frames, transmissions and shapes stay (mesh files by name, so a relative name holds only beside the original). Masses of
links that are fixed to a moving link are joined with it. Of a branched file only the chain and what is fixed to it is
written. An arm that is mounted has one link more, the root `world`, and one with a tool the link `tool` at its end.
"""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

from lwr_dyn.arms.urdf import elements
from lwr_dyn.arms.urdf.elements import CHOICE, COPIED, DRAKE, DRAWN, Attribute, SourcedText
from lwr_dyn.arms.urdf.geometry import COLOURS, Primitive, primitives
from lwr_dyn.foundation.arrays import arm_argument
from lwr_dyn.model.arm import Arm, Joint, JointLimits
from lwr_dyn.model.chain import Body, ChainLink, Installation, Rotor
from lwr_dyn.model.file_layout import FileJoint, FileLayout, fitting
from lwr_dyn.model.spatial import Pose

_ROTOR_TAGS = ("gear_ratio", "rotor_inertia")


@dataclass(frozen=True, slots=True, eq=False)
class CarriedXml:
    """Elements of the file as XML, by the link or joint that they belong to."""

    shapes: Mapping[str, tuple[str, ...]]
    inertials: Mapping[str, str]
    transmissions: Mapping[str, str]
    """Of joints that have one of their own, without the rotor, which the arm holds."""
    materials: tuple[str, ...]


def carried_xml(root: ElementTree.Element) -> CarriedXml:
    """The shapes, inertials, transmissions and materials of a parsed file."""
    shapes: dict[str, tuple[str, ...]] = {}
    inertials: dict[str, str] = {}
    for link in root.findall("link"):
        name = link.get("name", "")
        shapes[name] = tuple(elements.compact(x) for tag in ("visual", "collision") for x in link.findall(tag))
        for element in link.findall("inertial"):
            inertials[name] = elements.compact(element)
    transmissions = {}
    for element in root.findall("transmission"):
        joints = [x.get("name", "") for x in element.findall("joint")]
        if len(joints) == 1:
            transmissions[joints[0]] = elements.compact(_without_rotor(element))
    return CarriedXml(shapes, inertials, transmissions, tuple(map(elements.compact, root.findall("material"))))


def _without_rotor(transmission: ElementTree.Element) -> ElementTree.Element:
    out = copy.deepcopy(transmission)
    for actuator in out.findall("actuator"):
        for child in [x for x in actuator if x.tag.rpartition("}")[2] in _ROTOR_TAGS and "}" in x.tag]:
            actuator.remove(child)
    return out


def write_as_in_file(out: SourcedText, arm: Arm, layout: FileLayout) -> None:
    """Links and joints of the file; numbers of the dynamics are the arm's, all others are copied."""
    for xml in layout.materials:
        out.copied(1, xml, _path("material", ElementTree.fromstring(xml).get("name", "")))
    _resting_link(out, layout.root, layout)
    for frame in layout.fixed[0]:
        _resting_link(out, frame.link, layout)
        _fixed_joint(out, frame.joint, frame.parent, frame.link, frame.origin, (), COPIED)
    for joint, link, limits, fixed in zip(layout.joints, arm.chain.links, arm.limits, layout.fixed[1:], strict=True):
        _moving_link(out, joint.child, link, layout)
        _moving_joint(out, joint, link, limits)
        _transmission_of_file(out, joint, link.rotor)
        for frame in fixed:
            _open_link(out, frame.link)
            if link.body is not None:
                elements.write_weightless(out, f"{_path('link', frame.link)}/inertial")
            _close_link(out, frame.link, layout)
            _fixed_joint(out, frame.joint, frame.parent, frame.link, frame.origin, (), COPIED)


def _path(tag: str, name: str) -> str:
    return f"/robot/{tag}[@name='{name}']"


def _open_link(out: SourcedText, name: str) -> None:
    out.line(1, f"<link name={quoteattr(name)}>")


def _close_link(out: SourcedText, name: str, layout: FileLayout) -> None:
    """The shapes, and the end of the link."""
    seen: dict[str, int] = {}
    for xml in layout.shapes[name]:
        tag = ElementTree.fromstring(xml).tag
        seen[tag] = seen.get(tag, 0) + 1
        out.copied(2, xml, f"{_path('link', name)}/{tag}[{seen[tag]}]")
    out.line(1, "</link>")


def _resting_link(out: SourcedText, name: str, layout: FileLayout) -> None:
    """A link that does not move, with the mass that the file gives it; a bare frame stays bare."""
    _open_link(out, name)
    path = f"{_path('link', name)}/inertial"
    if name in layout.inertials:
        out.copied(2, layout.inertials[name], path)
    elif layout.shapes[name]:
        elements.write_weightless(out, path)
    _close_link(out, name, layout)


def _moving_link(out: SourcedText, name: str, link: ChainLink, layout: FileLayout) -> None:
    _open_link(out, name)
    if link.body is not None:
        elements.write_inertial(out, f"{_path('link', name)}/inertial", link.link, link.body, ())
    _close_link(out, name, layout)


def _moving_joint(out: SourcedText, joint: FileJoint, link: ChainLink, limits: JointLimits) -> None:
    path, kind = _path("joint", joint.joint), "continuous" if joint.unlimited else link.kind.value
    out.line(1, f'<joint name={quoteattr(joint.joint)} type="{kind}">')
    _placed(out, path, joint.parent, joint.child, joint.origin, (), COPIED)
    out.numbers(2, "axis", path, xyz=Attribute(joint.axis, (f"{joint.joint}.after",)))
    elements.write_limits(out, path, joint.joint, limits, joint.unlimited)
    out.line(1, "</joint>")


def _fixed_joint(
    out: SourcedText, name: str, parent: str, child: str, origin: Pose, placed: tuple[str, ...], word: str = CHOICE
) -> None:  # fmt: skip
    out.line(1, f'<joint name={quoteattr(name)} type="fixed">')
    _placed(out, _path("joint", name), parent, child, origin, placed, word)
    out.line(1, "</joint>")


def _placed(
    out: SourcedText, path: str, parent: str, child: str, origin: Pose, placed: tuple[str, ...], word: str = CHOICE
) -> None:  # fmt: skip
    """What a joint joins, and where; `placed` and `word` as of `write_origin`."""
    elements.write_origin(out, path, origin, placed, word)
    out.line(2, f"<parent link={quoteattr(parent)}/>")
    out.line(2, f"<child link={quoteattr(child)}/>")


def _transmission_of_file(out: SourcedText, joint: FileJoint, rotor: Rotor | None) -> None:
    """The file's own transmission, with the arm's rotor in it."""
    if not joint.transmission:
        return
    element = ElementTree.fromstring(joint.transmission)
    path = _path("transmission", element.get("name", ""))
    words = "".join(f" {name}={quoteattr(value)}" for name, value in element.attrib.items())
    out.line(1, f"<transmission{words}>")
    for child in element:
        if child.tag == "actuator" and rotor is not None:
            out.line(2, f"<actuator name={quoteattr(child.get('name', ''))}>")
            for part in child:
                out.copied(3, elements.compact(part), f"{path}/actuator/{part.tag}")
            elements.write_rotor(out, f"{path}/actuator", joint.joint, rotor)
            out.line(2, "</actuator>")
        else:
            out.copied(2, elements.compact(child), f"{path}/{child.tag}")
    out.line(1, "</transmission>")


ENDS = ("base", "flange")
"""The first and the last link, which carry shapes and no mass."""


def urdf_text(arm: Arm) -> str:
    """The arm as URDF text; the same arm gives the same bytes."""
    return "\n".join(urdf_with_sources(arm_argument(arm)).text) + "\n"


def urdf_with_sources(arm: Arm) -> SourcedText:
    """The URDF's lines and the source of every numeric attribute."""
    out = SourcedText()
    out.line(0, '<?xml version="1.0" encoding="utf-8"?>')
    for line in elements.header(arm):
        out.line(0, line)
    out.line(0, f'<robot name={quoteattr(arm.name)} xmlns:drake="{DRAKE}">')
    bare, there = arm.uninstalled(), arm.installation
    layout = fitting(bare.layout, bare.chain)
    if layout is None:
        _write_as_modelled(out, bare, primitives(arm))
    else:
        write_as_in_file(out, bare, layout)
    if there is not None:
        _write_installation(out, there, *(ENDS if layout is None else (layout.root, layout.tip)))
    out.line(0, "</robot>")
    return out


def _write_installation(out: SourcedText, there: Installation, base: str, flange: str) -> None:
    """Link `world` with the base fixed to it, link `tool` fixed to the flange; the last moving link has its mass."""
    world, mount, tool, holder = (_free_name(out, x) for x in ("world", "mount", "tool", "tool_joint"))
    if there.mount is not None:
        out.line(1, f"<link name={quoteattr(world)}/>")
        _fixed_joint(out, mount, world, base, there.mount, ("mount",))
    if not there.tool.frame.is_identity():
        _open_link(out, tool)
        elements.write_weightless(out, f"{_path('link', tool)}/inertial")
        out.line(1, "</link>")
        _fixed_joint(out, holder, flange, tool, there.tool.frame, ("tool",))


def _free_name(out: SourcedText, name: str) -> str:
    """The name, with underscores where the text has it already."""
    while any(f"name={quoteattr(name)}" in line for line in out.text):
        name += "_"
    return name


def _write_as_modelled(out: SourcedText, arm: Arm, shapes: tuple[Primitive, ...]) -> None:
    """Links base, the arm's own, flange, with z as joint axis and drawn shapes."""
    for name, rgba in COLOURS.items():
        out.line(1, f'<material name="{name}">')
        out.numbers(2, "color", _path("material", name), rgba=Attribute(rgba, word=DRAWN))
        out.line(1, "</material>")
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
    _fixed_joint(out, fixed, parent, "flange", arm.flange(), placed[-1])


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


def _link(
    out: SourcedText, name: str, shapes: tuple[Primitive, ...], body: Body | None = None, frame: tuple[str, ...] = ()
) -> None:  # fmt: skip
    path = _path("link", name)
    _open_link(out, name)
    if name in ENDS:
        elements.write_weightless(out, f"{path}/inertial")
    elif body is not None:
        elements.write_inertial(out, f"{path}/inertial", name, body, frame)
    for tag in ("visual", "collision"):
        mine = [s for s in shapes if s.link == name]
        for k, shape in enumerate(mine, start=1):
            _shape(out, tag, shape, f"{path}/{tag}[{k}]")
    out.line(1, "</link>")


def _shape(out: SourcedText, tag: str, shape: Primitive, path: str) -> None:
    out.line(2, f"<{tag}>")
    elements.write_origin(out, path, shape.pose, (), DRAWN, depth=3)
    out.line(3, "<geometry>")
    radius, length = (Attribute((x,), word=DRAWN) for x in (shape.radius, shape.length))
    out.numbers(4, "cylinder", f"{path}/geometry", radius=radius, length=length)
    out.line(3, "</geometry>")
    if tag == "visual":
        out.line(3, f'<material name="{shape.colour}"/>')
    out.line(2, f"</{tag}>")


def _joint(out: SourcedText, joint: Joint, parent: str, child: str, placed: tuple[str, ...]) -> None:
    path = _path("joint", joint.name)
    out.line(1, f'<joint name={quoteattr(joint.name)} type="{joint.kind.value}">')
    _placed(out, path, parent, child, joint.origin, placed)
    out.numbers(2, "axis", path, xyz=Attribute((0.0, 0.0, 1.0), word=CHOICE))
    elements.write_limits(out, path, joint.name, joint.limits)
    out.line(1, "</joint>")


def _transmission(out: SourcedText, link: ChainLink) -> None:
    """The joint's motor, which Drake needs for an actuator, and its rotor in the tags that Drake reads."""
    rotor, joint = link.rotor, link.joint
    path = f"{_path('transmission', f'{joint}_transmission')}/actuator"
    out.line(1, f"<transmission name={quoteattr(f'{joint}_transmission')}>")
    out.line(2, "<type>transmission_interface/SimpleTransmission</type>")
    out.line(2, f"<joint name={quoteattr(joint)}/>")
    out.line(2, f"<actuator name={quoteattr(f'{joint}_motor')}" + ("/>" if rotor is None else ">"))
    if rotor is not None:
        elements.write_rotor(out, path, joint, rotor)
        out.line(2, "</actuator>")
    out.line(1, "</transmission>")
