"""A program at the end of an emitted file that compares each function with its test vectors.

cc -O2 -std=c99 -DLWR4PLUS_SELF_TEST lwr4plus.c -lm -o self_test && ./self_test
"""

import textwrap
from collections.abc import Iterator

from lwr_dyn.codegen.emit.c_source import C_TYPES, literal
from lwr_dyn.codegen.emit.cases import STATES, TOLERANCE, EmittedCase, emitted_cases
from lwr_dyn.codegen.emit.emission import EmittedArm
from lwr_dyn.codegen.emit.functions import Argument
from lwr_dyn.foundation.arrays import Array

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
    cases = emitted_cases(emitted)
    arguments = {_test_name(a): rows for case in cases for a, rows in case.rows()}
    inputs = [_array(name, number, rows, emitted.dtype) for name, rows in arguments.items()]
    results = [_array(f"expected_{case.function.name}", "double", case.results, "float64") for case in cases]
    tests = [line for case in cases for line in _test(emitted, case)]
    for template in emitted.templates:
        if "c" in template.self_test:
            tests.append(f"failed += {emitted.name_of(template.name)}_self_test();")
    return "\n".join([
        f"#ifdef {emitted.prefix.upper()}_SELF_TEST",
        "#include <stdio.h>",
        "",
        *inputs,
        *results,
        *([_DIFFERENCE.format(number=number)] if cases else []),
        *(t.self_test["c"].replace("@NAME@", emitted.name_of(t.name)).replace("@NUMBER@", number)
          for t in emitted.templates if "c" in t.self_test),
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
    yield f"    failed += !(difference <= {TOLERANCE[emitted.dtype]!r});"
    yield "}"


def _test_name(argument: Argument) -> str:
    return f"test_{argument.name}_{argument.width}"


def _array(name: str, number: str, rows: Array, dtype: str) -> str:
    lines = []
    for row in rows:
        text = ", ".join(literal(x, dtype) for x in row)
        lines.append(textwrap.fill(f"{{{text}}},", 116, initial_indent="    ", subsequent_indent="     "))
    return "\n".join([f"static const {number} {name}[{len(rows)}][{rows.shape[1]}] = {{", *lines, "};", ""])
