"""Straight-line code as text of LLVM's language, for one state: the same operations as in the vector kernels.

Every instruction rounds by itself (no flag lets LLVM change one), and products that a sum takes in are those of
`StraightLineCode.contraction`; so the bits are those of a kernel of any number of lanes.
"""

from collections.abc import Iterator

import numpy as np

from lwr_dyn.codegen.kernels.machine_code import fuses
from lwr_dyn.codegen.kernels.straight_line import Node, StraightLineCode, Value

DECLARATIONS = """declare double @llvm.sqrt.f64(double)
declare double @llvm.fabs.f64(double)
declare double @llvm.fma.f64(double, double, double)"""

_BINARY = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
_CALLS = {"sqrt": "sqrt", "abs": "fabs"}


def number(x: float) -> str:
    """A number, bit for bit."""
    return "0x" + np.float64(x).tobytes()[::-1].hex().upper()


def scalar_function(name: str, code: StraightLineCode, inputs: int) -> str:
    """`double name(ptr in0, ..., ptr out)`: the results go to `out`, the flag is returned.

    `out` may be no input's memory. Raises `NotImplementedError` for operations that no function of a state has.
    """
    heads = ", ".join(f"ptr %in{i}" for i in range(inputs))
    lines = "\n".join(f"  {line}" for line in _instructions(code))
    return f"define internal double @{name}({heads}, ptr %out) noinline {{\n{lines}\n}}"


def fused_lines(name: str, x: str, y: str, z: str) -> list[str]:
    """%name = x y + z with one rounding, or with two where the processor has no such instruction."""
    if fuses():
        return [f"%{name} = call double @llvm.fma.f64(double {x}, double {y}, double {z})"]
    return [f"%{name}.p = fmul double {x}, {y}", f"%{name} = fadd double %{name}.p, {z}"]


def _instructions(code: StraightLineCode) -> Iterator[str]:
    fused = code.contraction()
    within = set(fused.values())
    wanted: dict[int, list[str]] = {}
    for j, value in enumerate(code.results):
        wanted.setdefault(value.node, []).extend(_stored(code, value, j))
    for i, node in enumerate(code.nodes):
        if i in fused:
            yield from _fused(code, i, node, fused[i])
        elif i not in within:
            yield from _operation(code, i, node)
        yield from wanted.get(i, ())
    if code.flag.sign < 0:
        yield f"%flag = fneg double {_of(code, code.flag.node)}"
    yield f"ret double {'%flag' if code.flag.sign < 0 else _of(code, code.flag.node)}"


def _of(code: StraightLineCode, i: int) -> str:
    node = code.nodes[i]
    return number(float(node.a)) if node.op in ("const", "zero") else f"%v{i}"


def _stored(code: StraightLineCode, value: Value, j: int) -> list[str]:
    x, lines = _of(code, value.node), []
    if value.sign < 0:
        lines, x = [f"%n{j} = fneg double {x}"], f"%n{j}"
    return [*lines, f"%o{j} = getelementptr double, ptr %out, i64 {j}", f"store double {x}, ptr %o{j}"]


def _fused(code: StraightLineCode, i: int, node: Node, product: int) -> list[str]:
    x, y = (_of(code, factor) for factor in (code.nodes[product].a, code.nodes[product].b))
    is_first, lines = product == node.a, []
    other = _of(code, node.b if is_first else node.a)
    if node.op == "-":
        lines = [f"%m{i} = fneg double {other if is_first else x}"]
        x, other = (x, f"%m{i}") if is_first else (f"%m{i}", other)
    return [*lines, *fused_lines(f"v{i}", x, y, other)]


def _operation(code: StraightLineCode, i: int, node: Node) -> list[str]:
    if node.op in ("const", "zero"):
        return []
    if node.op == "in":
        place = f"getelementptr double, ptr %in{node.a}, i64 {node.b}"
        return [f"%p{i} = {place}", f"%v{i} = load double, ptr %p{i}"]
    a, b = _of(code, node.a), _of(code, node.b)
    if node.op in _BINARY:
        return [f"%v{i} = {_BINARY[node.op]} double {a}, {b}"]
    if node.op in _CALLS:
        return [f"%v{i} = call double @llvm.{_CALLS[node.op]}.f64(double {a})"]
    test = {
        ">": (a, b, number(1.0), number(0.0)), "?": (a, number(0.5), b, number(0.0)), "min": (a, b, b, a),
        "max": (b, a, b, a),
    }.get(node.op)  # fmt: skip
    if test is None:
        raise NotImplementedError(f"operation {node.op} in a function of one state")
    left, right, yes, no = test
    return [
        f"%c{i} = fcmp ogt double {left}, {right}",
        f"%v{i} = select i1 %c{i}, double {yes}, double {no}",
    ]
