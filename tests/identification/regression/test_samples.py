"""Instants of logs: exact derivatives, no phase, torques untouched, slow and cut-out equations left out."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.excitation.motion_limits import MotionLimits
from lwr_dyn.identification.excitation.objectives import fourier_basis
from lwr_dyn.identification.logs.clock import on_even_clock
from lwr_dyn.identification.logs.joint_log import JointLog, log_of_run
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.identification.regression import samples as module
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule, sample_notes, sample_parts, samples_of
from lwr_dyn.identification.regression.stribeck import stribeck_search
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.model.transmission import Transmission

RATE = 1000.0


def sines(seconds=4.0, rate=RATE, noise=0.0):
    """Two joints on sines of 0.5 and 1.2 Hz: log, and the exact dq, ddq."""
    t = np.arange(round(seconds * rate)) / rate
    w = 2 * np.pi * np.array([0.5, 1.2])
    q, dq, ddq = np.sin(w * t[:, None]), w * np.cos(w * t[:, None]), -(w**2) * np.sin(w * t[:, None])
    rng = np.random.default_rng(0)
    log = JointLog("sines", (1, 2), t, q + noise * rng.normal(size=q.shape), rng.normal(size=q.shape))
    return log, dq, ddq


def rows_of(samples, rate=RATE):
    """Of the log, at each instant."""
    return np.round(samples.t * rate).astype(int)


def turned_round(t, speed, period):
    """Which of the times (k,) are within a period of a change of sign of speeds (m, n) at RATE."""
    out = np.zeros((t.size, speed.shape[1]), dtype=bool)
    for j, turns in enumerate((speed[1:] > 0.0).T != (speed[:-1] > 0.0).T):
        for at in np.flatnonzero(turns) / RATE:
            out[:, j] |= np.abs(t - at - 0.5 / RATE) <= period
    return out


def used_but_for_turns(used, otherwise, t, speed, period=1 / 20):
    """Whether equations are left out within a period of a reversal, to two rows, and nowhere else."""
    sure, perhaps = (turned_round(t, speed, period + rows / RATE) for rows in (-2, 2))
    return not (used & sure).any() and (used | perhaps)[otherwise].all() and otherwise[used].all()


@pytest.mark.parametrize(
    ("cutoff", "of_q", "of_dq", "of_ddq"), [(20.0, 1e-5, 1e-4, 2e-3), (None, 1e-15, 1e-9, 1e-8)], ids=["20 Hz", "none"]
)
def test_states_of_smooth_motions_are_exact_and_torques_untouched(cutoff, of_q, of_dq, of_ddq):
    """Without a filter to order 4 in the step; four periods of the filter are left out at both ends."""
    log, dq, ddq = sines()
    found = samples_of([log], SampleRule(cutoff=cutoff, slowest=0.0))
    at = rows_of(found)
    for name, exact, error in (("q", log.q, of_q), ("dq", dq, of_dq), ("ddq", ddq, of_ddq)):
        assert np.abs(getattr(found, name) - exact[at]).max() < error
    assert (found.tau == log.tau[at]).all()
    edge = 202 if cutoff else 2
    assert (np.diff(at) == 10).all()
    assert edge <= at[0] <= edge + 1
    assert edge < 4000 - at[-1] <= edge + 11


def test_own_speeds_stand_in_for_differences():
    """Through the same filter; accelerations are their differences."""
    log, dq, ddq = sines()
    for cutoff, errors in ((20.0, (1e-3, 1e-2)), (None, (1e-12, 1e-7))):
        rule = SampleRule(cutoff=cutoff, own_speeds=True)
        found = samples_of([replace(log, dq=2.0 * dq)], rule)
        for values, exact, error in zip((found.dq, found.ddq), (2.0 * dq, 2.0 * ddq), errors, strict=True):
            assert np.abs(values - exact[rows_of(found)]).max() < error
        assert (samples_of([log], rule).dq == samples_of([log], replace(rule, own_speeds=False)).dq).all()


def test_the_filter_takes_away_the_noise_of_accelerations():
    log, _, ddq = sines(noise=1e-5)
    filtered, raw = samples_of([log]), samples_of([log], SampleRule(cutoff=None))
    assert np.std(filtered.ddq - ddq[rows_of(filtered)]) < 0.03
    assert np.std(raw.ddq - ddq[rows_of(raw)]) > 10.0


def test_slow_joints_and_torques_that_are_cut_out_have_no_equation():
    log, dq, _ = sines()
    tau = log.tau.copy()
    tau[1000:2000, 1] = np.nan
    found = samples_of([JointLog("cut", (1, 2), log.t, log.q, tau)], SampleRule(slowest=np.array([0.5, 0.0])))
    inside = (found.t >= 1.0) & (found.t < 2.0)
    assert not found.used[inside, 1].any()
    otherwise = np.column_stack([np.abs(found.dq[:, 0]) > 0.5, ~inside])
    assert used_but_for_turns(found.used, otherwise, found.t, dq)
    assert np.isfinite(found.tau).all()
    assert found.equations == found.used.sum()
    every = samples_of([log], SampleRule(slowest=3.0).taking_all())
    assert every.used.all()


def test_a_joint_waits_for_all_motors_that_drive_it():
    log, dq, _ = sines()
    pair = Transmission([[2.0, -1.0], [2.0, 1.0]])
    found = samples_of([log], SampleRule(slowest=3.0, transmission=pair))
    fast = np.abs(pair.motor_velocity(found.dq)) > 3.0
    assert (found.used[:, 0] == found.used[:, 1]).all()
    assert not found.used[~fast.all(axis=1)].any()
    perhaps = turned_round(found.t, pair.motor_velocity(dq), 1 / 20 + 2 / RATE).any(axis=1)
    assert (found.used[:, 0] | perhaps)[fast.all(axis=1)].all()
    assert 0 < found.equations < found.used.size
    gears = samples_of([log], SampleRule(slowest=3.0, transmission=Transmission(np.diag([2.0, -1.0]))))
    assert used_but_for_turns(gears.used, np.abs(gears.dq * [2.0, -1.0]) > 3.0, gears.t, dq)


@pytest.mark.parametrize(("cutoff", "reach"), [(8.0, 1.0), (20.0, 1.0), (20.0, 2.0), (20.0, 0.0), (None, 1.0)])
def test_within_the_reach_of_the_filter_of_a_reversal_a_joint_has_no_equation(cutoff, reach):
    """On both sides, for that joint alone; without a filter the speed is right up to the reversal."""
    log, dq, _ = sines(8.0)
    found = samples_of([log], SampleRule(cutoff, slowest=0.0, reach=reach))
    if cutoff is None or reach == 0.0:
        assert found.used.all()
    else:
        everywhere = np.ones(found.used.shape, dtype=bool)
        assert used_but_for_turns(found.used, everywhere, found.t, dq, reach / cutoff)
        assert (found.used.mean(axis=0) < 0.98).all()


def test_gaps_part_recordings_and_a_short_one_is_left_out():
    first, *_ = sines(2.0)
    second, *_ = sines(3.0)
    t = np.concatenate([first.t, first.t[-1] + 5.0 + second.t[:-50], 100.0 + second.t[:50]])
    q, tau = (np.concatenate([getattr(first, x), getattr(second, x)]) for x in ("q", "tau"))
    gaps, alone = JointLog("two", (1, 2), t, q, tau), samples_of([first])
    found = samples_of([gaps, second])
    assert found.sources == ("two", "two", "sines")
    assert np.bincount(found.recording).tolist() == [len(alone), 255, len(samples_of([second]))]
    chosen = found.select(found.recording == 0)
    assert (chosen.ddq == alone.ddq).all()
    assert (len(chosen.select(slice(0, 7))), chosen.rows_in(0.1), chosen.rows_in(1e-9)) == (7, 10, 1)
    assert sample_notes([first, gaps], SampleRule()) == (
        "two: 3 recordings, split at gaps of 5 s at 1.999 s, 90.05 s at 9.948 s",
    )
    assert sample_notes([sines(20.0, rate=25.0)[0]], SampleRule()) == (
        "sines: filtered at 10 Hz in place of 20 Hz, which is too near to half of its rate of 25 Hz",
    )


def test_a_long_log_in_parts_is_the_same(monkeypatch):
    log, *_ = sines(30.0, noise=1e-5)
    whole = samples_of([log])
    monkeypatch.setattr(module, "PART", 3000)
    parts = list(sample_parts([log]))
    assert len(parts) == 10
    joined = samples_of([log])
    assert np.array_equal(joined.t, whole.t)
    assert np.array_equal(joined.used, whole.used)
    assert np.abs(joined.dq - whole.dq).max() < 1e-10
    assert np.abs(joined.ddq - whole.ddq).max() < 1e-7


def test_a_slow_log_lowers_the_cutoff():
    log, dq, _ = sines(20.0, rate=25.0)
    found = samples_of([log], SampleRule(slowest=0.0))
    at = rows_of(found, 25.0)
    assert np.diff(at).max() == 1
    assert np.abs(found.dq - dq[at]).max() < 0.02


def test_rows_of_an_uneven_clock_are_those_of_the_even_one():
    """In Python as at the command, which brings logs to an even clock when it reads them."""
    log, *_ = sines(4.0)
    t = log.t + np.random.default_rng(0).uniform(-3e-4, 3e-4, log.t.size)
    stamped = JointLog("sines", (1, 2), t, log.q, log.tau)
    found, even = samples_of([stamped]), samples_of([on_even_clock(stamped)])
    np.testing.assert_array_equal(found.ddq, even.ddq)
    true = samples_of([log])
    assert np.abs(np.interp(true.t, found.t, found.q[:, 0]) - true.q[:, 0]).max() < 2e-3


@pytest.mark.parametrize(("rows", "words"), [(300, "short: rows: 300 between gaps in time; needed: recordings longer"),
                                              (4, "short: rows: 4 between"), (None, "logs: rows: 0")])  # fmt: skip
def test_logs_of_no_clock_and_too_short_ones_are_refused(rows, words):
    log, *_ = sines(1.0)
    logs = [] if rows is None else [JointLog("short", (1, 2), log.t[:rows], log.q[:rows], log.tau[:rows])]
    with pytest.raises(LogError, match=words):
        samples_of(logs)
    still = replace(log, t=np.where(np.arange(log.t.size) == 50, log.t[49], log.t))
    with pytest.raises(LogError, match=r"sines: row 51, column time: 0\.049 s after 0\.049 s; needed: times that rise"):
        samples_of([still])


BAD_RULES = [
    ({"cutoff": 0.0}, "sample cutoff: 0.0; allowed: a frequency above 0, or none"),
    ({"spacing": -1.0}, "sample spacing: -1.0; allowed: a number above 0"),
    ({"slowest": float("nan")}, "sample slowest: nan; allowed: a number >= 0"),
    ({"reach": -0.1}, "sample reach: -0.1; allowed: a number >= 0"),
]


@pytest.mark.parametrize(("options", "message"), BAD_RULES)
def test_rules_outside_what_is_allowed(options, message):
    with pytest.raises(OptionError, match=message):
        SampleRule(**options)


DROP, SPEED = 4.0, 0.15
SENSORS = LogSensors(torque_noise=0.1, position_noise=1e-5)


@pytest.fixture(scope="module", params=[False, True], ids=["coulomb", "stribeck"])
def case(request):
    """Coulomb friction of 3 to 9 N m, with or without a Stribeck drop: the columns, the arm and its log of 10 s."""
    table = lwr_dyn.load("lwr4plus", "physical")
    more = lambda level: (level + DROP, SPEED) if request.param else ()  # noqa: E731
    sides = [Direction(3.0 + j, 2.0, *more(3.0 + j)) for j in range(7)]
    truth = replace(table, friction=tuple(JointFriction(side, side) for side in sides))
    rng, limits, basis = np.random.default_rng(3), MotionLimits.of(table), fourier_basis(10.0, 5, 1000)
    X = rng.normal(size=(basis.count, 7))
    X[0] = rng.uniform(limits.lower, limits.upper)
    motion = basis.motion(limits.fitted(X, basis, fill=True))
    run = lwr_dyn.simulate(truth, lwr_dyn.controller("inverse-dynamics", table), motion)
    return request.param, TorqueColumns(table.chain, "directions"), truth, log_of_run(run, rate=1000.0)


@pytest.mark.slow
def test_beside_reversals_nothing_is_left_but_noise_and_sigma_covers(case):
    """With a v_s that is known; without the cut joints 5 to 7 left 2 to 3 N m, columns were 7 sigma and more off."""
    stribeck, columns, truth, clean = case
    inside = []
    for seed in range(3):
        samples = samples_of([SENSORS.through(clean, seed)], SampleRule(slowest=0.01))
        if stribeck:
            information = information_of(samples, replace(columns, stribeck_velocity=np.full(7, SPEED)))
        else:
            found = stribeck_search(samples, columns)
            assert np.isnan(found.speeds).all()
            information = found.information
        assert information.noise == pytest.approx(np.full(7, 0.1), rel=0.15)
        misses = (information.values - information.base.of(information.columns.own(truth))) / information.sigma
        inside += (np.abs(misses[information.determined]) <= 3.0).tolist()
    assert np.mean(inside) > 0.99
