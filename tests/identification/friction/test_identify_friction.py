"""Identification returns what generated the data."""

import numpy as np
import pytest

from lwr_dyn.identification.friction.identify_friction import FitOptions, identify_friction
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from tests.identification.simulated import ideal_cruise, interval_coverage, true_values

IDEAL = 1e-6
"""Relative error allowed with logs without noise; rounding gives 1e-11."""
SENSORS = LogSensors(torque_noise=0.05, resolution=2e-5)
DRAWS = 40
"""A share of the 200 of a full count: 1120 intervals, of which 0.27 % miss; 99.3 % is 2.8 standard deviations off."""


def misses(found, arm):
    return [fit.estimate.values - true_values(arm, fit.joint, fit.sign, fit.names) for fit in found.fits]


@pytest.mark.slow
@pytest.mark.parametrize("robust", [False, True])
def test_ideal_runs_of_one_joint_at_a_time_give_table_1_back(wam, one_joint_at_a_time, robust):
    found = identify_friction(one_joint_at_a_time, wam, options=FitOptions(robust=robust))
    assert not found.faults
    assert len(found.fits) == 14
    assert np.abs(misses(found, wam)).max() < IDEAL
    assert found.friction()[4].positive.viscous == pytest.approx(-2.7045)


def test_ideal_runs_of_all_joints_need_the_coriolis_torque_taken_out(wam):
    logs = [ideal_cruise(wam.friction, np.full(7, v), wam) for v in (-0.3, -0.2, -0.1, 0.1, 0.2, 0.3)]
    assert np.abs(misses(identify_friction(logs, wam, "gravity"), wam)).max() > 1e-3
    assert np.abs(misses(identify_friction(logs, wam, "all"), wam)).max() < IDEAL


@pytest.mark.slow
def test_the_bias_of_averaging_a_cruise_is_stated_and_goes_with_the_inertia(wam, closed_loop_logs):
    plain, clean = (identify_friction(closed_loop_logs, wam, what) for what in ("gravity", "all"))
    assert not plain.faults
    assert not clean.faults
    biased, left = np.array(misses(plain, wam)), np.array(misses(clean, wam))
    stated = np.array([fit.bias for fit in plain.fits])
    assert np.abs(biased).max() > 0.3  # N m s/rad: joint 2 still rings when its cruise begins
    assert np.abs(left).max() < 0.02 * np.abs(biased).max()
    assert np.abs(stated - biased).max() < 0.02 * np.abs(biased).max()
    assert [fit.bias for fit in clean.fits] == pytest.approx(stated, rel=1e-6)


@pytest.mark.slow
def test_three_sigma_intervals_cover_the_truth(wam, closed_loop_logs):
    found = interval_coverage(closed_loop_logs, wam, SENSORS, range(DRAWS))
    assert found.intervals == 28 * DRAWS
    assert 0.993 <= found.share <= 1.0
    narrow = interval_coverage(closed_loop_logs, wam, SENSORS, range(10), "gravity")
    assert narrow.share < 0.98  # the bias of averaging shows: the intervals are no wider than they must be


@pytest.mark.slow
def test_intervals_are_as_wide_as_the_estimates_scatter(wam, closed_loop_logs):
    """Too wide intervals would cover as well: one sigma of Student's t holds 68.3 %, give or take 2 % in 840."""
    inside = []
    for seed in range(30):
        noisy = [SENSORS.through(log, 1000 + 5 * seed + i) for i, log in enumerate(closed_loop_logs)]
        for fit in identify_friction(noisy, wam, "all").fits:
            gap = np.abs(fit.estimate.values - true_values(wam, fit.joint, fit.sign, fit.names))
            inside += list(gap < 1.1969 * fit.estimate.standard_errors)  # Student's t of 3 degrees of freedom
    assert 0.62 < np.mean(inside) < 0.75
