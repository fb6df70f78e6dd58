"""A still of the 3D view before it starts, under the paths of the runs as SVG in their colours; the runs in numbers.

A row of the table says how far the tip is from its path, and the share of the torque limits that a run takes.
"""

from collections.abc import Sequence

import numpy as np

from lwr_dyn.arms.urdf.geometry import floor_height
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.number_text import short
from lwr_dyn.model.arm import Arm
from lwr_dyn.pages.markup import Html, element
from lwr_dyn.pages.plotting.drawn_panel import run_ink
from lwr_dyn.pages.replay.replay_page import RATE
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.pages.still import COLUMNS, ROWS, Camera, arm_solids, camera_of, png_address, ray_cast
from lwr_dyn.reproduction.report.content import Replay
from lwr_dyn.reproduction.report.figure_html import simplified

_MOMENT = 0.62
"""Share of the run's time at which the arm is shown."""


def still_html(replay: Replay) -> Html:
    """The still of a replay: its first run some way along its path, or its first still pose."""
    one = replay.runs[0] if replay.runs else None
    k = 0 if one is None else int(_MOMENT * (one.run.t.size - 1))
    arm, q = (replay.stills[0].arm, replay.stills[0].q) if one is None else (one.arm, one.run.q[k])
    solids = arm_solids(arm, np.asarray(q, dtype=np.float64))
    tracks = [points[:: max(1, len(points) // 800)] for points in _tracks(replay.runs)]
    camera = camera_of(arm, solids, tracks)
    picture, near = ray_cast(solids, camera)
    image = element("img", src=png_address(picture), alt=_description(arm, replay.runs), width=COLUMNS, height=ROWS)
    return element("div", _floor(arm, camera), image, _paths(replay.runs, camera, near, k), class_="still")


def _tracks(runs: Sequence[ReplayedRun]) -> list[Array]:
    return [track for one in runs for track in (one.reference_path, one.pose[:, :3, 3])]


def _paths(runs: Sequence[ReplayedRun], camera: Camera, near: Array, k: int) -> Html:
    """The reference, and what each run has drawn by then; behind the arm they are not drawn."""
    lines = [_line(one.reference_path, "ref", camera, near) for one in runs[:1]]
    lines += [_line(one.pose[: k + 1, :3, 3], run_ink(one), camera, near) for one in reversed(runs)]
    return Html(f'<svg viewBox="0 0 {COLUMNS} {ROWS}" aria-hidden="true">{"".join(lines)}</svg>')


def _line(points: Array, ink: str, camera: Camera, near: Array) -> str:
    seen = camera.seen(points[:: max(1, len(points) // 1500)])
    column, row = (np.clip(seen[:, i].astype(int), 0, most - 1) for i, most in ((0, COLUMNS), (1, ROWS)))
    hidden = seen[:, 2] < near[row, column]
    cuts = np.flatnonzero(np.diff(hidden)) + 1
    pieces = [
        part for part, away in zip(np.split(seen[:, :2], cuts), np.split(hidden, cuts), strict=True) if not away[0]
    ]
    path = "".join(
        "M" + " ".join(f"{x:.1f},{y:.1f}" for x, y in simplified(part, 0.4)) for part in pieces if len(part) > 1
    )
    return f'<path class="l {ink}" d="{path}"/>'


def _floor(arm: Arm, camera: Camera) -> Html:
    """The floor as a grid of half metres."""
    z, reach = floor_height(arm), 3.0
    ticks = np.arange(-reach, reach + 0.1, 0.5)
    ends = [[[t, -reach, z], [t, reach, z]] for t in ticks] + [[[-reach, t, z], [reach, t, z]] for t in ticks]
    lines = camera.seen(np.array(ends))[..., :2]
    path = "".join(f"M{a[0]:.0f},{a[1]:.0f}L{b[0]:.0f},{b[1]:.0f}" for a, b in lines)
    return Html(f'<svg viewBox="0 0 {COLUMNS} {ROWS}" aria-hidden="true"><path class="floor" d="{path}"/></svg>')


def _description(arm: Arm, runs: Sequence[ReplayedRun]) -> str:
    if not runs:
        return f"{arm.title} at rest"
    return f"{arm.title} on its path; {len(runs)} runs: {', '.join(one.label for one in runs)}"


def run_table_html(runs: Sequence[ReplayedRun]) -> Html:
    """A line a run, and how many samples a second the page has of them."""
    heads = (("run", None, None), ("tip RMS", "mm", "num"), ("max", "mm", "num"), ("torque", "of limit", "num"))
    top = [
        element("th", name, " ", element("small", unit) if unit else None, scope="col", class_=kind)
        for name, unit, kind in heads
    ]
    return element(
        "table",
        element("caption", _title(runs)),
        element("thead", element("tr", top)),
        element("tbody", map(_row, runs)),
        class_="runs",
    )


def _title(runs: Sequence[ReplayedRun]) -> str:
    last = max(float(one.run.t[-1]) for one in runs)
    return f"{len(runs)} run{'s' if len(runs) > 1 else ''}, {short(last)} s"


def rate_note(runs: Sequence[ReplayedRun]) -> str:
    """What the page has of the runs, in a sentence."""
    rates = [(one.run.t.size - 1) / float(one.run.t[-1] - one.run.t[0]) for one in runs if one.run.t.size > 1]
    fastest = max(rates, default=0.0)
    if fastest <= 1.01 * RATE:
        return "All samples of the runs are on this page."
    return (
        f"Replay and cursors have {RATE:g} samples a second; the run files have {short(fastest)}. "
        "Curves, peaks and this table are drawn from all of them."
    )


def _row(one: ReplayedRun) -> Html:
    error = 1e3 * one.tip_error
    swatch = element("i", class_=f"sw {run_ink(one)}")
    numbers = [short(float(np.sqrt(np.mean(error**2)))), short(float(error.max())), torque_share(one)]
    return element(
        "tr",
        element("th", swatch, one.caption, scope="row"),
        [element("td", number, class_="num mono") for number in numbers],
    )


def torque_share(one: ReplayedRun) -> str:
    """The largest share of a known torque limit that a run takes, over time and joints."""
    efforts = [joint.limits.effort for joint in one.arm.joints()]
    peaks = np.abs(one.run.tau_applied).max(axis=0)
    shares = [float(peak) / limit for peak, limit in zip(peaks, efforts, strict=True) if limit]
    return f"{100 * max(shares):.2g} %" if shares else "unknown"
