"""A URDF as written: links, joints and their places, what a joint moves and how links hang together; its findings.

A finding says what is wrong, where, what shows it, how sure that is, and what to write instead; faults of reading are
findings too. Links that fixed joints weld together count as one mass; poses of the links are given for several
positions of the joints, and loops and broken trees are passed over.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypedDict
from xml.sax.saxutils import quoteattr

import numpy as np

from lwr_dyn.arms.urdf.elements import DRAWN_HERE, WRITTEN_BY
from lwr_dyn.arms.urdf.xacro_files import UNTRUSTED
from lwr_dyn.checks.urdf.elements import JointElement, LinkElement, joint_of, link_of
from lwr_dyn.checks.urdf.xml_tree import Place, XmlElement, XmlFaultError, expand_with_places, read_tree
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import UrdfError
from lwr_dyn.foundation.files import ends_in, read_bytes
from lwr_dyn.foundation.number_text import number_text
from lwr_dyn.model.spatial import turn_about

FindingSeverity = Literal["error", "warning", "note"]
"""An error is impossible for a body or a joint, a warning most likely wrong, a note worth a look."""
Sureness = Literal["certain", "likely", "possible"]
SEVERITIES: tuple[FindingSeverity, ...] = ("error", "warning", "note")


@dataclass(frozen=True, slots=True)
class UrdfFinding:
    """A suspected fault."""

    what: str  # one clause with the numbers: "iyy and izz look exchanged"
    why: str  # the figures that show it
    place: Place
    subject: str  # "link wrist_1", "joint elbow"; empty for the whole file
    instead: str = ""  # the text to write, or what to do; empty where the file does not tell
    sure: Sureness = "certain"
    cause: str = ""  # groups findings over rules and links: "masses in g"; empty: grouped by code
    severity: FindingSeverity | None = None  # None: that of its rule
    link: str = ""  # that is judged; on one that no joint moves the finding becomes a note
    code: str = ""  # of its rule, filled in when the rule has run

    @property
    def level(self) -> FindingSeverity:
        """Its severity, an error where none is set."""
        return self.severity or "error"

    @property
    def message(self) -> str:
        """What, why and what to write instead, in one line."""
        parts = [f"{self.subject}: {self.what}" if self.subject else self.what, self.why]
        parts += [f"write {self.instead}" if self.instead.startswith("<") else self.instead]
        return "; ".join(part for part in parts if part)

    def record(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "code": self.code, "severity": self.level, "file": self.place.file, "line": self.place.line,
            "column": self.place.column, "subject": self.subject, "what": self.what, "why": self.why,
            "sure": self.sure, "instead": self.instead, "cause": self.cause,
        }  # fmt: skip


class UrdfRecord(TypedDict):
    """`UrdfFinding.record`: a fault in a URDF, with its place."""

    code: Annotated[str, "The rule."]
    severity: Annotated[str, "error, warning or note."]
    file: str
    line: int
    column: int
    subject: Annotated[str, "The link, joint or element."]
    what: str
    why: str
    sure: Annotated[str, "certain or how likely."]
    instead: Annotated[str, "What to write; empty where nothing can be said."]
    cause: Annotated[str, "The slip of many findings, such as masses in g; empty for one alone."]


def vector_text(values: Array) -> str:
    """Numbers separated by spaces, as an attribute holds them."""
    return " ".join(number_text(float(v)) for v in values)


def tag_text(element: XmlElement, **changed: str) -> str:
    """The opening tag of an element with some attributes changed or added."""
    cells = {**element.attributes, **changed}
    return f"<{' '.join([element.tag, *(f'{name}={quoteattr(text)}' for name, text in cells.items())])}/>"


def inertia_text(tensor: Array) -> str:
    """The `<inertia>` element of a tensor.

    >>> inertia_text(np.diag([0.1, 0.2, 0.25]))
    '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.25"/>'
    """
    pairs = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    cells = [f'{name}="{number_text(float(np.asarray(tensor)[at]))}"' for name, at in pairs.items()]
    return f"<inertia {' '.join(cells)}/>"


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
    content: bytes
    """The text, of a xacro what it expands to."""

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
    def is_drawn_here(self) -> bool:
        """Whether this package wrote the file and drew its shapes: they say nothing about the bodies."""
        return WRITTEN_BY in self.header and DRAWN_HERE in self.header

    @property
    def has_mass(self) -> bool:
        """Whether any link of the file has mass; without, it describes kinematics only."""
        return any(link.inertial is not None and not link.inertial.is_zero for link in self.links)

    def carried_by(self, *names: str, through_moving: bool = True) -> Iterator[str]:
        """These links and all further out, or those fixed to them alone; each once."""
        seen, waiting = set[str](), list(names)
        while waiting:
            name = waiting.pop()
            if name not in seen:
                seen.add(name)
                waiting += [x.child for x in self.joints_from(name) if through_moving or not x.moves]
                yield name

    def mass_beyond(self, name: str, through_moving: bool) -> float:
        """Mass [kg] of the links further out than a link, or of those fixed to it alone; without its own."""
        links = [self.link(x) for x in self.carried_by(name, through_moving=through_moving) if x != name]
        return sum(max(x.inertial.mass or 0.0, 0.0) for x in links if x is not None and x.inertial is not None)


def read_document(
    path: str | Path, xacro_args: Mapping[str, str] | None = None, trust_xacro: bool = False
) -> UrdfDocument:
    """A URDF or xacro file as a document; text that is no URDF makes a document with a finding and no links.

    Raises `FileAccessError` for a file that cannot be read or has over 50 MB, `MissingPackageError` for a xacro file
    where xacro is not installed.
    """
    file, place = str(path), Path(path)
    if not ends_in(file, ".xacro"):
        return document_of(read_bytes(place, NEEDED, LARGEST_FILE), file)
    try:
        return document_of(expand_with_places(place, xacro_args or {}, trust_xacro).encode(), file, carried=True)
    except UrdfError as refused:
        what = f"xacro refuses the file: {refused.found}"
        instead = "--trust-xacro, if the file is yours: all its code runs" if refused.allowed == UNTRUSTED else ""
        instead = refused.allowed if refused.allowed.startswith("--xacro-arg") else instead
        fault = UrdfFinding(what, "it expands to no URDF", Place(file, 1, 1), "", instead, code="xacro-refused")
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
    by_name: dict[str, LinkElement] = {}
    for link in links:
        by_name.setdefault(link.name, link)
    driven = frozenset(joint.child for joint in into.values() if joint.moves)
    return UrdfDocument(
        file, Path(file), content.partition(b"<robot")[0].decode("utf-8", "replace"), root, links, joints,
        tuple(faults), _moved(out_of), driven, by_name, into, out_of, content,
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


POSES = 12
"""Positions of the joints: all at 0, then drawn from their limits."""
TURNING, SLIDING = ("revolute", "continuous"), ("prismatic",)
_WIDEST = 2.0 * np.pi


@lru_cache(maxsize=4)
def link_poses(document: UrdfDocument) -> dict[str, Array]:
    """Pose of each link in its root, (12, 4, 4), the first at q = 0; without links behind an unreadable origin."""
    draws = np.random.default_rng(1).uniform(size=(POSES, max(len(document.joints), 1)))
    column = {joint.name: k for k, joint in enumerate(document.joints)}
    poses = {name: np.tile(np.eye(4), (POSES, 1, 1)) for name in document.roots}
    waiting = list(poses)
    while waiting:
        parent = waiting.pop()
        for joint in document.joints_from(parent):
            origin = joint.origin.pose
            if joint.child in poses or origin is None:
                continue
            poses[joint.child] = poses[parent] @ origin @ motion(joint, draws[:, column[joint.name]])
            waiting.append(joint.child)
    return poses


def motion(joint: JointElement, draws: Array) -> Array:
    """What a joint adds at positions drawn from its limits, the first at 0: (k, 4, 4) from draws of 0 to 1, (k,)."""
    out = np.tile(np.eye(4), (len(draws), 1, 1))
    length = 0.0 if joint.axis is None else float(np.linalg.norm(joint.axis))
    if joint.axis is None or not length > 0.0:
        return out
    axis, q = joint.axis / length, _positions(joint, draws)
    if joint.type in SLIDING:
        out[:, :3, 3] = q[:, None] * axis
    elif joint.type in TURNING:
        out[:, :3, :3] = turn_about(axis, q)
    return out


def _positions(joint: JointElement, draws: Array) -> Array:
    low, high = joint.lower, joint.upper
    if joint.type == "continuous" or low is None or high is None or not low < high:
        low, high = (-np.pi, np.pi) if joint.type in TURNING else (0.0, 0.0)
    if joint.type in TURNING:
        low, high = max(low, -_WIDEST), min(high, _WIDEST)
    out = low + draws * (high - low)
    out[0] = 0.0
    return out
