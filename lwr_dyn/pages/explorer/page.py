"""An arm -> one HTML file without requests: its scene, sliders, and tables in which each number opens its source.

The page computes with emitted functions, the code of `lwr-dyn kernels --language js`. The links' inertial parameters
and gravity are arguments, rotors are added by the page, so that arms with the same kinematics and limits, such as the
readings of one paper, need one set of functions. What the readings differ in, errata and numbers, stands in the page
too. Scripts lose their comments and the space that only people need; line ends stay, so no statement changes.
"""

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.codegen.kernels.kernel import require_packages
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.number_text import written_out
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import Pose, to_rpy
from lwr_dyn.pages.explorer.arm_html import (
    arm_pieces,
    changed_pieces,
    joint_columns,
    link_columns,
    tables,
    template,
)
from lwr_dyn.pages.explorer.page_data import ShownArm, beside_each_other, readings_shown, shown_records, start_pose
from lwr_dyn.pages.replay.look import font_faces, look_css
from lwr_dyn.pages.replay.replay_page import fill_template, generator_line, meshcat_bundle, resource_text, script_safe


def slips_record(arms: Sequence[Arm]) -> dict[str, Any]:
    """Readings of one robot of the package as JSON values, in the order of the arms.

    `about` and `applied` (ids) of each reading; `errata`: id -> where, printed, read as, why, for those that not all
    readings apply; `numbers`: heading -> one text for each arm, for the numbers that are not the same.
    """
    paper = open_paper(arms[0].name)
    chosen = [paper.readings[arm.reading] for arm in arms]
    common = set.intersection(*(set(reading.errata) for reading in chosen))
    applied = [[name for name in reading.errata if name not in common] for reading in chosen]
    named = {name for names in applied for name in names}
    errata = {e.id: [e.where, e.printed, e.read_as, e.why] for e in paper.errata if e.id in named}
    about = [reading.about for reading in chosen]
    return {"about": about, "applied": applied, "errata": errata, "numbers": differing_numbers(arms)}


def differing_numbers(arms: Sequence[Arm]) -> dict[str, list[str]]:
    """Heading of a number -> its text for each arm, for the numbers that are not the same; arms have the same joints.

    Numbers are those of the tables, the tensors of links in their URDF frames, and the frames of joints and flange,
    each in the link before it.
    """
    cells = [_numbers(arm) for arm in arms]
    rows = {key: [mine.get(key, "") for mine in cells] for key in cells[0]}
    return {key: texts for key, texts in rows.items() if len(set(texts)) > 1}


def _numbers(arm: Arm) -> dict[str, str]:
    columns = (*joint_columns(arm), *link_columns(arm))
    frames = {joint.name: joint.origin for joint in arm.joints()} | {"flange": arm.flange()}
    out = {f"{cell.heading}, {column.unit}": cell.text or "unknown" for column in columns for cell in column.cells}
    for link, body in zip(arm.chain.links, arm.bodies(), strict=True):
        if body is not None and not body.unknown:
            entries = [body.inertia_com[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
            out[f"{link.link}, xx, yy, zz, xy, xz, yz, kg m²"] = ", ".join(written_out(float(x)) for x in entries)
    for name, pose in frames.items():
        out |= _frame_texts(name, pose)
    return out


def _frame_texts(name: str, pose: Pose) -> dict[str, str]:
    angles = np.degrees(to_rpy(pose.rotation))
    return {
        f"{name}, origin x, y, z, mm": ", ".join(written_out(1000.0 * float(x)) for x in pose.position),
        f"{name}, roll, pitch, yaw, deg": ", ".join(written_out(float(x)) for x in angles),
    }


FUNCTIONS = (
    "inverse_dynamics", "mass_matrix", "gravity_vector", "flange_pose", "jacobian", "inverse_kinematics",
)  # fmt: skip

MOST_JOINTS = 8
"""Of an arm whose dynamics are written out: they grow with the square of the joints; longer ones have kinematics."""

KINEMATICS = ("flange_pose", "jacobian")

BUNDLE = "bundle/three.min.js"


@dataclass(frozen=True, slots=True)
class FunctionSets:
    """The functions of the arms of a page."""

    script: str
    """Defines `armSets`, a list of sets of functions; empty where no arm has one."""
    places: tuple[int | None, ...]
    """Of each arm's set in that list."""
    missing: tuple[str, ...]
    """Of each arm, what it lacks and why; empty where it has all."""


def function_sets(arms: Sequence[Arm]) -> FunctionSets:
    """The functions of some arms, each set once."""
    found: dict[bytes, int] = {}
    sources: list[str] = []
    places: list[int | None] = []
    missing: list[str] = []
    why: dict[bytes, str] = {}
    for arm in arms:
        key = _kinematics(arm)
        if key not in why:
            source, why[key] = functions_script(arm, f"armFunctions{len(sources)}")
            if source:
                found[key] = len(sources)
                sources.append(source)
        places.append(found.get(key))
        missing.append(why[key])
    names = ", ".join(f"armFunctions{k}" for k in range(len(sources)))
    script = "\n".join([*sources, f"var armSets = [{names}];"]) if sources else ""
    return FunctionSets(script, tuple(places), tuple(missing))


def functions_script(arm: Arm, name: str) -> tuple[str, str]:
    """The script that defines the functions of an arm, and what it lacks; an empty script where nothing is known."""
    try:
        require_packages()
        from lwr_dyn.codegen.emit.functions import Emitted, emitted_function
        from lwr_dyn.codegen.emit.javascript_file import javascript_source

        spec = _spec(arm)
    except LwrDynError as fault:
        return "", f"this page does not compute: {fault}"
    functions: list[Emitted] = []
    is_long = arm.n > MOST_JOINTS
    missing = (
        [f"torques are computed for arms of at most {MOST_JOINTS} joints; this one has {arm.n}"] if is_long else []
    )
    for function in KINEMATICS if is_long else FUNCTIONS:
        try:
            functions.append(emitted_function(spec, function, arm))
        except LwrDynError as fault:
            missing.append(str(fault))
    return javascript_source(functions, name, is_compact=True), "; ".join(dict.fromkeys(missing))


def _spec(arm: Arm) -> Any:
    """With inertia and gravity as arguments; an arm without masses keeps its kinematics."""
    from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec, kernel_spec
    from lwr_dyn.foundation.errors import MissingDataError

    inputs = ("inertia", "gravity")
    try:
        return kernel_spec(arm, inputs, rotors="none")
    except MissingDataError:
        return KernelSpec(arm.name, arm.chain, None, inputs, "none")


def _kinematics(arm: Arm) -> bytes:
    """All on which the functions of an arm depend: kinematics, limits, and whether its masses are known."""
    chain = arm.chain
    poses = [pose.matrix() for link in chain.links for pose in (link.before, link.after)]
    kinds = "".join(link.kind.value for link in chain.links)
    has_masses = all(link.body is not None and not link.body.unknown for link in chain.links)
    numbers = np.concatenate([np.ravel(x) for x in (*poses, chain.flange.matrix(), arm.lower, arm.upper)])
    return f"{kinds} {has_masses or arm.digest}".encode() + np.asarray(numbers, dtype=np.float64).tobytes()


def three_bundle() -> str:
    """three.js with its controls as a script that defines `lwrThree`; made by scripts/build_three.py."""
    return files("lwr_dyn.pages.explorer").joinpath(BUNDLE).read_text(encoding="utf-8")


_TOKEN = re.compile(
    r"""(?P<text>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')"""
    r"|(?P<comment>//[^\n]*|/\*.*?\*/)"
    r"|(?P<template>`)|(?P<open>\{)|(?P<close>\})"
    r"|(?P<space>[ \t]+)|(?P<word>[\w$]+)|(?P<other>.)",
    re.DOTALL,
)

_TEMPLATE = re.compile(r"(?:\\.|\$(?!\{)|[^`\\$])*(?:`|\$\{)", re.DOTALL)

_REGULAR_EXPRESSION = re.compile(r"/(?:\\.|\[(?:\\.|[^\]\\\n])*\]|[^/\\\[\n])+/[a-z]*")

_BEFORE_REGULAR_EXPRESSION = frozenset("(,=:[!&|?{};>\n")
"""What stands before a regular expression, and never before a division."""


def without_space(script: str) -> str:
    """The script; strings, templates and regular expressions are copied.

    >>> print(without_space("a = `x ${ b + `y  z` } ` + 'c  d'; // why\\nreturn a - -1;"))
    a=`x ${b+`y  z`} `+'c  d';
    return a- -1;
    """
    out: list[str] = []
    gap = ""
    for kind, text in _tokens(script):
        if kind == "space":
            gap = " "
        elif kind != "comment":
            if gap and out and _needed(out[-1][-1], text[0]):
                out.append(gap)
            out.append(text)
            gap = ""
    lines = (line.strip() for line in "".join(out).split("\n"))
    return "\n".join(line for line in lines if line)


def _needed(before: str, after: str) -> bool:
    """Whether two characters would read otherwise without the space between."""
    words = [c.isalnum() or c in "_$" for c in (before, after)]
    return all(words) or (before == after and before in "+-/") or (words[0] and after == ".")


def _tokens(script: str) -> Iterator[tuple[str, str]]:
    """Kind and text of each token; a template is a token up to its next `${`, and one from each `}` of such on."""
    place, depths, last = 0, [0], "\n"
    while place < len(script):
        kind, text = _next(script, place, last)
        if kind == "template" or (kind == "close" and depths[-1] == 0 and len(depths) > 1):
            found = _TEMPLATE.match(script, place + 1)
            assert found is not None  # our own scripts are whole
            kind, text = ("template", script[place : found.end()])
            depths = _depths(depths, script[place], text)
        elif kind in ("open", "close"):
            depths[-1] += 1 if kind == "open" else -1
        place += len(text)
        last = last if kind in ("space", "comment") else text[-1]
        yield kind, text


def _depths(depths: list[int], first: str, text: str) -> list[int]:
    """Open braces in each `${` that is open, after a piece of a template."""
    outer = depths if first == "`" else depths[:-1]
    return [*outer, 0] if text.endswith("${") else outer


def _next(script: str, place: int, last: str) -> tuple[str, str]:
    expression = _REGULAR_EXPRESSION.match(script, place) if last in _BEFORE_REGULAR_EXPRESSION else None
    if expression is not None and script[place : place + 2] not in ("//", "/*"):
        return "other", expression[0]
    found = _TOKEN.match(script, place)
    assert found is not None
    return str(found.lastgroup), found[0]


SCHEMA = 2

_HERE = "lwr_dyn.pages.explorer"

_SCRIPTS = (
    ("lwr_dyn.pages.replay", "numbers.js"), ("lwr_dyn.pages.replay", "drawing.js"),
    ("lwr_dyn.pages.replay", "stage.js"),
    (_HERE, "kinematics.js"), (_HERE, "arm_parts.js"), (_HERE, "state.js"), (_HERE, "arm_functions.js"),
    (_HERE, "arm_pieces.js"), (_HERE, "panels.js"), (_HERE, "written_numbers.js"), (_HERE, "pose_card.js"),
    (_HERE, "arm_chooser.js"), (_HERE, "explorer.js"),
)  # fmt: skip

_COMPUTING = tuple(
    (_HERE, name)
    for name in (
        "numerics.js", "flange_solver.js", "flange_drag.js", "link_drag.js", "arm_angle.js", "section_reach.js",
        "section_boundary.js", "workspace.js", "torques.js", "payload.js", "matrices.js", "pose_copy.js", "jacobian.js",
        "readings.js",
        "loop_modes.js", "largest_inertias.js", "gains.js", "link_shares.js", "entry_words.js", "equation.js",
    )
)  # fmt: skip

_BESIDE = ((_HERE, "numerics.js"), (_HERE, "flange_solver.js"), (_HERE, "side_by_side.js"))

_LAST = ((_HERE, "start.js"),)

_TURN = '<label><input id="turn" type="checkbox"> drag turns the flange</label>'


def explorer_html(
    arm: Arm, q: ArrayLike | None = None, *, beside: Arm | None = None, live: bool = False
) -> str:  # fmt: skip
    """The page of an arm with the other readings of its paper, or of two arms side by side.

    Parameters
    ----------
    arm : Arm
    q : (n,) array_like, optional
        Positions at the start [rad or m]; zero if not given, moved into the limits where they exclude it.
    beside : Arm, optional
        A second arm, of any number of joints.
    live : bool
        Whether the page connects to the meshcat server that served it; then it shows this arm alone.

    Raises
    ------
    ShapeError, OptionError
        q of another shape, or outside the limits.
    """
    if live:
        shown: Sequence[ShownArm] = (ShownArm(arm, arm.name, start_pose(arm, q), 0),)
        sets = FunctionSets("", (None,), ("",))
    else:
        shown = readings_shown(arm, q) if beside is None else beside_each_other(arm, beside, q)
        sets = function_sets([each.arm for each in shown])
    data = {"schema": SCHEMA, "live": live, "made_by": generator_line(), **shown_records(shown, sets.places, live)}
    if beside is None and len(shown) > 1:
        data["differing"] = slips_record([each.arm for each in shown])
    further = (*(_BESIDE if beside is not None else ()), *(_COMPUTING if sets.script else ()))
    scripts = [*_SCRIPTS, *dict.fromkeys(further), *_LAST]
    parts = {
        "policy": _policy(live),
        "style": "\n".join((font_faces() if live else "", look_css(), resource_text("explorer.css", _HERE))),
        "turn": _TURN if sets.script else "",
        **arm_pieces(arm, sets.missing[0]),
        "tables": tables(arm),
        "templates": _templates(shown, sets.missing),
        "footer": escape(generator_line() if live else f"lwr_dyn {VERSION}, drawn by three.js"),
        "data": _json(data),
        "drawing": meshcat_bundle() if live else three_bundle(),
        "robot": without_space(sets.script),
        "scripts": _script_text(scripts if live else [(_HERE, "own_stage.js"), *scripts]),
    }
    return fill_template(resource_text("explorer.html", _HERE), parts)


def write_explorer(path: str | Path, arm: Arm, q: ArrayLike | None = None, beside: Arm | None = None) -> None:
    """Write `explorer_html` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, explorer_html(arm, q, beside=beside))


def _json(data: Any) -> str:
    return script_safe(json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False))


def _script_text(scripts: Sequence[tuple[str, str]]) -> str:
    """Files as one script."""
    return without_space("\n".join(resource_text(name, package) for package, name in scripts))


def _templates(shown: Sequence[ShownArm], missing: Sequence[str]) -> str:
    """What the page writes of all arms but the first."""
    first = shown[0].arm
    return "\n".join(
        template(place, changed_pieces(each.arm, missing[place], first, missing[0]))
        for place, each in enumerate(shown)
        if place > 0
    )


def _policy(live: bool) -> str:
    connect = "connect-src 'self' ws:" if live else "connect-src 'none'"
    sources = "style-src 'unsafe-inline'; img-src data: blob:; font-src data:"
    return f"default-src 'none'; script-src 'unsafe-inline'; {sources}; {connect}"
