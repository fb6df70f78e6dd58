"""Runs -> one HTML file that replays them in 3D: meshcat's viewer, the runs and our player in one page.

The page makes no request: everything is inside it, and its content security policy forbids loading anything else.
"""

import json
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.arms.urdf.geometry import floor_height, stand_foot
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.installation import ends_of
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay import scene
from lwr_dyn.pages.replay.look import font_faces, look_css
from lwr_dyn.pages.replay.page_parts import (
    PLAYER,
    fill_template,
    generator_line,
    meshcat_bundle,
    pack_int32,
    resource_text,
    script_safe,
    subsample,
)
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, facts, replayed_runs
from lwr_dyn.simulation.metrics import tip_model
from lwr_dyn.simulation.stop_contacts import stop_contacts

SERIES_BUDGET = 4_300_000
"""Largest size of all series in the page [bytes]; above it more samples are left out; the page says how many it has."""
RATE = 100.0
"""Samples per second of a page [Hz]: enough for the eye, a tenth of the size of 1 kHz."""
_TRACE_POINTS = 1500
"""Largest number of points of a drawn path."""
_MOST_EVENTS = 400


def replay_html(
    runs: Sequence[Run],
    arms: Arm | Sequence[Arm],
    *,
    labels: Sequence[str] | None = None,
    title: str | None = None,
    trace: bool = True,
    frames: bool = False,
    layout: str = "overlaid",
    live: bool = False,
    rate: float = RATE,
) -> str:
    """One self-contained page that replays runs in 3D; the same runs give the same text.

    Parameters
    ----------
    runs : sequence of Run
        Shown together; the page lasts as long as the longest.
    arms : Arm or sequence of Arm
        One for all, or one per run.
    labels : sequence of str, optional
        One per run; the controllers' names if not given.
    title : str, optional
        Headline; the arm's title if not given.
    trace, frames : bool
        Whether the trace and the source's frames are shown at the start; the page has a switch for each.
    layout : {"overlaid", "beside"}
        Whether several arms are at one place or side by side at the start; the page has a switch.
    rate : float
        Samples of each run per second that the page keeps [Hz]; the page says how many of how many.
    live : bool
        Whether the page connects to the meshcat server that served it (`lwr_dyn.pages.replay.live`).

    Raises
    ------
    OptionError
        No run, not one arm and one label per run, a layout of another name, or a rate that is not positive.
    ShapeError
        A run that is empty, not finite, or has other joints than its arm.
    """
    if layout not in ("overlaid", "beside"):
        raise OptionError("layout", repr(layout), "overlaid, beside")
    shown = replayed_runs(runs, arms, labels)
    headline = shown[0].arm.title if title is None else title
    data = page_data(shown, rate) | {"title": headline, "live": live}
    data["start"] = {"trace": trace, "frames": frames, "beside": layout == "beside"}
    parts = {
        "title": escape(headline),
        "policy": replay_policy(live),
        "style": "\n".join([font_faces(), look_css(), resource_text("player.css"), resource_text("page.css")]),
        "controls": resource_text("controls.html"),
        "meshcat": meshcat_bundle(),
        "data": script_safe(json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)),
        "player": "\n".join(resource_text(name) for name in (*PLAYER, "start.js")),
    }
    return fill_template(resource_text("page.html"), parts)


def write_replay(path: str | Path, runs: Sequence[Run], arms: Arm | Sequence[Arm], **options: Any) -> None:
    """Write `replay_html(runs, arms, **options)` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, replay_html(runs, arms, **options))


def page_data(shown: Sequence[ReplayedRun], rate: float = RATE) -> dict[str, Any]:
    """The player's data: the runs, and the arms as meshcat commands."""
    if not rate > 0.0:
        raise OptionError("rate", rate, "a positive number of samples per second")
    strides = [max(1, round((one.run.t.size - 1) / max(float(np.ptp(one.run.t)) * rate, 1e-9))) for one in shown]
    samples = sum(one.run.t.size // stride * (2 * one.arm.n + 2) for one, stride in zip(shown, strides, strict=True))
    more = max(1, -(-samples * 16 // 3 // SERIES_BUDGET))  # four bytes a number, a third more as base64
    commands = [command for i, one in enumerate(shown) for command in scene.arm_commands(one, i)]
    records = [run_record(one, more * stride) for one, stride in zip(shown, strides, strict=True)]
    return {"runs": records, "scene": commands, "made_by": generator_line()}


def run_record(shown: ReplayedRun, stride: int = 1) -> dict[str, Any]:
    """One run as JSON values: label and facts, joints as origins and kinds, series as packed integers."""
    run, arm = shown.run, shown.arm
    keep = subsample(run.t.size, stride)
    drawn = subsample(run.t.size, -(-run.t.size // _TRACE_POINTS))
    path = shown.reference_path
    path = path[subsample(len(path), -(-len(path) // _TRACE_POINTS))]
    return {
        "label": shown.label,
        "place": shown.place,
        "tip_model": tip_model(run),
        "stops": stop_contacts(run, arm).sentence(),
        "facts": [[name, value] for name, value in facts(run).items() if value != shown.label],
        "joints": [
            {"name": j.name, "kind": j.kind.value, "origin": scene.column_major(j.origin)} for j in arm.joints()
        ],
        "flange": scene.column_major(arm.flange()),
        "base": scene.column_major(ends_of(arm.installation)[0]),
        "native": [scene.column_major(link.after) for link in arm.chain.links],
        "floor": floor_height(arm),
        "foot": stand_foot(arm).tolist(),
        "samples": [int(keep.size), int(run.t.size)],
        "t": pack_int32(run.t[keep]),
        "q": pack_int32(run.q[keep]),
        "q_ref": pack_int32(run.q_ref[keep]),
        "tip_error": pack_int32(shown.tip_error[keep]),
        "trace": {"t": pack_int32(run.t[drawn]), "points": pack_int32(shown.pose[drawn, :3, 3])},
        "reference": pack_int32(path),
        "events": [[event.t, event.kind, event.joint] for event in run.events[:_MOST_EVENTS]],
    }


def replay_policy(live: bool) -> str:
    """What the page may load: what stands in it; live also the server's messages."""
    connect = "connect-src 'self' ws:" if live else "connect-src 'none'"
    inside = "script-src 'unsafe-inline'; style-src 'unsafe-inline'; font-src data:; img-src data: blob:"
    return f"default-src 'none'; {inside}; {connect}"


def replay(
    runs: Run | Sequence[Run],
    path: str | Path,
    *,
    labels: Sequence[str] | None = None,
    title: str | None = None,
    trace: bool = True,
    frames: bool = False,
    layout: str = "overlaid",
    rate: float = 100.0,
) -> None:
    """Write one HTML page to `path`, no network, that replays runs in 3D with the arms that they name.

    labels: one per run; the controllers' names if not given. title: headline; the arm's title if not given. trace,
    frames: whether the trace and the source's frames are shown at the start. layout: "overlaid" or "beside". rate:
    samples a second on the page. Raises `FileAccessError`, `UnknownNameError` (an unknown robot), `OptionError`,
    `ShapeError`.
    """
    if not isinstance(runs, (Run, Sequence)):
        raise OptionError("runs", repr(runs), "a run or a list of runs, as simulate or Run.load give them")
    several = [runs] if isinstance(runs, Run) else list(runs)
    arms = [arm_of(run) for run in several]
    write_replay(path, several, arms, labels=labels, title=title, trace=trace, frames=frames, layout=layout, rate=rate)
