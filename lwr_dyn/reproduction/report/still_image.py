"""A still of the 3D view before it starts: the arm's cylinders drawn by ray casting, the paths of the runs over them.

The image has greys and transparency only, so it suits light and dark pages; the paths are SVG in the runs' colours.

The runs that a page shows: how far the tip is from its path, and the share of the torque limits that they take.
"""

import base64
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.arms.urdf.geometry import floor_height, primitives
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import ends_of, joint_motion
from lwr_dyn.pages.figures.figure import short
from lwr_dyn.pages.markup import Html, element
from lwr_dyn.pages.plotting.drawn_panel import run_ink
from lwr_dyn.pages.replay.replay_page import RATE
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.reproduction.report.content import Replay
from lwr_dyn.reproduction.report.figure_html import simplified

COLUMNS, ROWS = 960, 600
"""Pixels of the image."""

_SHARPER = 2
"""Rays a pixel, along each side."""

_ELEVATION = 0.27
"""[rad] The camera looks down by so much, as the 3D view does."""

_MOMENT = 0.62
"""Share of the run's time at which the arm is shown."""

_GREYS = {"orange": 0.86, "grey": 0.80, "dark": 0.30}
"""How bright the arm's parts are; the body has no run's colour."""

_LIGHT = np.array([0.45, -0.35, 0.82])

_LEVELS = 64
"""Shades of the image."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A cylinder in the base: its pose (4, 4), radius and length [m], brightness."""

    pose: Array
    radius: float
    length: float
    grey: float


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A view without perspective: rows are right, up and toward the eye; scale [pixels/m]."""

    axes: Array
    scale: float
    centre: Array

    def seen(self, points: Array) -> Array:
        """Points (..., 3) in the base -> column, row [pixels], and nearness [m]."""
        turned = points @ self.axes.T - self.centre
        return np.stack(
            [0.5 * COLUMNS + self.scale * turned[..., 0], 0.5 * ROWS - self.scale * turned[..., 1], turned[..., 2]],
            axis=-1,
        )


def still_html(replay: Replay) -> Html:
    """The still of a replay: its first run some way along its path, or its first still pose."""
    one = replay.runs[0] if replay.runs else None
    k = 0 if one is None else int(_MOMENT * (one.run.t.size - 1))
    arm, q = (replay.stills[0].arm, replay.stills[0].q) if one is None else (one.arm, one.run.q[k])
    solids = arm_solids(arm, np.asarray(q, dtype=np.float64))
    tracks = [points[:: max(1, len(points) // 800)] for points in _tracks(replay.runs)]
    camera = _camera(arm, solids, tracks)
    picture, near = ray_cast(solids, camera)
    image = element("img", src=png_address(picture), alt=_description(arm, replay.runs), width=COLUMNS, height=ROWS)
    return element("div", _floor(arm, camera), image, _paths(replay.runs, camera, near, k), class_="still")


def arm_solids(arm: Arm, q: Array) -> tuple[Solid, ...]:
    """What is drawn of an arm at q (n,) [rad or m], in its base."""
    here, poses = np.eye(4), {"base": ends_of(arm.installation)[0].matrix()}
    for link, joint, value in zip(arm.chain.links, arm.joints(), q, strict=True):
        here = here @ (joint.origin @ joint_motion(joint.kind, float(value))).matrix()
        poses[link.link] = here
    poses["flange"] = here @ arm.flange().matrix() @ ends_of(arm.installation)[1].matrix()
    return tuple(Solid(poses[s.link] @ s.pose.matrix(), s.radius, s.length, _GREYS[s.colour]) for s in primitives(arm))


def ray_cast(solids: Sequence[Solid], camera: Camera) -> tuple[Array, Array]:
    """Brightness with coverage (rows, columns, 2) from 0 to 1; nearness [m] (rows, columns), -inf where nothing is."""
    rows, columns, scale = ROWS * _SHARPER, COLUMNS * _SHARPER, camera.scale * _SHARPER
    near, grey = np.full((rows, columns), -np.inf), np.zeros((rows, columns))
    for solid in solids:
        middle = _SHARPER * camera.seen(solid.pose[:3, 3])[:2]
        reach = scale * float(np.hypot(solid.radius, 0.5 * solid.length)) + 1.0
        first, last = np.maximum(middle - reach, 0.0).astype(int), np.ceil(middle + reach).astype(int)
        window = np.s_[first[1] : min(last[1], rows), first[0] : min(last[0], columns)]
        if near[window].size == 0:
            continue
        down, across = np.mgrid[window]
        x = (across + 0.5 - 0.5 * columns) / scale + camera.centre[0]
        y = (0.5 * rows - down - 0.5) / scale + camera.centre[1]
        depth, normal = _hits(solid, np.stack([x, y], axis=-1), camera)
        better = depth > near[window]
        near[window] = np.where(better, depth, near[window])
        grey[window] = np.where(better, _shade(normal, solid.grey, camera.axes[2]), grey[window])
    covered = np.isfinite(near)
    parts = [np.where(covered, grey, 0.0), covered.astype(float)]
    light, share = (p.reshape(ROWS, _SHARPER, COLUMNS, _SHARPER).mean(axis=(1, 3)) for p in parts)
    picture = np.stack([light / np.maximum(share, 1e-9), share], axis=-1)
    return picture, near[::_SHARPER, ::_SHARPER] - camera.centre[2]


def _hits(solid: Solid, screen: Array, camera: Camera) -> tuple[Array, Array]:
    """Where rays through points (..., 2) of the screen meet a capped cylinder: nearness, and normals in the base."""
    turn, place = solid.pose[:3, :3], solid.pose[:3, 3]
    start = (screen @ camera.axes[:2] - place) @ turn  # in the cylinder's own frame, where its axis is z
    along = camera.axes[2] @ turn
    a = along[0] ** 2 + along[1] ** 2
    b = start[..., 0] * along[0] + start[..., 1] * along[1]
    c = start[..., 0] ** 2 + start[..., 1] ** 2 - solid.radius**2
    half = 0.5 * solid.length
    with np.errstate(divide="ignore", invalid="ignore"):
        side = (-b + np.sqrt(b * b - a * c)) / a if a > 1e-12 else np.full(b.shape, np.nan)
        cap = (
            (np.sign(along[2]) * half - start[..., 2]) / along[2] if abs(along[2]) > 1e-9 else np.full(b.shape, np.nan)
        )
        on_side = np.abs(start[..., 2] + side * along[2]) <= half
        radius = np.hypot(start[..., 0] + cap * along[0], start[..., 1] + cap * along[1])
    on_cap = radius <= solid.radius
    depth = np.where(on_cap, cap, np.where(on_side, side, -np.inf))
    met = start + np.where(np.isfinite(depth), depth, 0.0)[..., None] * along
    round_ = np.concatenate([met[..., :2] / solid.radius, np.zeros((*b.shape, 1))], axis=-1)
    flat = np.array([0.0, 0.0, np.sign(along[2])])
    return depth, np.where(on_cap[..., None], flat, round_) @ turn.T


def _shade(normal: Array, grey: float, eye: Array) -> Array:
    light = _LIGHT / np.linalg.norm(_LIGHT)
    half = (light + eye) / np.linalg.norm(light + eye)
    lit = np.clip(normal @ light, 0.0, None)
    shine = np.clip(normal @ half, 0.0, None) ** 24
    return np.asarray(np.clip(grey * (0.52 + 0.48 * lit) + 0.14 * shine, 0.0, 1.0))


def _camera(arm: Arm, solids: Sequence[Solid], tracks: Sequence[Array]) -> Camera:
    """Turned as the 3D view turns, so near that arm and paths fill the picture."""
    azimuth = _azimuth(tracks, flange_pose(arm.chain, np.zeros(arm.n))[:3, 3])
    c, s, e = np.cos(azimuth), np.sin(azimuth), _ELEVATION
    toward = np.array([c * np.cos(e), s * np.cos(e), np.sin(e)])
    right = np.array([-s, c, 0.0])
    axes = np.stack([right, np.cross(toward, right), toward])
    corners = [
        x.pose[:3, 3] + d * x.pose[:3, 2] * 0.5 * x.length + side
        for x in solids
        for d in (-1, 1)
        for side in x.radius * np.vstack([axes[:2], -axes[:2]])
    ]
    turned = np.vstack([np.array(corners), *tracks]) @ axes.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    scale = 0.9 * min(COLUMNS / (high[0] - low[0]), ROWS / (high[1] - low[1]))
    return Camera(axes, scale, 0.5 * (low + high))


def _azimuth(tracks: Sequence[Array], tip: Array) -> float:
    if not tracks:
        return -0.9 if np.hypot(tip[0], tip[1]) < 0.3 * np.linalg.norm(tip) else float(np.arctan2(tip[1], tip[0])) - 1.0
    points = np.vstack(tracks)
    size, middle = np.ptp(points, axis=0), 0.5 * (points.min(axis=0) + points.max(axis=0))
    if size[1] < 0.25 * min(size[0], size[2]):
        return float(-0.5 * np.pi + 0.42 * np.sign(middle[0] or 1.0))
    return float(0.42 * np.sign(middle[1] or -1.0))


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


def png_address(picture: Array) -> str:
    """Brightness with coverage (rows, columns, 2) from 0 to 1 as a PNG in an address."""
    shades = np.rint(picture[..., 0] * (_LEVELS - 1)) * (255.0 / (_LEVELS - 1))
    covered = np.rint(picture[..., 1] * 15.0) * 17.0
    pixels = np.where(covered[..., None] > 0.0, np.stack([shades, covered], axis=-1), 0.0).astype(np.uint8)
    rows, columns, _ = pixels.shape
    up = np.diff(pixels.astype(np.int16), axis=0, prepend=0).astype(np.uint8).reshape(rows, -1)
    body = zlib.compress(np.hstack([np.full((rows, 1), 2, np.uint8), up]).tobytes(), 9)
    head = struct.pack(">IIBBBBB", columns, rows, 8, 4, 0, 0, 0)
    data = b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*part) for part in ((b"IHDR", head), (b"IDAT", body), (b"IEND", b"")))
    return f"data:image/png;base64,{base64.b64encode(data).decode('ascii')}"


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


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
