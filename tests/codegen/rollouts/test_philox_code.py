"""The vector instructions of Philox: bit for bit the words of NumPy, in every lane of every width."""

import ctypes

import numpy as np
import pytest
from llvmlite import binding as llvm

from lwr_dyn.codegen.kernels.machine_code import compiled, target_machine
from lwr_dyn.codegen.rollouts.philox import uniform_numbers

SOURCE = """
from numba import carray, cfunc, types
from lwr_dyn.codegen.rollouts.philox_code import uniform_code

fill = uniform_code({lanes}, {words}, 3)
number = types.CPointer(types.float64)

@cfunc(types.int64(number, number, types.int64, types.int64, types.int64))
def kernel(out_, b_, seed, run, samples):
    b = carray(b_, (({words} + 4) * {lanes},), types.float64)
    out = carray(out_, (samples * ({words} + 4) * {lanes},), types.float64)
    for k in range(samples):
        fill(b, seed, run, k)
        for i in range(b.size):
            out[k * b.size + i] = b[i]
    return 0
"""
SAMPLES = 5


@pytest.mark.parametrize("lanes", [1, 4, 8])
def test_every_lane_has_the_numbers_of_its_run(lanes: int) -> None:
    words, seed, run = 8, 2**63 + 12345, 2**32 - 3  # lanes on both sides of a run's low half
    code, name = compiled(SOURCE.format(lanes=lanes, words=words))
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    kind = ctypes.CFUNCTYPE(ctypes.c_int64, *[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 3)
    room = np.full((words + 4) * lanes + 8, -1.0)
    buffer = room[-room.ctypes.data % 64 // 8 :][: (words + 4) * lanes]
    out = np.zeros((SAMPLES, words + 4, lanes))
    kind(engine.get_function_address(name))(out.ctypes.data, buffer.ctypes.data, seed - 2**64, run, SAMPLES)
    for lane in range(lanes):
        assert (out[:, 3:-1, lane] == uniform_numbers(seed, run + lane, SAMPLES, words)).all()
    assert (out[:, :3] == -1.0).all()
    assert (out[:, -1] == -1.0).all()
