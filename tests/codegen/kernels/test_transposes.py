"""Blocks of lanes by machine code of their own: transposes, rows of any width and step, what is read and fetched."""

import ctypes
import re

import numpy as np
import pytest
from llvmlite import binding as llvm
from llvmlite import ir

from lwr_dyn.codegen.kernels.loop_code import KernelLoop
from lwr_dyn.codegen.kernels.machine_code import load, target_machine
from lwr_dyn.codegen.kernels.transposes import LaneBlock, ResultRows, begins_on_vector, block_past_caches, rows_to_lanes
from lwr_dyn.kinematics.closed_forms.text_parser import parsed

LANES = 4
NUMBERS = {"float64": ir.DoubleType(), "float32": ir.FloatType()}


def function_of(build, dtype="float64", lanes=LANES, **options):
    """(module text, call of two arrays) of a function with this body, `build(block, source, target)`."""
    number, module = NUMBERS[dtype], ir.Module("lanes")
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [number.as_pointer()] * 2), "f")
    builder = ir.IRBuilder(function.append_basic_block())
    build(LaneBlock(builder, number, lanes, **options), *function.args)
    builder.ret_void()

    def call(source, target):
        engine = llvm.create_mcjit_compiler(llvm.parse_assembly(str(module)), target_machine())
        engine.finalize_object()
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in (source, target)]
        ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(engine.get_function_address("f"))(*pointers)
        return target

    return str(module), call


def columns(block, source, count):
    return [block.load(source, block.index(j * block.lanes)) for j in range(count)]


@pytest.mark.parametrize("dtype", NUMBERS)
@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
def test_lane_i_of_vector_k_becomes_lane_k_of_vector_i(lanes, dtype):
    def build(block, source, target):
        for i, vector in enumerate(block.transposed(columns(block, source, lanes))):
            block.store(vector, target, block.index(i * lanes))

    given = np.arange(lanes * lanes, dtype=dtype)
    _, call = function_of(build, dtype, lanes)
    assert (call(given, np.zeros_like(given)).reshape(lanes, lanes) == given.reshape(lanes, lanes).T).all()


def test_a_transpose_takes_log2_rounds_of_shuffles():
    text, _ = function_of(lambda block, a, b: block.transposed(columns(block, a, 8)), lanes=8)
    assert text.count("shufflevector") == 3 * 8


@pytest.mark.parametrize("is_streaming", [False, True])
@pytest.mark.parametrize("dtype", NUMBERS)
@pytest.mark.parametrize(
    ("width", "step"), [(1, 1), (1, 3), (2, 2), (3, 3), (2, 3), (4, 4), (5, 5), (5, 8), (6, 6), (8, 8), (9, 9), (3, 6)]
)
def test_results_go_to_their_rows_and_nowhere_behind_the_last(width, step, dtype, is_streaming):
    """Whole vectors may write over what pads a row of at least a vector; columns come in any order."""
    order = np.random.default_rng(width).permutation(width)

    def build(block, source, target):
        rows, known = ResultRows(block, target, width, step), columns(block, source, width)
        for j in order.tolist():
            rows.put(j, known[j])
        assert rows.columns == {}

    given = np.arange(1.0, 1.0 + LANES * width, dtype=dtype)
    is_aligned = step % LANES == 0
    _, call = function_of(build, dtype, is_streaming=is_streaming and is_aligned)
    memory = np.full(LANES * step + 40, 77.0, dtype)
    begin = -memory.ctypes.data // memory.itemsize % 16
    out = memory[begin:]
    call(given, out)
    rows = out[: LANES * step].reshape(LANES, step)
    assert (rows[:, :width] == given.reshape(width, LANES).T).all()
    assert (out[LANES * step :] == 77.0).all()
    if step >= LANES and width + LANES - width % LANES > step:
        assert (rows[:, width:] == 77.0).all()


@pytest.mark.parametrize("count", [1, 3, 4])
def test_the_first_numbers_leave_what_stands_behind_them(count):
    def build(block, source, target):
        block.store_first(block.load(source, block.index(0)), count, target, block.index(1))

    text, call = function_of(build)
    assert call(np.arange(4.0), np.full(6, 7.0)).tolist() == [7.0, *range(count), *[7.0] * (5 - count)]
    assert ("llvm.masked.store.v4f64" in text) == (count < 4)


def test_places_alignment_and_what_goes_past_the_caches():
    def build(block, source, target):
        vector = block.load(source, block.slot(2, block.index(3)), aligned=True)
        block.fetch(source, block.index(640))
        block.store(vector, target, block.index(0), aligned=True)
        block.give(block.load(source, block.index(1)), target, block.index(8))
        block.store_number(vector, 2, target, 5)

    for is_streaming in (False, True):
        text, _ = function_of(build, is_streaming=is_streaming)
        assert re.findall(r"align (\d+)", text) == ["32", "32", "8", "32" if is_streaming else "8"]
        assert ("!nontemporal" in text) == is_streaming
        assert re.search(r"@\"llvm.prefetch.p0\"\(i8\* .*, i32 0, i32 3, i32 1\)", text)
        assert (LaneBlock(None, NUMBERS["float32"], 8).bits, LaneBlock(None, NUMBERS["float64"], 8).bits) == (32, 64)
    given, target = (np.zeros(700 + 16)[k:] for k in (0, 0))
    given, target = (array[-array.ctypes.data // 8 % 8 :] for array in (given, target))
    given[:] = np.arange(len(given))
    _, call = function_of(build)
    assert call(given, target)[:12].tolist() == [20.0, 21.0, 22.0, 23.0, 0.0, 22.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0]


BOTH = """
int both(const double *x, int unused, double *out, double *b, int start, int stop)
{
    read(x, 1, 5, b, 0);
    copy(b, out, 4);
    return begins(out) * 2 + begins(x);
}
"""


def test_rows_are_read_into_lanes_and_blocks_written_past_the_caches():
    number = NUMBERS["float64"]
    helpers = (
        rows_to_lanes("read", number, LANES, 3, 2),
        block_past_caches("copy", number, LANES, 2, 8),
        begins_on_vector("begins", number, LANES),
    )
    code = load(KernelLoop(parsed(BOTH, {}), "both", (), helpers).machine_code(), "kernel", 1)

    def both(x, b, out):
        return code.call(x.ctypes.data, 0, out.ctypes.data, b.ctypes.data, 0, 0)

    given, memory = np.arange(48.0), np.full(80, 77.0)
    memory, given = memory[-memory.ctypes.data // 8 % 8 :], given[-given.ctypes.data // 8 % 8 :]
    x = given[1:41]
    b, out = memory[:32], memory[32:64]
    assert both(x, b, out) == 2  # out begins a vector, x does not
    expected = x[1 + 5 * np.arange(LANES) + np.arange(3)[:, None]]
    assert (b[8:20].reshape(3, LANES) == expected).all()
    assert (np.delete(b, range(8, 20)) == 77.0).all()
    assert (out[4:12] == b[8:16]).all()
    assert (np.delete(out, range(4, 12)) == 77.0).all()
