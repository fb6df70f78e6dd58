"""Philox against the known answers of Random123, the normal numbers made of it, and its vector code bit for bit."""

import ctypes

import numpy as np
import pytest
from llvmlite import binding as llvm

from lwr_dyn.codegen.kernels.loop_code import KernelLoop
from lwr_dyn.codegen.kernels.machine_code import target_machine
from lwr_dyn.codegen.rollouts.philox_code import normal_numbers, philox, uniform_code, uniform_numbers
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.closed_forms.text_parser import parsed

KNOWN = [
    ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
]
"""Rows "philox4x32 10" of tests/kat_vectors in Random123 1.14: counter, key, words."""


def _words(text: str) -> np.ndarray:
    return np.array([int(word, 16) for word in text.split()], dtype=np.uint32)


def test_known_answers_of_random123() -> None:
    for counter, key, words in KNOWN:
        assert (philox(_words(counter), _words(key)) == _words(words)).all()
    counters, keys, words = (np.array([_words(row[i]) for row in KNOWN]) for i in range(3))
    assert (philox(counters, keys) == words).all()


def test_the_counter_is_sample_block_and_run_and_the_key_the_seed() -> None:
    seed, run = 0x0123456789ABCDEF, 0xFEDCBA9876543210
    uniform = uniform_numbers(seed, run, 5, 8)
    counter = np.array([4, 1, 0x76543210, 0xFEDCBA98], dtype=np.uint32)
    words = philox(counter, np.array([0x89ABCDEF, 0x01234567], dtype=np.uint32))
    assert (uniform[4, 4:] == (words + 0.5) / 2.0**32).all()
    assert uniform.min() > 0.0
    assert uniform.max() < 1.0


def test_moments_of_the_normal_distribution_and_no_correlation() -> None:
    x = np.array([normal_numbers(7, run, 4000, 7) for run in range(20)])  # 560 000 numbers
    one = x.size**-0.5
    assert abs(x.mean()) < 4 * one
    assert abs(x.var() - 1.0) < 4 * np.sqrt(2) * one
    assert abs((x**3).mean()) < 4 * np.sqrt(15) * one
    assert abs((x**4).mean() - 3.0) < 4 * np.sqrt(96) * one
    share = [(x < z).mean() for z in (-2.0, -1.0, 0.0, 1.0, 2.0)]
    assert np.abs(np.array(share) - [0.0227501, 0.1586553, 0.5, 0.8413447, 0.9772499]).max() < 2 * one
    joints = np.corrcoef(x.reshape(-1, 7).T) - np.eye(7)
    assert np.abs(joints).max() < 4.5 / np.sqrt(80_000)
    for neighbour in (np.roll(x, 1, axis=0), np.roll(x, 1, axis=1), np.roll(x * x, 1, axis=0) - 1.0):
        assert abs((x * neighbour).mean()) < 5 * np.sqrt(2) * one


def test_numbers_of_a_run_do_not_depend_on_how_many_are_drawn() -> None:
    long = normal_numbers(3, 11, 50, 7)
    assert (normal_numbers(3, 11, 9, 7) == long[:9]).all()
    assert (normal_numbers(3, 11, 50, 5) == long[:, :5]).all()
    for other in (normal_numbers(3, 12, 50, 7), normal_numbers(4, 11, 50, 7), normal_numbers(3 << 32, 11, 50, 7)):
        assert not np.isclose(other, long, atol=1e-3).any(axis=1).all()


@pytest.mark.parametrize("value", [-1, 2**64, 0.5, True])
def test_a_seed_of_other_than_64_bits_is_refused(value: object) -> None:
    with pytest.raises(OptionError, match="seed"):
        normal_numbers(value, 0, 1, 1)  # type: ignore[arg-type]
    with pytest.raises(OptionError, match="number of the run"):
        normal_numbers(0, value, 1, 1)  # type: ignore[arg-type]


SOURCE = """
int kernel_of(double *out, double *b, int seed, int run, int samples)
{
    for (int k = 0; k < samples; k++) {
        fill(b, seed, run, k);
        for (int i = 0; i < SIZE; i++) {
            out[k * SIZE + i] = b[i];
        }
    }
    return 0;
}
"""
SAMPLES = 5


@pytest.mark.parametrize("lanes", [1, 4, 8])
def test_every_lane_has_the_numbers_of_its_run(lanes: int) -> None:
    words, seed, run = 8, 2**63 + 12345, 2**32 - 3  # lanes on both sides of a run's low half
    text = parsed(SOURCE, {"SIZE": (words + 4) * lanes})
    code = KernelLoop(text, "kernel_of", (), (uniform_code("fill", lanes, words, 3),)).machine_code()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    kind = ctypes.CFUNCTYPE(ctypes.c_int64, *[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 3)
    room = np.full((words + 4) * lanes + 8, -1.0)
    buffer = room[-room.ctypes.data % 64 // 8 :][: (words + 4) * lanes]
    out = np.zeros((SAMPLES, words + 4, lanes))
    kind(engine.get_function_address("kernel"))(out.ctypes.data, buffer.ctypes.data, seed - 2**64, run, SAMPLES)
    for lane in range(lanes):
        assert (out[:, 3:-1, lane] == uniform_numbers(seed, run + lane, SAMPLES, words)).all()
    assert (out[:, :3] == -1.0).all()
    assert (out[:, -1] == -1.0).all()
