"""Text that all written files share: numbers, comments, and the header that `lwr_dyn.arms.urdf.parse` reads back."""

from collections.abc import Sequence
from xml.sax.saxutils import escape

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.feasibility import unphysical_links
from lwr_dyn.model.file_layout import fitting

WRITTEN_BY = "written by lwr_dyn"
PARTLY_KNOWN = "inertia given in part, the unknown part written as 0: "
UNKNOWN_LIMITS = "unknown, written as stand-ins: "
ESTIMATED = "estimated, not measured: "
GRAVITY = "gravity in the base frame [m/s^2], which a URDF cannot hold: "
REFLECTED = "rotor inertia as the joint feels it; gear ratios are stand-ins of 1: "
"""Starts of header lines that are read back."""
ONE_SIDED = (
    "friction differs by direction, which a URDF and an MJCF cannot hold: none is written here; "
    'it is under "friction" in the sidecar'
)
"""The header line of an arm whose friction is left out."""
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
        f"{WRITTEN_BY}; do not edit: change the data file and write again",
        f"errata applied: {', '.join(arm.errata) or 'none'}",
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
        lines.insert(-1, ONE_SIDED)
    return ["<!--", *(f"  {comment(x)}" for x in lines), "-->"]


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
