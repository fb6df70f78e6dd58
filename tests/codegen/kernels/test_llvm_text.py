"""Texts as LLVM's language, compiled and called: types, choices that are not worked out, loops, the arm's table."""

import numpy as np
import pytest
from llvmlite import binding as llvm

from lwr_dyn.codegen.kernels.kernel import address
from lwr_dyn.codegen.kernels.llvm_text import llvm_text, table, table_places
from lwr_dyn.codegen.kernels.machine_code import load, target_machine
from lwr_dyn.kinematics.closed_forms.text_parser import parsed

NUMBERS = {"ROW": np.array([2.0, 3.0, 5.0]), "SCALE": 7.0, "COUNT": 3}
CONSTANTS = {"FIXED": (0.5, 0.25), "HALF": 0.5}


def called(body, given=(), size=4, extra=""):
    """What a function of this body leaves in `out`, and its result."""
    text = f"static const double SMALL = 1e-3;\n{extra}\nint f(const double *given, double *out)\n{{\n{body}\n}}\n"
    module = llvm.parse_assembly(llvm_text(parsed(text, {"COUNT": 3}), CONSTANTS, table_places(NUMBERS), "f"))
    module.verify()
    code = load(target_machine().emit_object(module), "kernel", 1)
    x, out, numbers = np.array([*given, 0.0]), np.zeros(size), table(NUMBERS)
    result = code.call(address(x), 0, address(out), address(numbers), 0, 0)
    return result, out.tolist()


def test_constants_of_all_kinds():
    assert called("out[0] = ROW[2] * SCALE;\nout[1] = FIXED[1] + HALF;\nout[2] = SMALL;\nreturn COUNT;") == (
        3, [35.0, 0.75, 1e-3, 0.0]
    )  # fmt: skip


def test_whole_numbers_become_doubles_where_they_are_kept_as_such():
    body = "const int k = 7 % 4;\ndouble x = 0.0;\nx = k;\nout[k - 2] = x / 2.0;\nout[0] = -k + 0.5;"
    body += "\nreturn k == 3 ? 9 : 8;"
    assert called(body) == (9, [-2.5, 1.5, 0.0, 0.0])


@pytest.mark.parametrize(("x", "wanted"), [(-1.0, 1), (0.5, 2), (3.0, 3), (float("nan"), 3)])
def test_branches_and_returns(x, wanted):
    body = "if (given[0] < 0.0) {\n return 1;\n} else if (given[0] < 1.0) {\n return 2;\n}\nreturn 3;"
    assert called(body, [x])[0] == wanted


def test_what_is_not_chosen_is_not_worked_out():
    """The array's end would be passed, far."""
    body = (
        "int i = 0;\nwhile (i < 2 && given[1000000000 * i] > 0.5) {\n i++;\n if (given[0] > 0.5) {\n return i;\n }\n}\n"
        "out[1] = i == 0 || given[1000000000] > 0.0 ? 4.0 : given[1000000000];\nreturn 5;"
    )
    assert called(body, [1.0]) == (1, [0.0, 0.0, 0.0, 0.0])
    assert called(body, [0.0]) == (5, [0.0, 4.0, 0.0, 0.0])


def test_functions_arrays_and_loops():
    extra = (
        "static void twice(const double *a, int at, double *b)\n{\n    for (int i = 0; i < 2; i++) {\n"
        "        b[at + i] = 2.0 * a[i];\n    }\n}\n"
        "static double root(double x)\n{\n    return sqrt(fabs(x)) + floor(-0.5) + copysign(2.0, x);\n}\n"
    )
    body = "double A[2];\ntwice(given, 0, A);\ntwice(A, 2, out);\nout[0] = root(-9.0);\nreturn !(A[0] > 1.0) ? 1 : 0;"
    assert called(body, [3.0, 4.0], extra=extra) == (0, [0.0, 0.0, 12.0, 16.0])


def test_products_and_sums_are_not_fused():
    """1 + 2^-30 squared, less its rounded square: 0 in two roundings, 2^-60 in one."""
    body = "const double x = given[0];\nout[0] = x * x - given[1];\nreturn 0;"
    x = 1.0 + 2.0**-30
    assert called(body, [x, x * x])[1][0] == 0.0
