"""A loop in C with a body, a helper and constants as machine code; what is missing or of another type."""

from dataclasses import replace

import numpy as np
import pytest
from llvmlite import ir

from lwr_dyn.codegen.kernels.kernel import address
from lwr_dyn.codegen.kernels.loop_code import KernelLoop, LaneBody
from lwr_dyn.codegen.kernels.loop_helpers import helper
from lwr_dyn.codegen.kernels.lowering import NUMBERS
from lwr_dyn.codegen.kernels.machine_code import load
from lwr_dyn.kinematics.closed_forms.text_parser import parsed

TEXT = """
static int beyond(const double *x, int at)
{
    return x[at] > LIMIT;
}

int twice(const double *x, int step, double *out, double *b, int start, int stop)
{
    int many = 0;
    for (int i = start; i < stop; i++) {
        b[0] = x[i * step];
        double_it(b);
        to_place(b, out, 2 * i);
        out[2 * i + 1] = third(b, i) == 1 ? 1.0 : 0.0;
        many += beyond(b, 1);
    }
    return many;
}
"""
DOUBLE = "def double_it(b):\n    for k in range(1):\n        x = b[0 + k]\n        y = x + x\n        b[1 + k] = y\n"
TO_PLACE = "def to_place(b, out, at):\n    for k in range(1):\n        x = b[1 + k]\n        out[at + k * 1 + 0] = x\n"


def third(dtype):
    """Whether a whole number is 3."""
    is_three = lambda builder, given: builder.icmp_signed("==", given[1], ir.Constant(ir.IntType(64), 3))  # noqa: E731
    return helper("third", "int", (("double*", "b"), ("int", "i")), NUMBERS[dtype], is_three)


def loop(dtype="float64"):
    bodies = LaneBody("double_it", DOUBLE), LaneBody("to_place", TO_PLACE)
    return KernelLoop(parsed(TEXT, {}), "twice", bodies, (third(dtype),), {"LIMIT": 0.5}, dtype)


@pytest.mark.parametrize("dtype", NUMBERS)
def test_a_loop_calls_bodies_and_helpers(dtype):
    code = load(loop(dtype).machine_code(), "kernel", 1)
    x, out, b = np.linspace(0.0, 1.0, 16, dtype=dtype), np.full(12, 7.0, dtype=dtype), np.zeros(16, dtype=dtype)
    assert code.call(address(x), 3, address(out), address(b), 1, 5) == 3
    assert out[2:10:2].tolist() == (2 * x[3:15:3]).tolist()
    assert out[3:10:2].tolist() == [0.0, 0.0, 1.0, 0.0]
    assert out[[0, 1, 10, 11]].tolist() == [7.0] * 4


def test_only_float64_has_numbers_of_64_bits():
    assert " double" not in loop("float32").assembly()
    assert " float" not in loop().assembly()


def test_a_body_that_is_not_there_is_named():
    """A loop whose body calls something that nothing defines."""
    whole = loop()
    with pytest.raises(KeyError, match="to_place"):
        replace(whole, bodies=whole.bodies[:1]).assembly()
