"""Random numbers, encoder and delay on symbols against the sensor and the delay of `simulate`, sample by sample."""

import ctypes

import casadi
import numpy as np
import pytest
from llvmlite import binding as llvm

from lwr_dyn.codegen.kernels.loop_code import KernelLoop
from lwr_dyn.codegen.kernels.machine_code import target_machine
from lwr_dyn.codegen.rollouts import step
from lwr_dyn.codegen.rollouts.philox_code import CountedEncoder, normal_numbers, philox, uniform_code, uniform_numbers
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.closed_forms.text_parser import parsed
from lwr_dyn.model.spatial import Vector
from lwr_dyn.simulation.loops import delayed
from lwr_dyn.simulation.plant import Encoder

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
DRAWN = 5


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
    out = np.zeros((DRAWN, words + 4, lanes))
    kind(engine.get_function_address("kernel"))(out.ctypes.data, buffer.ctypes.data, seed - 2**64, run, DRAWN)
    for lane in range(lanes):
        assert (out[:, 3:-1, lane] == uniform_numbers(seed, run + lane, DRAWN, words)).all()
    assert (out[:, :3] == -1.0).all()
    assert (out[:, -1] == -1.0).all()


N, SAMPLES, RATE = 3, 60, 500.0


def _encoder_function(encoder: Encoder, by_run: bool, noisy: bool) -> casadi.Function:
    q, dq, memory, noise = (casadi.SX.sym(name, size) for name, size in (("q", N), ("dq", N), ("m", 2 * N), ("e", N)))
    first, resolution = casadi.SX.sym("first"), casadi.SX.sym("resolution")
    count = resolution if by_run else encoder.resolution
    pole = encoder.velocity_filter(RATE).pole
    reading = step.encoder_reading(q, dq, memory, noise if noisy else None, count, pole, RATE, first)
    return casadi.Function("sample", [q, dq, memory, noise, resolution, first], list(reading))


@pytest.mark.parametrize("by_run", [True, False])
@pytest.mark.parametrize("noise", [0.0, 3e-4])
@pytest.mark.parametrize("resolution", [0.0, 0.01, 2 * np.pi / 2**12])
def test_readings_are_those_of_the_sensor(resolution: float, noise: float, by_run: bool) -> None:
    encoder = CountedEncoder(resolution, noise, 40.0, run=6)
    t = np.arange(SAMPLES)[:, None] / RATE
    phase = 3.0 * t + np.arange(N)
    q, dq = np.sin(phase), 3.0 * np.cos(phase)
    q[0] = [0.005, 0.015, -0.025]  # between two counts
    measure = encoder.sensor(q[0], dq[0], SAMPLES, RATE, seed=5)
    sample, memory = _encoder_function(encoder, by_run, noise > 0.0), np.zeros(2 * N)
    added = noise * normal_numbers(5, 6, SAMPLES, N)
    for k in range(SAMPLES):
        seen = measure(q[k], dq[k])
        *reading, memory = (x.full().ravel() for x in sample(q[k], dq[k], memory, added[k], resolution, k == 0))
        assert (reading[0] == seen[0]).all()
        assert np.abs(reading[1] - seen[1]).max() < 1e-12


def test_rounded_gives_halves_to_the_even_number() -> None:
    x = casadi.SX.sym("x", 8)
    values = np.array([-2.5, -1.5, -0.5, 0.5, 1.5, 2.4999999999999996, 7e5 + 0.5, -3.7])
    assert (casadi.Function("f", [x], [step.rounded(x)])(values).full().ravel() == np.round(values)).all()


def test_normals_are_those_of_philox() -> None:
    u = casadi.SX.sym("u", 8)
    function = casadi.Function("f", [u], [step.normals(u, 7)])
    expected = normal_numbers(1, 2, 9, 7)
    for row, uniform in zip(expected, uniform_numbers(1, 2, 9, 8), strict=True):
        assert np.abs(function(uniform).full().ravel() - row).max() < 1e-14


@pytest.mark.parametrize("most", [0, 1, 4])
def test_late_commands_are_those_of_a_delayed_controller(most: int) -> None:
    command, memory = casadi.SX.sym("c", N), casadi.SX.sym("m", N * most)
    delay, sample = casadi.SX.sym("d"), casadi.SX.sym("k")
    late = step.late_command(command, memory, delay, sample)
    function = casadi.Function("late", [command, memory, delay, sample], list(late))
    commands = np.random.default_rng(0).normal(size=(12, N))
    for samples in range(most + 1):
        given = iter(commands)
        controller = delayed(lambda *_, given=given: next(given), samples)
        kept = np.zeros(N * most)
        for k in range(12):
            expected = controller(0.0, *np.zeros((5, N)))
            found, kept = (x.full().ravel() for x in function(commands[k], kept, samples, k))
            assert (found == expected).all()


def test_an_encoder_of_a_run_differs_in_its_noise_alone() -> None:
    plain, counted = Encoder(0.01, 2e-3, 30.0), CountedEncoder(0.01, 2e-3, 30.0, run=4)
    assert (counted.noise_of(9, N, seed=8) == 2e-3 * normal_numbers(8, 4, 9, N)).all()
    assert (plain.noise_of(9, N, seed=8) == np.random.default_rng(8).normal(0.0, 2e-3, (9, N))).all()
    silent, zero = CountedEncoder(0.01, 0.0, 30.0, run=4), np.zeros(N)
    for encoder in (silent, Encoder(0.01, 0.0, 30.0)):
        measure = encoder.sensor(zero, zero, 3, RATE, 0)
        assert [measure(np.full(N, x), zero)[0][0] for x in (0.004, 0.006, 0.016)] == [0.0, 0.01, 0.02]


def test_figures_of_samples_are_sums_and_largest_values() -> None:
    """Two samples of two joints; the second is the last, which has no duration."""
    joint = {
        name: casadi.DM([step.STARTS[name]] * 2) if name in step.OF_JOINTS else casadi.DM(step.STARTS[name])
        for name in step.FIGURES
    }
    x = joint | {"tolerance": 8.0, "last": 1.0, "nothing": 0.0, "tip": casadi.DM([1.0, 2.0, 3.0])}
    x |= {"lower": casadi.DM([-1.0, -2.0]), "upper": casadi.DM([1.5, 2.0]), "rating": casadi.DM([5.0, 50.0])}

    def after(k, q, dq, command, applied, away):
        given = {"q": casadi.DM(q), "dq": casadi.DM(dq), "sample": casadi.DM(k), "reference": casadi.DM([0.0] * 6)}
        return step.figures(x | given, Vector(1.0 + away, 2.0, 3.0 - away), casadi.DM(command), casadi.DM(applied))

    x |= after(0, [0.5, -1.0], [1.0, -3.0], [6.0, -7.0], [5.0, -7.0], 2.0)
    x |= (out := after(1, [1.0, 0.5], [2.0, 1.0], [9.0, 1.0], [5.0, 1.0], 3.0))
    assert {name: casadi.DM(value).full().ravel().tolist() for name, value in out.items()} == {
        "tip_squares": [26.0], "tip_worst": [18.0], "tip_square": [18.0], "position_squares": [1.25, 1.25],
        "position_worst": [1.0, 1.0], "torque_worst": [5.0, 7.0], "command_worst": [9.0, 7.0],
        "torque_squares": [50.0, 50.0], "speed_worst": [2.0, 3.0], "saturated": [1.0, 0.0], "margin": [0.5, 1.0],
        "violation": [1.0], "angle_worst": [1.25], "trouble": [0.0],
    }  # fmt: skip
    for place in range(3):
        bad = [[np.nan, 0.0] if i == place else [0.0, 0.0] for i in range(3)]
        assert np.isnan(float(after(1, *bad, [0.0, 0.0], 0.0)["trouble"]))


def test_slots_stand_one_after_the_other() -> None:
    slots = step.Slots({"a": 2, "none": 0, "b": 3})
    found = slots.first("b"), slots.places("b"), slots.all_places(["b", "a"]), slots.size
    assert found == (2, range(2, 5), [2, 3, 4, 0, 1], 5)
    assert slots.filled({"b": [1.0, 2.0, 3.0], "none": []}).tolist() == [0.0, 0.0, 1.0, 2.0, 3.0]
