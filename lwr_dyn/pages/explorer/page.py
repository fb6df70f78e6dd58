"""An arm -> one HTML file without requests: its scene, sliders, and tables in which each number opens its source.

The page computes with emitted functions, the code of `lwr-dyn kernels --language js`. The links' inertial parameters
and gravity are arguments, rotors are added by the page, so that arms with the same kinematics and limits, such as the
readings of one paper, need one set of functions. What the readings differ in, errata and numbers, stands in the page
too. Scripts lose their comments and the space that only people need; line ends stay, so no statement changes.
"""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.codegen.kernels.kernel import require_packages
from lwr_dyn.foundation.errors import LwrDynError, MissingDataError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.number_text import written_out
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import to_rpy
from lwr_dyn.pages.explorer import arm_html, page_data
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.look import font_faces, look_css


def slips_record(arms: Sequence[Arm]) -> dict[str, Any]:
    """Readings of one robot of the package as JSON values, in the order of the arms.

    `about` and `applied` (ids) of each reading; `errata`: id -> where, printed, read as, why, for those that not all
    readings apply; `numbers`: heading -> one text for each arm, for the numbers that are not the same.
    """
    paper = open_paper(arms[0].name)
    chosen = [paper.readings[arm.reading] for arm in arms]
    common = set.intersection(*(set(reading.errata) for reading in chosen))
    named = set.union(*(set(reading.errata) for reading in chosen)) - common
    return {
        "about": [reading.about for reading in chosen],
        "applied": [[name for name in reading.errata if name not in common] for reading in chosen],
        "errata": {e.id: [e.where, e.printed, e.read_as, e.why] for e in paper.errata if e.id in named},
        "numbers": differing_numbers(arms),
    }


def differing_numbers(arms: Sequence[Arm]) -> dict[str, list[str]]:
    """Heading of a number -> its text for each arm, for the numbers that are not the same; arms have the same joints.

    Numbers are those of the tables, the tensors of links in their URDF frames, and the frames of joints and flange,
    each in the link before it.
    """
    cells = [_numbers(arm) for arm in arms]
    rows = {key: [mine.get(key, "") for mine in cells] for key in cells[0]}
    return {key: texts for key, texts in rows.items() if len(set(texts)) > 1}


def _numbers(arm: Arm) -> dict[str, str]:
    columns = (*arm_html.joint_columns(arm), *arm_html.link_columns(arm))
    frames = {joint.name: joint.origin for joint in arm.joints()} | {"flange": arm.flange()}
    out = {f"{cell.heading}, {column.unit}": cell.text or "unknown" for column in columns for cell in column.cells}
    for link, body in zip(arm.chain.links, arm.bodies(), strict=True):
        if body is not None and not body.unknown:
            entries = [body.inertia_com[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
            out[f"{link.link}, xx, yy, zz, xy, xz, yz, kg m²"] = ", ".join(written_out(float(x)) for x in entries)
    for name, pose in frames.items():
        angles = np.degrees(to_rpy(pose.rotation))
        out[f"{name}, origin x, y, z, mm"] = ", ".join(written_out(1000.0 * float(x)) for x in pose.position)
        out[f"{name}, roll, pitch, yaw, deg"] = ", ".join(written_out(float(x)) for x in angles)
    return out


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
    sources: list[str] = []
    found: dict[bytes, tuple[int | None, str]] = {}
    keys = [_kinematics(arm) for arm in arms]
    for key, arm in zip(keys, arms, strict=True):
        if key not in found:
            source, why = functions_script(arm, f"armFunctions{len(sources)}")
            found[key] = (len(sources) if source else None, why)
            sources += [source] if source else []
    places, missing = zip(*(found[key] for key in keys), strict=True)
    names = ", ".join(f"armFunctions{k}" for k in range(len(sources)))
    script = "\n".join([*sources, f"var armSets = [{names}];"]) if sources else ""
    return FunctionSets(script, places, missing)


def functions_script(arm: Arm, name: str) -> tuple[str, str]:
    """The script that defines the functions of an arm, and what it lacks; an empty script where nothing is known."""
    try:
        require_packages()
        from lwr_dyn.codegen.emit.functions import Emitted, emitted_function
        from lwr_dyn.codegen.emit.javascript_file import javascript_source

        spec = _spec(arm)
    except LwrDynError as fault:
        return "", f"this page does not compute: {fault}"
    functions, missing = list[Emitted](), list[str]()
    if arm.n > MOST_JOINTS:
        missing = [f"torques are computed for arms of at most {MOST_JOINTS} joints; this one has {arm.n}"]
    for function in KINEMATICS if missing else FUNCTIONS:
        try:
            functions.append(emitted_function(spec, function, arm))
        except LwrDynError as fault:  # what would be allowed is another arm
            missing.append(str(fault).partition("; allowed: ")[0].replace("_", " "))
    return javascript_source(functions, name, is_compact=True), "; ".join(dict.fromkeys(missing))


def _spec(arm: Arm) -> Any:
    """With inertia and gravity as arguments; an arm without masses keeps its kinematics."""
    from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec, kernel_spec

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
    return replay_page.resource_text(BUNDLE, _HERE)


def _template(depth: int) -> str:
    """The pattern of a template, in whose `${}` braces and templates are nested so deep."""
    return rf"`(?:\\.|\$\{{{_inside(depth)}*\}}|\$(?!\{{)|[^`\\$])*`"


def _inside(depth: int) -> str:
    """The pattern of what stands between braces."""
    return rf"(?:[^`{{}}]|\{{{_inside(depth - 1)}*\}}|{_template(depth - 1)})" if depth else "[^`{}]"


_SPACE = re.compile(
    rf"""(?P<kept>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|{_template(3)}"""
    r"|(?<=[(,=:\[!&|?{};>\n])[ ]?/(?![/*])(?:\\.|\[(?:\\.|[^\]\\\n])*\]|[^/\\\[\n])+/[a-z]*)"  # a regular expression
    r"|\s*//[^\n]*|/\*.*?\*/|(?<![\w$])[ \t]+(?=[^ +\-/.])|[ \t]+(?![\w$+\-/.])|(?P<end>\n\s*)",
    re.DOTALL,
)


def without_space(script: str) -> str:
    """The script; strings, templates and regular expressions are copied.

    >>> print(without_space("a = `x ${ b + `y  z` } ` + 'c  d'; // why\\n  return a - -1;"))
    a=`x ${ b + `y  z` } ` +'c  d';
    return a - -1;
    """
    return _SPACE.sub(lambda found: found["kept"] or ("\n" if found["end"] else ""), script).strip()


SCHEMA = 2

_HERE = "lwr_dyn.pages.explorer"

_SCRIPTS = (
    "kinematics.js", "arm_parts.js", "state.js", "arm_functions.js", "arm_pieces.js", "panels.js", "written_numbers.js",
    "pose_card.js", "arm_chooser.js", "explorer.js",
)  # fmt: skip

_COMPUTING = (
    "numerics.js", "flange_solver.js", "flange_drag.js", "link_drag.js", "arm_angle.js", "section_reach.js",
    "section_boundary.js", "workspace.js", "torques.js", "payload.js", "matrices.js", "pose_copy.js", "jacobian.js",
    "readings.js", "loop_modes.js", "largest_inertias.js", "gains.js", "link_shares.js", "entry_words.js",
    "equation.js",
)  # fmt: skip

_BESIDE = ("numerics.js", "flange_solver.js", "side_by_side.js")

_TURN = '<label><input id="turn" type="checkbox"> drag turns the flange</label>'


def explorer_html(arm: Arm, q: ArrayLike | None = None, *, beside: Arm | None = None, live: bool = False) -> str:
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
        shown: Sequence[page_data.ShownArm] = (page_data.ShownArm(arm, arm.name, page_data.start_pose(arm, q), 0),)
        sets = FunctionSets("", (None,), ("",))
    else:
        shown = page_data.readings_shown(arm, q) if beside is None else page_data.beside_each_other(arm, beside, q)
        sets = function_sets([each.arm for each in shown])
    data: dict[str, Any] = {"schema": SCHEMA, "live": live, "made_by": replay_page.generator_line()}
    data |= page_data.shown_records(shown, sets.places, live)
    if beside is None and len(shown) > 1:
        data["differing"] = slips_record([each.arm for each in shown])
    further = (*(_BESIDE if beside is not None else ()), *(_COMPUTING if sets.script else ()))
    stage = [replay_page.resource_text(name) for name in replay_page.STAGE]
    own = [replay_page.resource_text(name, _HERE) for name in (*_SCRIPTS, *dict.fromkeys(further), "start.js")]
    css = replay_page.resource_text("explorer.css", _HERE)
    drawing = [] if live else [replay_page.resource_text("own_stage.js", _HERE)]
    templates = (
        arm_html.template(place, arm_html.changed_pieces(each.arm, sets.missing[place], arm, sets.missing[0]))
        for place, each in enumerate(shown[1:], start=1)
    )
    parts = {
        "policy": replay_page.replay_policy(live),
        "style": "\n".join((font_faces(), look_css(), css)),
        "turn": _TURN if sets.script else "",
        **arm_html.arm_pieces(arm, sets.missing[0]),
        "tables": arm_html.tables(arm),
        "templates": "\n".join(templates),
        "footer": escape(replay_page.generator_line() if live else f"lwr_dyn {VERSION}, drawn by three.js"),
        "data": replay_page.script_safe(json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)),
        "drawing": replay_page.meshcat_bundle() if live else three_bundle(),
        "robot": without_space(sets.script),
        "scripts": without_space("\n".join([*drawing, *stage, *own])),
    }
    return replay_page.fill_template(replay_page.resource_text("explorer.html", _HERE), parts)


def write_explorer(path: str | Path, arm: Arm, q: ArrayLike | None = None, beside: Arm | None = None) -> None:
    """Write `explorer_html` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, explorer_html(arm, q, beside=beside))
