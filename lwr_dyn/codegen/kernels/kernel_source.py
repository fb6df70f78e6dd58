"""Generates the Python source of a kernel: a block of W states is copied to a buffer, the code works on its lanes.

The body is plain Python over lanes; `lowering.straight_line` gives it to numba as vector instructions.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

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

from numba import carray, cfunc, types

from lwr_dyn.codegen.kernels.lowering import {lowering}
from lwr_dyn.codegen.kernels.transposes import begins_on_vector, block_past_caches, rows_to_lanes

begins = begins_on_vector({lanes})
{stream}{transposes}


@straight_line("{dtype}")
def body(b, out, at):
    for k in range({lanes}):
{body}
{streamed}

@cfunc(types.int64({types}), error_model="numpy")
def kernel({arguments}, out_, b_, start, stop):
    """Rows start to stop; gives the number of states not finite, not determined, or with an angle too large."""
{arrays}
    out = carray(out_, ((stop + {lanes}) * {step},), types.{dtype})
    b = carray(b_, ({size},), types.{dtype})
    trouble, is_large = 0, stop - start > {many} and begins(out)
    for s in range(start, stop, {lanes}):
        lanes, whole = min({lanes}, stop - s), s + {two_blocks} <= stop
{copies}
{give}
        for k in range(lanes):
            trouble += not (b[{flag} + k] == 0.0)
    return trouble
'''

_GIVE_ROWS = """        if whole:
            body(b, out, s * {step})
        else:
            body(b, b, {tail})
            for k in range(lanes):
                for j in range({width}):
                    out[(s + k) * {step} + j] = b[{tail} + k * {step} + j]"""

_GIVE_LARGE = """        if whole and is_large:
            body(b, b, {tail})
            stream(b, out, s * {step})
        elif whole:""" + _GIVE_ROWS.removeprefix("        if whole:")

_GIVE_BLOCKS = """        if is_large:
            streamed(b, out, s * {width})
        else:
            body(b, out, s * {width})"""
_GIVE = {"rows": _GIVE_LARGE, "padded": _GIVE_LARGE, "blocks": _GIVE_BLOCKS}
_CACHE_BYTES = 1 << 21
"""Results of more bytes leave a core's cache before they are read: they are written past it."""

_COPY = """        if whole and {name}_step >= {width}:
{take}
        elif {name}_step != 0 or s == start:
            for k in range({lanes}):
                row = min(s + k, stop - 1) * {name}_step
                for j in range({width}):
                    b[({first} + j) * {lanes} + k] = {name}[row + j]"""


@dataclass(frozen=True, slots=True)
class KernelSource:
    """The Python text of a kernel and how it is called."""

    text: str
    interface: KernelInterface


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
    flag, tail, width = sum(widths), (sum(widths) + 1) * lanes, len(code.results)
    step = row_step(spec.layout, width, lanes)
    size = tail + (0 if spec.layout == "blocks" else step * lanes)
    many = _CACHE_BYTES // (step * np.dtype(spec.dtype).itemsize)
    number = f"types.CPointer(types.{spec.dtype})"
    fused = code.operations_after_contraction()
    text = _HEAD.format(
        function=function, name=spec.name, formula=function_shape(function).formula, dtype=spec.dtype, lanes=lanes,
        version=VERSION, generator=GENERATOR, operations=code.operations, fused=fused, inputs=", ".join(names),
        body="\n".join(_early_lines(code, slots, flag, spec.layout, step, lanes)),
        form=f"{spec.layout}, {spec.structure}",
        lowering="straight_line" if spec.layout != "blocks" else "straight_line, streaming",
        types=", ".join([f"{number}, types.int64"] * len(names) + [f"{number}, {number}, types.int64, types.int64"]),
        arguments=", ".join(f"{name}_, {name}_step" for name in names),
        arrays="\n".join(
            f"    {x} = carray({x}_, ((stop - 1) * {x}_step + {w},), types.{spec.dtype})"
            for x, w in zip(names, widths, strict=True)
        ),
        transposes="\n".join(
            f"take_{x} = rows_to_lanes({lanes}, {w}, {f})" for x, w, f in zip(names, widths, first, strict=True)
        ),
        give=_GIVE[spec.layout].format(step=step, width=width, tail=tail),
        many=many,
        streamed="" if spec.layout != "blocks" else "\n\nstreamed = streaming(body)\n",
        stream=f"stream = block_past_caches({lanes}, {step}, {tail})\n" if spec.layout != "blocks" else "",
        two_blocks=2 * lanes, step=step, size=size, flag=flag * lanes,
        copies="\n".join(_copy(x, w, f, lanes) for x, w, f in zip(names, widths, first, strict=True)),
    )  # fmt: skip
    counts = (code.operations, fused)
    return KernelSource(
        text, KernelInterface(names, tuple(widths), width, size, lanes, limit, *counts, entries, constants)
    )


def function_code(spec: KernelSpec, function: str) -> StraightLineCode:
    """The code of a function, for one state; raises `UnknownNameError` for an unknown function."""
    return _flagged(symbolic_function(spec, function), function, sincos(spec.dtype))


def _flagged(symbolic: Any, function: str, numbers: SinCos) -> StraightLineCode:
    # accelerations are not determined where B is singular
    by: FlaggedBy = "results" if function == "forward_dynamics" else "few results"
    return straight_line_code(symbolic, numbers, flagged_by=by)


def _copy(name: str, width: int, first: int, lanes: int) -> str:
    """Rows of one input into the buffer, by a transpose for every W columns; the last one ends with the row."""
    call = f"take_{name}({name}, s * {name}_step, {name}_step, b, {{}})"
    take = " " * 12 + call.format(0)
    if width > lanes:
        last = call.format(f"min(c, {width - lanes})")
        take = f"            for c in range(0, {width}, {lanes}):\n" + " " * 16 + last
    return _COPY.format(name=name, width=width, first=first, lanes=lanes, take=take)


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
