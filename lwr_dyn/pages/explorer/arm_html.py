"""What the page writes of one arm without a script: title, facts, notes, sliders, switches, tables.

Each piece stands in an element with an id. Another arm's pieces, as far as they differ, wait in a template. Each number
of the tables of joints and links opens its source: cell, page, kind of number, conversion.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from lwr_dyn.arms.urdf.model_files import UNSOURCED, quantity_sources
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.number_text import written_out
from lwr_dyn.model.arm import Arm, Joint, Source
from lwr_dyn.model.caveats import DYNAMICS
from lwr_dyn.model.chain import Body, JointKind, names_of_ends
from lwr_dyn.model.ellipsoid import inertia_ellipsoid, no_ellipsoid
from lwr_dyn.model.spatial import principal_moments
from lwr_dyn.pages.explorer.page_data import has_frames_of_its_own, position_text, slider_ranges

_MOST_CELLS = 12
"""Cells of the source that one number lists: a link of an assembly may come from a hundred."""


@dataclass(frozen=True, slots=True)
class NumberCell:
    """Numbers of one cell with their sources; `exact` are all their digits in SI; no text where a number is unknown."""

    heading: str
    text: str
    exact: str = ""
    sources: tuple[Source, ...] = ()
    how: str = ""
    """How it was computed from what the sources give."""


@dataclass(frozen=True, slots=True)
class NumberColumn:
    """A column of a table; its head shows the kinds of its numbers, so that estimates are seen as estimates."""

    title: str
    unit: str
    cells: tuple[NumberCell, ...]

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of its numbers, each once."""
        return tuple(dict.fromkeys(s.kind for cell in self.cells if cell.text for s in cell.sources))


def joint_columns(arm: Arm) -> tuple[NumberColumn, ...]:
    """Limits and rotor of each joint; a sliding joint has m, m/s, N, kg."""
    parts = (
        ("lower", "lower limit", "deg", "m"),
        ("upper", "upper limit", "deg", "m"),
        ("velocity", "speed", "deg/s", "m/s"),
        ("effort", "effort", "N m", "N"),
        ("armature", "rotor inertia at the joint", "kg m²", "kg"),
    )
    out = []
    for part, title, turning, sliding in parts:
        cells = []
        for joint in arm.joints():
            value = joint.armature if part == "armature" else getattr(joint.limits, part)
            revolute = joint.kind is JointKind.REVOLUTE
            si = sliding if not revolute else turning.replace("deg", "rad")
            mine = None if value is None else np.degrees(value) if revolute and "deg" in turning else value
            text = "" if mine is None else written_out(mine) + ("" if revolute else f" {sliding}")
            sources = quantity_sources(arm, f"{joint.name}.{part}")
            cells.append(NumberCell(f"{joint.name}, {title}", text, f"{value!r} {si}", sources))
        out.append(NumberColumn(title, turning, tuple(cells)))
    return tuple(out)


def link_columns(arm: Arm) -> tuple[NumberColumn, ...]:
    """Mass, centre of mass, principal moments and the ellipsoid of each link, in its URDF frame."""
    rows = [_link_cells(arm, link.link, body) for link, body in zip(arm.chain.links, arm.bodies(), strict=True)]
    titles = ("mass", "centre of mass x, y, z", "principal moments", "semi-axes of the ellipsoid")
    return tuple(map(NumberColumn, titles, ("kg", "mm", "kg m²", "mm"), zip(*rows, strict=True)))


def _link_cells(arm: Arm, link: str, body: Body | None) -> tuple[NumberCell, ...]:
    """The cells of a link, in the order of the columns."""
    names = [f"{link}, {what}" for what in ("mass", "centre of mass", "principal moments", "ellipsoid")]
    if body is None or body.unknown:
        return tuple(NumberCell(name, "") for name in names)
    mass, com, inertia = (quantity_sources(arm, f"{link}.{part}") for part in ("mass", "com", "inertia"))
    moments, shape = principal_moments(body.inertia_com), inertia_ellipsoid(body)
    tensor = "eigenvalues of the inertia about the centre of mass"
    root = "a = sqrt(5 (I2 + I3 - I1) / (2 m)), and so on"
    cells = {source.cell: source for source in (*inertia, *mass)}  # the mass is a source of a shifted tensor too
    return (
        _cell(names[0], np.array([body.mass]), "kg", mass),
        _cell(names[1], body.com, "m", com, scale=1000.0),
        _cell(names[2], moments, "kg m^2", inertia, tensor),
        NumberCell(names[3], "", how=no_ellipsoid(body))
        if shape is None
        else _cell(names[3], shape.semi_axes, "m", tuple(cells.values()), root, 1000.0),
    )


def _cell(
    heading: str, values: Array, unit: str, sources: tuple[Source, ...], how: str = "", scale: float = 1.0
) -> NumberCell:
    text = ", ".join(written_out(scale * float(x)) for x in values)
    return NumberCell(heading, text, f"{', '.join(repr(float(x)) for x in values)} {unit}", sources, how)


def table(
    caption: str, about: str, ident: str, names: Sequence[tuple[str, str]], columns: Sequence[NumberColumn]
) -> str:
    """A table with the popovers of its numbers, as a section of the page; `names` are (name, kind) of the rows."""
    pieces, n = list(table_cells(ident, columns).items()), len(columns)
    heads = "".join(f'<th scope="col" class="num" id="{key}">{piece}</th>' for key, piece in pieces[:n])
    rows = []
    for i, (name, kind) in enumerate(names, start=1):
        cells = "".join(f"<td class=num id={key}>{piece}</td>" for key, piece in pieces[i * n : (i + 1) * n])
        small = f" <small>{escape(kind)}</small>" if kind else ""
        rows.append(f'<tr><th scope="row">{escape(name)}{small}</th>{cells}</tr>')
    title, label = escape(caption), f'aria-label="{escape(caption)}, scrolls sideways"'
    return (
        f'<section class="card tab" id="{ident}" aria-labelledby="{ident}-title"><h2 id="{ident}-title">{title}</h2>'
        f'<p>{about}</p><div class="scroll" tabindex="0" role="region" {label}>'
        f'<table><thead><tr><th scope="col">name</th>{heads}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
        "</section>"
    )


def table_cells(ident: str, columns: Sequence[NumberColumn]) -> dict[str, str]:
    """Id of an element -> what stands in it: heads, then the cells row by row, each number with its popover."""
    pieces = {}
    for k, column in enumerate(columns, start=1):
        kinds = escape(" · ".join([column.unit, *column.kinds]))
        pieces[f"{ident}_h{k}"] = f"{escape(column.title)}<br><small>{kinds}</small>"
    cells = (cell for row in zip(*(column.cells for column in columns), strict=True) for cell in row)
    return pieces | {f"{ident}_{k}_c": _number(cell, f"{ident}_{k}") for k, cell in enumerate(cells, start=1)}


def _number(cell: NumberCell, key: str) -> str:
    """A button with the popover that it opens; of an unknown number why it is unknown."""
    if not cell.text:
        return f'<span class="soft">{escape(cell.how or "unknown")}</span>'
    button = f"<button class=n type=button popovertarget={key}>{escape(cell.text)}</button>"
    first = _list([("value", cell.exact), *([("computed", cell.how)] if cell.how else [])])
    listed = "".join(_list(_source_rows(source)) for source in cell.sources[:_MOST_CELLS])
    more = len(cell.sources) - _MOST_CELLS
    if not cell.sources:
        listed = _list([("source", UNSOURCED)])
    elif more > 0:
        listed += _list([("more", f"{more} further cells, in the .provenance.json of lwr-dyn urdf")])
    return f"{button}<div popover id={key} class=pop><h3>{escape(cell.heading)}</h3>{first}{listed}</div>"


def _source_rows(source: Source) -> Iterable[tuple[str, str]]:
    value = _value(source.value)
    yield "source", source.where
    yield "cell", source.cell
    yield "kind", source.kind
    yield "there", f"{value} {source.unit}" if value != "as in the file" else value
    yield "conversion", source.conversion
    if source.errata:
        yield "erratum", ", ".join(source.errata)


def _value(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_value(each)}" for key, each in value.items())
    return "; ".join(map(_value, value)) if isinstance(value, tuple | list) else str(value)


def _list(rows: Iterable[tuple[str, str]]) -> str:
    cells = (f"<dt>{escape(a)}<dd>{escape(b)}" for a, b in rows)  # HTML ends them
    return f"<dl>{''.join(cells)}</dl>"


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
    return "\n".join(table(*each) for each in _tables(arm))


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
    """What must be known before its numbers, reading, joints, mass and gravity in one line."""
    known = [body.mass for body in arm.bodies() if body is not None and not body.unknown]
    mass = f"masses of {len(known)} of {arm.n} links known"
    if len(known) == arm.n:
        mass = f"moving links {sum(known):.6g} kg"
    g, size = arm.chain.gravity, float(np.linalg.norm(arm.chain.gravity))
    along = ", ".join(f"{x:.3g}" for x in (g / size + 0.0 if size else g))
    origin = escape(arm.title) if arm.layout is not None else f"reading <b>{escape(arm.reading)}</b>"
    facts = [origin, f"{arm.n} joints", mass, f"gravity {size:.6g} m/s² along ({along})"]
    words = arm.caveats.words(DYNAMICS)
    return " · ".join([f'<b class="caveat">{escape(words)}</b>', *facts] if words else facts)


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
