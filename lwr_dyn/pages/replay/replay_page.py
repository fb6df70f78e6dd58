"""Runs -> one HTML file that replays them in 3D: meshcat's viewer, the runs and our player in one page.

The page makes no request: everything is inside it, and its content security policy forbids loading anything else. Other
pages are put together from the same parts: templates, scripts, meshcat's bundle, numbers packed for JavaScript.

The arm is `set_object` and `set_transform` commands of a meshcat viewer, which the live server uses too. Names come
from the place in the scene tree, not at random, so the same runs give the same bytes. Link k is at `link_path(run, k)`
below link k - 1; its transform is the joint's origin times the joint's motion, which the player sets.
"""

import base64
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.arms.urdf.geometry import Primitive, floor_height
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import ends_of, joint_motion
from lwr_dyn.model.run import Run
from lwr_dyn.model.spatial import Pose, rot_x
from lwr_dyn.pages.replay.drawn_shapes import drawn_shapes
from lwr_dyn.pages.replay.look import font_faces, look_css, tokens
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, facts, replayed_runs
from lwr_dyn.simulation.metrics import stop_contacts, tip_model

STAGE = ("numbers.js", "drawing.js", "framing.js", "stage.js")
"""The scripts of the stage, in their order."""

PLAYER = (*STAGE, "strip.js", "player.js")
"""The scripts of the player, in their order."""

SMALLEST = 1e-290
"""Numbers below this are drawn as zero: their step would not be a normal float."""


def fill_template(template: str, parts: Mapping[str, str]) -> str:
    """Replaces each @@name@@ in a template; inserted text is not expanded.

    >>> fill_template("<p>@@a@@</p>", {"a": "@@b@@"})
    '<p>@@b@@</p>'
    """
    pieces = template.split("@@")  # text, name, text, name, ..., text
    return "".join(parts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def pack_int32(values: Array) -> dict[str, Any]:
    """Numbers as 32-bit integers times a step, in base64: half the size of float64, error <= 2.4e-10 of the largest.

    >>> pack_int32(np.array([0.5, -0.25]))["shape"]
    [2]
    """
    largest = float(np.abs(values).max(initial=0.0))
    step = largest / (2**31 - 1) if largest > SMALLEST else 1.0
    integers = np.rint(values / step).astype("<i4")
    return {"shape": list(values.shape), "step": step, "data": base64.b64encode(integers.tobytes()).decode("ascii")}


def subsample(size: int, stride: int) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Indices 0, stride, 2 stride ... and the last one.

    >>> subsample(6, 2).tolist()
    [0, 2, 4, 5]
    """
    return np.union1d(np.arange(0, size, max(1, stride)), [size - 1])


def generator_line() -> str:
    """What generated the page, for its footer."""
    return f"lwr_dyn {VERSION}, drawn by meshcat and three.js"


def meshcat_folder() -> Path:
    """The folder of the viewer that the installed meshcat serves; raises `MissingDataError` when it is missing."""
    spec = find_spec("meshcat")
    folder = Path(spec.origin).parent / "viewer" / "dist" if spec and spec.origin else Path()
    if not (folder / "main.min.js").is_file():
        raise MissingDataError("meshcat", "viewer/dist/main.min.js", "a replay; install meshcat again")
    return folder


def meshcat_bundle() -> str:
    """The viewer of the installed meshcat (with three.js) as a script."""
    source = (meshcat_folder() / "main.min.js").read_text(encoding="utf-8")
    return "\n".join(line for line in source.splitlines() if not line.startswith("//# sourceMappingURL"))


def script_safe(text: str) -> str:
    """JSON text that cannot close the script element around it."""
    return text.replace("<", "\\u003c")


def resource_text(name: str, package: str = "lwr_dyn.pages.replay") -> str:
    """A file of a package, as text."""
    return files(package).joinpath(name).read_text(encoding="utf-8")


Command = Mapping[str, Any]

ROOT = "arms"

_UPRIGHT = Pose(rot_x(np.pi / 2), np.zeros(3))
"""Turns the y axis of a three.js cylinder to our z axis."""

_BODY = {"grey": "housing", "orange": "limb", "dark": "joint"}


def run_path(run: int) -> str:
    """Path of the base of run `run` in the scene tree."""
    return f"/{ROOT}/run_{run}"


def link_path(run: int, link: int) -> str:
    """Path of link `link`: 0 is the first frame of the chain, n + 1 the last one of an arm with n joints."""
    return "/".join([run_path(run), *(f"link_{i}" for i in range(link + 1))])


def arm_commands(shown: ReplayedRun, run: int) -> Iterator[Command]:
    """The shapes of an arm, then its links at the first sample of the run."""
    links = ["base", *(link.link for link in shown.arm.chain.links), "flange"]
    ends = dict(zip(("base", "flange"), ends_of(shown.arm.installation), strict=True))
    for k, shape in enumerate(drawn_shapes(shown.arm)):
        shape = replace(shape, pose=ends[shape.link] @ shape.pose) if shape.link in ends else shape
        yield cylinder(f"{link_path(run, links.index(shape.link))}/shape_{k}", shape, f"run{min(shown.place, 4) + 1}")
    yield from pose_commands(shown.arm, shown.run.q[0], run)


def pose_commands(arm: Arm, q: Array, run: int) -> Iterator[Command]:
    """The transforms that put the arm at q (n,) [rad or m]."""
    for i, (joint, value) in enumerate(zip(arm.joints(), q, strict=True), start=1):
        yield transform(link_path(run, i), joint.origin @ joint_motion(joint.kind, float(value)))
    yield transform(link_path(run, arm.n + 1), arm.flange())


def cylinder(path: str, shape: Primitive, accent: str) -> Command:
    """A drawn cylinder: bodies are grey, bands have the token `accent`; the page takes its colour from `userData`.

    A dark cylinder shorter than 0.7 radii is a band, and has the colour of its run; a foot has not.
    """
    is_band = shape.colour == "dark" and shape.link != "base" and shape.length <= 0.7 * shape.radius
    token = accent if is_band else _BODY[shape.colour]
    geometry = {
        "uuid": f"{path}#geometry",
        "type": "CylinderGeometry",
        "radiusTop": shape.radius,
        "radiusBottom": shape.radius,
        "height": shape.length,
        "radialSegments": 40,
    }
    material = {
        "uuid": f"{path}#material",
        "type": "MeshPhongMaterial",
        "color": int(tokens()[token][1:], 16),
        "specular": 0x2A2A2A,
        "shininess": 35,
    }
    mesh = {
        "uuid": path,
        "type": "Mesh",
        "geometry": geometry["uuid"],
        "material": material["uuid"],
        "matrix": column_major(shape.pose @ _UPRIGHT),
        "userData": {"token": token},
    }
    metadata = {"version": 4.5, "type": "Object"}
    scene = {"metadata": metadata, "geometries": [geometry], "materials": [material], "object": mesh}
    return {"type": "set_object", "path": path, "object": scene}


def transform(path: str, pose: Pose) -> Command:
    """Sets the pose of the node at `path` in its parent."""
    return {"type": "set_transform", "path": path, "matrix": column_major(pose)}


def column_major(pose: Pose) -> list[float]:
    """The 16 numbers of a pose in column-major order, as in three.js."""
    return [float(x) for x in pose.matrix().T.ravel()]


SERIES_BUDGET = 4_300_000
"""Largest size of all series in the page [bytes]; above it more samples are left out; the page says how many it has."""

RATE = 100.0
"""Samples per second of a page [Hz]: enough for the eye, a tenth of the size of 1 kHz."""

_TRACE_POINTS = 1500
"""Largest number of points of a drawn path."""


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
    headline = " and ".join(dict.fromkeys(run.arm.title for run in shown)) if title is None else title
    data = page_data(shown, rate) | {"title": headline, "live": live}
    data["start"] = {"trace": trace, "frames": frames, "beside": layout == "beside"}
    return player_page(headline, data, live)


def player_page(title: str, data: Mapping[str, Any], live: bool = False, own: Sequence[str] = (), of: str = "") -> str:
    """The page of the player with its data; `own` are further styles and scripts, files of the package `of`."""
    styles, scripts = ([resource_text(name, of) for name in own if name.endswith(end)] for end in (".css", ".js"))
    parts = {
        "title": escape(title),
        "policy": replay_policy(live),
        "style": "\n".join([font_faces(), look_css(), *map(resource_text, ("player.css", "page.css")), *styles]),
        "controls": resource_text("controls.html"),
        "meshcat": meshcat_bundle(),
        "data": script_safe(json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)),
        "player": "\n".join([*map(resource_text, (*PLAYER, "start.js")), *scripts]),
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
    commands = [command for i, one in enumerate(shown) for command in arm_commands(one, i)]
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
        "caveat": shown.caveat,
        "facts": [[name, value] for name, value in facts(run).items() if value != shown.label],
        "joints": [{"name": j.name, "kind": j.kind.value, "origin": column_major(j.origin)} for j in arm.joints()],
        "flange": column_major(arm.flange()),
        "base": column_major(ends_of(arm.installation)[0]),
        "native": [column_major(link.after) for link in arm.chain.links],
        "floor": floor_height(arm),
        "samples": [int(keep.size), int(run.t.size)],
        "t": pack_int32(run.t[keep]),
        "q": pack_int32(run.q[keep]),
        "q_ref": pack_int32(run.q_ref[keep]),
        "tip_error": pack_int32(shown.tip_error[keep]),
        "trace": {"t": pack_int32(run.t[drawn]), "points": pack_int32(shown.pose[drawn, :3, 3])},
        "reference": pack_int32(path),
        "events": [[event.t, event.kind, event.joint] for event in run.events[:400]],
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
