"""The numbers of `philox` as vector instructions: the driver of a kernel fills slots of its block with them.

Lane k of the block has the run `run + k`, so a run gets its numbers wherever it stands; words and uniform numbers are
bit for bit those of `philox.uniform_numbers`.
"""

import hashlib
from dataclasses import dataclass
from typing import Any

from llvmlite import binding as llvm
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from lwr_dyn.codegen.kernels.lowering import unlinked_address
from lwr_dyn.codegen.rollouts.philox import MULTIPLIERS, ROUNDS, WEYL, WORD

_INT, _NUMBER = ir.IntType(64), ir.DoubleType()
_LOW = 0xFFFFFFFF


def uniform_code(lanes: int, words: int, first_slot: int) -> Any:
    """An intrinsic `fill(b, seed, run, sample)` for generated drivers.

    It writes `words` uniform numbers (a multiple of 4) to the slots from `first_slot` on of the block `b` of float64;
    seed, run (of lane 0) and sample are int64. As of `lowering.straight_line`, its code is a function of the
    module `fill.assembly`, which `machine_code.compiled` links.
    """
    text = f"{lanes} {words} {first_slot}"
    name = f"lwr_dyn_philox_{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    llvm.add_symbol(name, unlinked_address())

    @intrinsic  # type: ignore[untyped-decorator]
    def fill(typing_context: Any, b: Any, seed: Any, run: Any, sample: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
            kind = ir.FunctionType(ir.VoidType(), [data.type, _INT, _INT, _INT])
            builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [data, *arguments[1:]])
            return context.get_dummy_value()

        return types.void(b, types.int64, types.int64, types.int64), code

    fill.assembly = _assembly(name, lanes, words, first_slot)
    return fill


def _assembly(name: str, lanes: int, words: int, first_slot: int) -> str:
    module = ir.Module(name)
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [_NUMBER.as_pointer(), _INT, _INT, _INT]), name)
    builder = ir.IRBuilder(function.append_basic_block())
    data, seed, run, sample = function.args
    write = _Words(builder, lanes)
    runs = builder.add(write.all_lanes(run), ir.Constant(write.vector, list(range(lanes))))
    counter = [write.low(write.all_lanes(sample)), write.low(runs), write.high(runs)]
    key = [write.low(write.all_lanes(seed)), write.high(write.all_lanes(seed))]
    for block in range(words // 4):
        four = write.philox([counter[0], write.number(block), *counter[1:]], key)
        for i, word in enumerate(four):
            place = builder.gep(data, [ir.Constant(_INT, (first_slot + 4 * block + i) * lanes)])
            target = builder.bitcast(place, ir.VectorType(_NUMBER, lanes).as_pointer())
            builder.store(write.uniform(word), target, align=8 * lanes)
    builder.ret_void()
    return str(module)


@dataclass(frozen=True, slots=True)
class _Words:
    """Instructions on vectors of words, each in 64 bits."""

    builder: Any
    lanes: int

    @property
    def vector(self) -> Any:
        return ir.VectorType(_INT, self.lanes)

    def number(self, x: int) -> Any:
        return ir.Constant(self.vector, [x] * self.lanes)

    def all_lanes(self, x: Any) -> Any:
        """One number in every lane."""
        value: Any = ir.Constant(self.vector, ir.Undefined)
        for lane in range(self.lanes):
            value = self.builder.insert_element(value, x, ir.Constant(ir.IntType(32), lane))
        return value

    def low(self, x: Any) -> Any:
        return self.builder.and_(x, self.number(_LOW))

    def high(self, x: Any) -> Any:
        return self.builder.lshr(x, self.number(32))

    def philox(self, counter: list[Any], key: list[Any]) -> list[Any]:
        """The four words of a counter, as `philox.philox`."""
        xor, c = self.builder.xor, counter
        for _ in range(ROUNDS):
            first, second = (
                self.builder.mul(x, self.number(m)) for m, x in zip(MULTIPLIERS, (c[0], c[2]), strict=True)
            )
            upper = (xor(xor(self.high(product), other), k) for product, other, k in (
                (second, c[1], key[0]), (first, c[3], key[1])
            ))  # fmt: skip
            c = [next(upper), self.low(second), next(upper), self.low(first)]
            key = [self.low(self.builder.add(k, self.number(w))) for k, w in zip(key, WEYL, strict=True)]
        return c

    def uniform(self, word: Any) -> Any:
        """(word + 1/2) / 2^32, exact."""
        kind = ir.VectorType(_NUMBER, self.lanes)
        half, size = (ir.Constant(kind, [ir.Constant(_NUMBER, x)] * self.lanes) for x in (0.5, WORD))
        return self.builder.fmul(self.builder.fadd(self.builder.sitofp(word, kind), half), size)
