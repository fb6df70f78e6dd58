"""Loops in C with bodies, helpers and constants as machine code; that of a batch around a body written by hand."""

from dataclasses import replace

import numpy as np
import pytest
from llvmlite import ir

from lwr_dyn.codegen.kernels.block_loop import BlockLoop
from lwr_dyn.codegen.kernels.kernel import address, aligned
from lwr_dyn.codegen.kernels.loop_code import KernelLoop, LaneBody
from lwr_dyn.codegen.kernels.loop_helpers import helper
from lwr_dyn.codegen.kernels.lowering import NUMBERS
from lwr_dyn.codegen.kernels.machine_code import load
from lwr_dyn.codegen.kernels.result_form import ResultForm, row_step
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


LANES, WIDTHS = 4, (1, 9)
BODY = """def body(b, out, at):
    for k in range(4):
        x = b[0 + k]
        first = b[4 + k]
        last = b[36 + k]
        total = x + first
        off = x - x
        b[40 + k] = off
        {0} = total
        {1} = last
"""
"""Results: x + y0 and y8; a flag where x is not finite."""


def kernel(layout, dtype):
    step = row_step(layout, 2, LANES)
    form = "out[at + {} + k]" if layout == "blocks" else f"out[at + k * {step} + {{}}]"
    places = (0, LANES) if layout == "blocks" else (0, 1)
    loop = BlockLoop(("x", "y"), WIDTHS, LANES, layout, 2, step, dtype)
    code = load(loop.around(BODY.format(*map(form.format, places))).machine_code(), "kernel", 2)
    return loop, ResultForm(layout, (2,), LANES, dtype), code


@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize("layout", ["rows", "padded", "blocks"])
def test_every_state_has_its_results_and_nothing_else_is_written(layout, dtype):
    loop, form, code = kernel(layout, dtype)
    rng, size = np.random.default_rng(0), np.dtype(dtype).itemsize
    for count in (1, 2, 4, 7, 8, 9, 23):
        x, y = rng.uniform(size=(count, 1)).astype(dtype), rng.uniform(size=(count, 9)).astype(dtype)
        x[count // 2] = np.nan
        for is_shared in (False, True):
            out, (memory, buffer) = form.empty(count), aligned(loop.buffer * size)
            given = (address(x), 1, address(y), 0 if is_shared else 9)
            assert code.call(*given, address(out), buffer, 0, count) == 1
            del memory
            rows = form.states_first(out, count)
            seen = np.broadcast_to(y[0], y.shape) if is_shared else y
            wanted = np.stack([x[:, 0] + seen[:, 0], seen[:, 8]], axis=1)
            assert np.array_equal(rows, wanted, equal_nan=True)
            if layout == "blocks":  # the last block repeats the last state
                rest = out[-1, :, (count - 1) % LANES :]
                assert np.array_equal(rest, np.broadcast_to(rest[:, :1], rest.shape), equal_nan=True)


def test_a_part_of_the_states_leaves_the_others():
    loop, form, code = kernel("rows", "float64")
    x, y, out = np.ones((20, 1)), np.arange(180.0).reshape(20, 9), np.full((20, 2), 7.0)
    memory, buffer = aligned(loop.buffer * 8)
    assert code.call(address(x), 1, address(y), 9, address(out), buffer, 3, 14) == 0
    del memory
    assert (np.delete(out, range(3, 14), axis=0) == 7.0).all()
    assert (out[3:14] == np.stack([1.0 + y[3:14, 0], y[3:14, 8]], axis=1)).all()
    assert form.shape_of(20) == out.shape
