"""A share of the coverage study (1000 fits an arm in the soak line `fits_cover`), and rules that are known to fail."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.coverage_study import SLOWEST, coverage_study
from tests.identification.fresh_study import fresh_motions, predicted_error, torque_error
from tests.identification.plants import perturbed_plant, random_motion, simulated_samples

DRAWS = range(40)


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
