"""Operations -> C99: one function each, no allocation, no globals, every operation a statement of its own.

One operation a statement keeps compilers from contracting a product and a sum, so that results have the same bits
everywhere (gcc contracts across statements where -ffp-contract=fast or its own dialect asks for it).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from lwr_dyn.codegen.emit.straight_code import EmittedCode, Operation, Store
from lwr_dyn.codegen.kernels.straight_line import Node

C_TYPES = {"float64": ("double", ""), "float32": ("float", "f")}
_FORMS = {
    ">": "{0} > {1} ? {one} : {zero}", "?": "{0} > {half} ? {1} : {zero}", "min": "{0} > {1} ? {1} : {0}",
    "max": "{1} > {0} ? {1} : {0}", "sqrt": "sqrt{f}({0})", "abs": "fabs{f}({0})", "sin": "sin{f}({0})",
    "cos": "cos{f}({0})", "2^": "two_to({0})", "exponent": "binary_exponent({0})",
    "significand": "binary_fraction({0})",
}  # fmt: skip
_BITS = """\
static double number_of(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static uint64_t bits_of(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
"""
_POWERS = {
    "2^": """\
static double two_to(double n)
{
    return number_of((bits_of(n + 6755399441055744.0) << 52) + (UINT64_C(1023) << 52));
}
""",
    "exponent": """\
static double binary_exponent(double x)
{
    return (double)((bits_of(x) >> 52) & 2047) - 1023.0;
}
""",
    "significand": """\
static double binary_fraction(double x)
{
    return number_of((bits_of(x) & ((UINT64_C(1) << 52) - 1)) | (UINT64_C(1023) << 52)) + (x - x);
}
""",
}
"""Powers of two by the bits of normal numbers: no branch; NaN and inf have the fraction NaN."""


def declaration(code: EmittedCode, name: str, restrict: str) -> str:
    """The head of the C function; `restrict` stands where the result may not be an argument."""
    number, _ = C_TYPES[code.dtype]
    arguments = [f"const {number} {a.name}[{a.width}]" for a in code.function.arguments]
    apart = f"{restrict} " if code.stores_early else ""
    return f"void {name}({', '.join([*arguments, f'{number} out[{apart}{code.function.width}]'])})"


def c_function(code: EmittedCode, name: str, restrict: str) -> str:
    """The C function."""
    read = {(x.a) for x in code.nodes if x.op == "in"}
    unread = [f"(void){a.name};" for i, a in enumerate(code.function.arguments) if i not in read]
    lines = (f"    {line}" for line in [*unread, *_lines(code)])
    return "\n".join([declaration(code, name, restrict), "{", *lines, "}", ""])


def shared_functions(codes: Sequence[EmittedCode]) -> str:
    """The static functions that the functions of a file call, with their headers; empty for most."""
    used = {node.op for code in codes for node in code.nodes}
    chosen = [text for op, text in _POWERS.items() if op in used]
    return "\n".join(["#include <stdint.h>\n#include <string.h>\n", _BITS, *chosen]) if chosen else ""


def needs_library(code: EmittedCode) -> bool:
    """Whether a function of <math.h> is called."""
    return any(node.op in ("sqrt", "abs", "sin", "cos") for node in code.nodes)


def literal(value: float, dtype: str) -> str:
    """A number as a C literal that reads back as itself."""
    if dtype == "float64":
        return repr(float(value))
    return f"{float(np.float32(value))!r}f"


def _lines(code: EmittedCode) -> Iterator[str]:
    number, f = C_TYPES[code.dtype]
    arguments = code.function.arguments
    words = {"f": f, "one": literal(1.0, code.dtype), "zero": literal(0.0, code.dtype),
             "half": literal(0.5, code.dtype)}  # fmt: skip

    def name(i: int) -> str:
        node: Node = code.nodes[i]
        if node.op == "const":
            return literal(node.a, code.dtype)
        return f"{arguments[node.a].name}[{node.b}]" if node.op == "in" else f"v{i}"

    for statement in code.statements:
        match statement:
            case Operation(i, node):
                form = _FORMS.get(node.op, f"{{0}} {node.op} {{1}}")
                yield f"const {number} v{i} = {form.format(name(node.a), name(node.b), **words)};"
            case Store(place, value):
                yield f"out[{place}] = {'-' if value.sign < 0 else ''}{name(value.node)};"
