"""The outermost points of mesh files.

STL, OBJ and DAE are read by trimesh. A DAE states its unit, which readers of URDFs apply (its up axis they do not).
The outermost points are kept by the content of the file: in memory, and in the user's cache folder as numbers alone.
"""

import hashlib
import re
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import Any, cast

import numpy as np

from lwr_dyn.checks.urdf.hulls import support_points
from lwr_dyn.checks.urdf.mesh_cache import keep_points, kept_points
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import read_bytes

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

    Raises
    ------
    MeshPointsError
        A file that cannot be read as the mesh its ending says, or without points.
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
            points = support_points(_read(content, ending))
        except Exception as fault:  # whatever a parser of three formats raises on a damaged file
            return f"not a readable {ending[1:].upper()} file ({type(fault).__name__})"
        keep_points(digest, points)
    return MeshPoints(digest, points) if len(points) else "without points"


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
