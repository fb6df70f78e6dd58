"""URDF file -> parsed URDF by yourdfpy, after checks of our own, with one error that names the faulty element.

Shapes and materials are dropped before, since dynamics needs none: so mesh files need not exist. Undeclared prefixes
are read as engines read them: urdfdom and Drake parse without namespaces, so files with `<drake:gear_ratio>` or
`<gazebo xlink:href="...">` and no declaration are about, which a strict parser refuses. A file of xacro macros is
expanded by the package `xacro` where it is installed; it needs no ROS.
"""

import hashlib
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.parsers.expat import errors
from xml.sax.saxutils import unescape

import numpy as np

from lwr_dyn.arms.urdf.elements import CAVEAT, GRAVITY, REFLECTED, UNKNOWN_LIMITS, WRITTEN_BY, comment
from lwr_dyn.arms.urdf.writer import CarriedXml, carried_xml
from lwr_dyn.arms.urdf.xacro_files import expand_xacro
from lwr_dyn.foundation.arrays import number_of
from lwr_dyn.foundation.errors import UrdfError
from lwr_dyn.foundation.files import ends_in, read_bytes
from lwr_dyn.model.caveats import Caveats, caveats_of_words
from lwr_dyn.model.chain import Rotor

DRAKE = "http://drake.mit.edu"
"""Drake's namespace, which an undeclared prefix `drake` stands for."""
_UNBOUND = errors.codes[errors.XML_ERROR_UNBOUND_PREFIX]
_PREFIX = re.compile(rb"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_]")
_DECLARED = re.compile(rb"xmlns:([A-Za-z_][\w.-]*)\s*=")
_ROOT = re.compile(rb"<!--.*?-->|(<robot\b[^>]*>)", re.DOTALL)
_AROUND = b" \t\r\n\0"
"""Before and after the document, where the engines pass over it."""
_XACRO = "xacro"
_DEEPEST = 100
"""Levels of nested elements: far above any URDF, far below what Python's recursion bears."""


def parse_xml(content: bytes, file: str, form: str = "URDF") -> ElementTree.Element:
    """The root element of a URDF, or of another form.

    Raises `UrdfError`: broken XML, elements nested too deep, a file of xacro macros (with the command that expands it).
    Tags that xacro left over stay in.
    """
    try:
        root = _tree(content.strip(_AROUND))
    except (ElementTree.ParseError, ValueError, LookupError) as fault:
        raise UrdfError(file, "XML", str(fault), f"a well-formed {form}") from None
    if _depth(root) > _DEEPEST:
        raise UrdfError(file, "XML", f"elements nested {_depth(root)} deep", f"at most {_DEEPEST} levels")
    used = next(_macros(root), "")
    if used:
        allowed = f"the URDF that it expands to, or a name that ends in .xacro: xacro {file} > expanded.urdf"
        raise UrdfError(file, used, "a file of xacro macros", allowed)
    return root


LEFTOVERS = ("include", "arg", "property", "macro")
"""Tags of xacro that make nothing by themselves."""
_DRAWN = ("visual", "collision", "material", "gazebo")
"""Elements whose contents no computation uses."""
_OUTSIDE = (*_DRAWN, "transmission")
"""What a macro may make that neither moves nor weighs."""
_EXPRESSION = re.compile(r"\$\{|\$\((arg|eval)\b")


def xacro_tag(tag: str) -> str:
    """A tag of xacro without its namespace or prefix; empty for others."""
    space, mark, name = tag.rpartition("}" if "}" in tag else ":")
    return name if mark and _XACRO in space.lower() else ""


def leftovers(root: ElementTree.Element) -> tuple[str, ...]:
    """The tags of xacro in a file, each once, as `<xacro:include>`; not those within a macro."""
    found, waiting = list[str](), [root]
    for element in waiting:
        tag = xacro_tag(str(element.tag))
        found += [f"<xacro:{tag}>"] if tag else []
        waiting += [] if tag == "macro" else element
    return tuple(dict.fromkeys(found))


def _macros(root: ElementTree.Element) -> Iterator[str]:
    """Where a file needs xacro: a call of a macro that could make links or joints; tags beside an expression.

    Every reader passes over tags of xacro, so a file in which they make nothing that moves is read as it stands.
    """
    macros = [x for x in root.iter() if xacro_tag(str(x.tag)) == "macro"]
    harmless = {x.get("name") for x in macros if all(y.tag in _OUTSIDE for y in x)}
    waiting, unexpanded = [root], False
    for element in waiting:
        tag = xacro_tag(str(element.tag))
        if tag and tag not in (*LEFTOVERS, *harmless):
            yield f"<xacro:{tag}>"
        if not tag and element.tag not in _DRAWN:
            waiting += element
            unexpanded = unexpanded or any(_EXPRESSION.search(text) for text in element.attrib.values())
    if unexpanded:
        yield from leftovers(root)


def _depth(root: ElementTree.Element) -> int:
    level, depth = [root], 0
    while level:
        level, depth = [child for element in level for child in element], depth + 1
    return depth


def _tree(content: bytes) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(content)
    except ElementTree.ParseError as fault:
        if fault.code != _UNBOUND:
            raise
    return ElementTree.fromstring(_with_declarations(content))


def _with_declarations(content: bytes) -> bytes:
    """The text with its undeclared prefixes declared in <robot>, on the same line, so that lines keep their numbers."""
    start = next((found for found in _ROOT.finditer(content) if found[1]), None)
    if start is None:
        return content
    known = {*_DECLARED.findall(start[1]), b"xml", b"xmlns"}
    unknown = sorted({*_PREFIX.findall(content)} - known)
    spaces = [b' xmlns:%s="%s"' % (x, DRAKE.encode() if x == b"drake" else b"undeclared:" + x) for x in unknown]
    at = start.start(1) + len(b"<robot")
    return content[:at] + b"".join(spaces) + content[at:]


_WIDTHS = {"xyz": 3, "rpy": 3}
_SCALARS = ("value", "ixx", "ixy", "ixz", "iyy", "iyz", "izz", "damping", "friction", "multiplier", "offset")
_LIMITS = ("lower", "upper", "effort", "velocity")
_NEEDED = {"link": ("inertial",), "joint": ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic")}
WORLD = ': write <link name="world"/>, which Drake adds unwritten'
"""Added to the message on a joint whose parent is not there."""
_CONTROL, _PRINTABLE = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]"), "letters that can be printed in a line"
_ROTOR = ("gear_ratio", "rotor_inertia")
_DRAKE = ("{https://drake.mit.edu/}", "{http://drake.mit.edu}", "{https://drake.mit.edu}", "{http://drake.mit.edu/}")


@dataclass(frozen=True, slots=True, eq=False)
class UrdfFile:
    """A parsed URDF: yourdfpy's links and joints, and the parts that yourdfpy does not read."""

    file: str
    name: str
    digest: str
    links: Mapping[str, Any]
    joints: Mapping[str, Any]
    rotors: Mapping[str, Rotor]
    placeholders: frozenset[str]
    """"joint limit" pairs that our own header lists as unknown."""
    gravity: tuple[float, ...] | None
    """Gravity [m/s^2] in our own header."""
    caveats: Caveats
    """What our own header says of its numbers."""
    leftovers: tuple[str, ...]
    """Tags of xacro that were passed over."""
    carried: CarriedXml
    """Shapes, materials and motors, which no computation uses."""


def parse_urdf(path: str | Path, xacro_args: Mapping[str, str] | None = None, trust_xacro: bool = False) -> UrdfFile:
    """Parse a URDF file, or what a `.xacro` file expands to with these arguments, trusted or not.

    Raises `FileAccessError`; `MissingPackageError` for a `.xacro` without xacro; `UrdfError`: what xacro refuses,
    broken XML, a missing name or attribute, a malformed number, a name used twice.
    """
    import yourdfpy

    file = Path(path).name
    if ends_in(file, ".xacro"):
        content = expand_xacro(path, xacro_args or {}, trust=trust_xacro).encode()
    else:
        content = read_bytes(path, "a readable .urdf file")
    checked = checked_xml(content, file)
    parsed = yourdfpy.URDF.load(BytesIO(checked.bare), build_scene_graph=False, load_meshes=False)
    return checked.urdf_file({x.name: x for x in parsed.robot.links}, {x.name: x for x in parsed.robot.joints})


@dataclass(frozen=True, slots=True, eq=False)
class CheckedXml:
    """A URDF whose parts can be parsed: all that is read of it but links and joints."""

    file: str
    root: ElementTree.Element
    """`<robot>` with the elements alone that a computation uses."""
    bare: bytes
    """Its text."""
    digest: str
    header: list[str]
    """Our own header; empty in another's file."""
    rotors: Mapping[str, Rotor]
    carried: CarriedXml
    leftovers: tuple[str, ...]

    def urdf_file(self, links: Mapping[str, Any], joints: Mapping[str, Any]) -> UrdfFile:
        """The file with its links and joints as yourdfpy parses them, or as objects that have the same fields."""
        starts = [x.removeprefix(GRAVITY) for x in self.header if x.startswith(GRAVITY)]
        gravity = [_float(v) for x in starts for v in x.split()]
        return UrdfFile(
            file=self.file, name=self.root.attrib["name"], digest=self.digest, links=links, joints=joints,
            rotors=self.rotors, placeholders=_named(self.header, UNKNOWN_LIMITS),
            gravity=tuple(gravity) if len(gravity) == 3 and np.isfinite(gravity).all() else None,
            caveats=own_caveats(self.header),
            leftovers=self.leftovers, carried=self.carried,
        )  # fmt: skip


def checked_xml(content: bytes, file: str) -> CheckedXml:
    """Check the text of a URDF; raises `UrdfError` as `parse_urdf`, for all that this refuses in a text."""
    root = parse_xml(content, file)
    _check(root, file)
    header = own_header(content.decode("utf-8", errors="replace"))
    rotors = _rotors(root, _named(header, REFLECTED), file)
    carried, passed = carried_xml(root), leftovers(root)
    _keep(root, ("link", "joint"))
    for element in root:
        _keep(element, _NEEDED[element.tag])
    bare = ElementTree.tostring(root, encoding="utf-8")
    _refuse_unreadable(bare, file)
    return CheckedXml(file, root, bare, hashlib.sha256(content).hexdigest(), header, rotors, carried, passed)


def _refuse_unreadable(bare: bytes, file: str) -> None:
    """Raise `UrdfError` for XML that yourdfpy's parser refuses: yourdfpy would guess at it, with another result."""
    from lxml import etree

    try:
        etree.fromstring(bare)
    except etree.XMLSyntaxError as fault:
        raise UrdfError(file, "XML", str(fault.msg), "a well-formed URDF") from None


def _named(lines: list[str], opening: str) -> frozenset[str]:
    """The names that a line of our header lists."""
    names = next((x.removeprefix(opening) for x in lines if x.startswith(opening)), "")
    return frozenset(names.split(", "))


def _keep(parent: ElementTree.Element, tags: tuple[str, ...]) -> None:
    for child in [c for c in parent if c.tag not in tags]:
        parent.remove(child)


def placeholder_name(joint: str, limit: str) -> str:
    """How our header names an unknown limit."""
    return comment(f"{joint} {limit}")


def own_caveats(header: list[str]) -> Caveats:
    """What our own header says that must be known before the numbers."""
    return caveats_of_words(unescape("; ".join(x.removeprefix(CAVEAT) for x in header if x.startswith(CAVEAT))))


def finite_numbers(text: str) -> list[float] | None:
    """The numbers of an attribute; None where one is no finite number."""
    numbers = [_float(word) for word in text.split()]
    return numbers if all(map(math.isfinite, numbers)) else None


def own_header(text: str) -> list[str]:
    """The lines of the first comment if this package wrote it."""
    comments = re.search(r"<!--(.*?)-->", text, re.DOTALL)
    lines = [line.strip() for line in comments[1].splitlines()] if comments else []
    return lines if any(line.startswith(WRITTEN_BY) for line in lines) else []


def _check(root: ElementTree.Element, file: str) -> None:
    """Faults that crash yourdfpy or that it accepts silently."""
    if root.tag != "robot":
        raise UrdfError(file, f"<{root.tag}>", "the outermost element", "<robot>")
    if not root.get("name"):
        raise UrdfError(file, "robot", "no name", "a name")
    if _CONTROL.search(root.attrib["name"]):
        raise UrdfError(file, "robot", f"the name {root.attrib['name']!r}", _PRINTABLE)
    links = _names(root, "link", file)
    _names(root, "joint", file)
    for link in root.findall("link"):
        for inertial in link.findall("inertial"):
            _numbers(list(inertial), f"link {link.get('name')!r}", file)
            _inertial(inertial, f"link {link.get('name')!r}", file)
    for joint in root.findall("joint"):
        _joint(joint, links, file)


def _joint(joint: ElementTree.Element, links: set[str], file: str) -> None:
    where = f"joint {joint.get('name')!r}"
    if not joint.get("type"):
        raise UrdfError(file, where, "no type", "revolute, continuous, prismatic, fixed")
    for tag in ("parent", "child"):
        end = joint.find(tag)
        name = "nothing" if end is None else end.get("link")
        if name not in links:
            allowed = "the name of a link of the file" + (WORLD if name == "world" else "")
            raise UrdfError(file, f"{where} <{tag}>", repr(name), allowed)
    _numbers(list(joint), where, file)


def _inertial(inertial: ElementTree.Element, where: str, file: str) -> None:
    """A complete inertial: yourdfpy reads a missing moment as 1 kg m^2."""
    for tag, names in (("mass", ("value",)), ("inertia", ("ixx", "iyy", "izz"))):
        element = inertial.find(tag)
        for name in names:
            if element is None or element.get(name) is None:
                raise UrdfError(file, f"{where} <{tag}> {name}", "missing", "a number")
    mass = inertial.find("mass")
    if mass is not None and float(mass.attrib["value"]) < 0.0:
        raise UrdfError(file, f"{where} <mass> value", repr(mass.attrib["value"]), "a mass of at least 0")


def _names(root: ElementTree.Element, tag: str, file: str) -> set[str]:
    seen: set[str] = set()
    for k, element in enumerate(root.findall(tag), start=1):
        name = element.get("name")
        if not name or name in seen:
            raise UrdfError(file, f"{tag} {name or k}", "used twice" if name else "no name", "a name of its own")
        if _CONTROL.search(name):
            raise UrdfError(file, f"{tag} {k}", f"the name {name!r}", _PRINTABLE)
        seen.add(name)
    return seen


def _numbers(elements: list[ElementTree.Element], where: str, file: str) -> None:
    """Every numeric attribute has its count of finite numbers; limits may be infinite."""
    for element in elements:
        for name, text in element.attrib.items():
            width = _WIDTHS.get(name, 1 if name in (*_SCALARS, *_LIMITS) else 0)
            if width == 0:
                continue
            numbers = [_float(word) for word in text.split()]
            bounded = [v for v in numbers if not (name in _LIMITS and math.isinf(v))]
            if len(numbers) != width or not all(math.isfinite(v) for v in bounded):
                allowed = "a finite number" if width == 1 else f"{width} finite numbers, separated by spaces"
                allowed += "; expand its ${...} and $(...) with xacro" if "$" in text else ""
                raise UrdfError(file, f"{where} <{element.tag}> {name}", repr(text), allowed)


def _float(word: str) -> float:
    try:
        return number_of(word)
    except ValueError:
        return math.nan


def _rotors(root: ElementTree.Element, reflected: frozenset[str], file: str) -> dict[str, Rotor]:
    """Rotors from Drake's tags; as in Drake, a missing gear ratio is 1 and a missing inertia 0."""
    out = {}
    for transmission in root.findall("transmission"):
        joint, actuator = transmission.find("joint"), transmission.find("actuator")
        if joint is None or actuator is None:
            continue
        name = joint.get("name", "")
        ratio, inertia = (_drake(actuator, tag, f"transmission of {name!r}", file) for tag in _ROTOR)
        if ratio is not None or inertia is not None:
            at_joint = comment(name) in reflected and ratio == 1.0
            out[name] = Rotor(1.0 if ratio is None else ratio, 0.0 if inertia is None else inertia, at_joint)
    return out


def _drake(actuator: ElementTree.Element, tag: str, where: str, file: str) -> float | None:
    elements = [x for space in _DRAKE for x in actuator.findall(space + tag)]
    if not elements:
        return None
    text = elements[0].get("value", "")
    value = _float(text)
    reverses = tag == "gear_ratio"  # below 0 the rotor turns the other way round
    if not (math.isfinite(value) and (reverses or value >= 0.0)):
        allowed = "a finite number" if reverses else "a finite number of at least 0"
        raise UrdfError(file, f"{where} <drake:{tag}> value", repr(text), allowed)
    return value
