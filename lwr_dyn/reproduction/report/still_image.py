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
    """The still of a replay: its first run some way along its path, or its first still pose.

    The reference and what each run has drawn by then lie over it; behind the arm they are not drawn.
    """
    one = replay.runs[0] if replay.runs else None
    k = 0 if one is None else int(_MOMENT * (one.run.t.size - 1))
    arm, q = (replay.stills[0].arm, replay.stills[0].q) if one is None else (one.arm, one.run.q[k])
    solids = arm_solids(arm, np.asarray(q, dtype=np.float64))
    whole = [track for each in replay.runs for track in (each.reference_path, each.pose[:, :3, 3])]
    tracks = [points[:: max(1, len(points) // 800)] for points in whole]
    camera = camera_of(arm, solids, tracks)
    picture, near = ray_cast(solids, camera)
    words = f"{arm.title} at rest"
    if replay.runs:
        words = f"{arm.title} on its path; {len(replay.runs)} runs: {', '.join(each.label for each in replay.runs)}"
    image = element("img", src=png_address(picture), alt=words, width=COLUMNS, height=ROWS)
    lines = [_line(each.reference_path, "ref", camera, near) for each in replay.runs[:1]]
    lines += [_line(each.pose[: k + 1, :3, 3], run_ink(each), camera, near) for each in reversed(replay.runs)]
    return element("div", _svg(_floor(arm, camera)), image, _svg("".join(lines)), class_="still")


def _svg(paths: str) -> Html:
    return Html(f'<svg viewBox="0 0 {COLUMNS} {ROWS}" aria-hidden="true">{paths}</svg>')


def _line(points: Array, ink: str, camera: Camera, near: Array) -> str:
    seen = camera.seen(points[:: max(1, len(points) // 1500)])
    column, row = (np.clip(seen[:, i].astype(int), 0, most - 1) for i, most in ((0, COLUMNS), (1, ROWS)))
    hidden = seen[:, 2] < near[row, column]
    cuts = np.flatnonzero(np.diff(hidden)) + 1
    parts = zip(np.split(seen[:, :2], cuts), np.split(hidden, cuts), strict=True)
    pieces = (simplified(part, 0.4) for part, away in parts if len(part) > 1 and not away[0])
    path = "".join("M" + " ".join(f"{x:.1f},{y:.1f}" for x, y in piece) for piece in pieces)
    return f'<path class="l {ink}" d="{path}"/>'


def _floor(arm: Arm, camera: Camera) -> str:
    """The floor as a grid of half metres."""
    z, reach = floor_height(arm), 3.0
    ticks = np.arange(-reach, reach + 0.1, 0.5)
    ends = [[[t, -reach, z], [t, reach, z]] for t in ticks] + [[[-reach, t, z], [reach, t, z]] for t in ticks]
    lines = camera.seen(np.array(ends))[..., :2]
    path = "".join(f"M{a[0]:.0f},{a[1]:.0f}L{b[0]:.0f},{b[1]:.0f}" for a, b in lines)
    return f'<path class="floor" d="{path}"/>'


def run_table_html(runs: Sequence[ReplayedRun]) -> Html:
    """A line a run, and how many samples a second the page has of them."""
    heads = (("run", None, None), ("tip RMS", "mm", "num"), ("max", "mm", "num"), ("torque", "of limit", "num"))
    top = [
        element("th", name, " ", element("small", unit) if unit else None, scope="col", class_=kind)
        for name, unit, kind in heads
    ]
    title = f"{len(runs)} run{'s' if len(runs) > 1 else ''}, {short(max(float(one.run.t[-1]) for one in runs))} s"
    head = element("thead", element("tr", top))
    return element("table", element("caption", title), head, element("tbody", map(_row, runs)), class_="runs")


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
    cells = [element("td", number, class_="num mono") for number in numbers]
    return element("tr", element("th", swatch, one.caption, scope="row"), cells)


def torque_share(one: ReplayedRun) -> str:
    """The largest share of a known torque limit that a run takes, over time and joints."""
    efforts = [joint.limits.effort for joint in one.arm.joints()]
    peaks = np.abs(one.run.tau_applied).max(axis=0)
    shares = [float(peak) / limit for peak, limit in zip(peaks, efforts, strict=True) if limit]
    return f"{100 * max(shares):.2g} %" if shares else "unknown"
