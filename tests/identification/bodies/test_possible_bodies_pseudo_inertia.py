"""The pseudo-inertia: linear, invertible, positive exactly for bodies."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.identification.bodies.possible_bodies import (
    UNITS,
    are_bodies,
    inertial_parameters,
    pseudo_inertia_weights,
    pseudo_inertias,
)
from lwr_dyn.model.chain import Body, is_physical


def test_of_point_masses_it_is_the_sum_of_their_second_moments():
    rng = np.random.default_rng(3)
    places, masses = rng.normal(size=(6, 3)), rng.uniform(1, 2, 6)
    points = np.column_stack([places, np.ones(6)])
    total = sum(body_parameters(Body(m, place, np.zeros((3, 3)))) for m, place in zip(masses, places, strict=True))
    P = pseudo_inertias(total)
    assert np.abs(P - np.einsum("k,ki,kj->ij", masses, points, points)).max() < 1e-12
    assert np.abs(inertial_parameters(P) - total).max() < 1e-12


def test_there_and_back_and_as_the_dual_of_the_weights():
    rng = np.random.default_rng(0)
    parameters, factors = rng.normal(size=(5, 3, 10)), rng.normal(size=10)
    P = pseudo_inertias(parameters)
    assert np.abs(inertial_parameters(P) - parameters).max() < 1e-13
    assert (np.swapaxes(UNITS, 1, 2) == UNITS).all()
    traces = np.trace(pseudo_inertia_weights(factors) @ P, axis1=-2, axis2=-1)
    assert np.abs(traces - parameters @ factors).max() < 1e-13


@pytest.mark.parametrize("reading", ["printed", "computed", "physical"])
def test_the_same_verdict_as_principal_moments(reading):
    bodies = [link.body for link in lwr_dyn.load("lwr4plus", reading).chain.links]
    verdict = are_bodies(np.array([body_parameters(body) for body in bodies]))
    assert verdict.tolist() == [is_physical(body) for body in bodies]
    flat = Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.1]))
    heavy = Body(-1.0, np.zeros(3), np.diag([1.0, 1.0, 1.5]))
    assert not are_bodies(np.array([body_parameters(flat), body_parameters(heavy)])).any()
    assert not are_bodies(np.full(10, np.nan))
