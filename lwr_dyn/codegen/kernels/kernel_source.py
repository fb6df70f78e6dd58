"""Generates the body of a kernel as Python: a block of W states is copied to a buffer, the code works on its lanes.

`lowering` makes vector instructions of it, `block_loop` is the loop around it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.block_loop import BlockLoop
from lwr_dyn.codegen.kernels.elementary import SinCos, sincos
from lwr_dyn.codegen.kernels.kernel_spec import GENERATOR, KernelInterface, KernelSpec, function_shape
from lwr_dyn.codegen.kernels.machine_code import lanes_of
from lwr_dyn.codegen.kernels.result_form import row_step
from lwr_dyn.codegen.kernels.straight_line import (
    OPERATIONS,
    FlaggedBy,
    Node,
    StraightLineCode,
    Value,
    compact,
    straight_line_code,
)
from lwr_dyn.codegen.kernels.symbolic_functions import symbolic_function
from lwr_dyn.foundation.version import VERSION

_HEAD = '''"""{function} of {name}: {formula}; {dtype}, blocks of {lanes} states; {form}.

Written by lwr_dyn {version}, generator {generator}: {operations} operations a state, {fused} with fused multiply-add.
Inputs: {inputs}.
"""


'''

_BODY = """def body(b, out, at):
    for k in range({lanes}):
{body}
"""


@dataclass(frozen=True, slots=True)
class KernelSource:
    """The body of a kernel in Python, what it is, how it is called, and the loop around it."""

    head: str
    body: str
    interface: KernelInterface
    loop: BlockLoop

    @property
    def text(self) -> str:
        """Head and body."""
        return self.head + self.body


def generate(spec: KernelSpec, function: str, lanes: int | None = None) -> KernelSource:
    """The source of a kernel, in blocks of `lanes` states; raises `UnknownNameError` for an unknown function."""
    numbers, symbolic = sincos(spec.dtype), symbolic_function(spec, function)
    widths = [symbolic.size1_in(i) for i in range(symbolic.n_in())]
    limit = float((numbers.most_half_turns - 1) * np.pi / np.sqrt(max(spec.n, 1)))
    lanes = lanes_of(spec.dtype) if lanes is None else lanes
    code = _flagged(symbolic, function, numbers)
    entries, constants = tuple[int, ...](), tuple[float, ...]()
    if spec.structure == "compact":
        code, entries, constants = compact(code)
    names = (*function_shape(function).states, *spec.parameters_of(function))
    first = [sum(widths[:i]) for i in range(len(widths))]
    slots = {("in", i, j): first[i] + j for i in range(len(widths)) for j in range(widths[i])}
    width = len(code.results)
    step = row_step(spec.layout, width, lanes)
    loop = BlockLoop(names, tuple(widths), lanes, spec.layout, width, step, spec.dtype)
    fused = code.operations_after_contraction()
    head = _HEAD.format(
        function=function, name=spec.name, formula=function_shape(function).formula, dtype=spec.dtype, lanes=lanes,
        version=VERSION, generator=GENERATOR, operations=code.operations, fused=fused, inputs=", ".join(names),
        form=f"{spec.layout}, {spec.structure}",
    )  # fmt: skip
    body = "\n".join(_early_lines(code, slots, sum(widths), spec.layout, step, lanes))
    counts = (code.operations, fused)
    interface = KernelInterface(names, tuple(widths), width, loop.buffer, lanes, limit, *counts, entries, constants)
    return KernelSource(head, _BODY.format(lanes=lanes, body=body), interface, loop)


def function_code(spec: KernelSpec, function: str) -> StraightLineCode:
    """The code of a function, for one state; raises `UnknownNameError` for an unknown function."""
    return _flagged(symbolic_function(spec, function), function, sincos(spec.dtype))


def _flagged(symbolic: Any, function: str, numbers: SinCos) -> StraightLineCode:
    # accelerations are not determined where B is singular
    by: FlaggedBy = "results" if function == "forward_dynamics" else "few results"
    return straight_line_code(symbolic, numbers, flagged_by=by)


_FORMS = {
    ">": "1.0 if {0} > {1} else 0.0", "?": "{1} if {0} > 0.5 else 0.0", "min": "{1} if {0} > {1} else {0}",
    "max": "{1} if {1} > {0} else {0}", "sqrt": "sqrt({0})", "abs": "abs({0})", "2^": "two_to({0})",
    "exponent": "exponent({0})", "significand": "significand({0})",
}  # fmt: skip


def placed_lines(
    code: StraightLineCode, slots: dict[tuple[str, int, int], int], places: Sequence[int], lanes: int
) -> list[str]:
    """Lines of the loop over lanes: inputs from `slots`; flag and results go to `places` at the end."""
    lines = [line for _, line in _operations(code, slots, lanes) if line]
    for place, value in zip(places, (code.flag, *code.results), strict=True):
        lines.append(f"b[{place * lanes} + k] = {_signed(code, value)}")
    return [f"        {line}" for line in lines]


def _early_lines(
    code: StraightLineCode, slots: dict[tuple[str, int, int], int], flag: int, layout: str, step: int, lanes: int
) -> list[str]:
    """Lines of the loop over lanes: every result goes to `out` as soon as it is known, the flag to its slot."""
    form = "out[at + {1} + k] = {2}" if layout == "blocks" else f"out[at + k * {step} + {{0}}] = {{2}}"
    wanted: dict[int, list[str]] = {code.flag.node: [f"b[{flag * lanes} + k] = {_signed(code, code.flag)}"]}
    for j, value in enumerate(code.results):
        wanted.setdefault(value.node, []).append(form.format(j, j * lanes, _signed(code, value)))
    lines = [x for i, line in _operations(code, slots, lanes) for x in (line, *wanted.get(i, ())) if x]
    return [f"        {line}" for line in lines]


def _operations(
    code: StraightLineCode, slots: dict[tuple[str, int, int], int], lanes: int
) -> Iterator[tuple[int, str]]:
    """Every node with the line that computes it; constants and products that a sum takes in need none."""
    fused = code.contraction()
    within = set(fused.values())
    for i, node in enumerate(code.nodes):
        line = ""
        if node.op == "in":
            line = f"v{i} = b[{slots[node] * lanes} + k]"
        elif i in fused:
            line = f"v{i} = {_fused(code, node, fused[i])}"
        elif node.op in OPERATIONS and i not in within:
            form = _FORMS.get(node.op, f"{{0}} {node.op} {{1}}")
            line = f"v{i} = {form.format(_name(code, node.a), _name(code, node.b))}"
        yield i, line


def _fused(code: StraightLineCode, sum_: Node, product: int) -> str:
    """A sum or difference with a product in it, as one instruction."""
    x, y = (_name(code, factor) for factor in (code.nodes[product].a, code.nodes[product].b))
    is_first = product == sum_.a
    other = _name(code, sum_.b if is_first else sum_.a)
    if sum_.op == "-":
        x, other = (x, f"-{other}") if is_first else (f"-{x}", other)
    return f"fma({x}, {y}, {other})"


def _name(code: StraightLineCode, i: int) -> str:
    if code.nodes[i].op not in ("const", "zero"):
        return f"v{i}"
    x = float(code.nodes[i].a)
    return repr(x) if np.isfinite(x) else "(1e999 - 1e999)" if np.isnan(x) else "1e999"


def _signed(code: StraightLineCode, value: Value) -> str:
    return f"{'-' if value.sign < 0 else ''}{_name(code, value.node)}"
