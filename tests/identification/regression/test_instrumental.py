"""Instrumental variables on logs without a filter, beside least squares on the same rows."""

from __future__ import annotations

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, OptionError, ShapeError
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.instrumental import UNFILTERED, instrumental, smooth_step, window_sums
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.run import Motion
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

ARM = lwr_dyn.load("lwr4plus", "physical")


@pytest.fixture(scope="module")
def plant():
    return perturbed_plant(TorqueColumns(ARM.chain), ARM, np.random.default_rng(1), 0.2)


@pytest.fixture(scope="module")
def motion():
    return random_motion(ARM, 10.0, np.random.default_rng(2), rate=1000.0)


def at(samples, motion):
    """The motion at the instants of samples."""
    rows = np.searchsorted(motion.t, samples.t - 1e-6)
    return Motion(samples.t, motion.q[rows], motion.dq[rows], motion.ddq[rows])


def z_of(plant, motion, tau, seed):
    log = simulated_log(plant, motion, 0.1, np.random.default_rng(seed), 1e-5, tau=tau)
    samples = samples_of([log], UNFILTERED)
    found = instrumental(samples, plant.columns, at(samples, motion))
    return (found.values - plant.base) / found.sigma, found, log


@pytest.mark.slow
def test_unfiltered_logs_are_cured(plant, motion):
    """Recovery figure: 8 logs with 1e-5 rad at 1 kHz; least squares on the same rows covers under half."""
    tau = plant.torque(motion)
    draws = [z_of(plant, motion, tau, seed) for seed in range(8)]
    z = np.array([d[0] for d in draws])
    assert (np.abs(z) < 3.0).mean() > 0.98
    assert 0.7 < np.mean(z**2) < 1.5
    assert np.sqrt(np.mean(z.mean(axis=0) ** 2)) < 0.55  # 8 draws of no bias give 0.35
    assert draws[0][1].noise == pytest.approx(0.1, rel=0.3)
    plain = information_of(samples_of([draws[0][2]], SampleRule(cutoff=None)), plant.columns)
    assert (np.abs((plain.values - plant.base) / plain.sigma) < 3.0).mean() < 0.6


def test_all_rows_are_more_precise_than_the_filter_on_every_tenth(plant, motion):
    _, found, log = z_of(plant, motion, plant.torque(motion), 0)
    filtered = information_of(samples_of([log]), plant.columns)
    assert np.median(found.sigma / filtered.sigma) < 0.5


def test_without_noise_the_truth_comes_back(plant, motion):
    log = simulated_log(plant, motion, 0.0, np.random.default_rng(0))
    samples = samples_of([log], UNFILTERED)
    found = instrumental(samples, plant.columns, at(samples, motion))
    assert found.values == pytest.approx(plant.base, abs=1e-6)


def test_a_reference_that_the_arm_follows_badly_still_works(plant, motion):
    """Instruments need not be the motion itself: one that lags by 20 ms and is 5 per cent large has no bias."""
    log = simulated_log(plant, motion, 0.1, np.random.default_rng(3), 1e-5)
    samples = samples_of([log], UNFILTERED)
    true = at(samples, motion)
    late = [1.05 * np.concatenate([x[:1].repeat(20, axis=0), x[:-20]]) for x in (true.q, true.dq, true.ddq)]
    z = instrumental(samples, plant.columns, Motion(samples.t, *late))
    assert (np.abs((z.values - plant.base) / z.sigma) < 3.0).mean() > 0.97


def test_slow_sums_of_white_noise_show_its_variance_and_of_differences_none():
    noise = np.random.default_rng(0).normal(size=(20_000, 2))
    one = np.zeros(len(noise), dtype=int)
    v = window_sums(noise, one, 100)
    assert v.T @ v / len(noise) == pytest.approx(np.eye(2), abs=0.2)
    second = np.diff(noise, n=2, axis=0)
    assert (window_sums(second, one[2:], 100) ** 2).sum() < 1e-3 * (second**2).sum()


def test_windows_stay_inside_recordings():
    """A step between two recordings is seen by no window."""
    recording = np.repeat([0, 1], 50)
    wave = np.tile(np.sin(2 * np.pi * np.arange(50) / 10), 2)[:, None] * np.where(recording, 1e3, 0.0)[:, None]
    first = window_sums(wave, recording, 20)[: len(window_sums(wave[:50], recording[:50], 20))]
    assert not first.any()


def test_the_weight_rises_smoothly():
    x = np.linspace(-1, 2, 3001)
    w = smooth_step(x)
    assert w[0] == 0.0
    assert w[-1] == 1.0
    assert np.abs(np.diff(w, n=2)).max() / 1e-6 < 6.0


def test_bad_input(plant, motion):
    samples = samples_of([simulated_log(plant, motion, 0.0, np.random.default_rng(0))], UNFILTERED)
    known = at(samples, motion)
    with pytest.raises(OptionError, match="window"):
        instrumental(samples, plant.columns, known, window=0.0)
    with pytest.raises(ShapeError, match="dq of the motion"):
        instrumental(samples, plant.columns, Motion(samples.t, known.q, known.dq[1:], known.ddq))
    still = Motion(samples.t, known.q, known.dq * 0.0, known.ddq)
    with pytest.raises(LogError, match="does not determine"):
        instrumental(samples, plant.columns, still)
