"""A share of the coverage study (1000 fits an arm in the soak line `base_fits`), and rules that are known to fail."""

import numpy as np
import pytest
from scipy.signal import lfilter

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.motion.validation import inflation_of, residuals_of, whiteness_of
from lwr_dyn.identification.regression.information import information_of, widened
from lwr_dyn.identification.regression.samples import SampleRule, exact_samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.coverage_study import SLOWEST, coverage_study
from tests.identification.fresh_study import fresh_motions, predicted_error, torque_error
from tests.identification.plants import perturbed_plant, random_motion, simulated_samples

DRAWS = range(40)


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["lwr4plus", "wam7"])
def test_intervals_hold_the_truth_with_encoders_and_a_filter(robot):
    found = coverage_study(lwr_dyn.load(robot), DRAWS)
    assert 0.990 <= found.share <= 1.0
    assert np.abs(found.bias).max() < 4.5 / np.sqrt(len(DRAWS))
    assert found.chi2.mean() == pytest.approx(1.0, abs=0.12)


@pytest.mark.parametrize("cutoff", [None, 80.0])
def test_without_a_filter_or_with_too_wide_a_one_parameters_lean(cutoff):
    """The noise of the columns themselves biases least squares: by 199 and 11 sigma at worst."""
    found = coverage_study(lwr_dyn.load("lwr4plus"), range(8), SampleRule(cutoff=cutoff, slowest=SLOWEST))
    assert np.abs(found.bias).max() > 4.5 / np.sqrt(8)
    assert found.share < 0.99


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["lwr4plus", "wam7"])
def test_fresh_torques_are_missed_by_what_the_covariance_says(robot):
    """Noise-free torque error on six motions that the fit has not seen (soak `fresh_torques`: 10 s optimised)."""
    arm, fresh = lwr_dyn.load(robot), fresh_motions(lwr_dyn.load(robot))
    columns, ratios = TorqueColumns(arm.chain), []
    for seed in range(12):
        rng = np.random.default_rng([seed, 2])
        plant = perturbed_plant(columns, arm, rng)
        found = information_of(simulated_samples(plant, random_motion(arm, 10.0, rng), 0.1, rng, 0.05), columns)
        ratios.append(torque_error(plant, found, fresh) / predicted_error(found, fresh))
    assert np.sqrt(np.mean(np.square(ratios))) == pytest.approx(1.0, abs=0.3)  # a few directions make most of it


@pytest.mark.slow
@pytest.mark.parametrize(("memory", "alone"), [(0.0, 0.99), (0.6, 0.9)])
def test_noise_that_lasts_widens_sigma_and_white_noise_does_not(memory, alone):
    """AR(1) noise of the torques: its slow sums are sqrt((1 + m) / (1 - m)) times those of white noise."""
    arm, rng = lwr_dyn.load("lwr4plus"), np.random.default_rng(15)
    columns = TorqueColumns(arm.chain)
    plant, motion = perturbed_plant(columns, arm, rng), random_motion(arm, 20.0, rng)
    tau, plain, wide, found = plant.torque(motion), [], [], []
    for _ in range(12):
        white = rng.normal(size=(len(tau) + 300, 7))
        noise = 0.1 * lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], white, axis=0)[300:]
        samples = exact_samples(motion.t, motion.q, motion.dq, motion.ddq, tau + noise, 0.05)
        fit = information_of(samples, columns)
        whiteness = whiteness_of(residuals_of(samples, columns, fit.values), samples.recording)
        wider = widened(fit, inflation_of(whiteness, 7))
        found.append(wider.inflation)
        plain.append(np.abs(fit.values - plant.base) <= 3.0 * fit.sigma)
        wide.append(np.abs(wider.values - plant.base) <= 3.0 * wider.sigma)
        assert wider.residual_noise == pytest.approx(fit.noise)
    assert np.mean(wide) > 0.985
    assert (np.mean(plain) > alone) == (memory == 0.0)
    assert np.mean(found) == pytest.approx(np.sqrt((1.0 + memory) / (1.0 - memory)), rel=0.1)


def test_noise_cannot_be_made_smaller_than_it_is():
    arm, rng = lwr_dyn.load("lwr4plus"), np.random.default_rng(16)
    plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng)
    fit = information_of(simulated_samples(plant, random_motion(arm, 5.0, rng), 0.1, rng, 0.05), plant.columns)
    assert widened(fit, np.ones(7)) is fit
    with pytest.raises(OptionError, match=r"inflation: 0\.5; allowed: numbers of at least 1"):
        widened(fit, np.full(7, 0.5))
