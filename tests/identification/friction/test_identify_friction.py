"""Cruises are found where a joint moves at constant speed, and their friction is what generated the data."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.identification.friction.friction_map import (
    CruiseRule,
    ModelTorque,
    find_cruises,
    map_points,
    position_noise,
)
from lwr_dyn.identification.friction.identify_friction import (
    FitOptions,
    friction_document,
    friction_map_figure,
    identify_friction,
)
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from lwr_dyn.trajectory.motion_profile import lspb
from tests.identification.simulated import ideal_cruise, interval_coverage, true_values
from tests.json_schemas import faults

IDEAL = 1e-6
"""Relative error allowed with logs without noise; rounding gives 1e-11."""
SENSORS = LogSensors(torque_noise=0.05, resolution=2e-5)
DRAWS = 40
"""A share of the 200 of a full count: 1120 intervals, of which 0.27 % miss; 99.3 % is 2.8 standard deviations off."""
T = np.arange(1001) / 100
COUNT = 4e-5


def long_ones(q, t=T):
    return [c for c in find_cruises(t, q) if c.duration >= 0.5]


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("count", [0.0, COUNT])
def test_the_straight_part_of_an_lspb_is_one_cruise(way, count):
    q = way * lspb(0.5, 7.0, 1.0).at(T).s
    q = np.round(q / count) * count if count else q
    (cruise,) = long_ones(q)
    assert 1.0 <= T[cruise.first] < 1.25
    assert 5.75 < T[cruise.last] <= 6.0


def test_a_staircase_of_speeds_gives_one_cruise_a_step():
    speed = np.select([T < 3, T < 6], [0.1, 0.2], -0.15)
    found = long_ones(np.cumsum(speed) / 100)
    assert [round(float(speed[c.first]), 2) for c in found] == [0.1, 0.2, -0.15]


def test_a_point_of_the_map_is_the_means_over_its_rows():
    """Rows 68 to 234 of a log, from 1: the speed is 0.2 from row 51 to 251, less a window at either end."""
    t, rng = np.arange(300) / 100, np.random.default_rng(0)
    log = JointLog("x", (3,), t, 0.2 * np.clip(t, 0.5, 2.5)[:, None], rng.normal(2.0, 0.1, (300, 1)))
    rows = slice(67, 234)
    torque = log.tau[rows, 0]
    (point,) = map_points(log)
    means = {"velocity": 0.2, "torque": np.trapezoid(torque, t[rows]) / 1.66, "spread": np.std(torque, ddof=1)}
    assert {key: getattr(point, key) for key in means} == pytest.approx(means)
    assert [point.joint, point.samples, point.inertia, point.source, point.first, point.last] == [
        3, 167, None, "x", 68, 234,
    ]  # fmt: skip
    read = replace(log, dq=rng.normal(0.2, 0.01, (300, 1)))
    assert map_points(read)[0].velocity == pytest.approx(np.trapezoid(read.dq[rows, 0], t[rows]) / 1.66)
    assert map_points(log, rule=CruiseRule(shortest=1.66)) == (point,)
    with pytest.raises(LogError, match=r"rows 68 to 234, column q3: the longest cruise takes 1\.66 s; needed: 1\.67 s"):
        map_points(log, rule=CruiseRule(shortest=1.67))


def test_the_figure_shows_the_points_and_the_fits_dashed_beyond_them():
    both = JointFriction(Direction(3.0, 0.5), Direction(2.0, 0.4))
    speeds = (0.1, 0.3, -0.2, -0.4)
    found = identify_friction([ideal_cruise([both], [v]) for v in speeds])
    figure = friction_map_figure(found)
    (panel,) = figure.panels
    assert (panel.title, panel.y_label, panel.y_unit, figure.columns) == ("joint 1", "friction", "N m", 2)
    points, *lines = panel.curves
    np.testing.assert_allclose((points.x, points.y), (speeds, [3.05, 3.15, -2.08, -2.16]))
    assert [c.colour for c in panel.curves] == [0, 1, 1, 1, 1]
    fit, beyond = "fit, viscous+coulomb", "fit, beyond the data"
    ends = [(c.label, c.dashed, c.x[0], c.x[-1], c.y[0], c.y[-1]) for c in lines]
    assert [x[:2] for x in ends] == [(fit, False), (beyond, True)] * 2
    np.testing.assert_allclose([x[2:] for x in ends], [
        (0.1, 0.3, 3.05, 3.15), (0.0, 0.1, 3.0, 3.05), (-0.2, -0.4, -2.08, -2.16), (0.0, -0.2, -2.0, -2.08),
    ], atol=1e-12)  # fmt: skip
    with pytest.raises(OptionError, match="friction map: without a point; allowed: at least one cruise"):
        friction_map_figure(replace(found, points=()))


STILL = {
    "rest": np.zeros_like(T), "acceleration": T**2 * 0.02, "oscillation": 0.3 * np.sin(2 * np.pi * T),
    "creep": 2e-4 * T, "noise": np.random.default_rng(0).normal(0.0, 1e-4, T.size),
}  # fmt: skip


@pytest.mark.parametrize("case", STILL)
def test_what_is_no_cruise(case):
    assert not long_ones(STILL[case])


def test_a_gap_in_time_parts_two_recordings():
    t = np.concatenate([T[:200], T[:200] + 60.0])
    found = long_ones(0.1 * np.concatenate([T[:200], T[:200]]), t)
    assert [c.last < 200 or c.first >= 200 for c in found] == [True, True]


def test_rows_need_not_be_even():
    t = T + np.random.default_rng(0).uniform(-3e-3, 3e-3, T.size)
    (cruise,) = long_ones(0.1 * t, t)
    assert cruise.duration == t[cruise.last] - t[cruise.first] > 9.0


def test_position_noise_sees_rounding_and_not_the_motion():
    q = lspb(0.5, 7.0, 1.0).at(T).s
    assert position_noise(q) < 2e-6  # the first step of the blend passes for a count
    assert position_noise(np.round(q / COUNT) * COUNT) == pytest.approx(COUNT / np.sqrt(12), rel=0.5)
    assert position_noise(q + np.random.default_rng(0).normal(0, 1e-4, T.size)) == pytest.approx(1e-4, rel=0.15)


def test_rules_and_parts_that_cannot_be_are_refused():
    for field in ("shortest", "window", "tolerance", "slowest"):
        with pytest.raises(OptionError, match=f"cruise {field}: 0; allowed: a number above 0"):
            CruiseRule(**{field: 0})
    with pytest.raises(OptionError, match="subtract: 'friction'; allowed: none, gravity"):
        ModelTorque(lwr_dyn.load("wam7"), "friction")


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
        facts = {
            "robot": robot, "subtracted": result.subtracted, "model": "viscous+coulomb", "robust": False,
            "weights": "samples", "rule": asdict(FitOptions().rule),
            "map": [json.loads(json_text(asdict(point))) for point in result.points],
        }  # fmt: skip
        assert {key: record[key] for key in facts} == facts
        for row, fit in zip(record["fits"], result.fits, strict=True):
            e, way = fit.estimate, "positive" if fit.sign > 0 else "negative"
            found_there = [row[key] for key in ("joint", "direction", "cruises", "dof", "residual_rms", "speeds")]
            assert found_there == [fit.joint, way, 3, 1, e.rms, [fit.slowest, fit.fastest]]
            assert row["speeds"] == pytest.approx([0.1, 0.3])
            units = {"coulomb": "N m", "viscous": "N m s/rad"}
            numbers = zip(fit.names, e.values, e.standard_errors, e.half_widths, strict=True)
            names = ("value", "standard_error", "three_sigma", "unit")
            shown = {name: tuple(one[key] for key in names) for name, one in row["parameters"].items()}
            assert shown == {name: (*parts, units[name]) for name, *parts in numbers}
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
    assert (plain.faults, clean.faults) == ((), ())
    biased, left = np.array(misses(plain, wam)), np.array(misses(clean, wam))
    stated = np.array([fit.bias for fit in plain.fits])
    assert np.abs(biased).max() > 0.3  # N m s/rad: joint 2 still rings when its cruise begins
    assert np.abs(left).max() < 0.02 * np.abs(biased).max()
    assert np.abs(stated - biased).max() < 0.02 * np.abs(biased).max()
    assert [fit.bias for fit in clean.fits] == pytest.approx(stated, rel=1e-6)


@pytest.mark.slow
def test_three_sigma_intervals_cover_the_truth(wam, closed_loop_logs):
    inside = interval_coverage(closed_loop_logs, wam, SENSORS, range(DRAWS))
    assert inside.size == 28 * DRAWS
    assert inside.mean() >= 0.993
    narrow = interval_coverage(closed_loop_logs, wam, SENSORS, range(10), "gravity")
    assert narrow.mean() < 0.98  # the bias of averaging shows: the intervals are no wider than they must be


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


def test_a_stribeck_dip_comes_back():
    truth = JointFriction(Direction(4.0, 1.2, 6.0, 0.05), Direction(3.0, -0.5, 3.9, 0.08))
    speeds = [s * v for s in (1, -1) for v in (0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3)]
    found = identify_friction([ideal_cruise([truth], [v]) for v in speeds], options=FitOptions(model="stribeck"))
    assert not found.faults
    for fit, way in zip(found.fits, (truth.positive, truth.negative), strict=True):
        assert fit.estimate.values == pytest.approx(
            [way.coulomb, way.viscous, way.static, way.stribeck_velocity], abs=IDEAL
        )


@pytest.mark.parametrize(
    ("truth", "speeds", "noise", "model"),
    [
        (Direction(4.0, 1.0), np.linspace(0.05, 0.4, 12), 0.02, "viscous+coulomb"),
        (Direction(4.0, 1.2, 6.0, 0.05), np.geomspace(0.01, 0.4, 14), 0.002, "stribeck"),
    ],
)
def test_a_wild_cruise_pulls_squares_but_not_the_robust_fit(truth, speeds, noise, model):
    other = Direction(3.0, 2.0)
    wild = ideal_cruise([JointFriction(Direction(9.0, truth.viscous), other)], [0.38])
    logs = [*(ideal_cruise([JointFriction(truth, other)], [v]) for v in speeds), wild]
    noisy = [LogSensors(noise).through(log, i) for i, log in enumerate(logs)]
    squares, robust = (
        identify_friction(noisy, options=FitOptions(model=model, robust=r)).fit(1, 1).estimate for r in (False, True)
    )
    wanted = [x for x in (truth.coulomb, truth.viscous, truth.static, truth.stribeck_velocity) if x is not None]
    assert abs(squares.values - wanted).max() > 0.5
    assert (abs(robust.values - wanted) < 3.0 * robust.standard_errors).all()
    assert (robust.standard_errors < [0.1, 0.2, 0.2, 0.01][: len(wanted)]).all()


def test_one_direction_and_one_speed_are_too_little_for_that_joint_only():
    both = [symmetric(2.0, 0.5), symmetric(1.0, 0.3)]
    logs = [ideal_cruise(both, dq, source=f"run {i}") for i, dq in enumerate([(0.1, 0.1), (0.2, 0.2), (0.1, -0.2)])]
    found = identify_friction(logs)
    assert [(f.joint, f.sign) for f in found.fits] == [(1, 1), (2, 1)]
    assert [str(f) for f in found.faults] == [
        "run 0, run 1, run 2: column q1: no cruise in the negative direction; "
        "needed: cruises at two or more speeds in either direction",
        "run 2: column q2, negative direction: 1 speed (0.2 to 0.2 rad/s) in 1 cruise; needed: two or more different "
        "speeds each way for Coulomb and viscous friction, four around the dip for Stribeck",
    ]
