"""Weighted least squares by blocks is least squares; what a log does not show is said; sigma covers the truth."""

import tracemalloc

import numpy as np
import pytest
from scipy.signal import lfilter

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.validation import inflation_of, residuals_of, whiteness_of
from lwr_dyn.identification.regression import information as module
from lwr_dyn.identification.regression.information import (
    equations_of,
    grouped,
    information_of,
    normal_equations,
    solve,
    widened,
)
from lwr_dyn.identification.regression.samples import SampleRule, exact_samples, sample_parts
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.coverage_study import SLOWEST, coverage_study, fresh_motions, predicted_error, torque_error
from tests.identification.plants import Motion, Plant, inside, perturbed_plant, random_motion, rms, simulated_samples

NOISE = np.array([0.3, 0.3, 0.1, 0.1, 0.05, 0.05, 0.02])
ALONG = 1e-9
"""Agreement with other roads, relative."""
BOTH = pytest.mark.parametrize("robot", ["lwr4plus", "wam7"])
DRAWS = range(40)


@pytest.fixture(scope="module")
def lwr():
    return lwr_dyn.load("lwr4plus")


@pytest.fixture(scope="module")
def plant(lwr):
    return perturbed_plant(TorqueColumns(lwr.chain), lwr, np.random.default_rng(3))


@pytest.fixture(scope="module")
def samples(lwr, plant):
    rng = np.random.default_rng(4)
    return simulated_samples(plant, random_motion(lwr, 10.0, rng), NOISE, rng, 0.05)


@pytest.fixture(scope="module")
def information(plant, samples):
    return information_of(samples, plant.columns)


def dense(plant, samples, noise):
    """Rows of base columns and torques, weighted, of the equations that are used, and their solution."""
    base = plant.columns.base()
    Y = plant.columns(samples.q, samples.dq, samples.ddq)[:, :, base.kept] / noise[:, None]
    W, y = Y[samples.used], (samples.tau / noise)[samples.used]
    return W, y, np.linalg.lstsq(W, y)[0]


def misses(found, plant):
    return (found.values - plant.base) / found.sigma


@pytest.fixture(scope="module")
def coupled():
    """Friction at motors that drive two joints."""
    arm, rng = lwr_dyn.load("wam7"), np.random.default_rng(11)
    columns = TorqueColumns(arm.chain, transmission=arm.transmission)
    own = columns.own(arm)
    own[columns.bodies :] = rng.uniform(0.001, 0.02, columns.count - columns.bodies)
    plant = Plant(columns, own)
    samples = simulated_samples(plant, random_motion(arm, 10.0, rng), 0.1, rng, 0.05)
    return plant, samples, information_of(samples, columns)


@pytest.mark.parametrize("case", ["alone", "coupled"])
def test_all_numbers_are_those_of_dense_least_squares(case, plant, samples, information, coupled):
    plant, samples, information = (plant, samples, information) if case == "alone" else coupled
    W, y, values = dense(plant, samples, information.noise)
    precision = W.T @ W
    assert np.abs(information.values - values).max() < ALONG * np.abs(values).max()
    assert np.abs(information.precision - precision).max() < ALONG * np.abs(precision).max()
    assert information.sigma == pytest.approx(np.sqrt(np.diag(np.linalg.inv(precision))), rel=1e-8)
    assert information.chi2 == pytest.approx(np.sum((y - W @ values) ** 2), rel=1e-8)
    assert (information.dof, information.equations.tolist()) == (len(y) - values.size, samples.used.sum(0).tolist())
    assert information.condition == pytest.approx(np.linalg.cond(W / np.linalg.norm(W, axis=0)), rel=1e-6)
    assert information.covariance @ precision == pytest.approx(np.eye(values.size), abs=1e-6)
    joint = np.nonzero(samples.used)[1]
    leverage = np.einsum("kb,bc,kc->k", W, np.linalg.inv(precision), W)
    assert information.paid == pytest.approx(np.bincount(joint, leverage), rel=1e-6)
    R = information.factor
    assert not np.tril(R, -1).any()
    assert (np.diag(R) > 0.0).all()
    assert np.abs(R.T @ R - precision).max() < 1e-12 * np.abs(precision).max()
    other = values + 0.3 * information.sigma
    left = np.square(y - W @ other) * np.square(information.noise)[joint]
    assert information.normal.residual_squares(other) == pytest.approx(np.bincount(joint, left), rel=1e-9)
    assert information.normal.residual_rms(other) ** 2 == pytest.approx(
        np.bincount(joint, left) / information.equations, rel=1e-9
    )


def test_the_noise_of_every_joint_is_found_and_the_truth_is_within_the_intervals(plant, information):
    assert information.noise == pytest.approx(NOISE, rel=0.08)
    assert information.chi2 / information.dof == pytest.approx(1.0, abs=1e-6)
    assert information.half_widths == pytest.approx(3.0 * information.sigma, rel=2e-3)
    z = misses(information, plant)
    assert np.abs(z).max() < 4.0
    assert 0.5 < np.mean(z**2) < 1.7


@BOTH
def test_direct_least_squares_by_pinocchios_regressor_agrees(robot):
    """Parameters of another kind (frames of the URDF, order of the tensor), the same torques everywhere."""
    arm, rng = lwr_dyn.load(robot), np.random.default_rng(5)
    plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng)
    samples = simulated_samples(plant, random_motion(arm, 10.0, rng, rate=40.0), 0.1, rng, 0.05)
    info = information_of(samples, plant.columns, noise=np.ones(7))
    regressor = lwr_dyn.dynamics_of(arm, "pinocchio").ungated.torque_regressor

    def rows(q, dq, ddq):
        bodies = np.array([regressor(*x) for x in zip(q, dq, ddq, strict=True)])
        return np.concatenate([bodies, plant.columns(q, dq, ddq)[:, :, plant.columns.bodies :]], axis=2)

    W = rows(samples.q, samples.dq, samples.ddq)[samples.used]
    size = np.linalg.norm(W, axis=0)
    size[size < 1e-9 * size.max()] = 1.0
    pi = np.linalg.lstsq(W / size, samples.tau[samples.used], rcond=1e-10)[0] / size
    fresh = rng.uniform(-2.0, 2.0, (3, 50, 7))
    torque = rows(*fresh) @ pi
    ours = plant.columns(*fresh)[:, :, info.base.kept]
    assert np.abs(ours @ info.values - torque).max() < ALONG * np.abs(torque).max()
    theirs = np.linalg.lstsq(ours.reshape(-1, info.base.count), torque.ravel())[0]
    assert np.abs(theirs - info.values).max() < ALONG * np.abs(info.values).max()


def test_recordings_add_up_and_blocks_do_not_matter(plant, samples, information, monkeypatch):
    base, third = plant.columns.base(), len(samples) // 3
    parts = [samples.select(slice(None, third)), samples.select(slice(third, None))]
    one, two = (normal_equations(part, plant.columns, base) for part in parts)
    monkeypatch.setattr(module, "BLOCK", 37)
    monkeypatch.setattr(module, "CHUNK", 111)
    for found in (solve(one + two, plant.columns, base), information_of(iter(parts), plant.columns)):
        assert found.values == pytest.approx(information.values, rel=1e-9, abs=1e-9)
        assert (found.equations == information.equations).all()


def test_exact_torques_give_the_truth(plant, samples):
    tau = plant.torque(Motion(samples.t, samples.q, samples.dq, samples.ddq))
    found = information_of(exact_samples(samples.t, samples.q, samples.dq, samples.ddq, tau), plant.columns)
    assert found.values == pytest.approx(plant.base, rel=1e-8, abs=1e-9)
    assert found.noise.max() < 1e-4
    assert found.determined.all()


def test_a_group_of_zeros_has_noise_that_others_bear():
    rows = equations_of(np.ones((5, 2, 1)), np.array([[0.0, 1.0]] * 5), np.ones((5, 2), dtype=bool))
    fit = grouped(rows, np.ones(2))
    assert (fit.noise >= 1e-9).all()
    assert np.isfinite(rows.weighted(fit.noise)[0]).all()
    assert np.square(fit.sigma).item() > 0.0


def test_a_joint_that_stands_still_leaves_its_own_parameters_open(lwr, plant, samples):
    rng = np.random.default_rng(6)
    motion = random_motion(lwr, 10.0, rng)
    still = np.arange(7) != 2
    frozen = Motion(motion.t, np.where(still, motion.q, 0.3), motion.dq * still, motion.ddq * still)
    found = information_of(simulated_samples(plant, frozen, 0.1, rng, 0.05), plant.columns)
    names, known = np.array(found.base.names)[found.base.kept], found.determined
    assert {"coulomb_3", "viscous_3", "offset_3", "armature_3"} <= set(names[~known].tolist())
    assert {"coulomb_4", "mx_7", "viscous_1"} <= set(names[known].tolist())
    assert np.isinf(found.sigma).tolist() == np.isinf(found.half_widths).tolist() == (~known).tolist()
    assert np.isfinite(found.values).all()
    assert np.isnan([found.noise, found.normal.residual_rms(found.values)])[:, 2].all()
    assert (found.equations[2], found.condition, found.paid[2]) == (0, np.inf, 0.0)
    assert np.abs(misses(found, plant)[known]).max() < 4.5
    none = exact_samples(samples.t, samples.q, 0 * samples.dq, 0 * samples.ddq, samples.tau)
    nothing = information_of(none, plant.columns)
    assert not nothing.determined.any()
    assert not nothing.values.any()
    assert (nothing.chi2, nothing.dof) == (0.0, 0)


def test_samples_of_another_arm_are_refused(plant, samples):
    two = exact_samples(samples.t, *(x[:, :2] for x in (samples.q, samples.dq, samples.ddq, samples.tau)))
    with pytest.raises(ShapeError, match="samples: 2 joints; allowed: 7, those of the columns"):
        information_of(two, plant.columns)


def test_noise_that_is_given_or_widened_is_taken(plant, samples, information):
    twice = information_of(samples, plant.columns, noise=2 * NOISE)
    assert (twice.noise == 2 * NOISE).all()
    assert twice.chi2 / twice.dof == pytest.approx(0.25, rel=0.1)
    factors = np.array([2.0, 1.0, 1.0, 1.0, 3.0, 1.0, 1.5])
    wide = widened(widened(information, np.sqrt(factors)), np.sqrt(factors))
    same = solve(information.normal, plant.columns, information.base, factors * information.noise)
    assert wide.inflation == pytest.approx(factors)
    assert wide.residual_noise == pytest.approx(information.noise)
    assert wide.values == pytest.approx(same.values)
    assert wide.sigma == pytest.approx(same.sigma)
    assert widened(information, np.ones(7)) is information
    with pytest.raises(OptionError, match=r"inflation: 0\.5; allowed: numbers of at least 1"):
        widened(information, np.full(7, 0.5))


@pytest.mark.slow
def test_a_long_log_needs_little_memory(lwr, plant):
    """Peak beyond the log, of 100 000 rows (the time and a million: soak line `million_rows`)."""
    motion = random_motion(lwr, 100.0, np.random.default_rng(14))
    rows = np.arange(100_000) % (len(motion.t) - 1)
    q, dq, ddq = motion.q[rows], motion.dq[rows], motion.ddq[rows]
    samples = exact_samples(np.arange(100_000) / 100.0, q, dq, ddq, np.ones_like(q), 0.05)
    log = JointLog("long", tuple(range(1, 8)), samples.t, q, samples.tau)
    information_of(samples.select(slice(0, 2000)), plant.columns)  # the kernel is loaded
    for source, most in ((lambda: samples, 15e6), (lambda: sample_parts([log]), 30e6)):
        tracemalloc.start()
        try:
            information_of(source(), plant.columns)
            assert tracemalloc.get_traced_memory()[1] < most
        finally:
            tracemalloc.stop()


@pytest.mark.slow
@BOTH
def test_intervals_hold_the_truth_with_encoders_and_a_filter(robot):
    """A share of the soak line `base_fits`, 1000 fits an arm."""
    z, chi2 = coverage_study(lwr_dyn.load(robot), DRAWS)
    assert inside(z) >= 0.990
    assert np.abs(z.mean(axis=0)).max() < 4.5 / np.sqrt(len(DRAWS))
    assert chi2.mean() == pytest.approx(1.0, abs=0.12)


@pytest.mark.parametrize("cutoff", [None, 80.0])
def test_without_a_filter_or_with_too_wide_a_one_parameters_lean(cutoff, lwr):
    """The noise of the columns themselves biases least squares: by 199 and 11 sigma at worst."""
    z, _ = coverage_study(lwr, range(8), SampleRule(cutoff=cutoff, slowest=SLOWEST))
    assert np.abs(z.mean(axis=0)).max() > 4.5 / np.sqrt(8)
    assert inside(z) < 0.99


@pytest.mark.slow
@BOTH
def test_fresh_torques_are_missed_by_what_the_covariance_says(robot):
    """Noise-free torque error on six motions that the fit has not seen (soak `fresh_torques`: 10 s optimised)."""
    arm, fresh = lwr_dyn.load(robot), fresh_motions(lwr_dyn.load(robot))
    columns, ratios = TorqueColumns(arm.chain), []
    for seed in range(12):
        rng = np.random.default_rng([seed, 2])
        plant = perturbed_plant(columns, arm, rng)
        found = information_of(simulated_samples(plant, random_motion(arm, 10.0, rng), 0.1, rng, 0.05), columns)
        ratios.append(torque_error(plant, found, fresh) / predicted_error(found, fresh))
    assert rms(np.array(ratios)) == pytest.approx(1.0, abs=0.3)  # a few directions make most of it


@pytest.mark.slow
@pytest.mark.parametrize(("memory", "alone"), [(0.0, 0.99), (0.6, 0.9)])
def test_noise_that_lasts_widens_sigma_and_white_noise_does_not(memory, alone, lwr):
    """AR(1) noise of the torques: its slow sums are sqrt((1 + m) / (1 - m)) times those of white noise."""
    rng, columns = np.random.default_rng(15), TorqueColumns(lwr.chain)
    plant, motion = perturbed_plant(columns, lwr, rng), random_motion(lwr, 20.0, rng)
    tau, plain, wide, found = plant.torque(motion), [], [], []
    for _ in range(12):
        white = rng.normal(size=(len(tau) + 300, 7))
        noise = 0.1 * lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], white, axis=0)[300:]
        samples = exact_samples(motion.t, motion.q, motion.dq, motion.ddq, tau + noise, 0.05)
        fit = information_of(samples, columns)
        whiteness = whiteness_of(residuals_of(samples, columns, fit.values), samples.recording)
        wider = widened(fit, inflation_of(whiteness, 7))
        found.append(wider.inflation)
        plain.append(misses(fit, plant))
        wide.append(misses(wider, plant))
    assert inside(np.array(wide)) > 0.985
    assert (inside(np.array(plain)) > alone) == (memory == 0.0)
    assert np.mean(found) == pytest.approx(np.sqrt((1.0 + memory) / (1.0 - memory)), rel=0.1)
