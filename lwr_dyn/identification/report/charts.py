"""Figures of the report: torques against their prediction with what is left, friction over speed with the fit, and the
arm in 3D that replays the recordings, with the ellipsoids of its links before and after, for report.js.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.number_text import short
from lwr_dyn.identification.motion import validation
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.ellipsoid import SolidEllipsoid, solid_ellipsoid
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.model.inertial_parameters import pseudo_inertias
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.figure import Axis, axis_of, round_length
from lwr_dyn.pages.plotting.line_plane import band_path, dots_path, grid_path, line_path, plane_html, tick_marks
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs

SIGMAS = 3.0
"""Half-width of the band of noise behind what is left."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownRecording:
    """One recording: t (k,) [s] from its first row; measured and predicted torques (k, n) [N m or N]; q (k, n).

    `used` (k, n) are the equations that the fit saw.
    """

    source: str
    t: Array
    q: Array
    measured: Array
    predicted: Array
    used: NDArray[np.bool_]

    def __post_init__(self) -> None:
        freeze_arrays(self, "t", "q", "measured", "predicted")

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.t[-1] - self.t[0])


def torque_rows_html(one: ShownRecording, noise: Array, joints: tuple[str, ...], units: tuple[str, ...]) -> str:
    """The rows of a recording.

    Parameters
    ----------
    noise : (n,) array
        Standard deviation of the torques as the fit found it [N m or N].
    joints, units : tuple of str
        Name of each joint, unit of its torque.
    """
    across = axis_of(one.t, most=8, padding=0.0)
    rows = "".join(_row(one, j, float(noise[j]), joints[j], units[j], across) for j in range(len(joints)))
    seconds = tick_marks(across, "xt", "left", "s")
    foot = f'<div class="trow foot"><div></div><div class="area"><div class="yt"></div>{seconds}</div></div>'
    return f'<div class="torques" data-low="{across.low:.6g}" data-high="{across.high:.6g}">{rows}{foot}</div>'


def _row(one: ShownRecording, j: int, noise: float, joint: str, unit: str, across: Axis) -> str:
    measured, predicted, used = one.measured[:, j], one.predicted[:, j], one.used[:, j]
    left = np.where(used, measured - predicted, np.nan)
    up = axis_of(np.concatenate([measured, predicted]), most=4)
    wide = SIGMAS * noise if np.isfinite(noise) else 0.0
    reach = max(float(np.nanmax(np.abs(left), initial=0.0)), wide) or 1.0
    end = round_length(reach)
    below = Axis(-1.1 * reach, 1.1 * reach, (-end, 0.0, end))
    rms, peak = validation.rms(left), largest_of(left)
    label = (
        f"{joint}: torque at most {said(largest_of(measured), unit)}; measured less predicted has an RMS "
        f"of {said(rms, unit)} and reaches {said(peak, unit)}"
    )
    lines = [
        grid_path(None, up), line_path(one.t, measured, across, up, "ref"),
        line_path(one.t, predicted, across, up, "r1"),
    ]  # fmt: skip
    ends = np.array([across.low, across.high])
    rest = [
        band_path(ends, np.full(2, -wide), np.full(2, wide), across, below, "band"),
        grid_path(None, below), line_path(one.t, left, across, below, "left"),
    ]  # fmt: skip
    facts = (("RMS left", rms), ("noise", noise), ("largest", peak))
    listed = "".join(f"<li><span>{name}</span> <b>{said(value, unit)}</b></li>" for name, value in facts)
    two = (
        f'<div class="area">{tick_marks(up, "yt", "top")}{plane_html(label, lines, "torque")}'
        f"{tick_marks(below, 'yt', 'top')}{plane_html(f'{joint}: measured less predicted torque', rest, 'rest')}</div>"
    )
    who = f'<div class="who"><h3>{escape(joint)}</h3><ul class="figures">{listed}</ul></div>'
    return f'<div class="trow">{who}{two}</div>'


def said(value: float, unit: str) -> str:
    """A number with its unit; "none" where nothing is known.

    >>> said(0.25, "N m"), said(float("nan"), "N m")
    ('0.25 N m', 'none')
    """
    return f"{short(value)} {unit}" if np.isfinite(value) else "none"


def largest_of(values: Array) -> float:
    """The largest magnitude of the finite values; NaN of none."""
    finite = values[np.isfinite(values)]
    return float(np.abs(finite).max()) if finite.size else float("nan")


KEY = (
    '<ul class="key"><li><i class="sw ref"></i>measured</li><li><i class="sw r1"></i>predicted</li>'
    '<li><i class="sw left"></i>measured less predicted, where the fit used it</li>'
    '<li><i class="sw band"></i>3 sigma of the noise</li></ul>'
)
"""What the lines are."""

DOTS = 600
"""Of a map at most, evenly in time."""
CURVE = 120
"""Points of a curve a direction."""
_SHARE = (0.002, 0.998)
"""Of the dots that the axis holds: single rows may be far off."""


def friction_maps_html(
    speed: Array, torque: Array, fitted: Sequence[JointFriction | None], table: Sequence[JointFriction | None],
    joints: tuple[str, ...], units: tuple[tuple[str, str], ...],
) -> str:  # fmt: skip
    """A map a joint.

    Parameters
    ----------
    speed : (k, n) array
        [rad/s or m/s]
    torque : (k, n) array
        Measured torque less what bodies and rotors take, NaN where it is not used [N m or N].
    fitted, table : sequence of n JointFriction or None
        The result, and the friction that the arm had.
    units : tuple of (str, str)
        Of speed and torque of each joint.
    """
    figures = (_map(speed[:, j], torque[:, j], fitted[j], table[j], joints[j], units[j]) for j in range(len(joints)))
    return f'<div class="many maps">{"".join(figures)}</div>'


def _map(
    speed: Array, torque: Array, fitted: JointFriction | None, table: JointFriction | None, joint: str,
    units: tuple[str, str],
) -> str:  # fmt: skip
    rows = np.flatnonzero(np.isfinite(torque) & np.isfinite(speed))
    rows = rows[:: max(1, -(-rows.size // DOTS))]
    v, tau = speed[rows], torque[rows]
    fastest = float(np.abs(v).max(initial=0.0)) or 1.0
    curves = [(one, kind) for one, kind in ((table, "ref"), (fitted, "r1")) if one is not None]
    lines = [(_curve(one, fastest), kind) for one, kind in curves]
    seen = np.quantile(tau, _SHARE) if tau.size else np.array([-1.0, 1.0])
    up = axis_of(np.concatenate([seen, *(y[np.isfinite(y)] for (_, y), _ in lines)]), most=5)
    across = axis_of(np.array([-fastest, fastest]), most=5, padding=0.02)
    paths = [grid_path(None, up), f'<path class="zero" d="M{round(2000 * float(across.share(0.0)))},0V1000"/>']
    paths += [dots_path(v, tau, across, up, "dots")]
    paths += [line_path(x, y, across, up, kind) for (x, y), kind in lines]
    label = f"{joint}: friction torque over speed, {rows.size} dots; {friction_words(fitted, units[1])}"
    area = (
        f'<div class="area">{tick_marks(up, "yt", "top")}{plane_html(label, paths, "map")}'
        f"<div></div>{tick_marks(across, 'xt', 'left')}</div>"
    )
    head = f"<figcaption><h3>{escape(joint)} <small>{' over '.join(reversed(units))}</small></h3></figcaption>"
    words = escape(friction_words(fitted, units[1]))
    return f'<figure>{head}{area}<p class="note">{words}</p></figure>'


def _curve(one: JointFriction, fastest: float) -> tuple[Array, Array]:
    """Speeds and torques of both directions, with a gap at rest."""
    v = fastest * np.linspace(1e-6, 1.0, CURVE)
    x = np.concatenate([-v[::-1], [0.0], v])
    y = one.torque(x)
    y[CURVE] = np.nan
    return x, y


def friction_words(one: JointFriction | None, unit: str) -> str:
    """A joint's friction in a sentence.

    >>> from lwr_dyn.model.friction import symmetric
    >>> friction_words(symmetric(2.0, 0.5), "N m")
    'Coulomb 2 and 2 N m (up, down), viscous 0.5 and 0.5, offset 0 N m'
    """
    if one is None:
        return "values that no friction can have: a level below 0"
    up, down = one.positive, one.negative
    said = (
        f"Coulomb {short(up.coulomb)} and {short(down.coulomb)} {unit} (up, down), viscous {short(up.viscous)} and "
        f"{short(down.viscous)}, offset {short(one.offset)} {unit}"
    )
    return said + "".join(_stribeck(way, each, unit) for way, each in (("up", up), ("down", down)))


def _stribeck(way: str, one: Direction, unit: str) -> str:
    if one.static is None or one.stribeck_velocity is None or one.static <= one.coulomb:
        return ""
    return f"; Stribeck {way}: {short(one.static)} {unit} at rest, falling over {short(one.stribeck_velocity)}"


PACKAGE = "lwr_dyn.identification.report"
_PLACE = 1
"""Of the motion's colour in the palette: the result has the first."""
_SAMPLES = 3000
"""Of a recording in 3D at most: two minutes at 25 Hz."""


def stage_data(arm: Arm, recordings: Sequence[ShownRecording], before: Array, after: Array) -> dict[str, Any]:
    """The page's data.

    Parameters
    ----------
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
        "made_by": replay_page.generator_line(),
        **{
            name: [None if (one := link_ellipsoid(row)) is None else replay_page.column_major(one.image) for row in of]
            for name, of in (("before", before), ("after", after))
        },
    }


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
    code = "\n".join(
        [*map(replay_page.resource_text, replay_page.STAGE), replay_page.resource_text("report.js", PACKAGE)]
    )
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
