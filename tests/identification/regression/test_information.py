"""Weighted least squares by blocks is least squares; what a log does not show is said, and sums over recordings add."""

import tracemalloc

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.regression import information as module
from lwr_dyn.identification.regression.information import information_of, normal_equations, solve
from lwr_dyn.identification.regression.least_squares import Spectrum, solved
from lwr_dyn.identification.regression.samples import exact_samples, sample_parts
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.plants import Motion, Plant, perturbed_plant, random_motion, simulated_samples

NOISE = np.array([0.3, 0.3, 0.1, 0.1, 0.05, 0.05, 0.02])
ALONG = 1e-9
"""Agreement with other roads, relative."""


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
    """Rows of base columns and torques, weighted, of the equations that are used."""
    base = plant.columns.base()
    Y = plant.columns(samples.q, samples.dq, samples.ddq)[:, :, base.kept] / noise[:, None]
    return Y[samples.used], (samples.tau / noise)[samples.used]


def test_values_and_sigma_are_those_of_dense_least_squares(plant, samples, information):
    W, y = dense(plant, samples, information.noise)
    values = np.linalg.lstsq(W, y)[0]
    assert np.abs(information.values - values).max() < ALONG * np.abs(values).max()
    wanted = np.sqrt(np.diag(np.linalg.inv(W.T @ W)))
    assert information.sigma == pytest.approx(wanted, rel=1e-8)
    assert information.chi2 == pytest.approx(np.sum((y - W @ values) ** 2), rel=1e-8)
    assert information.dof == len(y) - values.size
    assert information.condition == pytest.approx(np.linalg.cond(W / np.linalg.norm(W, axis=0)), rel=1e-6)


def test_friction_at_motors_that_drive_two_joints_is_least_squares_too():
    arm, rng = lwr_dyn.load("wam7"), np.random.default_rng(11)
    columns = TorqueColumns(arm.chain, transmission=arm.transmission)
    own = columns.own(arm)
    own[columns.bodies :] = rng.uniform(0.001, 0.02, columns.count - columns.bodies)
    plant = Plant(columns, own)
    samples = simulated_samples(plant, random_motion(arm, 10.0, rng), 0.1, rng, 0.05)
    W, y = dense(plant, samples, np.ones(7))
    values = np.linalg.lstsq(W, y)[0]
    found = information_of(samples, columns, noise=np.ones(7))
    assert np.abs(found.values - values).max() < ALONG * np.abs(values).max()


@pytest.mark.parametrize("robot", ["lwr4plus", "wam7"])
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


def test_the_noise_of_every_joint_is_found(information):
    assert information.noise == pytest.approx(NOISE, rel=0.08)
    assert information.chi2 / information.dof == pytest.approx(1.0, abs=1e-6)


def test_the_truth_is_within_the_intervals(plant, information):
    away = (information.values - plant.base) / information.sigma
    assert np.abs(away).max() < 4.0
    assert 0.5 < np.mean(away**2) < 1.7


def test_noise_that_is_given_is_taken(plant, samples):
    twice = information_of(samples, plant.columns, noise=2 * NOISE)
    assert (twice.noise == 2 * NOISE).all()
    assert twice.chi2 / twice.dof == pytest.approx(0.25, rel=0.1)


def test_factor_and_chi2(information):
    R = information.factor
    assert np.abs(np.tril(R, -1)).max() == 0.0
    assert np.abs(R.T @ R - information.precision).max() < 1e-12 * np.abs(information.precision).max()
    assert np.abs(information.normal.weighted(information.noise)[0] - information.precision).max() < 1e-6
    other = information.values + 0.3 * information.sigma
    squares = information.normal.residual_squares(other) / information.noise**2
    away = other - information.values
    assert information.chi2 + away @ information.precision @ away == pytest.approx(squares.sum(), rel=1e-9)
    assert information.covariance @ information.precision == pytest.approx(np.eye(information.base.count), abs=1e-6)


def test_recordings_add_up_and_blocks_do_not_matter(plant, samples, information, monkeypatch):
    base, half = plant.columns.base(), len(samples) // 3
    parts = [samples.select(slice(None, half)), samples.select(slice(half, None))]
    one, two = (normal_equations(part, plant.columns, base) for part in parts)
    summed = solve(one + two, plant.columns, base)
    assert summed.values == pytest.approx(information.values, rel=1e-9, abs=1e-9)
    assert (summed.equations == information.equations).all()
    monkeypatch.setattr(module, "BLOCK", 37)
    monkeypatch.setattr(module, "CHUNK", 111)
    streamed = information_of(iter(parts), plant.columns)
    assert streamed.values == pytest.approx(information.values, rel=1e-9, abs=1e-9)


def test_exact_torques_give_the_truth(plant, samples):
    tau = plant.torque(Motion(samples.t, samples.q, samples.dq, samples.ddq))
    found = information_of(exact_samples(samples.t, samples.q, samples.dq, samples.ddq, tau), plant.columns)
    assert found.values == pytest.approx(plant.base, rel=1e-8, abs=1e-9)
    assert found.noise.max() < 1e-4
    assert found.determined.all()


def test_a_joint_that_stands_still_leaves_its_own_parameters_open(lwr, plant):
    rng = np.random.default_rng(6)
    motion = random_motion(lwr, 10.0, rng)
    still = np.arange(7) != 2
    q = np.where(still, motion.q, 0.3)
    frozen = Motion(motion.t, q, motion.dq * still, motion.ddq * still)
    found = information_of(simulated_samples(plant, frozen, 0.1, rng, 0.05), plant.columns)
    names = np.array(found.base.names)[found.base.kept]
    hidden = set(names[~found.determined].tolist())
    assert {"coulomb_3", "viscous_3", "offset_3", "armature_3"} <= hidden
    assert {"coulomb_4", "mx_7", "viscous_1"} <= set(names[found.determined].tolist())
    assert np.isinf(found.sigma).tolist() == (~found.determined).tolist()
    assert np.isfinite(found.values).all()
    assert np.isnan(found.noise[2])
    assert found.equations[2] == 0
    assert found.condition == np.inf
    known = found.determined
    away = (found.values - plant.base)[known] / found.sigma[known]
    assert np.abs(away).max() < 4.5


def test_nothing_at_all_is_determined_without_equations(plant, samples):
    none = exact_samples(samples.t, samples.q, 0 * samples.dq, 0 * samples.ddq, samples.tau)
    found = information_of(none, plant.columns)
    assert not found.determined.any()
    assert (found.values == 0.0).all()
    assert (found.chi2, found.dof) == (0.0, 0)


def test_a_step_of_refinement_mends_an_inverse_that_is_nearly_singular():
    errors = []
    for seed in range(40):  # of one matrix the ratio is rounding, another on each processor
        rng = np.random.default_rng(seed)
        U = np.linalg.qr(rng.normal(size=(30, 30)))[0]
        matrix = U * np.geomspace(1.0, 1e-9, 30) @ U.T
        truth = rng.normal(size=30)
        side, inverse = matrix @ truth, Spectrum.of(matrix).inverse()
        errors.append((np.abs(solved(matrix, side, inverse) - truth).max(), np.abs(inverse @ side - truth).max()))
    refined, plain = np.median(errors, axis=0)
    assert refined < 0.7 * plain
    assert Spectrum.of(matrix).rank == 30
    assert Spectrum.of(np.zeros((3, 3))).rank == 0


def test_samples_of_another_arm_are_refused(plant, samples):
    two = exact_samples(samples.t, *(x[:, :2] for x in (samples.q, samples.dq, samples.ddq, samples.tau)))
    with pytest.raises(ShapeError, match="samples: 2 joints; allowed: 7, those of the columns"):
        information_of(two, plant.columns)


@pytest.mark.slow
def test_a_long_log_needs_little_memory(lwr, plant):
    """Peak beyond the log, of 100 000 rows (the time and a million: soak line `million_rows`)."""
    motion = random_motion(lwr, 100.0, np.random.default_rng(14))
    rows = np.arange(100_000) % (len(motion.t) - 1)
    q, dq, ddq = motion.q[rows], motion.dq[rows], motion.ddq[rows]
    samples = exact_samples(np.arange(100_000) / 100.0, q, dq, ddq, np.ones_like(q), 0.05)
    log = JointLog("long", tuple(range(1, 8)), samples.t, q, samples.tau)
    information_of(samples.select(slice(0, 2000)), plant.columns)  # the kernel is loaded
    assert _peak(lambda: information_of(samples, plant.columns)) < 15e6
    assert _peak(lambda: information_of(sample_parts([log]), plant.columns)) < 30e6


def _peak(call):
    tracemalloc.start()
    try:
        call()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
