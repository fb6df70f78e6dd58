"""What the page writes of one arm without a script: title, facts, notes, sliders, switches, tables.

Each piece stands in an element with an id. Another arm's pieces, as far as they differ, wait in a template.
"""

from html import escape

import numpy as np

from lwr_dyn.model.arm import Arm, Joint
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.installation import names_of_ends
from lwr_dyn.pages.explorer.number_tables import joint_columns, link_columns, table, table_cells
from lwr_dyn.pages.explorer.page_data import has_frames_of_its_own, position_text, slider_ranges

_LISTED = 400
"""Characters of a note that the page shows: a humanoid holds a hundred joints."""
_CLICK = "Each number opens its source."
_LINKS = (
    f"{_CLICK} Centres of mass stand in the link's URDF frame, moments about the centre of mass. The ellipsoid is the "
    "solid of one density with the link's mass and inertia: I₁ = m (b² + c²) / 5 and so on (Landau and Lifshitz, "
    "Mechanics, § 32, problem 2); it is not the link's shape."
)


def arm_pieces(arm: Arm, missing: str) -> dict[str, str]:
    """Id of an element -> what stands in it, but for the tables; `missing` says what the page does not compute."""
    first, last = names_of_ends(arm.installation)
    return {
        "arm-title": escape(arm.name if arm.layout is not None else arm.title),
        "arm-name": escape(f"{arm.name}, reading {arm.reading}"),
        "arm-by": _facts(arm),
        "arm-notes": _notes(arm, missing),
        "arm-ends": escape(f"{last.capitalize()} in {first}"),
        "arm-switches": _switches(arm),
        "sliders": "\n".join(_slider(arm, i, joint) for i, joint in enumerate(arm.joints())),
    }


def tables(arm: Arm) -> str:
    """The tables of joints and links."""
    return "\n".join(table(title, about, ident, names, columns) for title, about, ident, names, columns in _tables(arm))


def changed_pieces(arm: Arm, missing: str, first: Arm, first_missing: str) -> dict[str, str]:
    """The pieces and cells of an arm that differ from those of the page's first arm; other rows: whole tables."""
    mine, its = arm_pieces(arm, missing), arm_pieces(first, first_missing)
    for own, other in zip(_tables(arm), _tables(first), strict=True):
        _, _, ident, names, columns = own
        if names == other[3]:
            mine |= table_cells(ident, columns)
            its |= table_cells(ident, other[4])
        else:
            whole = table(*own)
            mine[ident] = whole[whole.index(">") + 1 : whole.rindex("</section>")]
    return {key: text for key, text in mine.items() if text != its.get(key)}


def template(place: int, pieces: dict[str, str]) -> str:
    """The pieces of arm `place`, as an element that shows nothing."""
    rows = "".join(f'<div data-for="{key}">{text}</div>' for key, text in pieces.items())
    return f'<template id="arm-{place}">{rows}</template>'


def _tables(arm: Arm) -> tuple[tuple[str, str, str, list[tuple[str, str]], tuple], ...]:  # type: ignore[type-arg]
    joints = [(joint.name, joint.kind.value) for joint in arm.joints()]
    links = [(link.link, "") for link in arm.chain.links]
    return (
        ("Joints", _CLICK, "joints", joints, joint_columns(arm)),
        ("Links", _LINKS, "links", links, link_columns(arm)),
    )


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
