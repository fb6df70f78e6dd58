"""Machine code: where its vectors and constants lie; of texts in C: types, choices, loops, the table of an arm."""

import platform
import re
from dataclasses import replace

import numpy as np
import pytest
from llvmlite import binding as llvm

import lwr_dyn
from lwr_dyn.codegen.kernels import machine_code
from lwr_dyn.codegen.kernels.kernel import address
from lwr_dyn.codegen.kernels.kernel_source import generate
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec
from lwr_dyn.codegen.kernels.llvm_text import llvm_text, table, table_places
from lwr_dyn.codegen.kernels.lowering import body_assembly
from lwr_dyn.codegen.kernels.machine_code import load, target_machine
from lwr_dyn.kinematics.closed_forms.text_parser import parsed
from lwr_dyn.model.chain import first_links

IS_X86 = platform.machine().lower() in ("x86_64", "amd64")


@pytest.mark.slow
@pytest.mark.skipif(not IS_X86, reason="reads the assembly of x86-64")
@pytest.mark.parametrize(("function", "layout"), [("coriolis_matrix", "rows"), ("forward_dynamics", "blocks")])
def test_spilled_vectors_are_aligned_and_constants_need_no_address_of_64_bits(function, layout):
    source = generate(kernel_spec(lwr_dyn.load("lwr4plus"), layout=layout), function)
    loop = source.loop.around(source.body)
    bodies = [body_assembly(x.text, x.name, "float64", x.is_streaming) for x in loop.bodies]
    assert len(bodies) == (2 if layout == "blocks" else 1)
    for body in bodies:
        written = target_machine(near=True).emit_assembly(llvm.parse_assembly(body))
        on_stack = re.findall(r"vmov(\w)pd\t[^\n]*\(%[re][sb]p\)", written)
        assert set(on_stack) == {"a"}  # not u, unaligned
        assert len(on_stack) > 20
        assert "movabs" not in written
        assert written.count("(%rip)") > 20


@pytest.mark.skipif(not IS_X86, reason="relocations of x86-64")
def test_a_whole_kernel_finds_its_constants_near():
    """Its body is a function of its own, but not one that others could call, which would count as far away."""
    arm = lwr_dyn.load("lwr4plus")
    chain = first_links(arm.chain, 2)
    source = generate(kernel_spec(replace(arm, chain=chain)), "potential_energy")
    assert machine_code._is_near(source.loop.around(source.body).machine_code())


@pytest.mark.skipif(not IS_X86, reason="relocations of x86-64")
@pytest.mark.parametrize(
    ("call", "is_near"), [("", True), ("call void @llvm.memset.p0.i64(ptr %x, i8 0, i64 %n, i1 0)", False)]
)
def test_code_that_calls_a_library_is_loaded_and_runs(call, is_near):
    """It finds the library by 64 bits: distances of 32 bits are for its own constants alone."""
    text = f"""
    declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
    define i64 @f(ptr %x, ptr %b, i64 %n, i64 %stop) {{
      {call}
      %y = load double, ptr %b
      %z = fmul double %y, 1.25
      store double %z, ptr %b
      ret i64 7
    }}"""
    code = machine_code.machine_code(llvm.parse_assembly(text))
    assert machine_code._is_near(code) is is_near
    assert machine_code._relocations(code) == ({2} if is_near else set())
    x, b = np.ones(64), np.array([4.0])
    loaded = machine_code.load(code, "f", 0)
    assert loaded.call(x.ctypes.data, b.ctypes.data, 8 * 64, 0) == 7
    assert b[0] == 5.0
    assert x.sum() == (64.0 if is_near else 0.0)


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
    assert [called("return (int)(given[0]);", [x])[0] for x in (2.9, -2.9)] == [2, -2]


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
