"""One compiled function of one form: from this process, from the cache, or built now."""

from __future__ import annotations

import hashlib
import os
from collections import deque
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields
from importlib.metadata import version
from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import numpy as np

from lwr_dyn.codegen import cache
from lwr_dyn.codegen.description import Description
from lwr_dyn.codegen.form import Form
from lwr_dyn.codegen.functions import function_shape
from lwr_dyn.errors import MissingPackageError

_ALIGNMENT = 64
_LEAST_PER_PART = 2048
"""States below which another thread costs more than it brings."""
_PARTS_PER_THREAD = 4
"""So that a thread that is held up leaves work to the others."""
_loaded: dict[str, Kernel] = {}
_pools: dict[int, ThreadPoolExecutor] = {}
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pools.clear)  # a child has none of its parent's threads


@dataclass(frozen=True, slots=True, eq=False)
class Kernel:
    """A compiled function over rows of states."""

    description: Description
    dtype: np.dtype[Any]
    code: Any

    def run(self, rows: Sequence[tuple[int, int]], out: int, count: int, threads: int = 1) -> int:
        """Rows 0 to `count`, given address and step (in numbers; 0 repeats one row) of each input; ungated.

        Returns the number of states with a value that is not finite or an angle beyond the kernel's limit, whose
        results mean nothing.
        """
        arguments = [x for pair in rows for x in pair]
        parts = self._parts(count, threads)
        if len(parts) == 1:
            return self._part(arguments, out, *parts[0])
        left = deque(parts)

        def work() -> int:
            found = 0
            while left:
                try:
                    part = left.popleft()
                except IndexError:  # another thread took the last one
                    break
                found += self._part(arguments, out, *part)
            return found

        others = [_pool(threads - 1).submit(work) for _ in range(threads - 1)]
        found = work()  # this thread too: a helper that wakes late finds less to do, one that sleeps on is let be
        return found + sum(other.result() for other in others if not other.cancel())

    def _parts(self, count: int, threads: int) -> list[tuple[int, int]]:
        """Whole blocks for every part."""
        used = 1 if threads == 1 else max(1, min(_PARTS_PER_THREAD * threads, count // _LEAST_PER_PART))
        blocks = -(-count // self.description.lanes)
        edges = [min(count, blocks * i // used * self.description.lanes) for i in range(used + 1)]
        return list(pairwise(edges))

    def _part(self, arguments: list[int], out: int, start: int, stop: int) -> int:
        room = np.empty(self.description.buffer * self.dtype.itemsize + _ALIGNMENT, dtype=np.uint8)
        address = room.__array_interface__["data"][0]
        return int(self.code.call(*arguments, out, address + -address % _ALIGNMENT, start, stop))


def _pool(threads: int) -> ThreadPoolExecutor:
    if threads not in _pools:
        _pools[threads] = ThreadPoolExecutor(threads, thread_name_prefix="lwr_dyn")
    return _pools[threads]


def require_packages() -> None:
    """Raise `MissingPackageError` unless the packages of the extra `batch` are there."""
    for package in ("numba", "casadi"):
        if find_spec(package) is None:
            raise MissingPackageError(package, "batch")


def key_of(form: Form, function: str) -> str:
    """Name of a kernel in the cache: the arm's data, the generator, the compiler and the machine."""
    from lwr_dyn.codegen.machine import host, lanes_of

    text = [form.digest(function), *host(), str(lanes_of(form.dtype)), version("numba"), version("llvmlite")]
    return f"{function}-{hashlib.sha256(chr(10).join(text).encode()).hexdigest()[:40]}"


def kernel_of(form: Form, function: str) -> Kernel:
    """The kernel of a function, loaded or compiled.

    Parameters
    ----------
    form : Form
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
    key = key_of(form, function)
    kernel = _loaded.get(key)
    if kernel is None:
        kernel = _loaded[key] = _from_cache(form, key) or _built(form, function, key)
    return kernel


def _from_cache(form: Form, key: str) -> Kernel | None:
    found = cache.kept(key)
    if found is None:
        return None
    known, code = found
    symbol = known.pop("symbol", None)
    if symbol is None or known.keys() != {f.name for f in fields(Description)}:
        return None
    known["inputs"], known["widths"] = tuple(known["inputs"]), tuple(known["widths"])
    return _ready(form, Description(**known), symbol, code)


def _built(form: Form, function: str, key: str) -> Kernel:
    from lwr_dyn.codegen.build import compiled, generate

    source = generate(form, function)
    code, symbol = compiled(source)
    cache.keep(key, {"symbol": symbol} | asdict(source.description), code)
    return _ready(form, source.description, symbol, code)


def _ready(form: Form, description: Description, symbol: str, code: bytes) -> Kernel:
    from lwr_dyn.codegen.machine import load

    return Kernel(description, np.dtype(form.dtype), load(code, symbol, len(description.inputs)))


def thread_count(threads: int | None) -> int:
    """The number of threads meant: all processors for None."""
    return os.cpu_count() or 1 if threads is None else threads
