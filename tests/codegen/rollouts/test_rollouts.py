"""Rollouts against `simulate`: the same metrics and states, run by run."""

import json
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.codegen.rollouts.kernel import BLOCK
from lwr_dyn.codegen.rollouts.philox_code import normal_numbers
from lwr_dyn.codegen.rollouts.result import figures_of
from lwr_dyn.codegen.rollouts.rollouts import rollouts
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.simulation.plant import Encoder

ARM = lwr_dyn.load("lwr4plus", "computed")
OWN = inertial_parameters(ARM.chain).ravel()
IST = lwr_dyn.reference("ist-clear", ARM)
SHORT = 2.0


def perturbed(runs, seed=0):
    """Inertial parameters (runs, 70): each link's mass and tensor by up to 10 %, one factor a link."""
    factors = np.random.default_rng(seed).uniform(0.9, 1.1, (runs, 7, 1))
    return (OWN.reshape(7, 10) * factors).reshape(runs, 70)


def test_a_rollout_is_the_run_of_simulate():
    law = lwr_dyn.controller("inverse-dynamics", ARM, omega_n=50.0)
    gains = law.Kp * np.array([[1.0], [0.8], [1.2]])
    options = {"tolerance": 1e-4, "quantiles": (0.5, 0.95)}
    done = rollouts(
        ARM, law, IST, parameters={"inertia": perturbed(3), "Kp": gains}, duration=SHORT, record=1, **options
    )
    assert done.flags == ("", "", "")
    assert json.loads(json.dumps(done.setup))["references"] == ["TaskReference"]
    assert "friction_width" not in done.setup
    assert repr(done) == f"Rollouts(3 runs, flags: none, {len(done.metrics)} metrics, record of {done.t.size} samples)"
    for i in (0, 2):
        run = done.run(i)
        expected = figures_of(run, ARM, **options)
        assert done.metrics.keys() == expected.keys()
        assert np.abs(run.q - done.q[i]).max() < 1e-12
        assert np.abs(run.dq - done.dq[i]).max() < 1e-12
        assert np.abs(run.tau_applied - done.tau[i]).max() < 1e-10  # of 100 N m
        for metric in ("tip_rms", "tip_max", "tip_final", "position_rms", "position_max", "limit_margin", "tip_q95"):
            assert np.abs(done.metrics[metric][i] - expected[metric]).max() < 1e-12
        assert done.metrics["first_violation"][i] == expected["first_violation"]
        assert (done.metrics["saturated_s"][i] == expected["saturated_s"]).all()


NOISE_ARM = lwr_dyn.load("lwr4plus", reading="physical")
REST = lwr_dyn.reference("hold", NOISE_ARM, q=np.radians([0.0, 30.0, 0.0, -60.0, 0.0, 30.0, 0.0]), duration=3.0)
NOISE = 2e-5


@cache
def law():
    """Not made when the tests are collected: it searches the largest inertias."""
    return lwr_dyn.controller("pd-gravity", NOISE_ARM)


FOUR = np.arange(4)


def noisy(rows=FOUR, **options):
    """Runs with noise of their own, counts in the odd ones, and a delay in the later ones."""
    given = {
        "noise": NOISE * (1.0 + rows % 3), "resolution": np.where(rows % 2, 2 * np.pi / 2**18, 0.0),
        "delay": np.minimum(rows // 2, 2),
    }  # fmt: skip
    options = {"duration": 0.3, "record": 1, "encoder": Encoder(cutoff_hz=60.0), **options}
    return lwr_dyn.rollouts(NOISE_ARM, law(), REST, parameters=given, **options)


def only_noise(sizes, **options):
    """Runs with noise alone, in the same kernel."""
    zeros = np.zeros(len(sizes))
    given = {"noise": sizes, "resolution": zeros, "delay": zeros}
    options = {"duration": 0.3, "encoder": Encoder(cutoff_hz=60.0), **options}
    return lwr_dyn.rollouts(NOISE_ARM, law(), REST, parameters=given, **options)


def same(one, other, rows=slice(None)):
    pairs = [
        (one.q, other.q),
        (one.tau, other.tau),
        *((one.metrics[name], other.metrics[name]) for name in one.metrics),
    ]
    return all(np.array_equal(a, b[rows]) for a, b in pairs)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "first_run"), [(0, 0), (2**63 + 5, 2**32 - 2)])
def test_simulate_repeats_noise_counts_and_delay(seed, first_run):
    done = noisy(seed=seed, first_run=first_run)
    for i in range(done.count):
        run = done.run(i)
        assert np.abs(run.q - done.q[i]).max() < 1e-12
        assert np.abs(run.tau_applied - done.tau[i]).max() < 1e-9
        assert run.meta["encoder"]["run"] == first_run + i
        assert run.meta["options"]["delay"] == min(i // 2, 2)


@pytest.mark.slow
def test_noise_alone_is_repeated_for_as_long_as_one_likes():
    """Counts are not: between two of them the loop is open, and rounding grows as the arm falls."""
    done = noisy(np.zeros(1, dtype=int), duration=3.0)
    run = done.run(0)
    assert np.abs(run.q - run.q_ref).max() > 0.1 * NOISE
    assert np.abs(run.q - done.q[0]).max() < 1e-14


@pytest.mark.slow
def test_the_numbers_are_the_same_for_any_batch_thread_and_place():
    rows = np.arange(BLOCK + 5)
    everything = noisy(rows, seed=3, first_run=10)
    assert same(noisy(rows, seed=3, first_run=10, threads=3), everything)
    for first, last in ((0, 1), (7, 20), (60, 69)):
        part = noisy(rows[first:last], seed=3, first_run=10 + first)
        assert same(part, everything, slice(first, last))
    assert not same(noisy(rows, seed=4, first_run=10), everything)
    assert not same(noisy(rows[:9], seed=3, first_run=11), everything, slice(9))


def test_a_run_feels_its_noise_in_proportion():
    """Around rest the loop is linear: twice the noise, by the same numbers, makes twice the error."""
    single, double = (only_noise([size], seed=1) for size in (1e-8, 2e-8))
    assert double.metrics["position_rms"] == pytest.approx(2.0 * single.metrics["position_rms"], rel=1e-5)
    assert (single.metrics["position_rms"] > 0.0).all()
    many = only_noise(np.full(200, 1e-8), seed=1)
    spread = many.metrics["tip_rms"].std() / many.metrics["tip_rms"].mean()
    assert 0.01 < spread < 0.5
    assert len(set(many.metrics["tip_rms"].tolist())) == 200


def test_the_first_torque_is_that_of_the_noise():
    """pd-gravity at rest on its reference: -Kp times the first noise; the change of gravity is small beside it."""
    done = only_noise([0.0, 1e-9], duration=0.01, record=1, seed=9, first_run=40)
    feedback = -np.asarray(law().Kp) * 1e-9 * normal_numbers(9, 41, 1, 7)[0]
    change = done.tau[1, 0] - done.tau[0, 0]
    assert np.abs(change - feedback).max() < 0.05 * np.abs(feedback).max()
    assert done.run(1).meta["encoder"]["run"] == 41


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5])
def test_a_seed_of_more_than_64_bits_is_refused(seed):
    with pytest.raises(OptionError, match="seed"):
        noisy(seed=seed)


def test_an_encoder_with_a_sensor_of_its_own_is_refused():
    class Mine(Encoder):
        def sensor(self, q0, dq0, samples, rate, seed):
            return lambda q, dq: (q, dq)

    with pytest.raises(OptionError, match="Mine, with a sensor of its own"):
        noisy(encoder=Mine())
