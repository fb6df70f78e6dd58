"""What a foreign URDF holds beyond the dynamics: taken from the file, and written again around the arm.

The text has the links, frames and axes of the file.
"""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

from lwr_dyn.arms.urdf.elements import (
    COPIED,
    Attribute,
    SourcedText,
    compact,
    write_inertial,
    write_limits,
    write_origin,
    write_rotor,
    write_weightless,
)
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, ChainLink, Rotor
from lwr_dyn.model.file_layout import FileJoint, FileLayout, FixedLink

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
        shapes[name] = tuple(compact(x) for tag in ("visual", "collision") for x in link.findall(tag))
        for element in link.findall("inertial"):
            inertials[name] = compact(element)
    transmissions = {}
    for element in root.findall("transmission"):
        joints = [x.get("name", "") for x in element.findall("joint")]
        if len(joints) == 1:
            transmissions[joints[0]] = compact(_without_rotor(element))
    return CarriedXml(shapes, inertials, transmissions, tuple(map(compact, root.findall("material"))))


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
        _fixed_joint(out, frame)
    for joint, link, limits, fixed in zip(layout.joints, arm.chain.links, arm.limits, layout.fixed[1:], strict=True):
        _moving_link(out, joint.child, link, layout)
        _moving_joint(out, joint, link, limits)
        _transmission(out, joint, link.rotor)
        for frame in fixed:
            _open_link(out, frame.link)
            if link.body is not None:
                write_weightless(out, f"{_path('link', frame.link)}/inertial")
            _close_link(out, frame.link, layout)
            _fixed_joint(out, frame)


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
        write_weightless(out, path)
    _close_link(out, name, layout)


def _moving_link(out: SourcedText, name: str, link: ChainLink, layout: FileLayout) -> None:
    _open_link(out, name)
    body: Body | None = link.body
    if body is not None:
        write_inertial(out, f"{_path('link', name)}/inertial", link.link, body, ())
    _close_link(out, name, layout)


def _moving_joint(out: SourcedText, joint: FileJoint, link: ChainLink, limits: JointLimits) -> None:
    path, kind = _path("joint", joint.joint), "continuous" if joint.unlimited else link.kind.value
    out.line(1, f'<joint name={quoteattr(joint.joint)} type="{kind}">')
    _placed(out, path, joint)
    out.numbers(2, "axis", path, xyz=Attribute(joint.axis, (f"{joint.joint}.after",)))
    write_limits(out, path, joint.joint, limits, joint.unlimited)
    out.line(1, "</joint>")


def _fixed_joint(out: SourcedText, frame: FixedLink) -> None:
    out.line(1, f'<joint name={quoteattr(frame.joint)} type="fixed">')
    _placed(out, _path("joint", frame.joint), frame)
    out.line(1, "</joint>")


def _placed(out: SourcedText, path: str, joint: FileJoint | FixedLink) -> None:
    child = joint.child if isinstance(joint, FileJoint) else joint.link
    write_origin(out, path, joint.origin, (), COPIED)
    out.line(2, f"<parent link={quoteattr(joint.parent)}/>")
    out.line(2, f"<child link={quoteattr(child)}/>")


def _transmission(out: SourcedText, joint: FileJoint, rotor: Rotor | None) -> None:
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
                out.copied(3, compact(part), f"{path}/actuator/{part.tag}")
            write_rotor(out, f"{path}/actuator", joint.joint, rotor)
            out.line(2, "</actuator>")
        else:
            out.copied(2, compact(child), f"{path}/{child.tag}")
    out.line(1, "</transmission>")
