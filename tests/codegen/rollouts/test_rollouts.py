"""Rollouts against `simulate`: the same metrics and states, run by run, with noise, counts and delay too."""

import json
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.codegen.rollouts.kernel import BLOCK
from lwr_dyn.codegen.rollouts.philox_code import normal_numbers
from lwr_dyn.codegen.rollouts.result import figures_of
from lwr_dyn.simulation.plant import Encoder

ARM = lwr_dyn.load("lwr4plus", "computed")
OWN = inertial_parameters(ARM.chain).ravel()
IST = lwr_dyn.reference("ist-clear", ARM)


def perturbed(runs, seed=0):
    """Inertial parameters (runs, 70): each link's mass and tensor by up to 10 %, one factor a link."""
    factors = np.random.default_rng(seed).uniform(0.9, 1.1, (runs, 7, 1))
    return (OWN.reshape(7, 10) * factors).reshape(runs, 70)


def same(one, other, rows=slice(None)):
    """Whether all numbers are those of rows of another call."""
    pairs = [(getattr(one, name), getattr(other, name)) for name in ("q", "dq", "tau")]
    pairs += [(one.metrics[name], other.metrics[name]) for name in other.metrics]
    return all(np.array_equal(a, b[rows]) for a, b in pairs)


def test_a_rollout_is_the_run_of_simulate():
    law = lwr_dyn.controller("inverse-dynamics", ARM, omega_n=50.0)
    gains = law.Kp * np.array([[1.0], [0.8], [1.2]])
    options = {"tolerance": 1e-4, "quantiles": (0.5, 0.95)}
    given = {"inertia": perturbed(3), "Kp": gains}
    done = lwr_dyn.rollouts(ARM, law, IST, parameters=given, duration=2.0, record=1, **options)
    assert done.flags == ("", "", "")
    setup = json.loads(json.dumps(done.setup))
    known = {"references": ["TaskReference"], "runs": 3, "first_run": 0, "parameters": ["inertia", "Kp"], "substeps": 1}
    assert setup | known | {"duration": 2.0} == setup
    assert "friction_width" not in setup
    assert repr(done) == f"Rollouts(3 runs, flags: none, {len(done.metrics)} metrics, record of {done.t.size} samples)"
    bounds = {"peak_torque": 1e-10, "peak_command": 1e-10, "torque_rms": 1e-10}  # of 100 N m
    for i in (0, 2):
        run = done.run(i)
        for name, found, bound in (("q", done.q, 1e-12), ("dq", done.dq, 1e-12), ("tau_applied", done.tau, 1e-10)):
            assert np.abs(getattr(run, name) - found[i]).max() < bound
        expected = figures_of(run, ARM, **options)
        assert done.metrics.keys() == expected.keys()
        for name in ("first_violation", "saturated_s"):
            assert np.array_equal(done.metrics[name][i], expected.pop(name))
        for name, value in expected.items():
            assert np.abs(done.metrics[name][i] - value).max() < bounds.get(name, 1e-12), name


NOISE_ARM = lwr_dyn.load("lwr4plus", reading="physical")
REST = lwr_dyn.reference("hold", NOISE_ARM, q=np.radians([0.0, 30.0, 0.0, -60.0, 0.0, 30.0, 0.0]), duration=3.0)
NOISE = 2e-5


@cache
def law():
    """Not made when the tests are collected: it searches the largest inertias."""
    return lwr_dyn.controller("pd-gravity", NOISE_ARM)


def noisy(noise, resolution=0.0, delay=0, **options):
    """Runs with noise of these sizes; all in the same kernel."""
    columns = np.broadcast_arrays(noise, resolution, delay)
    given = dict(zip(("noise", "resolution", "delay"), map(np.array, columns), strict=True))
    options = {"duration": 0.3, "record": 1, "encoder": Encoder(cutoff_hz=60.0), **options}
    return lwr_dyn.rollouts(NOISE_ARM, law(), REST, parameters=given, **options)


def counted(rows, **options):
    """Counts in the odd runs, and a delay in the later ones."""
    resolution = np.where(rows % 2, 2 * np.pi / 2**18, 0.0)
    return noisy(NOISE * (1.0 + rows % 3), resolution, np.minimum(rows // 2, 2), **options)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "first_run"), [(0, 0), (2**63 + 5, 2**32 - 2)])
def test_simulate_repeats_noise_counts_and_delay(seed, first_run):
    done = counted(np.arange(4), seed=seed, first_run=first_run)
    for i in range(4):
        run = done.run(i)
        assert np.abs(run.q - done.q[i]).max() < (1e-14 if i == 0 else 1e-12)  # noise alone; counts: an open loop
        assert np.abs(run.q - run.q_ref).max() > 0.1 * NOISE
        assert np.abs(run.tau_applied - done.tau[i]).max() < 1e-9
        assert (run.meta["encoder"]["run"], run.meta["options"]["delay"]) == (first_run + i, min(i // 2, 2))


@pytest.mark.slow
def test_the_numbers_are_the_same_for_any_batch_thread_and_place():
    rows = np.arange(BLOCK + 5)
    everything = counted(rows, seed=3, first_run=10)
    assert same(counted(rows, seed=3, first_run=10, threads=3), everything)
    for first, last in ((0, 1), (7, 20), (60, 69)):
        part = counted(rows[first:last], seed=3, first_run=10 + first)
        assert same(part, everything, slice(first, last))
    assert not same(counted(rows, seed=4, first_run=10), everything)
    assert not same(counted(rows[:9], seed=3, first_run=11), everything, slice(9))


def test_a_run_feels_its_noise_in_proportion():
    """Around rest the loop is linear: twice the noise, by the same numbers, makes twice the error."""
    single, double = (noisy([size], seed=1).metrics["position_rms"] for size in (1e-8, 2e-8))
    assert double == pytest.approx(2.0 * single, rel=1e-5)
    assert (single > 0.0).all()
    tips = noisy(np.full(200, 1e-8), seed=1).metrics["tip_rms"]
    assert 0.01 < tips.std() / tips.mean() < 0.5
    assert len(set(tips.tolist())) == 200


def test_the_first_torque_is_that_of_the_noise():
    """pd-gravity at rest on its reference: -Kp times the first noise; the change of gravity is small beside it."""
    done = noisy([0.0, 1e-9], duration=0.01, seed=9, first_run=40)
    feedback = -np.asarray(law().Kp) * 1e-9 * normal_numbers(9, 41, 1, 7)[0]
    change = done.tau[1, 0] - done.tau[0, 0]
    assert np.abs(change - feedback).max() < 0.05 * np.abs(feedback).max()
    assert done.run(1).meta["encoder"]["run"] == 41
