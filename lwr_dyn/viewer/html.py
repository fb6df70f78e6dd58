"""Runs -> one HTML file that replays them in 3D: meshcat's viewer, the runs and our player in one page, no request.

Everything the page needs is inside it, and its content security policy forbids it to load anything else. The player
(`PLAYER`) is plain JavaScript beside this file; `viewer.report` uses it too.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import MissingDataError, OptionError
from lwr_dyn.files import write_file
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.version import VERSION
from lwr_dyn.viewer import scene
from lwr_dyn.viewer.shown import Shown, facts, shown_runs

SERIES_BUDGET = 4_300_000
"""Bytes the series of all runs may take in the page; beyond, samples are left out, and the page says so."""
_TRACE_POINTS = 1500
"""A drawn path has at most this many points."""
_EVENTS = 400
PLAYER = ("numbers.js", "drawing.js", "stage.js", "strip.js", "player.js")
"""The scripts of the player, in their order."""
_LARGEST = 2**31 - 1


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
        Whether the drawn trace and the frames of the paper are shown at first; both have a switch on the page.
    layout : {"overlaid", "beside"}
        Whether several arms stand in one place or side by side at first; a switch too.
    live : bool
        Whether the page listens to the meshcat server it comes from (`lwr_dyn.viewer.live`).

    Raises
    ------
    OptionError
        No run, not one arm and one label per run, or a layout of another name.
    ShapeError
        A run that is empty, not finite, or has other joints than its arm.
    """
    if layout not in ("overlaid", "beside"):
        raise OptionError("layout", repr(layout), "overlaid, beside")
    shown = shown_runs(runs, arms, labels)
    headline = shown[0].arm.title if title is None else title
    data = page_data(shown) | {"title": headline, "live": live}
    data["start"] = {"trace": trace, "frames": frames, "beside": layout == "beside"}
    parts = {
        "title": escape(headline),
        "policy": _policy(live),
        "style": beside_this_file("player.css") + beside_this_file("page.css"),
        "controls": beside_this_file("controls.html"),
        "meshcat": meshcat_bundle(),
        "data": script_safe(json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)),
        "player": "\n".join(beside_this_file(name) for name in (*PLAYER, "start.js")),
    }
    return filled(beside_this_file("page.html"), parts)


def filled(template: str, parts: Mapping[str, str]) -> str:
    """A template in which each @@name@@ gives way to its part; what the parts hold is not looked at.

    >>> filled("<p>@@a@@</p>", {"a": "@@b@@"})
    '<p>@@b@@</p>'
    """
    pieces = template.split("@@")  # text, name, text, name, ..., text
    return "".join(parts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def write_replay(path: str | Path, runs: Sequence[Run], arms: Arm | Sequence[Arm], **options: Any) -> None:
    """Write `replay_html(runs, arms, **options)` to a file; raises as it does, and `FileAccessError`."""
    write_file(path, replay_html(runs, arms, **options))


def page_data(shown: Sequence[Shown]) -> dict[str, Any]:
    """What the player reads: the runs, and the arms as meshcat commands."""
    samples = sum(one.run.t.size * (2 * one.arm.n + 2) for one in shown)
    stride = max(1, -(-samples * 16 // 3 // SERIES_BUDGET))  # four bytes a number, a third more as base64
    commands = [command for i, one in enumerate(shown) for command in scene.arm_commands(one, i)]
    return {"runs": [run_record(one, stride) for one in shown], "scene": commands, "made_by": made_by()}


def run_record(shown: Shown, stride: int = 1) -> dict[str, Any]:
    """One run as JSON: who it is, its joints as origins and kinds, its series as packed integers."""
    run, arm = shown.run, shown.arm
    keep = every(run.t.size, stride)
    drawn = every(run.t.size, -(-run.t.size // _TRACE_POINTS))
    path = shown.reference_path
    path = path[every(len(path), -(-len(path) // _TRACE_POINTS))]
    return {
        "label": shown.label,
        "colour": shown.colour,
        "facts": [[name, value] for name, value in facts(run).items()],
        "joints": [
            {"name": j.name, "kind": j.kind.value, "origin": scene.column_major(j.origin)} for j in arm.joints()
        ],
        "flange": scene.column_major(arm.flange()),
        "native": [scene.column_major(link.after) for link in arm.chain.links],
        "floor": -arm.drawing.pedestal,
        "samples": [int(keep.size), int(run.t.size)],
        "t": packed(run.t[keep]),
        "q": packed(run.q[keep]),
        "q_ref": packed(run.q_ref[keep]),
        "tip_error": packed(shown.tip_error[keep]),
        "trace": {"t": packed(run.t[drawn]), "points": packed(shown.pose[drawn, :3, 3])},
        "reference": packed(path),
        "events": [[event.t, event.kind, event.joint] for event in run.events[:_EVENTS]],
    }


NOTHING = 1e-290
"""Numbers below this are drawn as zero: their step would not be a normal float."""


def packed(values: Array) -> dict[str, Any]:
    """Numbers as 32-bit integers times a step, in base64: half the size of float64, error <= 2.4e-10 of the largest.

    >>> packed(np.array([0.5, -0.25]))["shape"]
    [2]
    """
    largest = float(np.abs(values).max(initial=0.0))
    step = largest / _LARGEST if largest > NOTHING else 1.0
    integers = np.rint(values / step).astype("<i4")
    return {"shape": list(values.shape), "step": step, "data": base64.b64encode(integers.tobytes()).decode("ascii")}


def every(size: int, stride: int) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Indices 0, stride, 2 stride ... and the last one.

    >>> every(6, 2).tolist()
    [0, 2, 4, 5]
    """
    return np.union1d(np.arange(0, size, max(1, stride)), [size - 1])


def made_by() -> str:
    """What wrote the page, for its foot."""
    return f"lwr_dyn {VERSION}, drawn by meshcat and three.js"


def meshcat_folder() -> Path:
    """Where the installed meshcat keeps the viewer it serves; raises `MissingDataError` when it is not there."""
    spec = find_spec("meshcat")
    folder = Path(spec.origin).parent / "viewer" / "dist" if spec and spec.origin else Path()
    if not (folder / "main.min.js").is_file():
        raise MissingDataError("meshcat", "viewer/dist/main.min.js", "a replay; install meshcat again")
    return folder


def meshcat_bundle() -> str:
    """The viewer of the installed meshcat (with three.js), as it goes into a page."""
    source = (meshcat_folder() / "main.min.js").read_text(encoding="utf-8")
    return "\n".join(line for line in source.splitlines() if not line.startswith("//# sourceMappingURL"))


def _policy(live: bool) -> str:
    listens = "connect-src 'self' ws:" if live else "connect-src 'none'"
    return f"default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; {listens}"


def script_safe(text: str) -> str:
    """JSON that cannot end the script element it stands in."""
    return text.replace("<", "\\u003c")


def beside_this_file(name: str) -> str:
    """A file of this room, as text."""
    return files("lwr_dyn.viewer").joinpath(name).read_text(encoding="utf-8")
