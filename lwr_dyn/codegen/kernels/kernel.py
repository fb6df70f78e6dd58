"""A compiled function: of this process, from the cache on disk, or built now.

A kernel on disk is one file, written whole or not at all, its keyed digest checked before it is run. Machine code is
run only from a folder and a file that belong to this user and that no other can write, and only when it was signed with
this user's key (`key`, mode 0600, in the user's own cache folder), together with its name: what came from elsewhere,
another kernel under this name, and a link are built again. Two
processes that compile the same kernel write the same file, each under a temporary name and then renamed; a killed
process leaves at most a temporary file, which is deleted later. A damaged file is built again.
"""

from __future__ import annotations

import errno
import hashlib
import hmac
import json
import os
import secrets
import stat
import tempfile
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.kernel_spec import KernelInterface, KernelSpec, function_shape
from lwr_dyn.foundation.errors import FileAccessError, MissingPackageError
from lwr_dyn.foundation.files import LEFT_OVER, cache_folder, user_folder, write_in_place
from lwr_dyn.foundation.version import package_version

T = TypeVar("T")

_MARK = b"lwr_dyn kernel 3\n"

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
        if not content.startswith(_MARK) or not hmac.compare_digest(digest, _digest(key, rest)):
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
        write_in_place(folder / f"{key}.kernel", _MARK + _digest(key, rest) + rest)
        _sweep(folder)
    except (OSError, FileAccessError) as fault:
        if str(folder) not in _warned:
            _warned.add(str(folder))
            reason = getattr(fault, "reason", None) or getattr(fault, "strerror", None) or str(fault)
            warnings.warn(CacheWarning(str(folder), str(reason).lower()), stacklevel=2)


def _digest(key: str, content: bytes) -> bytes:
    """Ties the code to this user and to the name of the kernel, in which all that it depends on is digested."""
    return hmac.digest(_user_key(), key.encode() + b"\n" + content, "sha256").hex().encode() + b"\n"


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
    """The content of a regular file, no link, of this user, without those rights of others; or raises `OSError`."""
    with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0)), "rb") as stream:
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


_ALIGNMENT = 64

_LEAST_PER_PART = 2048
"""With fewer states in a part, another thread costs more time than it saves."""

_PARTS_PER_THREAD = 4
"""More parts than threads, so that the others take over the work of a slow one."""

_loaded: dict[str, Kernel] = {}

_pools: dict[int, ThreadPoolExecutor] = {}

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pools.clear)  # a forked child has no threads


@dataclass(frozen=True, slots=True, eq=False)
class Kernel:
    """A compiled function over rows of states."""

    interface: KernelInterface
    dtype: np.dtype[Any]
    code: Any

    def run(self, rows: Sequence[tuple[int, int]], out: int, count: int, threads: int = 1) -> int:
        """Compute rows 0 to `count` from the address and step (in numbers; 0 repeats one row) of each input; ungated.

        Returns the number of states with a value that is not finite or an angle beyond the kernel's limit, whose
        results are invalid.
        """
        arguments = [x for pair in rows for x in pair]
        lanes, used = self.interface.lanes, 1
        if threads > 1:
            used = max(1, min(_PARTS_PER_THREAD * threads, count // _LEAST_PER_PART))
        blocks = -(-count // lanes)
        parts = list(pairwise(min(count, blocks * i // used * lanes) for i in range(used + 1)))  # whole blocks
        if len(parts) == 1:
            return self._part(arguments, out, *parts[0])
        return shared_out(parts, lambda part: self._part(arguments, out, *part), threads)

    def _part(self, arguments: list[int], out: int, start: int, stop: int) -> int:
        buffer, place = aligned(self.interface.buffer * self.dtype.itemsize)
        invalid = int(self.code.call(*arguments, out, place, start, stop))
        del buffer
        return invalid


def shared_out(parts: Iterable[T], task: Callable[[T], int], threads: int) -> int:
    """The sum of what a task gives for each part, over threads: each takes the next part when it has done one."""
    left = deque(parts)

    def work() -> int:
        total = 0
        while left:
            try:
                part = left.popleft()
            except IndexError:  # another thread took the last one
                break
            total += task(part)
        return total

    if threads == 1:
        return work()
    if threads not in _pools:
        _pools[threads] = ThreadPoolExecutor(threads - 1, thread_name_prefix="lwr_dyn")
    others = [_pools[threads].submit(work) for _ in range(threads - 1)]
    total = work()  # this thread works too; threads that have not begun by the end are cancelled
    return total + sum(other.result() for other in others if not other.cancel())


MAKERS = ("llvmlite", "mpmath")
"""Packages on which the machine code depends; mpmath finds the polynomials of sin, cos, exp and log."""

_codes: dict[str, Any] = {}

_building = threading.Lock()


def address(array: NDArray[Any]) -> int:
    """Where the numbers of an array begin in memory."""
    return int(array.__array_interface__["data"][0])


def aligned(size: int) -> tuple[NDArray[np.uint8], int]:
    """Memory for `size` bytes, and the address in it at which a vector may begin."""
    memory = np.empty(size + _ALIGNMENT, dtype=np.uint8)
    return memory, address(memory) + -address(memory) % _ALIGNMENT


def cache_name(kind: str, text: Iterable[str]) -> str:
    """Name of a kernel in the cache, from all on which it depends."""
    return f"{kind}-{hashlib.sha256(chr(10).join(text).encode()).hexdigest()[:40]}"


def kept_code(key: str, made: Callable[[], bytes], inputs: int) -> Any:
    """The `LoadedCode` of that key: of this process, from the cache, or of the object code `made` now."""
    from lwr_dyn.codegen.kernels.machine_code import load

    with _building:
        if key not in _codes:
            _, code = _record_and_code(key, set(), lambda: (made(), {}))
            _codes[key] = load(code, "kernel", inputs)
        return _codes[key]


def _record_and_code(
    key: str, names: set[str], made: Callable[[], tuple[bytes, dict[str, Any]]]
) -> tuple[dict[str, Any], bytes]:
    """A record of these names, and the object code of a function `kernel`: from the cache, or made now."""
    kept = read_cache(key)
    if kept is not None and kept[0].keys() == names:
        return kept
    code, record = made()
    write_cache(key, record, code)
    return record, code


def require_packages() -> None:
    """Raise `MissingPackageError` unless the packages of the extra `batch` are installed."""
    for package in ("llvmlite", "casadi", "mpmath"):
        if find_spec(package) is None:
            raise MissingPackageError(package, "batch")


def key_of(spec: KernelSpec, function: str) -> str:
    """Name of a kernel in the cache, from the arm's data, the generator, the compiler and the processor."""
    from lwr_dyn.codegen.kernels.machine_code import host_cpu, lanes_of

    text = [spec.digest(function), *host_cpu(), str(lanes_of(spec.dtype)), *map(package_version, MAKERS)]
    return cache_name(function, text)


def kernel_of(spec: KernelSpec, function: str) -> Kernel:
    """The kernel of a function, loaded or compiled.

    Parameters
    ----------
    spec : KernelSpec
    function : str

    Raises
    ------
    UnknownNameError
        No function of that name.
    MissingPackageError
        The extra `batch` is not installed.
    """
    function_shape(function)
    require_packages()
    from lwr_dyn.codegen.kernels.machine_code import load

    key = key_of(spec, function)
    kernel = _loaded.get(key)
    if kernel is None:
        record, code = _record_and_code(key, {f.name for f in fields(KernelInterface)}, lambda: _made(spec, function))
        values: dict[str, Any] = {name: tuple(x) if isinstance(x, list) else x for name, x in record.items()}
        interface = KernelInterface(**values)
        kernel = _loaded[key] = Kernel(interface, np.dtype(spec.dtype), load(code, "kernel", len(interface.inputs)))
    return kernel


def _made(spec: KernelSpec, function: str) -> tuple[bytes, dict[str, Any]]:
    from lwr_dyn.codegen.kernels.kernel_source import generate

    source = generate(spec, function)
    return source.loop.around(source.body).machine_code(), asdict(source.interface)
