"""An arm -> one HTML file without requests: its scene, sliders, and tables in which each number opens its source."""

import json
from html import escape
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.explorer.computing import robot_script, three_bundle
from lwr_dyn.explorer.number_tables import joint_columns, link_columns, table
from lwr_dyn.explorer.page_data import explorer_data, has_frames_of_its_own, motor_limits, position_text, slider_ranges
from lwr_dyn.explorer.readings import further_script
from lwr_dyn.files import write_file
from lwr_dyn.model.arm import Arm, Joint
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.installation import names_of_ends
from lwr_dyn.version import VERSION
from lwr_dyn.viewer.look import font_faces, look_css
from lwr_dyn.viewer.page_parts import fill_template, generator_line, meshcat_bundle, resource_text, script_safe

_HERE = "lwr_dyn.explorer"
_SCRIPTS = (
    ("lwr_dyn.viewer", "numbers.js"), ("lwr_dyn.viewer", "drawing.js"), ("lwr_dyn.viewer", "stage.js"),
    (_HERE, "kinematics.js"), (_HERE, "arm_parts.js"), (_HERE, "state.js"), (_HERE, "explorer.js"),
)  # fmt: skip
_COMPUTING = tuple(
    (_HERE, name)
    for name in (
        "flange_solver.js",
        "flange_drag.js",
        "link_drag.js",
        "arm_angle.js",
        "workspace.js",
        "torques.js",
        "pose_copy.js",
        "jacobian.js",
        "readings.js",
    )
)
_TURN = '<label><input id="turn" type="checkbox"> drag turns the flange</label>'
_LISTED = 400
"""Characters of a note that the page shows: a humanoid holds a hundred joints."""


def explorer_html(arm: Arm, q: ArrayLike | None = None, *, live: bool = False) -> str:
    """The page of an arm.

    Parameters
    ----------
    arm : Arm
    q : (n,) array_like, optional
        Positions at the start [rad or m]; zero if not given, moved into the limits where they exclude it.
    live : bool
        Whether the page connects to the meshcat server that served it.

    Raises
    ------
    ShapeError, OptionError
        q of another shape, or outside the limits.
    """
    robot, missing = ("", "") if live else robot_script(arm)
    data = explorer_data(arm, q) | {"live": live, "motors": motor_limits(arm)}
    scripts = _SCRIPTS if live else ((_HERE, "own_stage.js"), *_SCRIPTS, *(_COMPUTING if robot else ()))
    first, last = names_of_ends(arm.installation)
    parts = {
        "policy": _policy(live),
        "title": escape(arm.name if arm.layout is not None else arm.title),
        "name": escape(f"{arm.name}, reading {arm.reading}"),
        "style": "\n".join((font_faces() if live else "", look_css(), resource_text("explorer.css", _HERE))),
        "switches": _switches(arm),
        "turn": _TURN if robot else "",
        "by": _facts(arm),
        "notes": _notes(arm, missing),
        "sliders": "\n".join(_slider(arm, i, joint) for i, joint in enumerate(arm.joints())),
        "first": first,
        "last": last.capitalize(),
        "tables": _tables(arm),
        "footer": escape(generator_line() if live else f"lwr_dyn {VERSION}, drawn by three.js"),
        "data": script_safe(json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)),
        "drawing": meshcat_bundle() if live else three_bundle(),
        "robot": f"{robot}\n{further_script(arm)}" if robot else "",
        "scripts": "\n".join(resource_text(name, package) for package, name in scripts),
    }
    return fill_template(resource_text("explorer.html", _HERE), parts)


def write_explorer(path: str | Path, arm: Arm, q: ArrayLike | None = None) -> None:
    """Write `explorer_html(arm, q)` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, explorer_html(arm, q))


def _facts(arm: Arm) -> str:
    """Reading, joints, mass and gravity in one line."""
    known = [body.mass for body in arm.bodies() if body is not None and not body.unknown]
    mass = (
        f"moving links {sum(known):.6g} kg" if len(known) == arm.n else f"masses of {len(known)} of {arm.n} links known"
    )
    g = arm.chain.gravity
    origin = escape(arm.title) if arm.layout is not None else f"reading <b>{escape(arm.reading)}</b>"
    facts = [origin, f"{arm.n} joints", mass]
    facts.append(f"gravity {np.linalg.norm(g):.6g} m/s² along ({', '.join(f'{x:.3g}' for x in _unit(g))})")
    return " · ".join(facts)


def _unit(g: np.ndarray) -> np.ndarray:
    size = float(np.linalg.norm(g))
    return g / size + 0.0 if size else g


def _notes(arm: Arm, missing: str) -> str:
    lines = [missing] if missing else []
    lines += [note if len(note) <= _LISTED else f"{note[:_LISTED]} ..." for note in arm.notes]
    if arm.layout is not None and any("<mesh" in shape for shapes in arm.layout.shapes.values() for shape in shapes):
        lines.append("shapes are drawn along the joints; the meshes of the file are not drawn")
    elif not arm.drawing.cylinders:
        lines.append("shapes are drawn along the joints; no dynamics depends on them")
    text = "".join(f"<p>{escape(line)}</p>" for line in lines)
    return f'<div class="notes" tabindex="0" role="region" aria-label="Notes">{text}</div>' if lines else ""


def _switches(arm: Arm) -> str:
    rows = (
        ("flange", names_of_ends(arm.installation)[1] + " frame", True),
        ("frames", "joint frames", False),
        ("native", "source's DH frames", False),
        ("centres", "centres of mass", True),
        ("ellipsoids", "inertia ellipsoids", False),
        ("limits", "joint limits", False),
        ("gravity", "gravity", True),
        ("see-through", "see-through arm", False),
    )
    left_out = set() if has_frames_of_its_own(arm) else {"native"}
    if all(body is None for body in arm.bodies()):
        left_out |= {"centres", "ellipsoids"}
    if all(limits.lower is None or limits.upper is None for limits in arm.limits):
        left_out.add("limits")
    return "\n".join(
        f'<label><input id="{ident}" type="checkbox"{" checked" if on else ""}> {label}</label>'
        for ident, label, on in rows
        if ident not in left_out
    )


def _slider(arm: Arm, i: int, joint: Joint) -> str:
    low, up = slider_ranges(arm)[i]
    revolute = joint.kind is JointKind.REVOLUTE
    unit, scale = ("deg", 180.0 / np.pi) if revolute else ("m", 1.0)
    name = escape(joint.name)
    return (
        f'<div class="joint"><label for="slider_{i + 1}" title="{name}">{name}</label>'
        f'<input id="slider_{i + 1}" type="range" min="{low * scale!r}" max="{up * scale!r}" step="any" value="0">'
        f'<input id="value_{i + 1}" type="text" inputmode="decimal" aria-label="{name}, {unit}">'
        f'<span class="unit">{unit}</span>'
        f"<small>{_range_words(arm, joint)}</small></div>"
    )


def _range_words(arm: Arm, joint: Joint) -> str:
    """Both limits under a slider, or that one is unknown."""
    low, up = joint.limits.lower, joint.limits.upper
    if low is None and up is None:
        endless = arm.layout is not None and joint.name in arm.layout.unlimited()
        return f"<span>{'no limits: it turns without end' if endless else 'limits unknown'}</span>"
    ends = [position_text(joint.kind, x).removesuffix(" deg").removesuffix(" m") for x in (low, up)]
    return "".join(f"<span>{'limit unknown' if end == 'unknown' else end}</span>" for end in ends)


_CLICK = "Each number opens its source."
_LINKS = (
    f"{_CLICK} Centres of mass stand in the link's URDF frame, moments about the centre of mass. The ellipsoid is the "
    "solid of one density with the link's mass and inertia: I₁ = m (b² + c²) / 5 and so on (Landau and Lifshitz, "
    "Mechanics, § 32, problem 2); it is not the link's shape."
)


def _tables(arm: Arm) -> str:
    joints = [(joint.name, joint.kind.value) for joint in arm.joints()]
    links = [(link.link, "") for link in arm.chain.links]
    return "\n".join(
        (
            table("Joints", _CLICK, "joints", joints, joint_columns(arm)),
            table("Links", _LINKS, "links", links, link_columns(arm)),
        )
    )


def _policy(live: bool) -> str:
    connect = "connect-src 'self' ws:" if live else "connect-src 'none'"
    sources = "style-src 'unsafe-inline'; img-src data: blob:; font-src data:"
    return f"default-src 'none'; script-src 'unsafe-inline'; {sources}; {connect}"
