"""Files are written under a temporary name and renamed: a kill leaves the old file or none."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from lwr_dyn.errors import FileAccessError


def write_file(path: str | Path, data: str | bytes) -> None:
    """Write text (UTF-8) or bytes, whole or not at all; raises `FileAccessError` when the place cannot be written."""
    target = Path(path)
    content = data.encode("utf-8") if isinstance(data, str) else data
    temporary = None
    try:
        if target.is_dir():
            raise IsADirectoryError(21, "is a directory")
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, target)
    except OSError as fault:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
        reason = (fault.strerror or str(fault)).lower()
        raise FileAccessError(str(path), reason, "a file in an existing, writable directory") from None


def check_writable(path: str | Path) -> None:
    """Raise `FileAccessError` now, before long work, when a file could not be written there later."""
    target = Path(path)
    if target.is_dir():
        raise FileAccessError(str(path), "is a directory", "a file in an existing, writable directory")
    if not (target.parent.is_dir() and os.access(target.parent, os.W_OK | os.X_OK)):
        raise FileAccessError(
            str(path), f"cannot write in {target.parent}", "a file in an existing, writable directory"
        )


def write_folder(folder: str | Path, files: Mapping[str, str | bytes]) -> None:
    """Write several files into a folder, made if missing; raises `FileAccessError`."""
    make_folder(folder)
    for name, data in files.items():
        write_file(Path(folder) / name, data)


def make_folder(folder: str | Path) -> Path:
    """The folder, made if missing; raises `FileAccessError` when it cannot be."""
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        raise FileAccessError(str(folder), reason, "a directory that can be made and written") from None
    return Path(folder)
