"""What log and table say together: the same as dense Bayes by another road, and a plus-minus that covers."""

from dataclasses import astuple, replace

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.special import softmax
from scipy.stats import multivariate_normal, norm, qmc

from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.identification.bodies import table_posterior
from lwr_dyn.identification.bodies.body_prior import body_prior, constraints_of
from lwr_dyn.identification.bodies.link_spreads import Scales, covariances, link_spreads
from lwr_dyn.identification.bodies.table_posterior import USUAL, TablePosterior, logs_of, scales_of
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.model.chain import Body
from lwr_dyn.model.inertial_parameters import inertial_parameters, pseudo_inertias
from tests.identification.cover_study import cover_cell
from tests.identification.plants import perturbed_plant, random_motion, rms, simulated_samples


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
        normal = multivariate_normal(np.zeros(len(S)), S * np.outer(unit, unit))
        density = normal.logpdf(unit * (seen.values - G @ prior.table)) + np.log(unit).sum()
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
    assert scales_of(logs).mass == pytest.approx(np.exp(logs[3]))


SECOND = ((1, 1, -1), (1, -1, 1), (-1, 1, 1), (-1, -1, -1))
"""Of a second difference: factor, steps along both."""


def test_the_mixture_counts_scales_about_the_likeliest_by_their_evidence(posterior):
    """As far about them as the evidence is curved, by differences over 0.3; a fifth wider; 64 points."""
    logs = logs_of(replace(USUAL, shape=0.12))
    ways = 0.3 * np.eye(5)
    curved = np.array([
        [sum(c * posterior.evidence(logs + a * u + b * v) for c, a, b in SECOND) / 0.36 for v in ways] for u in ways
    ])  # fmt: skip
    at = posterior.evidence(logs)
    curved[np.diag_indices(5)] = [(2 * at - posterior.evidence(logs + u) - posterior.evidence(logs - u)) / 0.09
                                  for u in ways]  # fmt: skip
    values, axes = np.linalg.eigh(curved)
    points = np.vstack([np.zeros(5), norm.ppf(qmc.Sobol(5, seed=1).random(64)[:63])])
    beliefs = [posterior.given(logs + axes @ (p * np.sqrt(1.2 / np.maximum(values, 0.5)))) for p in points]
    weights = softmax([b.evidence + 0.5 * p @ p for b, p in zip(beliefs, points, strict=True)])
    means, found = np.array([b.mean for b in beliefs]), posterior.mixed(logs)
    spread = np.cov(means.T, aweights=weights, ddof=0)
    unit = posterior.table_sigma(logs)
    assert found.mean / unit == pytest.approx(weights @ means / unit)
    wanted = np.average([b.covariance for b in beliefs], axis=0, weights=weights) + spread
    assert found.covariance / np.outer(unit, unit) == pytest.approx(wanted / np.outer(unit, unit))
    assert found.evidence == posterior.evidence(logs)


def test_factors_are_those_of_students_t(seen, lwr, columns, monkeypatch):
    """(5 + expected square of a kind's part of a link's difference, in units of its scale) / (5 + its dimension)."""
    once, twice = (TablePosterior(seen, body_prior(columns, columns.own(lwr))) for _ in range(2))
    monkeypatch.setattr(table_posterior, "ROUNDS", 0)
    logs = once.likeliest()
    monkeypatch.setattr(table_posterior, "ROUNDS", 1)
    twice.likeliest()
    belief, prior, scales = once.given(logs), once.prior, scales_of(logs)
    spreads = link_spreads(prior.table[:70].reshape(7, 10))
    whole, away = covariances(spreads, scales), belief.mean - prior.table
    for i in range(7):
        ten = slice(10 * i, 10 * i + 10)
        squares = np.outer(away[ten], away[ten]) + belief.covariance[ten, ten]
        unit = np.sqrt(np.outer(np.diag(whole[i]), np.diag(whole[i])))
        for k, (scale, dimension) in enumerate(zip(astuple(scales)[:4], (10, 3, 6, 1), strict=True)):
            own = scale**2 * spreads[i, k]
            part = own @ (np.linalg.inv(whole[i] / unit) / unit)
            expected = part @ squares @ part.T + own - part @ own
            square = np.trace(np.linalg.pinv(own / unit, 1e-8, hermitian=True) @ (expected / unit))
            assert twice.local[i, k] == pytest.approx(np.clip((5 + square) / (5 + dimension), 0.1, 100.0), rel=1e-3)
    table, rotors = prior.table[prior.rotors], once.rotors
    off = np.log(rotors / table) ** 2 + np.diag(belief.covariance)[prior.rotors] / rotors**2
    assert twice.local_rotors == pytest.approx((5 + off / scales.rotor**2) / 6)


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


@pytest.fixture(scope="module")
def links(lwr, columns):
    return columns.own(lwr)[: columns.bodies].reshape(-1, 10)


def test_a_shape_is_the_inverse_hessian_of_the_log_det_distance(lwr, columns, links):
    prior = body_prior(columns, columns.own(lwr))
    curvature = prior.derivatives(prior.table, 1.0)[1]
    for i, spread in enumerate(link_spreads(links)):
        ten = slice(10 * i, 10 * i + 10)
        unit = np.outer(1.0 / prior.units[ten], 1.0 / prior.units[ten])
        assert spread[0] * unit == pytest.approx(np.linalg.inv(curvature[ten, ten] / unit), abs=1e-8)


def test_moved_centres_and_masses_have_the_covariances_that_are_said(links):
    """Of drawn bodies; to second order a centre moved by s adds m s^2, a mass moves all ten alike."""
    m, c, metres = links[3][0], links[3][1:4] / links[3][0], 1e-4
    P, T = pseudo_inertias(links[3]), np.tile(np.eye(4), (4000, 1, 1))
    T[:, :3, 3] = np.random.default_rng(0).normal(0.0, metres, (len(T), 3))
    moved = inertial_parameters(T @ P @ np.swapaxes(T, 1, 2))
    spreads = link_spreads(links[3:4])
    size = np.sqrt(np.diag(covariances(spreads, Scales(0.0, metres, 0.0, 0.0, 0.0))[0]))
    assert size[0] == 0.0
    assert moved.std(axis=0)[1:] == pytest.approx(size[1:], rel=0.05)
    second = spreads * (np.arange(6) == 4)[:, None, None]
    added = np.diag(covariances(second, Scales(0.0, 0.1, 0.0, 0.0, 0.0))[0])
    assert added == pytest.approx((m * 0.01) ** 2 * np.array([0, 0, 0, 0, 2, 0.5, 0.5, 2, 0.5, 2]))
    point = body_parameters(Body(m, c, np.zeros((3, 3))))
    assert spreads[0, 3] == pytest.approx(np.outer(point, point), abs=1e-12)


def test_a_tensor_has_its_own_moments_all_of_them_together_and_turned_axes(links):
    """By one direction at a time: symmetric matrices of length 1 between the roots of the second moments."""
    P, axes = pseudo_inertias(links[4]), -np.cross(np.eye(3)[:, None], np.eye(3))
    S = P[:3, :3] - np.outer(P[:3, 3], P[:3, 3]) / P[3, 3]

    def read(second):
        return inertial_parameters(np.pad(second, (0, 1)))

    def drawn(second):
        pairs = [np.outer(a, b) + np.outer(b, a) for i, a in enumerate(np.eye(3)) for b in np.eye(3)[: i + 1]]
        root = np.linalg.cholesky(second)
        ways = np.array([read(root @ (pair / np.linalg.norm(pair)) @ root.T) for pair in pairs])
        return ways.T @ ways

    ways = np.array([read(S), *(read(W @ S + S @ W.T) for W in axes)])
    found = link_spreads(links[4:5])[0]
    assert found[2] == pytest.approx(drawn(S) + ways.T @ ways, abs=1e-15)
    assert found[5] == pytest.approx(drawn(sum(W @ S @ W.T for W in axes)), abs=1e-15)


def test_a_share_for_all_kinds_and_factors_of_links(links):
    whole = Scales.of_deviation(0.2)
    assert whole == Scales(0.2, 0.05 * 0.2, 0.2, 0.1, 0.2)
    first = link_spreads(links) * (np.arange(6) < 4)[:, None, None]  # without the second order
    quarter = covariances(first, Scales(0.1, 0.005, 0.1, 0.05, 0.2))
    assert covariances(first, whole, np.full((len(links), 4), 0.25)) == pytest.approx(quarter)
