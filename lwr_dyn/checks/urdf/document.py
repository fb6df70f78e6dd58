"""A URDF as written: links, joints and their places, which links a joint moves; faults of reading are findings."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from lwr_dyn.arms.urdf.xml_text import DRAWN_HERE, WRITTEN_BY
from lwr_dyn.checks.urdf.elements import JointElement, LinkElement, joint_of, link_of
from lwr_dyn.checks.urdf.finding import UrdfFinding
from lwr_dyn.checks.urdf.xacro_places import expand_with_places
from lwr_dyn.checks.urdf.xml_tree import Place, XmlElement, XmlFaultError, read_tree
from lwr_dyn.foundation.errors import UrdfError
from lwr_dyn.foundation.files import ends_in, read_bytes

LARGEST_FILE = 50_000_000
"""Bytes of a file."""
NEEDED = "a readable .urdf or .xacro file"


@dataclass(frozen=True, slots=True, eq=False)
class UrdfDocument:
    """The contents of a file. It is compared and hashed by identity, so results for it can be cached."""

    file: str
    """Its name as given."""
    path: Path
    header: str
    """The text before `<robot>`."""
    digest: str
    """SHA-256 of the text; of a xacro, of what it expands to."""
    root: XmlElement | None
    """None where the file is no XML."""
    links: tuple[LinkElement, ...]
    joints: tuple[JointElement, ...]
    faults: tuple[UrdfFinding, ...]
    """Faults of reading."""
    moved: frozenset[str]
    """Links with a moving joint between the root and them."""
    driven: frozenset[str]
    """Links that a moving joint carries itself; the other moved ones are fixed to these."""
    by_name: Mapping[str, LinkElement]
    into: Mapping[str, JointElement]
    """Child link -> the first joint that carries it."""
    out_of: Mapping[str, tuple[JointElement, ...]]
    """Parent link -> the joints that start there."""

    def link(self, name: str) -> LinkElement | None:
        """The first link of this name."""
        return self.by_name.get(name)

    def joint_into(self, name: str) -> JointElement | None:
        """The joint that carries a link."""
        return self.into.get(name)

    def joints_from(self, name: str) -> tuple[JointElement, ...]:
        """The joints that start at a link."""
        return self.out_of.get(name, ())

    @property
    def roots(self) -> tuple[str, ...]:
        """Links that no joint carries."""
        return tuple(name for name in self.by_name if name not in self.into)

    @property
    def root_link(self) -> str | None:
        """The one root of the tree; None where there is not exactly one."""
        return self.roots[0] if len(self.roots) == 1 else None

    @property
    def is_drawn_here(self) -> bool:
        """Whether this package wrote the file and drew its shapes: they say nothing about the bodies."""
        return WRITTEN_BY in self.header and DRAWN_HERE in self.header

    @property
    def moved_links(self) -> tuple[LinkElement, ...]:
        """The links that move, in the file's order."""
        return tuple(link for link in self.links if link.name in self.moved)


def read_document(path: str | Path, xacro_args: Mapping[str, str] | None = None) -> UrdfDocument:
    """A URDF or xacro file as a document; text that is no URDF makes a document with a finding and no links.

    Raises
    ------
    FileAccessError
        The file cannot be read, or is larger than 50 MB.
    MissingPackageError
        A xacro file, and xacro is not installed.
    """
    file, place = str(path), Path(path)
    if not ends_in(file, ".xacro"):
        return document_of(read_bytes(place, NEEDED, LARGEST_FILE), file)
    try:
        return document_of(expand_with_places(place, xacro_args or {}).encode(), file, carried=True)
    except UrdfError as refused:
        what = f"xacro refuses the file: {refused.found}"
        fault = UrdfFinding(what, "it expands to no URDF", Place(file, 1, 1), "", code="xacro-refused")
        return replace(document_of("<robot/>", file), root=None, faults=(fault,))


def document_of(content: bytes | str, file: str, carried: bool = False) -> UrdfDocument:
    """A URDF text as a document; `carried` as in `read_tree`."""
    content = content.encode() if isinstance(content, str) else content
    root, faults = None, []
    try:
        root = read_tree(content, file, carried)
    except XmlFaultError as fault:
        faults = [_not_xml(content, fault)]
    elements = [] if root is None or root.tag != "robot" else root.children
    links = tuple(link_of(x) for x in elements if x.tag == "link")
    joints = tuple(joint_of(x) for x in elements if x.tag == "joint")
    into: dict[str, JointElement] = {}
    starting: dict[str, list[JointElement]] = {}
    for joint in joints:
        into.setdefault(joint.child, joint)
        starting.setdefault(joint.parent, []).append(joint)
    out_of = {name: tuple(some) for name, some in starting.items()}
    by_name = {link.name: link for link in reversed(links)}
    by_name = {link.name: by_name[link.name] for link in links}
    return UrdfDocument(
        file, Path(file), content.partition(b"<robot")[0].decode("utf-8", "replace"),
        hashlib.sha256(content).hexdigest(), root, links, joints, tuple(faults),
        _moved(out_of), frozenset(j.child for j in into.values() if j.moves), by_name, into, out_of,
    )  # fmt: skip


def _moved(out_of: Mapping[str, tuple[JointElement, ...]]) -> frozenset[str]:
    """Links beyond a moving joint; of a loop, all that hangs on one of its moving joints."""
    moved = {joint.child for joints in out_of.values() for joint in joints if joint.moves}
    waiting = list(moved)
    while waiting:
        new = {joint.child for joint in out_of.get(waiting.pop(), ())} - moved
        moved |= new
        waiting += new
    return frozenset(moved)


def _not_xml(content: bytes, fault: XmlFaultError) -> UrdfFinding:
    """The finding of a text that is no XML, or no UTF-8."""
    why = "no program can read the file"
    try:
        content.decode("utf-8")
    except UnicodeDecodeError as bad:
        before = content[: bad.start]
        line = before.count(b"\n") + 1
        column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8")) + 1
        what = f"byte 0x{content[bad.start]:02x} is not UTF-8"
        place = Place(fault.place.file, line, column)
        return UrdfFinding(what, why, place, "", "save the file as UTF-8", code="xml-encoding")
    return UrdfFinding(f"not XML: {fault.said}", why, fault.place, "", code="xml-syntax")
