"""A picture of an arm: its cylinders drawn by ray casting, with the paths of runs over them where that is asked.

The image of a page has greys and transparency only, so it suits light and dark pages; a still for readers that show no
page stands on the light card, in colours.
"""

import base64
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arms.urdf.geometry import primitives
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import ends_of, joint_motion
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replayed_runs import replayed_runs

COLUMNS, ROWS = 960, 600
"""Pixels of the image."""

_SHARPER = 2
"""Rays a pixel, along each side."""

_ELEVATION = 0.27
"""[rad] The camera looks down by so much, as the 3D view does."""

_GREYS = {"orange": 0.86, "grey": 0.80, "dark": 0.30}
"""How bright the arm's parts are; the body has no run's colour."""

_LIGHT = np.array([0.45, -0.35, 0.82])

SAME_DEPTH = 1e-9
"""[m] Faces that lie in one another are drawn as the first of them."""

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


def arm_still(arm: Arm, q: Array, run: Run | None = None) -> bytes:
    """The arm at q (n,) [rad or m] as PNG, with the path of a run over its reference."""
    lines: list[tuple[Array, str, float]] = []
    if run is not None:
        (shown,) = replayed_runs([run], arm)
        lines = [(shown.reference_path, tokens()["ref"], 4.0), (shown.pose[:, :3, 3], shown.colour, 2.0)]
    solids = arm_solids(arm, q)
    camera = camera_of(arm, solids, [points for points, *_ in lines])
    picture, near = ray_cast(solids, camera)
    light, share = picture[..., :1], picture[..., 1:]
    image = share * light + (1.0 - share) * _rgb(tokens()["card"])
    for points, colour, width in lines:
        inked = _stroke(camera.seen(points), near, width)[..., None]
        image = inked * _rgb(colour) + (1.0 - inked) * image
    return png_bytes(np.rint(255.0 * image).astype(np.uint8))


def _rgb(colour: str) -> Array:
    return np.array([int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)])


def _stroke(seen: Array, near: Array, width: float) -> Array:
    """Coverage (rows, columns) of a line through points (k, 3) of the image; behind the arm it is not drawn."""
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(seen[:, :2], axis=0).T)))
    at = np.arange(0.0, along[-1] + 0.5, 0.5)
    column, row, depth = (np.interp(at, along, seen[:, i]) for i in range(3))
    out, reach = np.zeros((ROWS, COLUMNS)), int(np.ceil(0.5 * width)) + 1
    for down in range(-reach, reach + 1):
        for across in range(-reach, reach + 1):
            i, k = np.floor(row).astype(int) + down, np.floor(column).astype(int) + across
            inside = (i >= 0) & (i < ROWS) & (k >= 0) & (k < COLUMNS)
            i, k, x, y, z = i[inside], k[inside], column[inside], row[inside], depth[inside]
            covered = np.clip(0.5 * width + 0.5 - np.hypot(k + 0.5 - x, i + 0.5 - y), 0.0, 1.0)
            np.maximum.at(out, (i, k), np.where(z >= near[i, k], covered, 0.0))
    return out


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
        better = depth > near[window] + SAME_DEPTH
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
    side = cap = np.full(b.shape, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        if a > 1e-12:
            side = (-b + np.sqrt(b * b - a * c)) / a
        if abs(along[2]) > 1e-9:
            cap = (np.sign(along[2]) * half - start[..., 2]) / along[2]
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


def camera_of(arm: Arm, solids: Sequence[Solid], tracks: Sequence[Array]) -> Camera:
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


def png_address(picture: Array) -> str:
    """Brightness with coverage (rows, columns, 2) from 0 to 1 as a PNG in an address."""
    shades = np.rint(picture[..., 0] * (_LEVELS - 1)) * (255.0 / (_LEVELS - 1))
    covered = np.rint(picture[..., 1] * 15.0) * 17.0
    pixels = np.where(covered[..., None] > 0.0, np.stack([shades, covered], axis=-1), 0.0).astype(np.uint8)
    return f"data:image/png;base64,{base64.b64encode(png_bytes(pixels)).decode('ascii')}"


def png_bytes(pixels: NDArray[np.uint8]) -> bytes:
    """Pixels (rows, columns, channels) as a PNG: two channels are grey with coverage, three are red, green, blue."""
    rows, columns, channels = pixels.shape
    up = np.diff(pixels.astype(np.int16), axis=0, prepend=0).astype(np.uint8).reshape(rows, -1)
    body = zlib.compress(np.hstack([np.full((rows, 1), 2, np.uint8), up]).tobytes(), 9)
    head = struct.pack(">IIBBBBB", columns, rows, 8, {2: 4, 3: 2}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*part) for part in ((b"IHDR", head), (b"IDAT", body), (b"IEND", b"")))


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
