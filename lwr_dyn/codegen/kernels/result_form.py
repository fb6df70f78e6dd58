"""How results of a batch lie in memory, and which entries of a matrix are computed and stored at all.

Once all nodes of straight-line code are known, quotients become products with reciprocals and the unused are dropped.
Memory of a large result serves the next one of its size when its last view is gone: the system clears every page of new
memory, which for 40 MB takes three times as long as the kernel that fills it.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.errors import OptionError, ShapeError


class Value(NamedTuple):
    """A node with a sign."""

    sign: int
    node: int


class Node(NamedTuple):
    """`in` (row = array, column), `const` (its value), or an operation on nodes; of one node a = b.

    Beside + - * / and sqrt: > gives 1.0 or 0.0; min and max give the first where a node is NaN; ? gives b where a is
    1.0, else 0.0; abs; 2^ of a whole number; exponent e and significand m of 2^e m, 1 <= m < 2. sin and cos stand only
    in code for other languages, which call their library.
    """

    op: str
    a: Any
    b: Any = None


OPERATIONS = ("+", "-", "*", "/", ">", "sqrt", "min", "max", "?", "abs", "2^", "exponent", "significand",
              "sin", "cos")  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class StraightLineCode:
    """`nodes` in order, `results` as signed nodes, and a `flag` that marks invalid states.

    `flag` is 0 for a lane with finite inputs and angles that the range reduction accepts, NaN when an input (or a
    result that stands for it) is not finite, and above 0 for a finite angle that is too large.
    """

    nodes: tuple[Node, ...]
    results: tuple[Value, ...]
    flag: Value

    @property
    def operations(self) -> int:
        """Additions, products, quotients, comparisons and roots of one state."""
        return sum(node.op in OPERATIONS for node in self.nodes)

    def operations_after_contraction(self) -> int:
        """The same with fused multiply-add: a product that only one sum uses is not counted."""
        uses: dict[int, list[str]] = {}
        for node in self.nodes:
            if node.op in OPERATIONS:
                for i in {node.a, node.b}:
                    uses.setdefault(i, []).append(node.op)
        taken: set[int] = set()
        fused = 0
        for i, node in enumerate(self.nodes):
            if node.op in ("+", "-"):
                for operand in (node.a, node.b):
                    if i not in taken and self.nodes[operand].op == "*" and uses[operand] in (["+"], ["-"]):
                        fused, taken = fused + 1, taken | {i}
        return self.operations - fused


Traced = tuple[Sequence[Node], Sequence[Value], Value]
"""Nodes, results, flag."""


def by_reciprocals(nodes: Sequence[Node], results: Sequence[Value], flag: Value) -> Traced:
    """With x / d as x (1 / d) wherever d divides more than one number.

    A divider of a vector register takes as long as a dozen products. One quotient alone keeps its exact rounding.
    """
    divisors = Counter(node.b for node in nodes if node.op == "/")
    out: list[Node] = []
    new: list[int] = []
    one: dict[int, int] = {}

    def added(node: Node) -> int:
        out.append(node)
        return len(out) - 1

    for node in nodes:
        if node.op not in OPERATIONS:
            new.append(added(node))
            continue
        a, b = new[node.a], new[node.b]
        if node.op != "/" or divisors[node.b] == 1:
            new.append(added(Node(node.op, a, b)))
            continue
        if b not in one:
            one[b] = added(Node("/", added(Node("const", 1.0)), b))
        new.append(one[b] if out[a] == ("const", 1.0, None) else added(Node("*", *sorted((a, one[b])))))
    return out, [Value(v.sign, new[v.node]) for v in results], Value(flag.sign, new[flag.node])


def without_the_unused(nodes: Sequence[Node], results: Sequence[Value], flag: Value) -> StraightLineCode:
    """The code without operations that neither a result nor the flag needs."""
    needed = {value.node for value in (*results, flag)}
    for i in reversed(range(len(nodes))):
        if i in needed and nodes[i].op in OPERATIONS:
            needed |= {nodes[i].a, nodes[i].b}
    new: dict[int, int] = {}
    used: list[Node] = []
    for i, node in enumerate(nodes):
        if i in needed:
            new[i] = len(used)
            used.append(Node(node.op, new[node.a], new[node.b]) if node.op in OPERATIONS else node)
    renumbered = [Value(v.sign, new[v.node]) for v in results]
    return StraightLineCode(tuple(used), tuple(renumbered), Value(flag.sign, new[flag.node]))


_PASSING = {"+": 2, "-": 2, "*": 2, "/": 1, "sqrt": 1, "abs": 1}
"""Operations that give no finite number where one of their first so many operands is not finite."""


def reached_inputs(nodes: Sequence[Node]) -> list[int]:
    """For every node the inputs that make it not finite where they are not finite themselves: bit i for node i."""
    reached: list[int] = []
    for i, node in enumerate(nodes):
        passing = (node.a, node.b)[: _PASSING.get(node.op, 0)]
        reached.append(1 << i if node.op == "in" else reduce(or_, (reached[j] for j in passing), 0))
    return reached


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


def compact(code: StraightLineCode) -> tuple[StraightLineCode, tuple[int, ...], tuple[float, ...]]:
    """Code with every distinct result once, without constants; for each result its place, constants of the others.

    Places count from 1, negative where the sign is turned; 0 is a constant.
    """
    places: dict[int, int] = {}
    entries, constants = [], []
    for value in code.results:
        node = code.nodes[value.node]
        is_constant = node.op == "const"
        constants.append(value.sign * node.a if is_constant else 0.0)
        entries.append(0 if is_constant else value.sign * places.setdefault(value.node, len(places) + 1))
    results = tuple(Value(1, node) for node in places)
    return replace(code, results=results), tuple(entries), tuple(constants)


def matrix_entries(entries: tuple[int, ...], constants: tuple[float, ...], shape: tuple[int, ...]) -> MatrixEntries:
    """As `compact` gives them, in the shape of the matrix."""
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
