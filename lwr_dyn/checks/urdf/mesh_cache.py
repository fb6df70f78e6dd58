"""Outermost points of meshes on disk, by the digest of the mesh file: plain numbers, checked when read.

A damaged or foreign file is passed over and written again; a folder that cannot be written costs only time.
"""

import hashlib
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import cache_folder, write_file

_MARK = b"lwr_dyn hull 1\n"
_LARGEST = 100_000
"""[bytes] of one file: 600 points need 14 400."""


def folder() -> Path:
    """The folder `hulls` beside the kernels; raises `FileAccessError` where there is no home folder."""
    return cache_folder() / "hulls"


def kept_points(key: str) -> Array | None:
    """The points kept under a key, (k, 3) array [m]; None without any, or with a damaged file."""
    try:
        path = folder() / f"{key}.points"
        content = path.read_bytes() if path.stat().st_size <= _LARGEST else b""
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
        write_file(folder() / f"{key}.points", _MARK + _digest(key, data) + data)
    except (OSError, FileAccessError):
        return


def _digest(key: str, data: bytes) -> bytes:
    """Ties the numbers to the mesh they were taken from; nothing that is read is ever run."""
    return hashlib.sha256(key.encode() + data).digest()
