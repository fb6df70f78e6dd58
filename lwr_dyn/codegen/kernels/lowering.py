"""Lowers the body of a kernel, a straight-line loop over lanes, to LLVM vector instructions.

Each statement is one instruction on a vector of W lanes, so thousands of them compile in a tenth of a second, and no
optimiser has to find the vectors.
"""

import ast
from typing import Any

from llvmlite import ir

from lwr_dyn.codegen.kernels.machine_code import fuses
from lwr_dyn.codegen.kernels.transposes import LaneBlock, ResultRows, function_of

_INSTRUCTIONS = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
NUMBERS: dict[str, Any] = {"float64": ir.DoubleType(), "float32": ir.FloatType()}
"""LLVM's types."""
_BYTES = {"float64": 8, "float32": 4}


def body_assembly(text: str, name: str, dtype: str, is_streaming: bool = False) -> str:
    """A body in Python as an LLVM module of one function of this name, on pointers to b, and to out + at.

    The text is a function `body(b)` or `body(b, out, at)` of one loop ``for k in range(W)``. Its statements are
    ``v = b[I + k]``, ``v = x + y`` (also - * /), ``v = z if x > y else w``, ``v = f(x)`` with f of sqrt, abs, two_to,
    exponent, significand (the last three of float64 alone), ``v = fma(x, y, z)``, which is x y + z rounded once,
    ``b[I + k] = x`` and ``b[I + k] = -x``, where x, y, z, w are names or numbers (of the type of b, `dtype`), and I a
    multiple of W. Results also go to rows, ``out[at + k * S + J] = x``, W columns J at once when they are known, or to
    blocks, ``out[at + I + k] = x``, past the caches with `is_streaming` (they must be aligned then), and do not overlap
    b.
    """
    definition: Any = ast.parse(text).body[0]
    loop = definition.body[0]
    module = ir.Module(name)
    has_results = len(definition.args.args) > 1
    kind = ir.FunctionType(ir.VoidType(), [NUMBERS[dtype].as_pointer()] * (2 if has_results else 1))
    function = ir.Function(module, kind, name)
    builder = ir.IRBuilder(function.append_basic_block())
    _Lanes(builder, function.args, dtype, int(loop.iter.args[0].value), is_streaming).write(loop.body)
    builder.ret_void()
    return str(module).replace(")\n{", f") {_ALIGNED_STACK}\n{{", 1)


_ALIGNED_STACK = '"frame-pointer"="all"'
"""Only with a frame pointer may LLVM align the stack: a vector that is kept there must not lie across cache lines."""


def _target(statement: Any) -> Any:
    return statement.targets[0]


def _is_row(target: Any) -> bool:
    """Whether a statement writes `out[at + k * S + J]`: blocks and the buffer end in `+ k]`."""
    return not isinstance(target, ast.Name) and isinstance(target.slice.right, ast.Constant)


class _Lanes:
    """Translates statements to instructions on vectors of lanes."""

    def __init__(self, builder: Any, pointers: Any, dtype: str, lanes: int, is_streaming: bool) -> None:
        self.block = LaneBlock(builder, NUMBERS[dtype], lanes, is_streaming)
        self.builder, self.number, self.lanes = builder, NUMBERS[dtype], lanes
        self.data, self.out = pointers[0], pointers[-1]
        self.rows: ResultRows | None = None
        self.vector = ir.VectorType(self.number, lanes)
        self.align = lanes * _BYTES[dtype]
        self.names: dict[str, Any] = {}

    def write(self, statements: list[Any]) -> None:
        widths = [row.slice.right.value for row in map(_target, statements) if _is_row(row)]
        for statement in statements:
            target, value = _target(statement), self._value(statement.value)
            if isinstance(target, ast.Name):
                self.names[target.id] = value
            elif _is_row(target):
                if self.rows is None:
                    step = int(target.slice.left.right.right.value)
                    self.rows = ResultRows(self.block, self.out, max(widths) + 1, step)
                self.rows.put(target.slice.right.value, value)
            elif target.value.id == "out":
                self.block.give(value, self.out, self.block.index(target.slice.left.right.value))
            else:
                self.builder.store(value, self._place(target), align=self.align)

    def _place(self, subscript: Any) -> Any:
        index = ir.Constant(ir.IntType(64), subscript.slice.left.value)
        return self.builder.bitcast(self.builder.gep(self.data, [index]), self.vector.as_pointer())

    def constant(self, x: float) -> Any:
        return ir.Constant(self.vector, [ir.Constant(self.number, x)] * self.lanes)

    def _call(self, name: str, *x: Any) -> Any:
        return _RARER[name](self, *x) if name in _RARER else self._intrinsic(_INTRINSICS[name], *x)

    def _intrinsic(self, name: str, *x: Any) -> Any:
        kind = ir.FunctionType(self.vector, [self.vector] * len(x))
        full = f"llvm.{name}.v{self.lanes}f{64 if self.number == ir.DoubleType() else 32}"
        return self.builder.call(function_of(self.builder.module, kind, full), x)

    def fused(self, x: Any, y: Any, z: Any) -> Any:
        """x y + z with one rounding; with two where the processor has no such instruction."""
        return self._intrinsic("fma", x, y, z) if fuses() else self.builder.fadd(self.builder.fmul(x, y), z)

    def whole(self, x: int) -> Any:
        """A whole number in every lane."""
        return ir.Constant(ir.VectorType(ir.IntType(64), self.lanes), [ir.Constant(ir.IntType(64), x)] * self.lanes)

    def bits(self, x: Any) -> Any:
        """The bits of float64 numbers."""
        return self.builder.bitcast(x, ir.VectorType(ir.IntType(64), self.lanes))

    def number_of(self, bits: Any) -> Any:
        """The other way."""
        return self.builder.bitcast(bits, self.vector)

    def _value(self, node: Any) -> Any:
        match node:
            case ast.Name():
                return self.names[node.id]
            case ast.Constant(value=float() as x):
                return self.constant(x)
            case ast.Subscript():
                return self.builder.load(self._place(node), align=self.align)
            case ast.Call(func=ast.Name(id=name)):
                return self._call(name, *map(self._value, node.args))
            case ast.UnaryOp():
                return self.builder.fneg(self._value(node.operand))
            case ast.BinOp():
                instruction = getattr(self.builder, _INSTRUCTIONS[type(node.op)])
                return instruction(self._value(node.left), self._value(node.right))
            case ast.IfExp(test=ast.Compare() as test):
                left, right = self._value(test.left), self._value(test.comparators[0])
                above = self.builder.fcmp_ordered(">", left, right)
                return self.builder.select(above, self._value(node.body), self._value(node.orelse))
            case _:
                raise SyntaxError(f"not a straight-line statement: {ast.unparse(node)}")


_MAGIC, _ONE, _HIGH = 1.5 * 2.0**52, 1023 << 52, 0x433 << 52
"""Its sum with a whole number holds that in its low bits; the bits of 1.0 and of 2^52."""


def _two_to(lanes: _Lanes, x: Any) -> Any:
    """2^x of whole x from -1022 to 1023."""
    builder = lanes.builder
    low = builder.shl(lanes.bits(builder.fadd(x, lanes.constant(_MAGIC))), lanes.whole(52))
    return lanes.number_of(builder.add(low, lanes.whole(_ONE)))


def _exponent(lanes: _Lanes, x: Any) -> Any:
    builder = lanes.builder
    biased = builder.or_(builder.lshr(lanes.bits(x), lanes.whole(52)), lanes.whole(_HIGH))
    return builder.fsub(lanes.number_of(biased), lanes.constant(2.0**52 + 1023.0))


def _significand(lanes: _Lanes, x: Any) -> Any:
    builder = lanes.builder
    fraction = builder.and_(lanes.bits(x), lanes.whole((1 << 52) - 1))
    return lanes.number_of(builder.or_(fraction, lanes.whole(_ONE)))


_INTRINSICS = {"sqrt": "sqrt", "abs": "fabs"}
_RARER: dict[str, Any] = {"two_to": _two_to, "exponent": _exponent, "significand": _significand, "fma": _Lanes.fused}
