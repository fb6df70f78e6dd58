"""Text in, its faults told; files out, under a temporary name and renamed: a kill leaves the old file or none."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from lwr_dyn.errors import FileAccessError


def read_text(path: str | Path, needed: str, encoding: str = "utf-8") -> str:
    """A file as text; raises `FileAccessError` when it cannot be read or is not UTF-8, saying what is needed."""
    try:
        return Path(path).read_bytes().decode(encoding)
    except UnicodeDecodeError:
        raise FileAccessError(str(path), "not UTF-8 text", needed) from None
    except OSError as fault:
        raise FileAccessError(str(path), (fault.strerror or str(fault)).lower(), needed) from None


def write_file(path: str | Path, data: str | bytes) -> None:
    """Write text (UTF-8) or bytes, whole or not at all; raises `FileAccessError` when the place cannot be written."""
    write_files({Path(path): data})


def write_files(files: Mapping[Path, str | bytes]) -> None:
    """Write several files, all staged before the first is renamed; raises `FileAccessError` with none of them there."""
    staged: list[tuple[str, Path]] = []
    target = Path()
    try:
        for target, data in files.items():
            if target.is_dir():
                raise IsADirectoryError(21, "is a directory")
            handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
            staged.append((temporary, target))
            with os.fdopen(handle, "wb") as stream:
                stream.write(data.encode("utf-8") if isinstance(data, str) else data)
            os.chmod(temporary, 0o666 & ~_umask())
        while staged:
            temporary, target = staged[0]
            os.replace(temporary, target)
            staged.pop(0)
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        raise FileAccessError(str(target), reason, "a file in an existing, writable directory") from None
    finally:
        for temporary, _ in staged:
            Path(temporary).unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


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
    place = make_folder(folder)
    write_files({place / name: data for name, data in files.items()})


def make_folder(folder: str | Path) -> Path:
    """The folder, made if missing; raises `FileAccessError` when it cannot be."""
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        raise FileAccessError(str(folder), reason, "a directory that can be made and written") from None
    return Path(folder)
