"""A program as Python source: a block of W states goes into one small buffer, straight-line code works on its lanes.

The body is plain Python over lanes; `lowering.straight_line` gives it to numba as vector instructions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.codegen.description import Description
from lwr_dyn.codegen.form import GENERATOR, Form
from lwr_dyn.codegen.functions import function_shape
from lwr_dyn.codegen.program import OPERATIONS, Program
from lwr_dyn.version import VERSION

_HEAD = '''"""{function} of {name}: {says}; {dtype}, blocks of {lanes} states.

Written by lwr_dyn {version}, generator {generator}: {operations} operations a state, {fused} with fused multiply-add.
Inputs: {inputs}.
"""

from numba import carray, cfunc, types

from lwr_dyn.codegen.lowering import straight_line
from lwr_dyn.codegen.transposes import lanes_to_rows, rows_to_lanes

{transposes}


@straight_line("{dtype}")
def body(b):
    for k in range({lanes}):
{body}


@cfunc(types.int64({types}), error_model="numpy")
def kernel({arguments}, out_, b_, start, stop):
    """Rows start to stop; gives the number of states with a value that is not finite or an angle that is too large."""
{arrays}
    out = carray(out_, (stop * {width},), types.{dtype})
    b = carray(b_, ({size},), types.{dtype})
    trouble = 0
    for s in range(start, stop, {lanes}):
        lanes, whole = min({lanes}, stop - s), s + {two_blocks} <= stop
{copies}
        body(b)
        for k in range(lanes):
            trouble += not (b[{flag} + k] == 0.0)
        if whole:
{give}
        else:
            for k in range(lanes):
                for j in range({width}):
                    out[(s + k) * {width} + j] = b[({first_result} + j) * {lanes} + k]
    return trouble
'''

_COPY = """        if whole and {name}_step >= {width}:
{take}
        elif {name}_step != 0 or s == start:
            for k in range({lanes}):
                row = min(s + k, stop - 1) * {name}_step
                for j in range({width}):
                    b[({first} + j) * {lanes} + k] = {name}[row + j]"""


@dataclass(frozen=True, slots=True)
class Source:
    """Python text of a kernel and how to call it."""

    text: str
    description: Description


def source_of(form: Form, function: str, program: Program, widths: Sequence[int], lanes: int, limit: float) -> Source:
    """The Python source of a kernel.

    Parameters
    ----------
    form : Form
    function : str
    program : Program
    widths : sequence of int
        Values of one row of each input.
    lanes : int
        States of a block, W.
    limit : float
        The largest angle [rad] that the range reduction takes; whoever calls brings larger ones near zero.
    """
    names = (*function_shape(function).states, *form.parameters_of(function))
    first = [sum(widths[:i]) for i in range(len(widths))]
    slots = {("in", i, j): first[i] + j for i in range(len(widths)) for j in range(widths[i])}
    flag, results = sum(widths), sum(widths) + 1
    width, size = len(program.results), (sum(widths) + 1 + len(program.results)) * lanes
    number = f"types.CPointer(types.{form.dtype})"
    fused = program.operations_after_contraction()
    text = _HEAD.format(
        function=function, name=form.name, says=function_shape(function).says, dtype=form.dtype, lanes=lanes,
        version=VERSION, generator=GENERATOR, operations=program.operations, fused=fused, inputs=", ".join(names),
        body="\n".join(_body(program, slots, flag, results, lanes)),
        types=", ".join([f"{number}, types.int64"] * len(names) + [f"{number}, {number}, types.int64, types.int64"]),
        arguments=", ".join(f"{name}_, {name}_step" for name in names),
        arrays="\n".join(
            f"    {x} = carray({x}_, ((stop - 1) * {x}_step + {w},), types.{form.dtype})"
            for x, w in zip(names, widths, strict=True)
        ),
        transposes="\n".join(
            [f"take_{x} = rows_to_lanes({lanes}, {w}, {f})" for x, w, f in zip(names, widths, first, strict=True)]
            + [f"give_rows = lanes_to_rows({lanes}, {width}, {results})"]
        ),
        give=_groups(f"give_rows(b, out, s * {width}, {{}})", width, lanes),
        two_blocks=2 * lanes, width=width, size=size, flag=flag * lanes, first_result=results,
        copies="\n".join(_copy(x, w, f, lanes) for x, w, f in zip(names, widths, first, strict=True)),
    )  # fmt: skip
    known = Description(names, tuple(widths), width, size, lanes, limit, program.operations, fused)
    return Source(text, known)


def _copy(name: str, width: int, first: int, lanes: int) -> str:
    """Rows of one input into the buffer."""
    take = _groups(f"take_{name}({name}, s * {name}_step, {name}_step, b, {{}})", width, lanes)
    return _COPY.format(name=name, width=width, first=first, lanes=lanes, take=take)


def _groups(call: str, width: int, lanes: int) -> str:
    """A transpose for every W columns: the last group overlaps the one before it instead of leaving the row."""
    if width <= lanes:
        return " " * 12 + call.format(0)
    last = f"min(c, {width - lanes})"
    return f"            for c in range(0, {width}, {lanes}):\n" + " " * 16 + call.format(last)


def _body(program: Program, slots: dict[tuple[str, int, int], int], flag: int, results: int, lanes: int) -> list[str]:
    """Lines of the loop over lanes."""
    lines, names = [], []
    for i, node in enumerate(program.nodes):
        if node.op in ("const", "zero"):
            names.append(repr(node.a))
            continue
        names.append(f"v{i}")
        if node.op == "in":
            lines.append(f"v{i} = b[{slots[node] * lanes} + k]")
        elif node.op == ">":
            lines.append(f"v{i} = 1.0 if {names[node.a]} > {names[node.b]} else 0.0")
        elif node.op in OPERATIONS:
            lines.append(f"v{i} = {names[node.a]} {node.op} {names[node.b]}")
    for j, value in enumerate((program.flag, *program.results)):
        place = flag if j == 0 else results + j - 1
        lines.append(f"b[{place * lanes} + k] = {'-' if value.sign < 0 else ''}{names[value.node]}")
    return [f"        {line}" for line in lines]
