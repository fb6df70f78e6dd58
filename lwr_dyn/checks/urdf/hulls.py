"""Convex hulls of bodies, and the meshes that they are made of.

A hull of about 600 support directions loses 0.4 to 3 % of the volume of a round body and nothing of a box. The
covariance H of the solid hull is what an inertia is held against: for a full body of even density the covariance of the
mass is H itself.

A mesh is found by its package, by `file://`, or beside the URDF. STL, OBJ and DAE are read by trimesh; a DAE states its
unit, which readers of URDFs apply (its up axis they do not). The outermost points are kept by the content of the file:
in memory, and in the user's cache folder as plain numbers, checked when read. A damaged or foreign file there is passed
over and written again; a folder that cannot be written costs only time.
"""

import hashlib
import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, lru_cache
from io import BytesIO
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote

import numpy as np

from lwr_dyn.arms.urdf.xacro_files import package_folder
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import cache_folder, read_bytes, write_in_place

_DIRECTIONS = 574
_CHUNK = 8192
"""Points that are multiplied with all directions at once: 20 MB."""
_FLAT = 1e-9
"""Volume over diameter^3 below which a body is a sheet or a line, without a covariance to compare with."""


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """A solid convex body."""

    vertices: Array  # (k, 3) [m]
    planes: Array  # (f, 4), outward unit normal n and offset d [m] of each face: n . x + d <= 0 inside
    volume: float  # [m^3]
    centroid: Array  # (3,) [m]
    covariance: Array  # (3, 3) [m^2], mean of (x - centroid)(x - centroid)' over the volume
    diameter: float  # [m], the largest width


@cache
def directions() -> Array:
    """About 600 unit vectors, even on the sphere, with axes, edges and corners of the cube: (600, 3) array."""
    k = np.arange(_DIRECTIONS) + 0.5
    z, turn = 1.0 - 2.0 * k / _DIRECTIONS, np.pi * (1.0 + 5.0**0.5) * k
    even = np.column_stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z])
    grid = np.array(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3)).reshape(3, -1).T
    cube = grid[np.abs(grid).sum(axis=1) > 0.0]
    return np.vstack([cube / np.linalg.norm(cube, axis=1)[:, None], even])


def support_points(points: Array) -> Array:
    """Those of (n, 3) points [m] that are outermost in one of the `directions`, (k, 3), k <= 600; all are finite."""
    points = np.asarray(points, dtype=float)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) <= len(directions()):
        return np.unique(points, axis=0)
    kept = points
    while len(kept) > len(directions()):  # support points of the chunks, then of what they left
        chunks = [kept[k : k + _CHUNK] for k in range(0, len(kept), _CHUNK)]
        kept = np.vstack([chunk[np.unique((chunk @ directions().T).argmax(axis=0))] for chunk in chunks])
        if len(chunks) == 1:
            break
    return kept


def solid_hull(points: Array) -> Hull | None:
    """The convex hull of points, (n, 3) array [m]; None for a sheet, a line or fewer than four points."""
    if len(points) < 4:
        return None
    from scipy.spatial import ConvexHull, QhullError  # most files have no mesh, and the linter starts without SciPy

    try:
        found = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    vertices = points[found.vertices]
    diameter = float(np.ptp(vertices @ directions().T, axis=0).max())
    if not found.volume > _FLAT * diameter**3:
        return None
    middle = vertices.mean(axis=0)
    corners = points[found.simplices] - middle
    parts = np.abs(np.linalg.det(corners)) / 6.0  # tetrahedra from the middle to each face
    volume = float(parts.sum())
    sums = corners.sum(axis=1)
    shift = parts @ sums / (4.0 * volume)
    second = (np.einsum("f,fki,fkj->ij", parts, corners, corners) + np.einsum("f,fi,fj->ij", parts, sums, sums)) / (
        20.0 * volume
    )
    return Hull(vertices, found.equations, volume, middle + shift, second - np.outer(shift, shift), diameter)


def depth(hull: Hull, point: Array) -> float:
    """Signed distance [m] of a point from the hull's faces: below 0 inside, outside at least this far away."""
    return float((hull.planes[:, :3] @ point + hull.planes[:, 3]).max())


def gap(one: Hull, other: Hull, pose: Array) -> float:
    """Distance [m] between two hulls along the best of the directions; at most the true one, 0 where they meet.

    `pose` (4, 4) is that of the other hull's frame in the frame of the first.
    """
    if depth(one, pose[:3, 3]) <= 0.0 and depth(other, np.zeros(3)) <= 0.0:  # the joint lies inside both
        return 0.0
    return _gap(one, other, pose.tobytes())


@lru_cache(maxsize=4096)
def _gap(one: Hull, other: Hull, pose_bytes: bytes) -> float:
    """`gap`, kept for the neighbours that two files have in common."""
    pose: Array = np.frombuffer(pose_bytes).reshape(4, 4)
    moved = other.vertices @ pose[:3, :3].T + pose[:3, 3]
    between = moved.mean(axis=0) - one.vertices.mean(axis=0)
    length = float(np.linalg.norm(between))
    ways = np.vstack([directions(), between[None] / length]) if length > 0.0 else directions()
    apart = (moved @ ways.T).min(axis=0) - (one.vertices @ ways.T).max(axis=0)
    return float(max(apart.max(), 0.0))


def reach_along(hull: Hull, axes: Array, origin: Array) -> tuple[Array, Array]:
    """How far the hull reaches from a point, back and forth along axes (the columns of (3, k)): two (k,) arrays [m]."""
    along = (hull.vertices - origin) @ axes
    return -along.min(axis=0), along.max(axis=0)


_SCHEMES = ("package://", "model://")
REMOTE = ("http://", "https://")


@dataclass(frozen=True, slots=True)
class MeshPath:
    """Where a mesh lies; without `path` it is not there, or its package is not."""

    path: Path | None
    package_missing: str = ""
    """The package whose folder is not on this machine."""
    expected: Path | None = None
    """Where the file should be, if that is known."""


def mesh_path(mesh: str, document: Path) -> MeshPath:
    """The file of a mesh, named as in the URDF `document`.

    `package://NAME/...` is looked for in folders named NAME above the URDF and beside these, and in ROS_PACKAGE_PATH
    and AMENT_PREFIX_PATH; where there is none, in the folders above under the rest of the name.
    """
    if "\0" in mesh or mesh.startswith(REMOTE):
        return MeshPath(None)
    if not mesh.startswith(_SCHEMES):
        local = Path(document).parent / unquote(mesh.removeprefix("file://"))
        return _there(local)
    package, _, rest = mesh.partition("://")[2].partition("/")
    folder = package_folder(package, document)
    if folder is not None:
        return _there(folder / rest)
    for above in document.resolve().parents:
        if rest and (above / rest).is_file():
            return MeshPath(above / rest)
    return MeshPath(None, package_missing=package)


def _there(path: Path) -> MeshPath:
    try:
        return MeshPath(path if path.is_file() else None, expected=path)
    except OSError:  # a name longer than the file system takes
        return MeshPath(None, expected=path)


_MARK = b"lwr_dyn hull 1\n"
_LARGEST_KEPT = 100_000
"""[bytes] of one file: 600 points need 14 400."""


def folder() -> Path:
    """The folder `hulls` beside the kernels; raises `FileAccessError` where there is no home folder."""
    return cache_folder() / "hulls"


def kept_points(key: str) -> Array | None:
    """The points kept under a key, (k, 3) array [m]; None without any, or with a damaged file."""
    try:
        path = folder() / f"{key}.points"
        is_ours = not path.is_symlink() and path.stat().st_size <= _LARGEST_KEPT
        content = path.read_bytes() if is_ours else b""
    except (OSError, FileAccessError):
        return None
    digest, data = content[len(_MARK) : len(_MARK) + 32], content[len(_MARK) + 32 :]
    if not content.startswith(_MARK) or digest != _digest(key, data) or len(data) % 24:
        return None
    points = np.frombuffer(data, dtype="<f8").reshape(-1, 3).astype(float)
    return points if np.isfinite(points).all() else None


def keep_points(key: str, points: Array) -> None:
    """Keep points, (k, 3) array [m], under a key."""
    data = np.ascontiguousarray(points, dtype="<f8").tobytes()
    try:
        cache_folder().mkdir(mode=0o700, parents=True, exist_ok=True)  # parents of a folder get the rights of the umask
        folder().mkdir(mode=0o700, exist_ok=True)
        write_in_place(folder() / f"{key}.points", _MARK + _digest(key, data) + data)
    except (OSError, FileAccessError):
        return


def _digest(key: str, data: bytes) -> bytes:
    """Ties the numbers to the mesh they were taken from; nothing that is read is ever run."""
    return hashlib.sha256(key.encode() + data).digest()


OTHER_FORMAT = "format"
FORMATS = (".stl", ".obj", ".dae")
_LARGEST = 256_000_000
"""[bytes] of one mesh file."""
_UNIT = re.compile(rb"<unit\b[^>]*?\bmeter\s*=\s*[\"']([^\"']+)[\"']")


class MeshPointsError(Exception):
    """Why a mesh gives no points: for findings, never seen by a user as an error."""


@dataclass(frozen=True, slots=True, eq=False)
class MeshPoints:
    """The outermost points of a mesh file, (k, 3) array [m], and the digest of its content."""

    digest: str
    points: Array


def mesh_points(path: Path) -> MeshPoints:
    """The outermost points of a mesh file.

    Raises `MeshPointsError` for one that cannot be read as the mesh its ending says, or without points.
    """
    try:
        state = path.stat()
    except OSError as fault:
        raise MeshPointsError(str(fault.strerror)) from None
    found = _points(str(path), state.st_mtime_ns, state.st_size)
    if isinstance(found, str):
        raise MeshPointsError(found)
    return found


@lru_cache(maxsize=2048)
def _points(path: str, changed: int, size: int) -> MeshPoints | str:
    """The points, or why there are none; asked again when the file has changed."""
    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        return f"{OTHER_FORMAT} {ending or 'without an ending'} is not read (read are {', '.join(FORMATS)})"
    try:
        content = read_bytes(path, "a mesh file", _LARGEST)
    except FileAccessError as fault:
        return fault.reason
    digest = hashlib.sha256(ending.encode() + content).hexdigest()
    points = kept_points(digest)
    if points is None:
        try:
            with _quiet():
                points = support_points(_read(content, ending))
        except Exception as fault:  # whatever a parser of three formats raises on a damaged file
            return f"not a readable {ending[1:].upper()} file ({type(fault).__name__})"
        keep_points(digest, points)
    return MeshPoints(digest, points) if len(points) else "without points"


@contextmanager
def _quiet() -> Iterator[None]:
    """Without trimesh's log, which prints a traceback for a texture that is not there."""
    log = logging.getLogger("trimesh")
    before, log.disabled = log.disabled, True
    try:
        yield
    finally:
        log.disabled = before


def _read(content: bytes, ending: str) -> Array:
    """All vertices of a mesh in metres, each part where the file's own scene puts it: (n, 3) array."""
    import trimesh

    options: dict[str, Any] = {"skip_materials": True} if ending == ".obj" else {}
    scene = trimesh.load_scene(BytesIO(content), file_type=ending[1:], process=False, **options)
    parts = []
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        vertices = np.asarray(cast(Any, scene.geometry[name]).vertices, dtype=float).reshape(-1, 3)
        parts.append(vertices @ pose[:3, :3].T + pose[:3, 3])
    points = np.vstack(parts) if parts else np.zeros((0, 3))
    return points * (_unit(content) if ending == ".dae" else 1.0)


def _unit(content: bytes) -> float:
    """Metres per unit of a DAE file; 1 where it is not stated."""
    stated = _UNIT.search(content[:100_000])
    return float(stated[1]) if stated else 1.0
