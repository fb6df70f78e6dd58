"""Kinds of difference: the shape is the log-det metric, and drawn bodies have the covariances that are said."""

import numpy as np
import pytest

from lwr_dyn.identification.bodies.body_prior import body_prior
from lwr_dyn.identification.bodies.link_spreads import Scales, covariances, link_spreads
from lwr_dyn.model.inertial_parameters import inertial_parameters, pseudo_inertias


@pytest.fixture(scope="module")
def links(lwr, columns):
    return columns.own(lwr)[: columns.bodies].reshape(-1, 10)


def test_a_shape_is_the_inverse_hessian_of_the_log_det_distance(lwr, columns, links):
    prior = body_prior(columns, columns.own(lwr))
    curvature = prior.derivatives(prior.table, 1.0)[1]
    for i, spread in enumerate(link_spreads(links)):
        ten = slice(10 * i, 10 * i + 10)
        unit = 1.0 / prior.units[ten]
        inverse = np.linalg.inv(curvature[ten, ten] / np.outer(unit, unit)) / np.outer(unit, unit)
        assert (spread[0] - inverse) * np.outer(unit, unit) == pytest.approx(0.0, abs=1e-8)


def test_moved_centres_and_masses_have_the_covariances_that_are_said(links):
    rng, (metres, share) = np.random.default_rng(0), (1e-4, 1e-3)
    P = pseudo_inertias(links[3])
    T = np.tile(np.eye(4), (4000, 1, 1))
    T[:, :3, 3] = rng.normal(0.0, metres, (4000, 3))
    moved = inertial_parameters(T @ P @ np.swapaxes(T, 1, 2))
    spread = covariances(link_spreads(links[3:4]), Scales(0.0, metres, 0.0, 0.0, 0.0))[0]
    size = np.sqrt(np.diag(spread))
    assert size[0] == 0.0
    assert moved.std(axis=0)[1:] == pytest.approx(size[1:], rel=0.05)
    heavier = link_spreads(links[3:4])[0, 3] * share**2
    assert np.sqrt(heavier[0, 0]) == pytest.approx(share * links[3][0])
    assert np.linalg.matrix_rank(heavier, tol=1e-12) == 1
    half = covariances(link_spreads(links), Scales.of_deviation(0.2), np.full((len(links), 4), 0.25))
    assert (half[:, 0, 0] < covariances(link_spreads(links), Scales.of_deviation(0.2))[:, 0, 0]).all()
