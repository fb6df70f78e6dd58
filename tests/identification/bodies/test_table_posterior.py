"""What log and table say together: the same as dense Bayes by another road, and a plus-minus that covers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.stats import multivariate_normal

from lwr_dyn.identification.bodies.body_prior import body_prior, constraints_of
from lwr_dyn.identification.bodies.link_spreads import Scales, covariances, link_spreads
from lwr_dyn.identification.bodies.table_posterior import USUAL, TablePosterior, logs_of, scales_of
from lwr_dyn.identification.regression.information import information_of
from tests.identification.cover_study import cover_cell, rms
from tests.identification.plants import perturbed_plant, random_motion, simulated_samples


@pytest.fixture(scope="module")
def seen(lwr, columns):
    rng = np.random.default_rng(3)
    plant = perturbed_plant(columns, lwr, rng)
    return information_of(simulated_samples(plant, random_motion(lwr, 5.0, rng), 0.3, rng, 0.05), columns)


@pytest.fixture
def posterior(seen, lwr, columns):
    return TablePosterior(seen, body_prior(columns, columns.own(lwr)))


def dense_covariance(prior, scales):
    """C (p, p), written out: links, then each joint's rotor and friction."""
    links = covariances(link_spreads(prior.table[: prior.bodies].reshape(-1, 10)), scales)
    rest = np.square(prior.spread)
    rest[prior.rotors] = np.square(scales.rotor * prior.table[prior.rotors])
    return block_diag(*links, np.diag(rest[prior.bodies :]))


def test_mean_and_covariance_are_those_of_the_normal_equations(seen, posterior):
    prior, G = posterior.prior, seen.base.grouping
    table_precision = np.linalg.inv(dense_covariance(prior, USUAL))
    covariance = np.linalg.inv(G.T @ seen.precision @ G + table_precision)
    mean = covariance @ (G.T @ seen.precision @ seen.values + table_precision @ prior.table)
    belief = posterior.given(logs_of(USUAL))
    sigma = np.sqrt(np.diag(covariance))
    assert np.abs((belief.mean - mean) / sigma).max() < 1e-4
    assert np.abs((belief.covariance - covariance) / np.outer(sigma, sigma)).max() < 1e-4
    assert posterior.table_sigma(logs_of(USUAL)) == pytest.approx(np.sqrt(np.diag(dense_covariance(prior, USUAL))))


def test_evidence_is_the_density_of_the_base_parameters(seen, posterior):
    """Up to a constant, and beside that of the scales about the usual ones."""
    prior, G = posterior.prior, seen.base.grouping
    found = []
    for scales in (USUAL, replace(USUAL, centre=0.03), replace(USUAL, shape=0.2, mass=0.2)):
        S = seen.covariance + G @ dense_covariance(prior, scales) @ G.T
        unit = 1.0 / np.sqrt(np.diag(S))
        density = (
            multivariate_normal(np.zeros(len(S)), S * np.outer(unit, unit)).logpdf(
                unit * (seen.values - G @ prior.table)
            )
            + np.log(unit).sum()
        )
        off = (logs_of(scales) - logs_of(USUAL)) / np.array([1.0, 1.0, 1.0, 0.4, 1.5])
        found.append(density - 0.5 * off @ off - posterior.evidence(logs_of(scales)))
    assert np.ptp(found) < 1e-3


def test_the_likeliest_scales_are_a_maximum(posterior):
    logs = posterior.likeliest()
    best = posterior.evidence(logs)
    for k in posterior.varied:
        for step in (-0.5, 0.5):
            there = logs.copy()
            there[k] += step
            assert posterior.evidence(there) < best + 0.05
    mixed, alone = posterior.mixed(logs), posterior.given(logs)
    assert np.trace(mixed.covariance) > np.trace(alone.covariance)
    assert scales_of(logs).mass == pytest.approx(np.exp(logs[3]))


def test_what_is_known_is_met_and_no_evidence(seen, lwr, columns):
    """A value that was copied from the table leaves the evidence of other scales as it is."""
    prior = body_prior(columns, columns.own(lwr))
    at = columns.names.index("m_1")  # no torque of an arm on a floor shows it
    known = constraints_of([f"m_1 = {prior.table[at]:.17g}"], columns.names)
    free, held = TablePosterior(seen, prior), TablePosterior(seen, prior, known)
    wide, narrow = (logs_of(Scales(0.08, 0.01, 0.15, mass, 0.3)) for mass in (0.3, 0.05))
    gains = [one.evidence(wide) - one.evidence(narrow) for one in (free, held)]
    assert gains[1] == pytest.approx(gains[0], abs=1e-3)
    assert held.given(wide).mean[at] == pytest.approx(prior.table[at], rel=1e-6)
    assert held.given(wide).covariance[at, at] < 1e-6 * free.given(wide).covariance[at, at]


@pytest.mark.slow
@pytest.mark.parametrize(("arm", "truth", "noise"), [("lwr4plus", "rotors", "coloured"), ("wam7", "natural", "white")])
def test_a_plus_minus_covers(arm, truth, noise):
    """A share of the study in `scripts/soak.py fits_cover`: seeds and arms as they were fixed."""
    cell = cover_cell(arm, truth, noise, range(3))
    assert cell.inside >= 0.97
    assert 0.6 < rms(cell.misses) < 1.3
    assert cell.refused == 0
