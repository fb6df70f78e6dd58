"""W x W transposes in registers, between rows of states and lanes of a block, as numba intrinsics.

Copying one number at a time costs more than the arithmetic of a small kernel; log2(W) rounds of shuffles copy W x W.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def rows_to_lanes(lanes: int, width: int, first: int) -> Any:
    """An intrinsic `(x, start, step, b, c)`: b[(first + j) W + k] = x[start + k step + j] for W columns j from c.

    With rows shorter than W, c is 0 and up to W - width numbers behind a row are read: more rows must follow.
    """

    @intrinsic  # type: ignore[untyped-decorator]
    def read(typing_context: Any, x: Any, start: Any, step: Any, b: Any, c: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            block = _LaneBlock(context, builder, signature.args[0].dtype, lanes)
            source, target = (block.data(signature.args[i], arguments[i]) for i in (0, 3))
            at = builder.add(arguments[1], arguments[4])
            places = [builder.add(at, builder.mul(arguments[2], block.index(k))) for k in range(lanes)]
            columns = block.transposed([block.load(source, place) for place in places])
            for j, vector in enumerate(columns[:width]):
                block.store(vector, target, block.slot(first + j, arguments[4]), aligned=True)
            return context.get_dummy_value()

        return types.void(x, types.int64, types.int64, b, types.int64), code

    return read


def lanes_to_rows(lanes: int, width: int, first: int) -> Any:
    """An intrinsic `(b, out, start, c)`: out[start + k width + j] = b[(first + j) W + k] for W columns j from c.

    Rows shorter than W (c is 0) are written with W numbers, each over the surplus of the one before; the last ones
    number by number.
    """

    @intrinsic  # type: ignore[untyped-decorator]
    def write(typing_context: Any, b: Any, out: Any, start: Any, c: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            block = _LaneBlock(context, builder, signature.args[0].dtype, lanes)
            source, target = (block.data(signature.args[i], arguments[i]) for i in (0, 1))
            slots = [block.slot(first + j, arguments[3]) for j in range(min(lanes, width))]
            vectors = [block.load(source, slot, aligned=True) for slot in slots]
            _write_rows(block, vectors, target, builder.add(arguments[2], arguments[3]), width)
            return context.get_dummy_value()

        return types.void(b, out, types.int64, types.int64), code

    return write


def _write_rows(block: _LaneBlock, vectors: list[Any], target: Any, start: Any, width: int) -> None:
    builder, lanes = block.builder, block.lanes
    if width == 1:
        block.store(vectors[0], target, start)
        return
    rows = block.transposed(vectors + vectors[:1] * (lanes - len(vectors)))
    whole = lanes - (0 if width >= lanes else -(-(lanes - width) // width))
    for k, row in enumerate(rows):
        place = builder.add(start, block.index(k * width))
        if k < whole:
            block.store(row, target, place)
            continue
        for j in range(width):
            number = builder.extract_element(row, ir.Constant(ir.IntType(32), j))
            builder.store(number, builder.gep(target, [builder.add(place, block.index(j))]))


class _LaneBlock:
    """Vectors of W lanes in a function being built."""

    def __init__(self, context: Any, builder: Any, dtype: Any, lanes: int) -> None:
        self.context, self.builder, self.lanes = context, builder, lanes
        self.vector = ir.VectorType(context.get_data_type(dtype), lanes)
        self.bytes: int = dtype.bitwidth // 8

    def data(self, array_type: Any, array: Any) -> Any:
        return self.context.make_array(array_type)(self.context, self.builder, array).data

    def index(self, i: int) -> Any:
        return ir.Constant(ir.IntType(64), i)

    def slot(self, first: int, column: Any) -> Any:
        """The index in the buffer at which the lanes of column `first + column` begin."""
        return self.builder.mul(self.builder.add(self.index(first), column), self.index(self.lanes))

    def _place(self, data: Any, index: Any) -> Any:
        return self.builder.bitcast(self.builder.gep(data, [index]), self.vector.as_pointer())

    def _align(self, aligned: bool) -> int:
        return self.bytes * (self.lanes if aligned else 1)

    def load(self, data: Any, index: Any, aligned: bool = False) -> Any:
        return self.builder.load(self._place(data, index), align=self._align(aligned))

    def store(self, vector: Any, data: Any, index: Any, aligned: bool = False) -> None:
        self.builder.store(vector, self._place(data, index), align=self._align(aligned))

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
