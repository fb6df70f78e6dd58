"""Memory of large results: what an array leaves when its last view is gone serves the next one of the same size.

The system clears every page of new memory: for 40 MB that takes three times as long as the kernel that fills it.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

ALIGNMENT = 64
LEAST, MOST = 1 << 20, 1 << 28
"""Bytes of the smallest memory that is kept, and of all that is kept at a time."""
_kept: dict[int, list[NDArray[np.uint8]]] = {}
"""Size -> memory that waits. Single steps of lists and dicts alone: no thread sees them half done."""


class _Loan:
    """The owner of an array that NumPy did not make: it gives the memory back when no view holds it any more."""

    __slots__ = ("__array_interface__", "_memory")

    def __init__(self, memory: NDArray[np.uint8], size: int) -> None:
        place = memory.__array_interface__["data"][0]
        self.__array_interface__ = {
            "shape": (size,), "typestr": "|u1", "data": (place + -place % ALIGNMENT, False), "version": 3
        }  # fmt: skip
        self._memory = memory

    def __del__(self) -> None:
        size = self._memory.size
        if kept_bytes() + size > MOST:
            _kept.clear()
        if LEAST <= size <= MOST:
            _kept.setdefault(size, []).append(self._memory)


def kept_bytes() -> int:
    """All that waits now."""
    return sum(size * len(waiting) for size, waiting in _kept.copy().items())


def result_memory(shape: tuple[int, ...], dtype: str) -> NDArray[Any]:
    """An array that begins on a cache line, its numbers not set; it may take the memory of one that is gone."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    try:
        memory = _kept.get(size + ALIGNMENT, []).pop()
    except IndexError:
        memory = np.empty(size + ALIGNMENT, dtype=np.uint8)
    array: NDArray[Any] = np.asarray(_Loan(memory, size)).view(dtype).reshape(shape)
    return array
