"""Identification returns what generated the data."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from lwr_dyn.foundation.tables import json_text
from lwr_dyn.identification.friction.identify_friction import FitOptions, friction_document, identify_friction
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from tests.identification.simulated import ideal_cruise, interval_coverage, true_values
from tests.json_schemas import faults

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
    found = identify_friction(logs, wam, "all")
    assert np.abs(misses(found, wam)).max() < IDEAL
    left_in = identify_friction(logs, wam, "gravity")
    for result, robot in ((found, "wam7"), (left_in, None)):
        record = json.loads(json_text({"caveats": [], **friction_document(result, robot).record()}))
        assert faults("identify friction", record) == []
        head = {
            "robot": robot,
            "subtracted": result.subtracted,
            "model": "viscous+coulomb",
            "robust": False,
            "weights": "samples",
        }
        assert {key: record[key] for key in head} == head
        assert record["rule"] == asdict(FitOptions().rule)
        assert record["map"] == [json.loads(json_text(asdict(point))) for point in result.points]
        for row, fit in zip(record["fits"], result.fits, strict=True):
            e = fit.estimate
            assert (row["joint"], row["direction"]) == (fit.joint, "positive" if fit.sign > 0 else "negative")
            assert (row["cruises"], row["dof"], row["residual_rms"]) == (3, 1, e.rms)
            assert row["speeds"] == [fit.slowest, fit.fastest] == pytest.approx([0.1, 0.3])
            numbers = zip(row["parameters"].items(), fit.names, e.values, e.standard_errors, e.half_widths, strict=True)
            for (name, one), expected, value, error, width in numbers:
                assert (name, one["value"], one["standard_error"], one["three_sigma"]) == (
                    expected,
                    value,
                    error,
                    width,
                )
                assert one["unit"] == {"coulomb": "N m", "viscous": "N m s/rad"}[name]
    largest = max(found.points, key=lambda point: abs(point.inertia))
    said = f"the mean of B ddq + C dq over a cruise is at most {abs(largest.inertia):.3g} N m (joint {largest.joint})"
    assert f"{said}; it is taken out\n" in friction_document(found).text() + "\n"
    moved = max(abs(b) for fit in left_in.fits for b in fit.bias)
    words = f"{said}; left in, it moves a parameter by at most {moved:.3g} ("
    text = friction_document(left_in).text()
    assert words in text
    assert text.splitlines()[0] == "42 cruises in 1 files, least squares, taken out of the torques: g"
    assert text.rstrip().endswith("--subtract all takes it out")


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
