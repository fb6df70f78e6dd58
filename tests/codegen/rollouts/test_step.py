"""Encoder and delay on symbols against the sensor and the delay of `simulate`, sample by sample."""

import casadi
import numpy as np
import pytest

from lwr_dyn.codegen.rollouts.philox_code import CountedEncoder, normal_numbers, uniform_numbers
from lwr_dyn.codegen.rollouts.step import (
    FIGURES,
    OF_JOINTS,
    STARTS,
    Slots,
    encoder_reading,
    figures,
    late_command,
    normals,
    rounded,
)
from lwr_dyn.model.spatial import Vector
from lwr_dyn.simulation.loops import delayed
from lwr_dyn.simulation.plant import Encoder

N, SAMPLES, RATE = 3, 60, 500.0


def _encoder_function(encoder: Encoder, by_run: bool, noisy: bool) -> casadi.Function:
    q, dq, memory, noise = (casadi.SX.sym(name, size) for name, size in (("q", N), ("dq", N), ("m", 2 * N), ("e", N)))
    first, resolution = casadi.SX.sym("first"), casadi.SX.sym("resolution")
    count = resolution if by_run else encoder.resolution
    pole = encoder.velocity_filter(RATE).pole
    reading = encoder_reading(q, dq, memory, noise if noisy else None, count, pole, RATE, first)
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
    assert (casadi.Function("f", [x], [rounded(x)])(values).full().ravel() == np.round(values)).all()


def test_normals_are_those_of_philox() -> None:
    u = casadi.SX.sym("u", 8)
    function = casadi.Function("f", [u], [normals(u, 7)])
    expected = normal_numbers(1, 2, 9, 7)
    for row, uniform in zip(expected, uniform_numbers(1, 2, 9, 8), strict=True):
        assert np.abs(function(uniform).full().ravel() - row).max() < 1e-14


@pytest.mark.parametrize("most", [0, 1, 4])
def test_late_commands_are_those_of_a_delayed_controller(most: int) -> None:
    command, memory = casadi.SX.sym("c", N), casadi.SX.sym("m", N * most)
    delay, sample = casadi.SX.sym("d"), casadi.SX.sym("k")
    late = late_command(command, memory, delay, sample)
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
    joint = {name: casadi.DM([STARTS[name]] * 2) if name in OF_JOINTS else casadi.DM(STARTS[name]) for name in FIGURES}
    x = joint | {"tolerance": 8.0, "last": 1.0, "nothing": 0.0, "tip": casadi.DM([1.0, 2.0, 3.0])}
    x |= {"lower": casadi.DM([-1.0, -2.0]), "upper": casadi.DM([1.5, 2.0]), "rating": casadi.DM([5.0, 50.0])}
    samples = [
        ([0.5, -1.0], [1.0, -3.0], [6.0, -7.0], [5.0, -7.0], 2.0),
        ([1.0, 0.5], [2.0, 1.0], [9.0, 1.0], [5.0, 1.0], 3.0),
    ]
    for k, (q, dq, command, applied, away) in enumerate(samples):
        given = {"q": casadi.DM(q), "dq": casadi.DM(dq), "sample": casadi.DM(k), "reference": casadi.DM([0.0] * 6)}
        out = figures(x | given, Vector(1.0 + away, 2.0, 3.0 - away), casadi.DM(command), casadi.DM(applied))
        x |= out
    assert {name: casadi.DM(value).full().ravel().tolist() for name, value in out.items()} == {
        "tip_squares": [26.0], "tip_worst": [18.0], "tip_square": [18.0], "position_squares": [1.25, 1.25],
        "position_worst": [1.0, 1.0], "torque_worst": [5.0, 7.0], "command_worst": [9.0, 7.0],
        "torque_squares": [50.0, 50.0], "speed_worst": [2.0, 3.0], "saturated": [1.0, 0.0], "margin": [0.5, 1.0],
        "violation": [1.0], "angle_worst": [1.25], "trouble": [0.0],
    }  # fmt: skip
    bad = figures(
        x | given | {"dq": casadi.DM([np.nan, 0.0])},
        Vector(0.0, 0.0, 0.0),
        casadi.DM([0.0, 0.0]),
        casadi.DM([0.0, 0.0]),
    )
    assert np.isnan(float(bad["trouble"]))


def test_slots_stand_one_after_the_other() -> None:
    slots = Slots({"a": 2, "none": 0, "b": 3})
    assert (slots.first("b"), slots.places("b"), slots.all_places(["b", "a"]), slots.size) == (
        2,
        range(2, 5),
        [2, 3, 4, 0, 1],
        5,
    )
