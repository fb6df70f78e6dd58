"""Stribeck speeds come back from logs with their standard errors, and joints without such friction get no term."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionRule, motion_document
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.stribeck import stribeck_search, with_unknown_speeds
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.transmission import Transmission
from tests.identification.coverage_study import torque_error
from tests.identification.plants import Plant, inside, perturbed_plant, random_motion, simulated_log, simulated_samples

TRUE = np.array([0.05, 0.05, np.nan, 0.08, 0.1, np.nan, 0.05])
THERE = ~np.isnan(TRUE)
NOISE = 0.1
FINE = SampleRule(slowest=0.01)
MOTORS = Transmission(np.eye(7) + 0.3 * np.eye(7, k=-1))
DRAWS = 6
"""Of 40: 99.0 % of 200 speeds within 3 sigma; of 3440 parameters 99.68 % (99.65 % with speeds as if known)."""


@pytest.fixture(scope="module")
def lwr():
    return lwr_dyn.load("lwr4plus")


def made(lwr, seed, form="symmetric", speeds=TRUE, motors=None, seconds=10.0, noise=NOISE, slowest=0.01):
    """A plant with 30 % of Stribeck drop, and samples of it."""
    rng = np.random.default_rng(seed)
    plant = perturbed_plant(TorqueColumns(lwr.chain, form, speeds, motors), lwr, rng)
    return plant, simulated_samples(plant, random_motion(lwr, seconds, rng), noise, rng, slowest)


@pytest.fixture(scope="module", params=["symmetric", "directions"])
def case(request, lwr):
    """Plant with 30 % of Stribeck drop at five joints, its log of 20 s, and what the search finds."""
    rng = np.random.default_rng(7)
    plant = perturbed_plant(TorqueColumns(lwr.chain, request.param, TRUE), lwr, rng)
    log = simulated_log(plant, random_motion(lwr, 20.0, rng, 1000.0), NOISE, rng, 1e-5)
    return plant, log, stribeck_search(samples_of([log], FINE), TorqueColumns(lwr.chain, request.param))


@pytest.mark.slow
def test_the_speeds_come_back_and_only_where_there_are_some(case):
    found = case[2]
    assert (np.isnan(found.speeds) == ~THERE).all()
    assert found.speeds[THERE] == pytest.approx(TRUE[THERE], rel=0.025)
    assert (found.drop[THERE] > 100.0).all()
    assert not found.drop[~THERE].any()
    assert not found.at_bound.any()
    assert not any(x.flags.writeable for x in (found.speeds, found.drop, found.lowest, found.highest))
    assert found.information.noise == pytest.approx(np.full(7, NOISE), rel=0.1)
    assert found.information.base.count == (69 + 5 if found.columns.friction == "symmetric" else 69 + 7 + 10)


@pytest.mark.slow
def test_the_term_ends_the_error_that_unmodelled_stribeck_friction_makes(lwr, case):
    """Fresh motions, noise-free torque error [N m]: 0.6 and more without the term, below the noise with it."""
    plant, log, found = case
    rng = np.random.default_rng(8)
    fresh = [random_motion(lwr, 10.0, rng) for _ in range(3)]
    plain = TorqueColumns(lwr.chain, plant.columns.friction)
    without = torque_error(plant, information_of(samples_of([log], FINE), plain), fresh)
    error = torque_error(plant, found.information, fresh)
    assert 5 * error < 5 * NOISE < without + NOISE
    assert without > 5 * error


def test_the_drop_and_the_bounds_of_the_search_are_what_is_said(lwr):
    """Drop of chi^2 by one joint's column; a third of the largest speed and half of the least that is used."""
    _, samples = made(lwr, 2)
    found = stribeck_search(samples, TorqueColumns(lwr.chain))
    assert found.speeds == pytest.approx(TRUE, rel=0.2, nan_ok=True)
    noise = found.information.noise
    for j in np.flatnonzero(THERE):
        alone = replace(found.columns, stribeck_velocity=np.where(np.arange(7) == j, np.nan, found.speeds))
        less = information_of(samples, alone, noise=noise).chi2 - found.information.chi2
        assert found.drop[j] == pytest.approx(less, rel=0.02)
    speeds = np.where(samples.used, np.abs(samples.dq), np.nan)
    assert found.highest == pytest.approx(np.nanmax(speeds, axis=0) / 3.0)
    assert found.lowest == pytest.approx(np.nanmin(speeds, axis=0) / 2.0)
    low, high = found.lowest, found.highest
    at = np.array([1.005 * low[0], 1.02 * low[1], 0.98 * high[2], 0.995 * high[3], np.nan, np.nan, low[6]])
    assert replace(found, speeds=at).at_bound.tolist() == [True, False, False, True, False, False, True]


@pytest.mark.parametrize("rises", [False, True])
def test_an_arm_without_stribeck_friction_gets_no_term(lwr, rises):
    """Nor one whose friction rises from rest."""
    plant, samples = made(lwr, 13, speeds=np.full(7, 0.1))
    drop = np.array([name.startswith("stribeck") for name in plant.columns.names])
    plant = Plant(plant.columns, plant.parameters * np.where(drop, -1.0 if rises else 0.0, 1.0))
    rng = np.random.default_rng(9)
    tau = plant.columns.torques(samples.q, samples.dq, samples.ddq, plant.parameters)
    samples = replace(samples, tau=tau + rng.normal(0.0, NOISE, tau.shape))
    found = stribeck_search(samples, plant.columns)
    assert (np.isnan(found.speeds).all(), found.columns.stribeck_velocity) == (True, None)
    assert rises or torque_error(plant, found.information, [random_motion(lwr, 10.0, rng)]) < NOISE


def test_a_speed_below_what_is_used_is_said_to_be_at_the_bound(lwr):
    _, samples = made(lwr, 10, speeds=np.full(7, 0.05), seconds=20.0, noise=0.01, slowest=0.15)
    found = stribeck_search(samples, TorqueColumns(lwr.chain))
    there = ~np.isnan(found.speeds)
    assert (found.speeds[there] >= found.lowest[there]).all()
    assert (np.abs(found.speeds[there] - 0.05) < 0.05).all()


def test_speeds_of_motors_are_looked_for_among_those_that_motors_have(lwr):
    """Behind gears of 50 they are 50 times those of joints, which is above the speeds of any joint."""
    gears = Transmission(50.0 * np.eye(7))
    _, samples = made(lwr, 3, speeds=50.0 * TRUE, motors=gears, noise=1e-3)
    found = stribeck_search(samples, TorqueColumns(lwr.chain, "symmetric", transmission=gears))
    assert found.speeds[THERE] == pytest.approx(50.0 * TRUE[THERE], rel=0.05)


@pytest.mark.slow
def test_speeds_and_parameters_are_within_their_errors(lwr):
    of_speeds, of_values = [], []
    for seed in range(DRAWS):
        plant, samples = made(lwr, seed, "directions")
        found = stribeck_search(samples, TorqueColumns(lwr.chain, "directions"))
        information, sigma = with_unknown_speeds(samples, found.information)
        assert (np.isnan(sigma) == ~THERE).all()
        assert (information.sigma >= found.information.sigma * (1.0 - 1e-9)).all()
        of_speeds.append(((found.speeds - TRUE) / sigma)[THERE])
        of_values.append((information.values - information.base.of(plant.parameters)) / information.sigma)
    assert 0.6 < np.sqrt(np.mean(np.square(of_speeds))) < 1.6
    assert (np.abs(of_speeds) < 4.5).all()
    assert inside(np.array(of_values)) > 0.99


@pytest.mark.parametrize(("form", "motors"), [("symmetric", None), ("directions", MOTORS)])
def test_errors_are_those_of_the_slopes_of_torques_as_further_columns(lwr, form, motors):
    plant, samples = made(lwr, 4, form, motors=motors)
    columns, given = plant.columns, information_of(samples, plant.columns)
    states, whole = (samples.q, samples.dq, samples.ddq), np.zeros(plant.columns.count)
    whole[given.base.kept] = given.values

    def torques(moved):
        return replace(columns, stribeck_velocity=TRUE + moved).torques(*states, whole)

    h = 1e-5
    T = np.stack([(torques(h * e) - torques(-h * e)) / (2 * h) for e in np.eye(7)[THERE]], axis=2)
    W, weight = columns(*states)[:, :, given.base.kept], samples.used / np.square(given.noise)
    WW, WT, TT = (np.einsum("kja,kj,kjb->ab", x, weight, y, optimize=True) for x, y in ((W, W), (W, T), (T, T)))
    found, sigma = with_unknown_speeds(samples, given)
    assert (np.isnan(sigma) == ~THERE).all()
    assert sigma[THERE] == pytest.approx(np.sqrt(np.diag(np.linalg.inv(TT - WT.T @ np.linalg.solve(WW, WT)))), rel=1e-3)
    inverse = np.linalg.inv(WW - WT @ np.linalg.solve(TT, WT.T))
    assert found.sigma == pytest.approx(np.sqrt(np.diag(inverse)), rel=1e-3)
    assert np.abs(found.sigma / given.sigma).max() > 1.1


@pytest.mark.slow
@pytest.mark.parametrize("motors", [None, MOTORS])
def test_they_are_the_curvature_of_chi2(lwr, motors):
    """Second differences of the least chi^2 over v_s, at motors too."""
    _, samples = made(lwr, 2, motors=motors, noise=1e-3)
    found = stribeck_search(samples, TorqueColumns(lwr.chain, "symmetric", transmission=motors))
    _, sigma = with_unknown_speeds(samples, found.information)
    noise, joints, step = found.information.noise, np.flatnonzero(THERE), 0.02 * found.speeds

    def chi2(*moves):
        speeds = found.speeds.copy()
        for j, side in moves:
            speeds[j] += side * step[j]
        return information_of(samples, replace(found.columns, stribeck_velocity=speeds), noise=noise).chi2

    H = np.zeros((len(joints), len(joints)))
    for a, i in enumerate(joints):
        for b, j in enumerate(joints[: a + 1]):
            four = sum(s * t * chi2((i, s), (j, t)) for s, t in [(1, 1), (1, -1), (-1, 1), (-1, -1)])
            H[a, b] = H[b, a] = four / (4.0 * step[i] * step[j]) / 2.0
    assert sigma[THERE] == pytest.approx(np.sqrt(np.diag(np.linalg.inv(H))), rel=0.05)


def test_the_text_has_them(lwr):
    rng = np.random.default_rng(3)
    plant = perturbed_plant(TorqueColumns(lwr.chain, "directions", TRUE), lwr, rng)
    log = simulated_log(plant, random_motion(lwr, 20.0, rng, 400.0), NOISE, rng, 1e-5)
    result = identify_motion([log], lwr, MotionRule(FINE, stribeck=True))
    table = motion_document(result).text().split("Stribeck speeds\n")[1].split("\n\n")[0]
    assert table.count("+-") == 5
    assert (np.abs(result.stribeck.speeds - TRUE)[THERE] < 4.0 * result.stribeck_sigma[THERE]).all()
