"""The arm in 3D that replays the recordings, with the ellipsoids of its links before and after, for report.js."""

import json
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.possible_bodies import pseudo_inertias
from lwr_dyn.identification.report.charts import ShownRecording
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.ellipsoid import SolidEllipsoid, solid_ellipsoid
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs

PACKAGE = "lwr_dyn.identification.report"

_SCRIPTS = ("numbers.js", "drawing.js", "stage.js")

_PLACE = 1
"""Of the motion's colour in the palette: the result has the first."""

_SAMPLES = 3000
"""Of a recording in 3D at most: two minutes at 25 Hz."""


def stage_data(arm: Arm, recordings: Sequence[ShownRecording], before: Array, after: Array) -> dict[str, Any]:
    """The page's data.

    Parameters
    ----------
    arm : Arm
    recordings : sequence of ShownRecording
        At least one.
    before, after : (n, 10) array
        Inertial parameters of the links in the frames of the source, as in `INERTIAL`: the table's, the result's.
    """
    shown = [_shown(arm, one) for one in recordings]
    return {
        "scene": list(replay_page.arm_commands(shown[0], 0)),
        "runs": [replay_page.run_record(shown[0], _stride(shown[0]))],
        "others": [replay_page.run_record(one, _stride(one)) for one in shown[1:]],
        "native": [replay_page.column_major(link.after) for link in arm.chain.links],
        "before": _ellipsoids(before),
        "after": _ellipsoids(after),
        "made_by": replay_page.generator_line(),
    }


def _ellipsoids(parameters: Array) -> list[list[float] | None]:
    found = [link_ellipsoid(row) for row in parameters]
    return [None if one is None else replay_page.column_major(one.image) for one in found]


def _shown(arm: Arm, one: ShownRecording) -> ReplayedRun:
    nothing, zero = np.zeros_like(one.q), np.zeros_like(one.t)
    run = Run(one.t, one.q, nothing, one.q, nothing, nothing, nothing, nothing, zero, {})
    return replace(replayed_runs([run], arm, [one.source])[0], place=_PLACE)


def _stride(shown: ReplayedRun) -> int:
    steps, duration = shown.run.t.size - 1, float(np.ptp(shown.run.t))
    return max(1, round(steps / max(duration * replay_page.RATE / 2, 1.0)), -(-steps // _SAMPLES))


def stage_html(recordings: Sequence[ShownRecording]) -> str:
    """The place of the arm, its controls and switches."""
    names = [escape(one.source) for one in recordings]
    options = "".join(f'<option value="{k}">{name}</option>' for k, name in enumerate(names))
    choice = f'<label>recording <select id="recording">{options}</select></label>' if len(names) > 1 else ""
    switches = "".join(
        f'<label><input id="{ident}" type="checkbox" checked> {mark}{label}</label>'
        for ident, label, mark in (
            ("show-before", "table's ellipsoids", '<i class="sw ref"></i>'),
            ("show-after", "result's ellipsoids", '<i class="sw r1"></i>'),
            ("see-through", "see-through arm", ""),
            ("show-path", "path of the flange", ""),
        )
    )
    speeds = "".join(
        f'<option value="{x:g}"{" selected" if x == 1 else ""}>{x:g} &times;</option>' for x in (0.25, 0.5, 1, 2, 4)
    )
    return (
        '<div id="stage"></div><div class="controls">'
        '<button id="play" type="button" aria-label="play or pause">\u25b6</button>'
        '<input id="scrub" type="range" min="0" max="1" step="any" value="0" aria-label="time">'
        f'<output id="clock">0.00 s</output><label>speed <select id="speed">{speeds}</select></label>{choice}</div>'
        f'<div class="controls" role="group" aria-label="What is drawn">{switches}</div>'
    )


def stage_scripts(data: dict[str, Any]) -> str:
    """Script elements: the data, meshcat and the page's own code."""
    text = replay_page.script_safe(json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False))
    code = "\n".join([*map(replay_page.resource_text, _SCRIPTS), replay_page.resource_text("report.js", PACKAGE)])
    return (
        f'<script type="application/json" id="stage-data">{text}</script>\n'
        f"<script>\n{replay_page.meshcat_bundle()}\n</script>\n<script>\n{code}\n</script>\n"
    )


def central_moments(parameters: Array) -> tuple[float, Array, Array]:
    """Mass [kg], centre of mass (3,) [m] and S (3, 3) [kg m^2] about it, of ten parameters as in `INERTIAL`.

    >>> mass, com, moments = central_moments(np.array([2.0, 0.0, 0.0, 2.0, 3.0, 0.0, 0.0, 3.0, 0.0, 1.0]))
    >>> mass, com.tolist(), np.diag(moments).tolist()
    (2.0, [0.0, 0.0, 1.0], [0.5, 0.5, 0.5])
    """
    P = pseudo_inertias(parameters)
    mass, first = float(P[3, 3]), P[:3, 3]
    if mass == 0.0:
        return mass, np.zeros(3), P[:3, :3]
    return mass, first / mass, P[:3, :3] - np.outer(first, first) / mass


def link_ellipsoid(parameters: Array) -> SolidEllipsoid | None:
    """The ellipsoid of a link's ten parameters in its frame; None for what no body can be.

    Of a pseudo-inertia P = [[S, h], [h^T, m]], S = integral of r r^T dm, the second moments about the centre h / m are
    S - h h^T / m: a body is one that can be (P > 0) where its ellipsoid is real.

    >>> link_ellipsoid(np.array([5.0, 0.0, 0.0, 5.0, 7.0, 0.0, 0.0, 7.0, 0.0, 2.0])).semi_axes
    array([1., 1., 1.])
    """
    return solid_ellipsoid(*central_moments(parameters))
