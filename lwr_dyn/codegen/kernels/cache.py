"""Compiled kernels on disk: one file each, written whole or not at all, its keyed digest checked before it is run.

Machine code is run only from a folder and a file that belong to this user and that no other can write, and only when it
was signed with this user's key (`key`, mode 0600, in the user's own cache folder): what came from elsewhere is built
again. Two processes that compile the same kernel write the same file, each under a temporary name and then renamed; a
killed process leaves at most a temporary file, which is deleted later. A damaged file is built again.
"""

import errno
import hmac
import json
import os
import secrets
import stat
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import LEFT_OVER, cache_folder, user_folder, write_file

_MARK = b"lwr_dyn kernel 2\n"
_warned: set[str] = set()


class CacheWarning(UserWarning):
    """Compiled kernels cannot be kept in a file; every process compiles them again."""

    def __init__(self, folder: str, reason: str) -> None:
        super().__init__(
            f"compiled kernels cannot be kept in {folder} ({reason}): this process compiles its own; "
            "name another folder in LWR_DYN_CACHE"
        )
        self.folder, self.reason = folder, reason


def read_cache(key: str) -> tuple[dict[str, Any], bytes] | None:
    """Record and code of the kernel of that key; None without one, or with a damaged or a foreign one."""
    try:
        _refuse_foreign(cache_folder())
        content = _own_bytes(cache_folder() / f"{key}.kernel")
        digest, rest = content[len(_MARK) : len(_MARK) + 65], content[len(_MARK) + 65 :]
        if not content.startswith(_MARK) or not hmac.compare_digest(digest, _digest(rest)):
            return None
        text, _, code = rest.partition(b"\n")
        record = json.loads(text)
    except (OSError, FileAccessError, ValueError, RecursionError):
        return None
    return (record, code) if isinstance(record, dict) else None


def write_cache(key: str, record: dict[str, Any], code: bytes) -> None:
    """Write a kernel; a folder that cannot be written is warned of once."""
    folder = Path("~")
    rest = json.dumps(record).encode() + b"\n" + code
    try:
        folder = cache_folder()
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        _refuse_foreign(folder)
        write_file(folder / f"{key}.kernel", _MARK + _digest(rest) + rest)
        _sweep(folder)
    except (OSError, FileAccessError) as fault:
        if str(folder) not in _warned:
            _warned.add(str(folder))
            reason = getattr(fault, "reason", None) or getattr(fault, "strerror", None) or str(fault)
            warnings.warn(CacheWarning(str(folder), str(reason).lower()), stacklevel=2)


def _digest(content: bytes) -> bytes:
    return hmac.digest(_user_key(), content, "sha256").hex().encode() + b"\n"


def _user_key() -> bytes:
    """This user's secret of 32 bytes, made when it is not there; raises `OSError` or `FileAccessError`."""
    path = user_folder() / "key"
    if not path.exists():
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        handle, made = tempfile.mkstemp(dir=path.parent, prefix=".key.")  # mode 0600
        with os.fdopen(handle, "wb") as stream:
            stream.write(secrets.token_bytes(32))
        try:
            os.link(made, path)  # of two processes the first one's stays
        except FileExistsError:
            pass
        finally:
            os.unlink(made)
    secret = _own_bytes(path, 0o077)
    if len(secret) != 32:
        raise FileAccessError(str(path), f"{len(secret)} bytes", "32 secret bytes: delete it, and it is made again")
    return secret


def _own_bytes(path: Path, refused: int = 0o022) -> bytes:
    """The content of a regular file of this user without those rights of others; raises `OSError` otherwise."""
    with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as stream:
        found = os.fstat(stream.fileno())
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "not a regular file", str(path))
        _refuse_others(found, path, refused)
        return stream.read()


def _refuse_foreign(folder: Path) -> None:
    _refuse_others(os.stat(folder), folder, 0o022)


def _refuse_others(found: os.stat_result, path: Path, refused: int) -> None:
    """Raise `PermissionError` for what another user owns, or has one of the refused rights to."""
    if hasattr(os, "getuid") and (found.st_uid != os.getuid() or found.st_mode & refused):
        rights = f"owner {found.st_uid}, mode {found.st_mode & 0o777:03o}"
        raise PermissionError(errno.EPERM, f"{path.name} is open to others: {rights}", str(path))


def _sweep(folder: Path) -> None:
    """Delete the temporary files of killed processes."""
    for path in folder.glob(".*.kernel.*"):
        try:
            if time.time() - path.stat().st_mtime > LEFT_OVER:
                path.unlink()
        except OSError:  # another process was quicker
            continue
