"""Machine code of a kernel's body: vectors on the stack do not lie across cache lines, constants are near."""

import platform
import re
from dataclasses import replace

import numpy as np
import pytest
from llvmlite import binding as llvm

import lwr_dyn
from lwr_dyn.codegen.kernels import machine_code
from lwr_dyn.codegen.kernels.kernel_source import generate
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec
from lwr_dyn.codegen.kernels.lowering import body_assembly
from lwr_dyn.codegen.kernels.machine_code import target_machine
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
