"""Frequency response and bandwidth of a chirp against the second-order loop."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.responses.step_and_chirp import frequency_responses
from tests.simulation.responses.loops import ARM, OMEGA, START, answered

SWEEP = {"low": 1.0, "high": 40.0, "duration": 3.0}


@pytest.mark.slow
@pytest.mark.parametrize(("xi", "joint"), [(0.5, 2), (1.0, 7)])
def test_the_response_is_that_of_theory(xi, joint):
    (found,) = frequency_responses(answered("chirp", xi, joint, **SWEEP), ARM)
    s = 2j * np.pi * found.f
    H = OMEGA**2 / (s**2 + 2.0 * xi * OMEGA * s + OMEGA**2)
    assert np.abs(found.H / H - 1.0).max() < 3e-3
    bandwidth = OMEGA / (2.0 * np.pi) * np.sqrt(1 - 2 * xi**2 + np.sqrt((1 - 2 * xi**2) ** 2 + 1))
    assert found.bandwidth == pytest.approx(bandwidth, rel=2e-3)
    assert found.joint == joint
    assert found.least_coherence > 0.999
    if xi < 0.7:
        assert found.peak == pytest.approx(1.0 / (2.0 * xi * np.sqrt(1.0 - xi**2)), rel=2e-3)
        assert found.peak_at == pytest.approx(OMEGA / (2.0 * np.pi) * np.sqrt(1.0 - 2.0 * xi**2), rel=0.04)


@pytest.mark.slow
def test_feed_forward_of_the_rates_leaves_nothing_to_follow():
    (found,) = frequency_responses(answered("chirp", 1.0, 7, rates=True, rate=1000.0, **SWEEP | {"high": 10.0}), ARM)
    assert np.abs(found.H - 1.0).max() < 3e-4  # of order 1 in the step: the taper ends with a jump of ddq
    assert np.isnan(found.bandwidth)
    assert found.to_json()["bandwidth"] is None


def test_noise_lowers_the_coherence():
    loop = lwr_dyn.controller("inverse-dynamics", ARM)
    reference = lwr_dyn.reference("chirp", ARM, start=START, joint=4, **SWEEP)
    run = lwr_dyn.simulate(ARM, loop, reference, encoder=Encoder(0.0, 3e-4, 100.0))
    (found,) = frequency_responses(run, ARM)
    assert found.coherence[-1] < 0.999
    assert found.bandwidth == pytest.approx(5.2, rel=0.1)


def test_sweeps_that_did_not_end_are_left_out():
    loop = lwr_dyn.controller("inverse-dynamics", ARM)
    reference = lwr_dyn.reference("chirp", ARM, start=START, **SWEEP)
    run = lwr_dyn.simulate(ARM, loop, reference, duration=8.5, rate=500.0)
    assert [one.joint for one in frequency_responses(run, ARM)] == [1, 2]


def test_a_run_of_another_task_is_refused(two_runs):
    with pytest.raises(OptionError, match="a run of the task 'chirp'"):
        frequency_responses(two_runs[0])
