"""Stribeck speeds come back from logs, and joints without such friction get no term."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.stribeck import stribeck_search
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification import plants
from tests.identification.fresh_study import torque_error

TRUE = np.array([0.05, 0.05, np.nan, 0.08, 0.1, np.nan, 0.05])
NOISE = 0.1
FINE = SampleRule(slowest=0.01)


@pytest.fixture(scope="module")
def lwr():
    return lwr_dyn.load("lwr4plus")


@pytest.fixture(scope="module", params=["symmetric", "directions"])
def case(request, lwr):
    """Plant with 30 % of Stribeck drop at five joints, its log of 20 s, and what the search finds."""
    rng = np.random.default_rng(7)
    plant = plants.perturbed_plant(TorqueColumns(lwr.chain, request.param, TRUE), lwr, rng)
    log = plants.simulated_log(plant, plants.random_motion(lwr, 20.0, rng, 1000.0), NOISE, rng, 1e-5)
    return plant, log, stribeck_search(samples_of([log], FINE), TorqueColumns(lwr.chain, request.param))


@pytest.mark.slow
def test_the_speeds_come_back_and_only_where_there_are_some(case):
    found = case[2]
    assert (np.isnan(found.speeds) == np.isnan(TRUE)).all()
    there = ~np.isnan(TRUE)
    assert found.speeds[there] == pytest.approx(TRUE[there], rel=0.025)
    assert (found.drop[there] > 100.0).all()
    assert (found.drop[~there] == 0.0).all()
    assert not found.at_bound.any()
    assert found.information.noise == pytest.approx(np.full(7, NOISE), rel=0.1)
    assert found.information.base.count == 69 + (7 if "directions" in found.columns.friction else 0) + (
        5 if found.columns.friction == "symmetric" else 10
    )


@pytest.mark.slow
def test_the_term_ends_the_error_that_unmodelled_stribeck_friction_makes(lwr, case):
    """Fresh motions, noise-free torque error [N m]: 0.6 and more without the term, below the noise with it."""
    plant, log, found = case
    rng = np.random.default_rng(8)
    fresh = [plants.random_motion(lwr, 10.0, rng) for _ in range(3)]
    plain = TorqueColumns(lwr.chain, plant.columns.friction)
    without = torque_error(plant, information_of(samples_of([log], FINE), plain), fresh)
    error = torque_error(plant, found.information, fresh)
    assert error < NOISE
    assert without > 4 * NOISE
    assert without > 5 * error


def test_an_arm_without_stribeck_friction_gets_no_term(lwr):
    rng = np.random.default_rng(9)
    plant = plants.perturbed_plant(TorqueColumns(lwr.chain), lwr, rng)
    samples = plants.simulated_samples(plant, plants.random_motion(lwr, 10.0, rng), NOISE, rng, 0.01)
    found = stribeck_search(samples, plant.columns)
    assert np.isnan(found.speeds).all()
    assert found.columns.stribeck_velocity is None
    assert torque_error(plant, found.information, [plants.random_motion(lwr, 10.0, rng)]) < NOISE


def test_friction_that_rises_from_rest_is_not_taken_for_a_drop(lwr):
    rng = np.random.default_rng(13)
    plant = plants.perturbed_plant(TorqueColumns(lwr.chain, "symmetric", np.full(7, 0.1)), lwr, rng)
    rising = plant.parameters.copy()
    for k, name in enumerate(plant.columns.names):
        rising[k] *= -1.0 if name.startswith("stribeck") else 1.0
    samples = plants.simulated_samples(
        plants.Plant(plant.columns, rising), plants.random_motion(lwr, 10.0, rng), NOISE, rng, 0.01
    )
    assert np.isnan(stribeck_search(samples, plant.columns).speeds).all()


def test_a_speed_below_what_is_used_is_said_to_be_at_the_bound(lwr):
    rng = np.random.default_rng(10)
    plant = plants.perturbed_plant(TorqueColumns(lwr.chain, "symmetric", np.full(7, 0.05)), lwr, rng)
    samples = plants.simulated_samples(plant, plants.random_motion(lwr, 20.0, rng), 0.01, rng, 0.15)
    found = stribeck_search(samples, plant.columns)
    there = ~np.isnan(found.speeds)
    assert (found.speeds[there] >= found.lowest[there]).all()
    assert (np.abs(found.speeds[there] - 0.05) < 0.05).all()
