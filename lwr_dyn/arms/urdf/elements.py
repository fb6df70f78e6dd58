"""Elements of a URDF, each number with its source, and what all written files share: numbers, comments, header.

The header is read back by `lwr_dyn.arms.urdf.parse`.
"""

import copy
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree
from xml.sax.saxutils import escape

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.caveats import DYNAMICS
from lwr_dyn.model.chain import Body, Rotor, unphysical_links
from lwr_dyn.model.file_layout import fitting
from lwr_dyn.model.spatial import Pose, to_rpy

WRITTEN_BY = "written by lwr_dyn"
PARTLY_KNOWN = "inertia given in part, the unknown part written as 0: "
UNKNOWN_LIMITS = "unknown, written as stand-ins: "
ESTIMATED = "estimated, not measured: "
CAVEAT = "before its numbers: "
GRAVITY = "gravity in the base frame [m/s^2], which a URDF cannot hold: "
REFLECTED = "rotor inertia as the joint feels it; gear ratios are stand-ins of 1: "
"""Starts of header lines that are read back."""

ONE_SIDED = (
    "friction differs by direction, which a URDF and an MJCF cannot hold: none is written here; "
    'it is under "friction" in the sidecar'
)
"""The header line of an arm whose friction is left out."""
SIGMOID = (
    "friction is a sigmoid of the speed, which a URDF and an MJCF cannot hold: none is written here; "
    'it is under "friction" in the sidecar'
)
"""The same of an arm whose friction is smooth."""

INSTALLED = "link world: the base is mounted, gravity is in world; link tool: its mass is in the last moving link"
DRAWN_HERE, AS_IN_FILE = "drawn by lwr_dyn, not from the source", "as in the source, meshes by name"


def number(x: float) -> str:
    """repr without a negative zero.

    >>> number(-0.0), number(0.1)
    ('0.0', '0.1')
    """
    return repr(float(x) + 0.0)


def numbers(values: Array | Sequence[float]) -> str:
    """Numbers separated by spaces."""
    return " ".join(number(v) for v in values)


def comment(text: str) -> str:
    """Text that is valid inside an XML comment.

    >>> comment("a -- b")
    'a - - b'
    """
    return " ".join(escape(text).replace("--", "- -").split())


def header(arm: Arm) -> list[str]:
    """The comment at the top of a file: robot, reading, source, and which numbers are estimated, unknown or drawn."""
    unknown, bare = [f"{name} {x}" for name, x in unknown_limits(arm)], arm.uninstalled()
    lines = [
        f"{arm.title}; robot {arm.name}, reading {arm.reading}",
        *caveat_lines(arm),
        f"{WRITTEN_BY}; do not edit: change the data file and write again",
        f"errata applied: {arm.caveats.errata_words(arm.errata)}",
        f"source file sha256: {arm.digest or 'none'}",
        f"{GRAVITY}{numbers(arm.chain.gravity)}",
        *([] if arm.installation is None else [INSTALLED]),
        "inertials: about the centre of mass, axes of the link frame; every number's source is in the .provenance.json",
        f"inertias that no body can have: {', '.join(unphysical_links(arm.chain)) or 'none'}",
        *(f"{PARTLY_KNOWN}{x.link}" for x in arm.chain.links if x.body is not None and x.body.unknown),
        *(f"{ESTIMATED}{line}" for line in estimates(arm)),
        "rotor inertia: not part of the links' inertials; see the .srdf, the drake: tags and the MJCF .xml",
        f"{UNKNOWN_LIMITS}{', '.join(unknown) or 'nothing'}",
        f"visual and collision shapes: {DRAWN_HERE if fitting(bare.layout, bare.chain) is None else AS_IN_FILE}",
    ]
    reflected = [link.joint for link in arm.chain.links if link.rotor is not None and link.rotor.reflected]
    if reflected:
        lines.insert(-1, f"{REFLECTED}{', '.join(reflected)}")
    if arm.friction:
        lines.insert(-1, SIGMOID if any(x is not None and x.sigmoid is not None for x in arm.friction) else ONE_SIDED)
    return ["<!--", *(f"  {comment(x)}" for x in lines), "-->"]


def caveat_lines(arm: Arm) -> list[str]:
    """What must be known before the numbers of a rigid arm, in a line; none where nothing must."""
    words = arm.caveats.words(DYNAMICS)
    rotors = [f"{arm.coupled_rotors}; a URDF and an MJCF cannot hold it"] if arm.coupled_rotors else []
    return [*([f"{CAVEAT}{words}"] if words else []), *rotors]


def estimates(arm: Arm) -> list[str]:
    """Inertial values that were estimated, one line per method."""
    methods: dict[str, dict[str, list[str]]] = {}
    for quantity, cells in arm.sources.items():
        link, _, part = quantity.rpartition(".")
        for cell in cells:
            if cell.kind == "estimated" and link:
                methods.setdefault(cell.where, {}).setdefault(part, []).append(link)
    return [
        "; ".join(f"{part} of {', '.join(links)}" for part, links in parts.items()) + f" (how: {where})"
        for where, parts in methods.items()
    ]


def unknown_limits(arm: Arm) -> list[tuple[str, str]]:
    """(joint, limit) pairs that a URDF requires and the source does not give; an unlimited joint requires no range."""
    layout, names = fitting(arm.layout, arm.uninstalled().chain), ("lower", "upper", "velocity", "effort")
    unlimited = frozenset() if layout is None else layout.unlimited()
    out = []
    for joint in arm.joints():
        unknown = [x for x in names if getattr(joint.limits, x) is None]
        if joint.name in unlimited:
            unknown = unknown[2:] if len(unknown) == 3 else []
        out += [(joint.name, x) for x in unknown]
    return out


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

DRAWN, UNKNOWN, CHOICE, WEIGHTLESS, COPIED = "drawn", "unknown", "by choice", "weightless", "copied"
"""Words for numbers without a cell: a shape, a placeholder, a frame placed by choice, a frame without mass, a number
of a foreign file that no computation uses."""

_NUMBERS = re.compile(r"\s*[-+.\d][-+.\deE\s]*")


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

    def copied(self, depth: int, xml: str, path: str) -> None:
        """A foreign element as it is, indented; `path` is its own."""
        element = ElementTree.fromstring(xml)
        self._copied_numbers(element, path)
        ElementTree.indent(element, "  ", depth)
        self.line(depth, ElementTree.tostring(element, encoding="unicode").replace(" />", "/>"))

    def _copied_numbers(self, element: ElementTree.Element, path: str) -> None:
        for name, text in element.attrib.items():
            written = _floats(text)
            if written:
                self.attributes[f"{path}/@{name}"] = Attribute(written, word=COPIED)
        for child in element:
            self._copied_numbers(child, f"{path}/{child.tag}")


def _floats(text: str) -> tuple[float, ...]:
    """The numbers of an attribute; empty if it is not made of finite numbers."""
    if not _NUMBERS.fullmatch(text):
        return ()
    try:
        found = tuple(map(float, text.split()))
    except ValueError:
        return ()
    return found if all(map(math.isfinite, found)) else ()


def compact(element: ElementTree.Element) -> str:
    """An element as XML text without the white space between its parts."""
    bare = copy.deepcopy(element)
    for part in bare.iter():
        part.tail = None
        part.text = (part.text or "").strip() or None
    return ElementTree.tostring(bare, encoding="unicode")


def write_origin(
    out: SourcedText, path: str, pose: Pose, quantities: tuple[str, ...], word: str = CHOICE, depth: int = 2
) -> None:
    """Position and angles of a pose; `word` counts where no quantities are given."""
    word = "" if quantities else word
    xyz, rpy = (Attribute(tuple(map(float, v)), quantities, word) for v in (pose.position, to_rpy(pose.rotation)))
    out.numbers(depth, "origin", path, xyz=xyz, rpy=rpy)


def write_inertial(out: SourcedText, path: str, name: str, body: Body, frame: tuple[str, ...]) -> None:
    """The `<inertial>` of the arm's link `name`; `frame` lists what moves the paper's frame to the URDF's."""
    com = Attribute(tuple(map(float, body.com)), (f"{name}.com", *frame))
    mass = Attribute((float(body.mass),), (f"{name}.mass",))
    quantities = (f"{name}.inertia", *frame)
    _inertial(out, path, com, mass, {k: Attribute((v,), quantities) for k, v in _moments(body.inertia_com).items()})


def write_weightless(out: SourcedText, path: str) -> None:
    """An `<inertial>` of zeros."""
    zero, nothing = Attribute((0.0,), word=WEIGHTLESS), Body.massless()
    origin = Attribute((0.0, 0.0, 0.0), word=WEIGHTLESS)
    _inertial(out, path, origin, zero, dict.fromkeys(_moments(nothing.inertia_com), zero))


def _moments(tensor: Array) -> dict[str, float]:
    return {f"i{'xyz'[r]}{'xyz'[c]}": float(tensor[r, c]) for r in range(3) for c in range(r, 3)}


def _inertial(out: SourcedText, path: str, com: Attribute, mass: Attribute, moments: Mapping[str, Attribute]) -> None:
    out.line(2, "<inertial>")
    out.numbers(3, "origin", path, xyz=com, rpy=Attribute((0.0, 0.0, 0.0), word=CHOICE))
    out.numbers(3, "mass", path, value=mass)
    out.numbers(3, "inertia", path, **moments)
    out.line(2, "</inertial>")


def write_limits(out: SourcedText, path: str, joint: str, limits: JointLimits, unlimited: bool = False) -> None:
    """`<limit>` with placeholders, and `<dynamics>`; an unlimited joint has no range."""
    cells = {}
    for name, placeholder in PLACEHOLDERS.items():
        value = getattr(limits, name)
        unknown = Attribute((placeholder,), word=UNKNOWN)
        cells[name] = unknown if value is None else Attribute((value,), (f"{joint}.{name}",))
    if unlimited:
        cells = {name: cell for name, cell in cells.items() if name in ("effort", "velocity")}
    if not unlimited or any(cell.quantities for cell in cells.values()):
        out.numbers(2, "limit", path, **cells)
    friction = {"damping": ("viscous", limits.viscous), "friction": ("coulomb", limits.coulomb)}
    known = {tag: Attribute((v,), (f"{joint}.{name}",)) for tag, (name, v) in friction.items() if v is not None}
    if known:
        out.numbers(2, "dynamics", path, **known)


def write_rotor(out: SourcedText, path: str, joint: str, rotor: Rotor) -> None:
    """The rotor in the tags that Drake reads; `path` is the actuator's."""
    unknown, ratio = Attribute((rotor.gear_ratio,), word=UNKNOWN), (f"{joint}.gear_ratio",)
    value = unknown if rotor.reflected else Attribute((rotor.gear_ratio,), ratio)
    out.numbers(3, "drake:gear_ratio", path, value=value)
    out.numbers(3, "drake:rotor_inertia", path, value=Attribute((rotor.inertia,), (f"{joint}.rotor_inertia",)))
