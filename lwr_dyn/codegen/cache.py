"""Compiled kernels on disk: one file each, written whole or not at all, its digest checked before it is run.

Two processes that compile the same kernel write the same file, each under a temporary name and then renamed; a killed
process leaves at most a temporary file, which is deleted later. A damaged file is built again.
"""

import hashlib
import json
import os
import sys
import time
import warnings
from pathlib import Path
from typing import Any

from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import write_file

_MARK = b"lwr_dyn kernel 1\n"
_LEFT_OVER = 3600.0
"""[s] An unfinished file older than this belongs to a killed process."""
_warned: set[str] = set()


class CacheWarning(UserWarning):
    """Compiled kernels cannot be kept in a file; every process compiles them again."""

    def __init__(self, folder: str, reason: str) -> None:
        super().__init__(
            f"compiled kernels cannot be kept in {folder} ({reason}): this process compiles its own; "
            "name another folder in LWR_DYN_CACHE"
        )
        self.folder, self.reason = folder, reason


def cache_folder() -> Path:
    """The folder of kernels: LWR_DYN_CACHE, or lwr_dyn in the user's cache folder (XDG_CACHE_HOME, ~/.cache ...)."""
    if chosen := os.environ.get("LWR_DYN_CACHE"):
        return Path(chosen)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "lwr_dyn"


def read_cache(key: str) -> tuple[dict[str, Any], bytes] | None:
    """Record and code of the kernel of that key; None without one, or with a damaged one."""
    try:
        content = (cache_folder() / f"{key}.kernel").read_bytes()
    except OSError:
        return None
    digest, rest = content[len(_MARK) : len(_MARK) + 65], content[len(_MARK) + 65 :]
    if not content.startswith(_MARK) or digest != _digest(rest):
        return None
    text, _, code = rest.partition(b"\n")
    record: dict[str, Any] = json.loads(text)
    return record, code


def write_cache(key: str, record: dict[str, Any], code: bytes) -> None:
    """Write a kernel; a folder that cannot be written is warned of once."""
    folder = cache_folder()
    rest = json.dumps(record).encode() + b"\n" + code
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_file(folder / f"{key}.kernel", _MARK + _digest(rest) + rest)
        _sweep(folder)
    except (OSError, FileAccessError) as fault:
        if str(folder) not in _warned:
            _warned.add(str(folder))
            reason = getattr(fault, "reason", None) or getattr(fault, "strerror", None) or str(fault)
            warnings.warn(CacheWarning(str(folder), str(reason).lower()), stacklevel=2)


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode() + b"\n"


def _sweep(folder: Path) -> None:
    """Delete the temporary files of killed processes."""
    for path in folder.glob(".*.kernel.*"):
        try:
            if time.time() - path.stat().st_mtime > _LEFT_OVER:
                path.unlink()
        except OSError:  # another process was quicker
            continue
