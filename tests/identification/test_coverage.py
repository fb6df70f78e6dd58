"""A share of the coverage study (1000 fits an arm in the soak line `fits_cover`), and rules that are known to fail."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.regression.samples import SampleRule
from tests.identification.coverage_study import SLOWEST, coverage_study

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
