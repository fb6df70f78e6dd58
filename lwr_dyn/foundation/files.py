"""Reads files with one clear error; writes files under a temporary name and renames them: none is ever incomplete."""

import contextlib
import glob
import os
import stat
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError

LARGEST = 64_000_000
"""[bytes] The longest file that is read as a whole: a table, a model, a program. Logs and runs have their own."""
LEFT_OVER = 3600.0
"""[s] An unfinished file older than this belongs to a killed process."""
_WRITABLE = "a file in an existing, writable directory"


def read_text(path: str | Path, needed: str, encoding: str = "utf-8", largest: int = LARGEST) -> str:
    """A file as text; raises `FileAccessError` as `read_bytes` and when it is not UTF-8."""
    try:
        return read_bytes(path, needed, largest).decode(encoding)
    except UnicodeDecodeError:
        raise FileAccessError(str(path), "not UTF-8 text", needed) from None


def read_bytes(path: str | Path, needed: str, largest: int = LARGEST) -> bytes:
    """The content of a file; raises `FileAccessError` when it cannot be read or has more than `largest` bytes."""
    check_readable(path, needed, largest)
    try:
        return Path(path).read_bytes()
    except OSError as fault:
        raise FileAccessError(str(path), reason_of(fault), needed) from None


def check_readable(path: str | Path, needed: str, largest: int | None = None) -> None:
    """Raise `FileAccessError` for what is no regular file (a pipe may never end), is not there, or is too long."""
    try:
        found = os.stat(path)
    except OSError as fault:
        raise FileAccessError(str(path), reason_of(fault), needed) from None
    except ValueError:
        raise FileAccessError(repr(str(path)), "a null character", needed) from None
    if stat.S_ISDIR(found.st_mode):
        raise FileAccessError(str(path), "is a directory", needed)
    if not stat.S_ISREG(found.st_mode):
        raise FileAccessError(str(path), "a pipe or a device", f"a regular file: {needed}")
    if largest is not None and found.st_size > largest:
        raise FileAccessError(str(path), f"{found.st_size} bytes", f"at most {largest} bytes")


def ends_in(path: object, *endings: str) -> bool:
    """Whether a path ends in one of these, in upper or lower case.

    >>> ends_in("ARM.URDF", ".urdf")
    True
    """
    return str(path).lower().endswith(endings)


def reason_of(fault: OSError) -> str:
    """The system's reason in lower case: "no such file or directory"."""
    return (fault.strerror or str(fault)).lower()


def write_file(path: str | Path, data: str | bytes) -> None:
    """Write text (UTF-8) or bytes, completely or not at all; raises `FileAccessError`."""
    write_files({Path(path): data})


def write_files(files: Mapping[Path, str | bytes]) -> None:
    """Write several files, all under temporary names before the first is renamed; raises `FileAccessError`.

    A link stays a link: the file that it names is written.
    """
    staged: list[tuple[str, Path]] = []
    target = Path()
    for path in files:
        check_writable(path)
    try:
        for target, data in ((Path(os.path.realpath(path)), data) for path, data in files.items()):
            _sweep(target)
            handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.", suffix=".part")
            staged.append((temporary, target))
            with os.fdopen(handle, "wb") as stream:
                stream.write(data.encode("utf-8") if isinstance(data, str) else data)
            os.chmod(temporary, target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask())
        while staged:
            temporary, target = staged[0]
            os.replace(temporary, target)
            staged.pop(0)
    except OSError as fault:
        raise FileAccessError(str(target), reason_of(fault), _WRITABLE) from None
    finally:
        for temporary, _ in staged:
            Path(temporary).unlink(missing_ok=True)


def write_in_place(path: Path, data: str | bytes) -> None:
    """As `write_file`, but a link is replaced: nothing outside a folder of ours is written through it."""
    with contextlib.suppress(OSError):
        if path.is_symlink():
            path.unlink()
    write_file(path, data)


def _sweep(target: Path) -> None:
    """Delete what killed processes have left of this file."""
    for path in target.parent.glob(f".{glob.escape(target.name)}.????????.part"):
        with contextlib.suppress(OSError):  # another process was quicker
            if time.time() - path.stat().st_mtime > LEFT_OVER:
                path.unlink()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def check_writable(path: str | Path, ending: str = "") -> None:
    """Raise `FileAccessError` now, before long work, when a file that ends so could not be written there later."""
    if not ends_in(path, ending):
        raise FileAccessError(str(path), f"does not end in {ending}", f"a path that ends in {ending}")
    try:
        target = Path(os.path.realpath(path))
        kind = target.stat().st_mode if target.exists() else stat.S_IFREG
    except OSError as fault:
        raise FileAccessError(str(path), reason_of(fault), _WRITABLE) from None
    except ValueError:
        raise FileAccessError(repr(str(path)), "a null character", _WRITABLE) from None
    if target.is_symlink():
        raise FileAccessError(str(path), "a link that leads to itself", _WRITABLE)
    if not stat.S_ISREG(kind):
        raise FileAccessError(str(path), "is a directory" if target.is_dir() else "a pipe or a device", _WRITABLE)
    if not target.parent.is_dir():
        raise FileAccessError(str(path), f"no directory {Path(path).parent}", _WRITABLE)
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise FileAccessError(str(path), f"no right to write in {target.parent}", _WRITABLE)


def write_folder(folder: str | Path, files: Mapping[str, str | bytes]) -> None:
    """Write several files into a folder, which is created if missing; raises `FileAccessError`."""
    place = make_folder(folder)
    write_files({place / name: data for name, data in files.items()})


def make_folder(folder: str | Path) -> Path:
    """The folder, created if missing; raises `FileAccessError`."""
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        allowed = "a directory that exists or can be made, and can be written"
        raise FileAccessError(str(folder), reason_of(fault), allowed) from None
    return Path(folder)


def cache_folder() -> Path:
    """The folder of kernels and hulls: LWR_DYN_CACHE, or `user_folder`; raises `FileAccessError` as that."""
    chosen = os.environ.get("LWR_DYN_CACHE")
    return Path(chosen) if chosen else user_folder()


def user_folder() -> Path:
    """lwr_dyn in the user's cache folder (XDG_CACHE_HOME, ~/.cache ...).

    Raises `FileAccessError` for a user without a home folder, such as a number alone in a container.
    """
    try:
        return _caches() / "lwr_dyn"
    except RuntimeError:
        raise FileAccessError("~", "no home folder", "a folder in HOME") from None


def _caches() -> Path:
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base)
