"""An arm -> one HTML file without requests: its scene, sliders, and tables in which each number opens its source."""

import json
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.model.arm import Arm
from lwr_dyn.pages.explorer.arm_html import arm_pieces, changed_pieces, tables, template
from lwr_dyn.pages.explorer.arms_shown import ShownArm, beside_each_other, readings_shown, shown_records
from lwr_dyn.pages.explorer.computing import FunctionSets, function_sets, three_bundle
from lwr_dyn.pages.explorer.page_data import start_pose
from lwr_dyn.pages.explorer.script_space import without_space
from lwr_dyn.pages.explorer.slips import slips_record
from lwr_dyn.pages.replay.look import font_faces, look_css
from lwr_dyn.pages.replay.page_parts import fill_template, generator_line, meshcat_bundle, resource_text, script_safe

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
