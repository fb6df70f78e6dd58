"""A file of C99 and its header: provenance, guards, the functions, a self-test behind #ifdef.

Each function allocates nothing and has no globals; every operation is a statement of its own, which keeps compilers
from contracting a product and a sum, so that results have the same bits everywhere (gcc contracts across statements
where -ffp-contract=fast or its own dialect asks for it). The self-test compares each function with its test vectors:

cc -O2 -std=c99 -DLWR4PLUS_SELF_TEST lwr4plus.c -lm -o self_test && ./self_test
"""

import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from lwr_dyn.codegen.emit import emission
from lwr_dyn.codegen.emit.emission import STATES, EmittedArm, EmittedCase, identifier, wrapped
from lwr_dyn.codegen.emit.functions import Argument, EmittedCode, Operation, Store, TemplateFunction
from lwr_dyn.codegen.kernels.straight_line import Node
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError

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


_DIFFERENCE = """\
/* largest difference; NaN where a result is */
static double test_difference(const {number} *found, const double *expected, int n)
{{
    double worst = 0.0;
    int i;
    for (i = 0; i < n; i++) {{
        const double signed_difference = (double)found[i] - expected[i];
        const double difference = signed_difference < 0.0 ? -signed_difference : signed_difference;
        if (!(difference <= 1e300)) {{
            return difference;
        }}
        worst = difference > worst ? difference : worst;
    }}
    return worst;
}}
"""


def self_test(emitted: EmittedArm) -> str:
    """The self-test behind #ifdef PREFIX_SELF_TEST."""
    number, _ = C_TYPES[emitted.dtype]
    cases = emission.emitted_cases(emitted)
    arguments = {_test_name(a): rows for case in cases for a, rows in case.rows()}
    inputs = [_array(name, number, rows, emitted.dtype) for name, rows in arguments.items()]
    results = [_array(f"expected_{case.function.name}", "double", case.results, "float64") for case in cases]
    tests = [line for case in cases for line in _test(emitted, case)]
    tested = [template for template in emitted.templates if "c" in template.self_test]
    tests += [f"failed += {emitted.name_of(template.name)}_self_test();" for template in tested]
    return "\n".join([
        f"#ifdef {emitted.prefix.upper()}_SELF_TEST",
        "#include <stdio.h>",
        "",
        *inputs,
        *results,
        *([_DIFFERENCE.format(number=number)] if cases else []),
        *(filled(t.self_test["c"], t, emitted) for t in tested),
        "int main(void)",
        "{",
        *([f"    static {number} out[{max(case.function.width for case in cases)}];", "    double difference;",
           "    int i;"] if cases else []),
        "    int failed = 0;",
        *(f"    {line}" for line in tests),
        "    return failed > 0;",
        "}",
        "#endif",
        "",
    ])  # fmt: skip


def _test(emitted: EmittedArm, case: EmittedCase) -> Iterator[str]:
    name, width = case.function.name, case.function.width
    arguments = "".join(f"{_test_name(a)}[i], " for a in case.function.arguments)
    yield f"for (i = 0; i < {STATES}; i++) {{"
    yield f"    {emitted.name_of(name)}({arguments}out);"
    yield f"    difference = test_difference(out, expected_{name}[i], {width}) / {case.largest!r};"
    yield f'    printf("{name} %d: %.1e\\n", i, difference);'
    yield f"    failed += !(difference <= {emission.TOLERANCE[emitted.dtype]!r});"
    yield "}"


def _test_name(argument: Argument) -> str:
    return f"test_{argument.name}_{argument.width}"


def _array(name: str, number: str, rows: Array, dtype: str) -> str:
    lines = []
    for row in rows:
        text = ", ".join(literal(x, dtype) for x in row)
        lines.append(textwrap.fill(f"{{{text}}},", 116, initial_indent="    ", subsequent_indent="     "))
    return "\n".join([f"static const {number} {name}[{len(rows)}][{rows.shape[1]}] = {{", *lines, "};", ""])


_FAST_MATH = """\
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(_M_FP_FAST)
#error "compile without -ffast-math, -Ofast, /fp:fast: they change results, and break the sine and cosine of this file"
#endif
"""

_PRECISION = """\
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "compile for arithmetic in the type itself (-mfpmath=sse): sine and cosine here rely on its rounding"
#endif
"""

_UNCONTRACTED = """\
#if defined(__clang__) && defined(__STDC__)
#pragma STDC FP_CONTRACT OFF
#endif
"""
"""clang, unlike gcc with -std=c99, otherwise contracts a product and a sum of one statement."""


def c_files(emitted: EmittedArm, path: Path) -> dict[Path, str]:
    """FILE.c and FILE.h; raises `OptionError` for a path with another ending, or that #include cannot name."""
    if path.suffix != ".c":
        raise OptionError("--out", repr(str(path)), "a path that ends in .c")
    header = path.with_suffix(".h")
    if any(c in header.name for c in '"\\') or not header.name.isprintable():
        raise OptionError("--out", repr(header.name), "a file name without quotes, backslashes, control characters")
    return {path: c_text(emitted, header.name), header: header_text(emitted, header.stem)}


def c_text(emitted: EmittedArm, header: str) -> str:
    """The source, which includes the header of that name."""
    library = emitted.templates or any(needs_library(code) for code in emitted.codes)
    parts = [
        comment(emission.provenance_lines(emitted)),
        f'#include "{header}"\n' + ("#include <math.h>\n" if library else "") + "#include <float.h>\n",
        _FAST_MATH + (_PRECISION if emitted.kind == "own" else ""),
        *filter(None, [shared_functions(emitted.codes)]),
        *(c_function(code, emitted.name_of(code.function.name), restrict_of(emitted)) for code in emitted.codes),
        *([_UNCONTRACTED] if emitted.templates else []),
        *(filled(template.written("c", emitted.kind), template, emitted) for template in emitted.templates),
        self_test(emitted),
    ]
    return "\n".join(parts)


def header_text(emitted: EmittedArm, stem: str) -> str:
    """The header: a declaration of each function with its units; C++ takes it too."""
    guard = "_".join([*dict.fromkeys((emitted.prefix, identifier(stem))), "h"]).upper()
    restrict = restrict_of(emitted)
    parts = [
        comment(emission.provenance_lines(emitted)),
        f"#ifndef {guard}\n#define {guard}\n",
        f"#if defined(__cplusplus) || defined(_MSC_VER)\n#define {restrict}\n#else",
        f"#define {restrict} restrict\n#endif\n",
        '#ifdef __cplusplus\nextern "C" {\n#endif\n',
        *_declarations(emitted),
        "#ifdef __cplusplus\n}\n#endif\n",
        "#endif\n",
    ]
    return "\n".join(parts)


def comment(lines: list[str]) -> str:
    """Lines as a comment of C."""
    return "\n".join(["/*", *(f" * {line}" for line in lines), " */", ""])


def filled(text: str, template: TemplateFunction, emitted: EmittedArm) -> str:
    """A text of a template with its names."""
    number, _ = C_TYPES[emitted.dtype]
    return text.replace("@NAME@", emitted.name_of(template.name)).replace("@NUMBER@", number)


def restrict_of(emitted: EmittedArm) -> str:
    """The macro that stands for C's restrict, which C++ does not have."""
    return f"{emitted.prefix.upper()}_RESTRICT"


def _declarations(emitted: EmittedArm) -> Iterator[str]:
    for code in emitted.codes:
        name = emitted.name_of(code.function.name)
        yield comment(_described(code)) + f"{declaration(code, name, restrict_of(emitted))};\n"
    for template in emitted.templates:
        lines = [x for line in template.text.splitlines() for x in wrapped(line)]
        yield comment(lines) + f"{filled(template.declaration['c'], template, emitted)};\n"


def _described(code: EmittedCode) -> list[str]:
    function = code.function
    where = "out must not overlap an argument" if code.stores_early else "out may be an argument"
    texts = [
        f"{function.text}; {code.operations} operations, {where}",
        *(f"{a.name} [{a.unit}]" for a in function.arguments),
        f"out [{function.unit}]",
    ]
    return [line for text in texts for line in wrapped(text)]
