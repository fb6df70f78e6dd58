"""Gains of torques from normal equations: the same as from the rows, and nothing that no torque shows."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.identification.regression.drive_gains import FreedGains, gains_alone, volume_of
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.load_friction import (
    load_indices,
    loads_moved,
    with_load_friction,
    with_moving_loads,
)
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.plants import perturbed_plant, random_motion, simulated_samples

WIDTH = 0.1


@pytest.fixture(scope="module")
def plant(lwr):
    return perturbed_plant(TorqueColumns(lwr.chain, "directions"), lwr, np.random.default_rng(1))


@pytest.fixture(scope="module")
def gains():
    return np.exp(np.random.default_rng(2).normal(0.0, WIDTH, 7))


@pytest.fixture(scope="module")
def samples(plant, lwr, gains):
    rng = np.random.default_rng(3)
    seen = simulated_samples(plant, random_motion(lwr, 5.0, rng), 0.1, rng, 0.05)
    noise = rng.normal(0.0, 0.1, seen.tau.shape)
    return replace(seen, tau=gains * plant.columns.torques(seen.q, seen.dq, seen.ddq, plant.parameters) + noise)


def without_last(samples):
    used = samples.used.copy()
    used[:, 6] = False
    return replace(samples, used=used)


@pytest.mark.parametrize("moving", [False, True], ids=["known loads", "loads that move"])
def test_gains_are_those_of_the_equations_of_both_written_out(samples, plant, moving):
    """The score of the columns X, then of the gains' columns D, its slope, its variance: by rows.

    Loads that friction grows with move with the bodies: then the slope is that of differences of the torques.
    """
    columns, taken, volume = plant.columns, np.linspace(-0.05, 0.1, 7), np.linspace(0.0, 5.0, 7) * (not moving)
    states = samples.q, samples.dq, samples.ddq
    if moving:
        there = replace(columns, carried=plant.parameters[columns.table_indices])
        share = np.zeros(there.count)
        share[load_indices(there)] = 0.3
        samples = replace(samples, tau=samples.tau + there.torques(*states, share))
        columns = with_load_friction(samples, columns)
    given, loads = information_of(samples, columns), load_indices(columns)
    about, kept, b = given.values * 1.02, given.base.kept, given.base.count
    dry = np.isin(kept, np.setdiff1d(columns.friction_indices, loads))
    W = columns(*states)[:, :, kept]
    D = np.einsum("kj,ji->kji", W @ np.where(dry, 0.0, about), np.eye(7))
    weight = samples.used / np.square(given.noise)

    def torques(values):
        whole = np.zeros(columns.count)
        whole[kept] = values
        at = replace(columns, carried=whole[columns.table_indices]) if moving else columns
        return at.torques(*states, whole)

    h, J = 1e-6, W
    if moving:
        J = np.stack([(torques(given.values + e) - torques(given.values - e)) / (2 * h) for e in h * np.eye(b)], axis=2)
    X, slope = (np.concatenate([one, D], axis=2) for one in (W, J))
    prior = np.diag([0.0] * b + [WIDTH**-2.0] * 7)
    M, V = (np.einsum("kjb,kj,kjc->bc", X, weight, one) + prior for one in (slope, X))
    score = np.einsum("kjb,kj,kj->b", X, weight, samples.tau - torques(given.values))
    score[b:] -= taken / WIDTH**2 + volume
    inverse = np.linalg.inv(M)
    wanted, covariance = np.concatenate([given.values, np.zeros(7)]) + inverse @ score, inverse @ V @ inverse.T
    sigma = np.sqrt(np.diag(covariance))
    change = loads_moved(samples, given, given.values) if moving else None
    freed = FreedGains.of(given, taken, WIDTH, about, volume, moving=change)
    off, near = (0.02, 1e-3) if moving else (1e-5, 1e-5)
    assert np.abs((freed.information.values - wanted[:b]) / sigma[:b]).max() < off
    assert freed.information.sigma == pytest.approx(sigma[:b], rel=near)
    assert freed.steps(wanted[:b]) == pytest.approx(-np.log1p(-wanted[b:]), abs=near * sigma[b:].min() + 1e-7)
    assert freed.covariance(covariance[:b, :b]) == pytest.approx(covariance[b:, b:], rel=1e-3, abs=1e-8)
    gains = freed.gains(covariance[:b, :b])
    sure = freed.with_errors_of(replace(gains, covariance=1e-12 * np.diag(np.diag(gains.covariance))))
    alone = np.linalg.inv(M[:b, :b])
    assert sure.sigma == pytest.approx(np.sqrt(np.diag(alone @ V[:b, :b] @ alone.T)), rel=1e-3)
    if moving:
        assert with_moving_loads(samples, given).sigma == pytest.approx(sure.sigma, rel=1e-3)
        still = FreedGains.of(given, taken, WIDTH, about)
        assert np.abs(still.information.sigma / sigma[:b] - 1.0).max() > 0.05
        whole = np.zeros(columns.count)
        whole[kept] = given.values
        added = np.diag(freed.with_friction(whole, np.zeros((columns.count,) * 2)))
        assert not added[loads].any()  # a share is none of torque
        assert (added[np.setdiff1d(columns.friction_indices, loads)] > 0.0).all()


def test_a_joint_without_equations_keeps_the_prior_s_gain(samples, plant, gains):
    """Also beside shares of the load, and in a log without noise."""
    six = without_last(samples)
    given = information_of(six, with_load_friction(six, plant.columns))
    freed = FreedGains.of(given, np.zeros(7), WIDTH, moving=loads_moved(six, given, given.values))
    errors = freed.covariance(freed.information.covariance)
    assert np.isfinite(freed.information.values).all()
    assert freed.steps(freed.information.values)[6] == pytest.approx(0.0, abs=1e-9)
    assert errors[6, 6] == pytest.approx(WIDTH**2)
    assert (np.diag(errors)[:4] < 0.3 * WIDTH**2).all()
    exact = gains * plant.columns.torques(samples.q, samples.dq, samples.ddq, plant.parameters)
    information = information_of(replace(six, tau=exact), plant.columns)
    logs = gains_alone(information.normal, plant.columns, information.base, WIDTH)
    assert np.ptp(logs[:6] - np.log(gains[:6])) < 1e-3
    assert logs[6] == pytest.approx(0.0, abs=1e-9)


def test_gains_alone_meet_the_truth_and_leave_the_common_factor_to_the_prior(samples, plant, gains):
    information = information_of(samples, plant.columns)
    normal, base = information.normal, information.base
    logs = gains_alone(normal, plant.columns, base, WIDTH)
    freed = FreedGains.of(information_of(samples.times(np.exp(-logs)), plant.columns), logs, WIDTH)
    errors = freed.covariance(freed.information.covariance)
    off = logs - np.log(gains)
    assert off @ np.linalg.solve(errors, off) < 24.3  # chi^2 of 7, 99.9 %
    assert np.sqrt(errors.sum()) / 7 == pytest.approx(WIDTH / np.sqrt(7), rel=0.05)
    heavier = gains_alone(normal.times(np.full(7, 1.1)), plant.columns, base, WIDTH)
    assert np.ptp(heavier - logs) < 0.02
    assert np.abs(heavier - logs).max() < 0.02  # no torque shows that all are larger
    assert np.abs(freed.steps(freed.information.values)).max() < 1e-5


def test_gains_by_loud_torques_are_off_by_what_their_errors_say(samples, plant):
    """Gains of the prior's width, 20 times the noise: a column with that noise would have others, and be surer."""
    rng, columns, chi2 = np.random.default_rng(5), plant.columns, []
    exact = columns.torques(samples.q, samples.dq, samples.ddq, plant.parameters)
    for _ in range(12):
        true = rng.normal(0.0, WIDTH, 7)
        loud = replace(samples, tau=np.exp(true) * exact + rng.normal(0.0, 2.0, exact.shape))
        information = information_of(loud, columns)
        logs = gains_alone(information.normal, columns, information.base, WIDTH)
        freed = FreedGains.of(information_of(loud.times(np.exp(-logs)), columns), logs, WIDTH)
        off = logs - true
        chi2.append(off @ np.linalg.solve(freed.covariance(freed.information.covariance), off) / 7)
    assert 0.6 < np.mean(chi2) < 1.5  # 1 +- 0.15


def test_errors_with_those_of_gains_are_between_known_and_unknown_ones(samples, plant):
    given = information_of(samples, plant.columns)
    freed = FreedGains.of(given, np.zeros(7), WIDTH)
    errors = freed.covariance(freed.information.covariance)
    same = freed.with_errors_of(freed.gains(freed.information.covariance))
    friction = np.isin(given.base.kept, plant.columns.friction_indices)
    assert same.sigma[~friction] == pytest.approx(freed.information.sigma[~friction], rel=1e-3)
    at = friction & (np.abs(given.values) > 30.0 * given.sigma)
    joints = np.array([int(plant.columns.names[k].rsplit("_", 1)[1]) - 1 for k in given.base.kept[at]])
    of_gains = np.abs(given.values[at]) * np.sqrt(np.diag(errors))[joints]
    assert np.median(same.sigma[at] / of_gains) == pytest.approx(1.0, abs=0.1)
    known = freed.with_errors_of(replace(freed.gains(freed.information.covariance), covariance=1e-12 * np.eye(7)))
    assert known.sigma == pytest.approx(given.sigma, rel=1e-4)


def test_friction_in_true_torques_has_the_errors_of_its_gain(samples, plant):
    columns, given = plant.columns, information_of(samples, plant.columns)
    freed = FreedGains.of(given, np.zeros(7), WIDTH)
    sure = freed.with_friction(plant.parameters, np.zeros((columns.count,) * 2))
    part = columns.of_joint(2)
    at = part.start + 1
    alone = freed.covariance(np.zeros((given.base.count,) * 2))[2, 2]
    assert sure[at, at] == pytest.approx(plant.parameters[at] ** 2 * alone)
    assert sure[part.start, part.start] == 0.0
    assert not sure[: columns.bodies].any()


def test_the_volume_counts_parameters_of_bodies(samples, plant):
    """Where the log says all: their number, whoever's equations say them."""
    given = information_of(samples, plant.columns)
    covariance = np.zeros((plant.columns.count,) * 2)
    covariance[np.ix_(given.base.kept, given.base.kept)] = given.covariance
    assert volume_of(given, covariance).sum() == pytest.approx(np.sum(given.base.kept < plant.columns.bodies), rel=1e-6)
