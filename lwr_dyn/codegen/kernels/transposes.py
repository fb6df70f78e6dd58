"""W x W transposes in registers, between rows of states and lanes of a block.

Copying one number at a time costs more than the arithmetic of a small kernel; log2(W) rounds of shuffles copy W x W.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir

from lwr_dyn.codegen.kernels.loop_helpers import Helper, helper

_AHEAD = 64
"""States between the rows that are read and those that are fetched."""


def rows_to_lanes(name: str, number: Any, lanes: int, width: int, first: int) -> Helper:
    """A helper `(x, start, step, b, c)`: b[(first + j) W + k] = x[start + k step + j] for W columns j from c.

    With rows shorter than W, c is 0 and up to W - width numbers behind a row are read: more rows must follow. Rows that
    will be read soon are fetched into the cache: the processor does not foresee them across pages.
    """

    def write(builder: Any, arguments: Any) -> None:
        block, (x, start, step, b, c) = LaneBlock(builder, number, lanes), arguments
        at = builder.add(start, c)
        places = [builder.add(at, builder.mul(step, block.index(k))) for k in range(lanes)]
        soon = builder.mul(step, block.index(_AHEAD))
        for place in places:
            block.fetch(x, builder.add(place, soon))
        columns = block.transposed([block.load(x, place) for place in places])
        for j, vector in enumerate(columns[:width]):
            block.store(vector, b, block.slot(first + j, c), aligned=True)

    arguments = (("double*", "x"), ("int", "start"), ("int", "step"), ("double*", "b"), ("int", "c"))
    return helper(name, "void", arguments, number, write)


def block_past_caches(name: str, number: Any, lanes: int, width: int, first: int) -> Helper:
    """A helper `(b, out, start)`: out[start + i] = b[first + i] for width W numbers, past the caches.

    out[start] must begin a whole vector.
    """

    def write(builder: Any, arguments: Any) -> None:
        block, (b, out, start) = LaneBlock(builder, number, lanes, is_streaming=True), arguments
        for i in range(width):
            vector = block.load(b, block.index(first + i * lanes), aligned=True)
            block.give(vector, out, builder.add(start, block.index(i * lanes)))

    return helper(name, "void", (("double*", "b"), ("double*", "out"), ("int", "start")), number, write)


def begins_on_vector(name: str, number: Any, lanes: int) -> Helper:
    """A helper `(x)`: whether an array begins on a whole vector."""

    def write(builder: Any, arguments: Any) -> Any:
        block = LaneBlock(builder, number, lanes)
        rest = builder.urem(builder.ptrtoint(arguments[0], ir.IntType(64)), block.index(block.bits // 8 * lanes))
        return builder.icmp_unsigned("==", rest, block.index(0))

    return helper(name, "int", (("double*", "x"),), number, write)


def function_of(module: Any, kind: Any, name: str) -> Any:
    """A function of an LLVM module by its name, declared if it is new."""
    return module.globals.get(name) or ir.Function(module, kind, name)


class ResultRows:
    """Rows of results in a function being built: columns are given in any order and written W at once when known."""

    def __init__(self, block: LaneBlock, target: Any, width: int, step: int) -> None:
        self.block, self.target, self.width, self.step = block, target, width, step
        self.columns: dict[int, Any] = {}

    def put(self, column: int, vector: Any) -> None:
        """The numbers of a column, one in each lane."""
        lanes = self.block.lanes
        self.columns[column] = vector
        first = column - column % lanes
        group = range(first, min(first + lanes, self.width))
        if all(j in self.columns for j in group):
            self._write(first, [self.columns.pop(j) for j in group])

    def _write(self, first: int, vectors: list[Any]) -> None:
        block, known, lanes = self.block, len(vectors), self.block.lanes
        if self.step == 1:  # one number a row: a vector holds the rows side by side
            block.store(vectors[0], self.target, block.index(0))
            return
        if known == 1:
            for k in range(lanes):
                block.store_number(vectors[0], k, self.target, k * self.step + first)
            return
        undefined = [ir.Constant(block.vector, ir.Undefined)] * (lanes - known)
        is_narrow, end = self.step < lanes, lanes * self.step
        for k, row in enumerate(block.transposed(vectors + undefined)):
            index = k * self.step + first
            if first + lanes <= self.step or (is_narrow and index + lanes <= end):
                block.give(row, self.target, block.index(index))  # narrow rows: over the surplus of the one before
            elif is_narrow:
                for j in range(known):
                    block.store_number(row, j, self.target, index + j)
            else:
                block.store_first(row, known, self.target, block.index(index))


class LaneBlock:
    """Vectors of W lanes in a function being built."""

    def __init__(self, builder: Any, number: Any, lanes: int, is_streaming: bool = False) -> None:
        self.builder, self.lanes, self.is_streaming = builder, lanes, is_streaming
        self.vector = ir.VectorType(number, lanes)
        self.bits = 64 if number == ir.DoubleType() else 32

    def index(self, i: int) -> Any:
        """A place as a number of 64 bits."""
        return ir.Constant(ir.IntType(64), i)

    def slot(self, first: int, column: Any) -> Any:
        """The index in the buffer at which the lanes of column `first + column` begin."""
        return self.builder.mul(self.builder.add(self.index(first), column), self.index(self.lanes))

    def _place(self, data: Any, index: Any) -> Any:
        return self.builder.bitcast(self.builder.gep(data, [index]), self.vector.as_pointer())

    def _align(self, aligned: bool) -> int:
        return self.bits // 8 * (self.lanes if aligned else 1)

    def load(self, data: Any, index: Any, aligned: bool = False) -> Any:
        """W numbers from an index on."""
        return self.builder.load(self._place(data, index), align=self._align(aligned))

    def fetch(self, data: Any, index: Any) -> None:
        """The cache line of an index into the cache; it may lie behind the end."""
        number, place = ir.IntType(32), ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [place, number, number, number])
        prefetch = function_of(self.builder.module, kind, "llvm.prefetch.p0")
        to_read, keep, is_data = (ir.Constant(number, i) for i in (0, 3, 1))
        at = self.builder.bitcast(self.builder.gep(data, [index]), place)
        self.builder.call(prefetch, [at, to_read, keep, is_data])

    def store(self, vector: Any, data: Any, index: Any, aligned: bool = False) -> None:
        """W numbers to an index."""
        self.builder.store(vector, self._place(data, index), align=self._align(aligned))

    def give(self, vector: Any, data: Any, index: Any) -> None:
        """A whole vector of results: past the caches where the block streams."""
        stored = self.builder.store(vector, self._place(data, index), align=self._align(self.is_streaming))
        if self.is_streaming:
            one = ir.Constant(ir.IntType(32), 1)
            stored.set_metadata("nontemporal", self.builder.module.add_metadata([one]))

    def store_number(self, vector: Any, lane: int, data: Any, index: int) -> None:
        """The number of one lane."""
        number = self.builder.extract_element(vector, ir.Constant(ir.IntType(32), lane))
        self.builder.store(number, self.builder.gep(data, [self.index(index)]))

    def store_first(self, vector: Any, count: int, data: Any, index: Any) -> None:
        """The first numbers; what stands behind them is not touched."""
        if count == self.lanes:
            self.store(vector, data, index)
            return
        mask_type, pointer = ir.VectorType(ir.IntType(1), self.lanes), self.vector.as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [self.vector, pointer, ir.IntType(32), mask_type])
        name = f"llvm.masked.store.v{self.lanes}f{self.bits}.p0"
        masked = function_of(self.builder.module, kind, name)
        mask = ir.Constant(mask_type, [ir.Constant(ir.IntType(1), i < count) for i in range(self.lanes)])
        align = ir.Constant(ir.IntType(32), self._align(False))
        self.builder.call(masked, [vector, self._place(data, index), align, mask])

    def transposed(self, vectors: list[Any]) -> list[Any]:
        """Lane i of vector k as lane k of vector i: pairs 1, 2, 4 ... apart swap their halves."""
        vectors, apart, lanes = list(vectors), 1, self.lanes
        while apart < lanes:
            low = [lane if not lane & apart else lanes + lane - apart for lane in range(lanes)]
            high = [lane + apart if not lane & apart else lanes + lane for lane in range(lanes)]
            for i in range(lanes):
                if not i & apart:
                    pair = vectors[i], vectors[i + apart]
                    vectors[i], vectors[i + apart] = (self._shuffled(*pair, mask) for mask in (low, high))
            apart *= 2
        return vectors

    def _shuffled(self, a: Any, b: Any, mask: list[int]) -> Any:
        constant = ir.Constant(ir.VectorType(ir.IntType(32), self.lanes), mask)
        return self.builder.shuffle_vector(a, b, constant)
