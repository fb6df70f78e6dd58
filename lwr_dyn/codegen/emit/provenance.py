"""What stands at the top of an emitted file: the arm and its source, what wrote it, what its numbers mean."""

import textwrap
from importlib.metadata import version

from lwr_dyn.arms.urdf.xml_text import estimates, numbers
from lwr_dyn.codegen.emit.emission import EmittedArm
from lwr_dyn.codegen.kernels.sincos import sincos
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.feasibility import unphysical_links
from lwr_dyn.model.installation import names_of_ends

WIDTH = 110
_FRICTION = {True: "the arm's own, added in inverse and subtracted in forward dynamics", False: "none"}


def provenance_lines(emitted: EmittedArm) -> list[str]:
    """Robot, reading, errata, hash of the data, versions, units and range: plain lines that fit into a comment."""
    return [line for text in _texts(emitted) for line in wrapped(text)]


def wrapped(text: str) -> list[str]:
    """Text as lines that may stand in a comment of C or JavaScript: ASCII, and nothing that ends the comment."""
    plain = text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")
    plain = plain.encode("ascii", "backslashreplace").decode().replace("\\", "/")
    return textwrap.wrap(plain, WIDTH, subsequent_indent="  ") or [""]


def _texts(emitted: EmittedArm) -> list[str]:
    arm, spec = emitted.arm, emitted.spec
    loaded = ", ".join(f"{name} {value}" for name, value in arm.loaded_with.items() if value)
    first, _ = names_of_ends(arm.installation)
    unphysical = unphysical_links(arm.chain) if arm.chain.bodies is not None else ()
    return [
        f"{arm.title}; robot {arm.name}, reading {arm.reading}",
        f"written by lwr-dyn {VERSION} with CasADi {version('casadi')}; do not edit: write it again",
        f"errata applied: {', '.join(arm.errata) or 'none'}",
        f"source file sha256: {arm.digest or 'none'}",
        *([f"loaded with: {loaded}"] if loaded else []),
        *([] if "gravity" in spec.inputs else [f"gravity in the {first} frame [m/s^2]: {numbers(arm.chain.gravity)}"]),
        *([] if "friction" in spec.inputs else [f"friction: {_FRICTION[spec.friction is not None]}"]),
        "rotors: as inertia at the joints (armature) where the source gives them",
        f"inertias that no body can have: {', '.join(unphysical) or 'none'}",
        *(f"estimated: {line}" for line in estimates(arm)),
        f"joints: {', '.join(_joints(emitted))}; frames: {_frames(arm)}",
        f"numbers: {emitted.dtype}, SI; {_range(emitted)}",
    ]


def _frames(arm: Arm) -> str:
    """Both frames of the functions; where a mount or tool makes it another one, that one by its name."""
    ends = zip(names_of_ends(arm.installation), ("base", "flange"), strict=True)
    return ", ".join(said if end == said else f"{end} (where a function says {said})" for end, said in ends)


def _joints(emitted: EmittedArm) -> list[str]:
    return [
        f"q[{i}] {link.joint} [{'rad' if link.kind is JointKind.REVOLUTE else 'm'}]"
        for i, link in enumerate(emitted.arm.chain.links)
    ]


def _range(emitted: EmittedArm) -> str:
    if emitted.kind == "libm":
        return "sine and cosine of the library"
    most = int(sincos(emitted.dtype).most_half_turns * 3.14159)
    return f"sine and cosine by polynomials of its own, for angles up to {most} rad; larger ones give wrong results"
