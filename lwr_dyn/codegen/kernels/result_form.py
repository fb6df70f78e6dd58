"""How results of a batch lie in memory, and which entries of a matrix are computed and stored at all.

Memory of a large result serves the next one of its size when its last view is gone: the system clears every page of new
memory, which for 40 MB takes three times as long as the kernel that fills it.
"""

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.errors import OptionError, ShapeError

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


Layout = Literal["rows", "padded", "blocks"]

Structure = Literal["dense", "compact"]

LAYOUTS, STRUCTURES = get_args(Layout), get_args(Structure)

LARGE = 4096
"""From that many states rows begin on a cache line too, so that they can be written past the caches."""


@dataclass(frozen=True, slots=True, eq=False)
class MatrixEntries:
    """Which stored value every entry of a matrix is: structure="compact" stores each value once, constants never.

    entry = sign values[index], or its constant where the sign is 0.
    """

    index: NDArray[np.int64]
    """Shape of the matrix."""
    sign: NDArray[np.int64]
    constant: NDArray[np.float64]
    count: int
    """Values stored for a state."""

    def dense(self, values: NDArray[Any]) -> NDArray[Any]:
        """The whole matrices (..., shape) from stored values (..., count); raises `ShapeError`."""
        if values.shape[-1:] != (self.count,):
            raise ShapeError("values", f"shape {values.shape}", f"(..., {self.count})")
        if not self.count:
            return np.broadcast_to(self.constant.astype(values.dtype), (*values.shape[:-1], *self.index.shape)).copy()
        entries: NDArray[Any] = values[..., self.index] * self.sign.astype(values.dtype)
        return np.where(self.sign == 0, self.constant.astype(values.dtype), entries)


def matrix_entries(entries: tuple[int, ...], constants: tuple[float, ...], shape: tuple[int, ...]) -> MatrixEntries:
    """As `straight_line.compact` gives them, in the shape of the matrix."""
    places = np.array(entries, dtype=np.int64).reshape(shape)
    index = np.maximum(np.abs(places) - 1, 0)
    return MatrixEntries(index, np.sign(places), np.array(constants).reshape(shape), int(np.abs(places).max(initial=0)))


def row_step(layout: str, width: int, lanes: int) -> int:
    """Numbers from one state's result to the next one's: of padded rows, whole vectors."""
    return -(-width // lanes) * lanes if layout == "padded" else width


@dataclass(frozen=True, slots=True)
class ResultForm:
    """How the results of many states lie in one array.

    rows: (N, *shape). padded: the same, but every state's numbers begin on a whole vector. blocks: (blocks, *shape, W),
    W states side by side; the last block repeats the last state.
    """

    layout: str
    shape: tuple[int, ...]
    """Of one result."""
    lanes: int
    """W."""
    dtype: str

    def shape_of(self, count: int) -> tuple[int, ...]:
        """The shape of the array for that many states."""
        if self.layout == "blocks":
            return (-(-count // self.lanes), *self.shape, self.lanes)
        return (count, *self.shape)

    def empty(self, count: int) -> NDArray[Any]:
        """An array for the results of that many states."""
        if self.layout == "rows" and count < LARGE:
            return np.empty(self.shape_of(count), dtype=self.dtype)
        if self.layout != "padded":
            return result_memory(self.shape_of(count), self.dtype)
        whole = result_memory((count, row_step("padded", int(np.prod(self.shape)), self.lanes)), self.dtype)
        inner = np.empty((1, *self.shape), dtype=self.dtype).strides[1:]
        return np.lib.stride_tricks.as_strided(whole, (count, *self.shape), (whole.strides[0], *inner))

    def holds(self, out: NDArray[Any]) -> bool:
        """Whether an array of that shape lies in memory as `empty` makes it."""
        is_regular = out.strides == self.empty(1).strides if self.layout == "padded" else bool(out.flags.c_contiguous)
        vector = self.lanes * out.itemsize if self.layout != "rows" else 1
        return is_regular and out.__array_interface__["data"][0] % vector == 0

    def place_of(self, states: NDArray[np.int64]) -> tuple[Any, ...]:
        """The index of the results of states with these numbers."""
        return (states // self.lanes, ..., states % self.lanes) if self.layout == "blocks" else (states,)

    def states_first(self, result: NDArray[Any], count: int) -> NDArray[Any]:
        """The results of all states as (N, *shape); those of blocks are copied.

        >>> ResultForm("blocks", (2,), 2, "float64").states_first(np.arange(8.0).reshape(2, 2, 2), 3)
        array([[0., 2.],
               [1., 3.],
               [4., 6.]])
        """
        if self.layout != "blocks":
            return result
        return np.moveaxis(result, -1, 1).reshape(-1, *self.shape)[:count]


def check_form(layout: str, structure: str) -> None:
    """Raise `OptionError` for a layout or a structure that does not exist."""
    for option, value, allowed in (("layout", layout, LAYOUTS), ("structure", structure, STRUCTURES)):
        if value not in allowed:
            raise OptionError(option, repr(value), ", ".join(allowed))
