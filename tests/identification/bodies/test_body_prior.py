"""Constraints on the consistent fit: they hold exactly, the table moves least, contradictions are named."""

import numpy as np
import pytest
from scipy.optimize import minimize

from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.identification.bodies.body_prior import ConstraintError, body_prior, constrained_prior, constraints_of
from lwr_dyn.identification.bodies.consistent import consistent_fit
from lwr_dyn.identification.regression.information import information_of
from tests.identification.plants import Plant, perturbed_plant, random_motion, rms, simulated_samples


@pytest.fixture(scope="module")
def prior(lwr, columns):
    return body_prior(columns, columns.own(lwr))


def said_of(lwr, plant, rng, seconds=10.0):
    """What a log of a plant says."""
    return information_of(simulated_samples(plant, random_motion(lwr, seconds, rng), 0.1, rng, 0.05), plant.columns)


@pytest.fixture(scope="module")
def known(lwr, columns):
    rng = np.random.default_rng(4)
    plant = perturbed_plant(columns, lwr, rng)
    return plant, said_of(lwr, plant, rng, 5.0)


def test_a_parameter_that_moves_by_its_unit_alone_is_half_a_distance_away(prior):
    share = 1e-3
    away = [prior.distance(prior.table + share * step, 1.0) for step in np.diag(prior.units)]
    assert away == pytest.approx([0.5 * share**2] * prior.table.size, rel=0.01)


TRUE_ONES = (
    ["total mass = 16"],
    ["m_4 = 2.5", "mx_4 - 0.01 m_4 = 0", "armature_3 = 0.2"],
    ["m_2 = 2", "mz_2 = 0.2", "Ixx_2 = 0.021"],  # z^2 m is 0.02: a thin body
    ["m_2 = 2", "m_2 = 2", "coulomb_1 = 10"],
    ["armature_2 = 0", "armature_7 = 0", "m_1 = 3"],  # direct drives
)


@pytest.mark.slow
@pytest.mark.parametrize("texts", TRUE_ONES)
def test_they_hold_and_every_link_is_a_body(known, lwr, columns, texts):
    constraints = constraints_of(texts, columns.names)
    fit = consistent_fit(known[1], columns.own(lwr), constraints=constraints)
    assert np.abs(constraints.matrix @ fit.parameters - constraints.values).max() < 1e-9
    assert np.abs(constraints.matrix @ fit.covariance @ constraints.matrix.T).max() < 1e-12
    assert (fit.physical.all(), fit.constraints) == (True, tuple(texts))


@pytest.mark.slow
def test_true_ones_help(known, lwr, columns):
    """The plant's own masses make the fit of what torques do not show better, and sure of it."""
    plant, information = known
    masses = constraints_of([f"m_{i} = {plant.parameters[10 * i - 10]:.12g}" for i in range(1, 8)], columns.names)
    fits = [consistent_fit(information, columns.own(lwr), constraints=c) for c in (None, masses)]
    free, held = (np.square((fit.parameters - plant.parameters) / fits[0].sigma).sum() for fit in fits)
    assert held < free - 3.0  # seven squares fewer, of 98
    assert fits[1].sigma[0] < 1e-6 < fits[0].sigma[0]
    loose = np.setdiff1d(np.arange(columns.count), np.arange(0, columns.bodies, 10))
    gaps = (fits[1].parameters - plant.parameters)[loose] / fits[1].sigma[loose]
    assert 0.8 < rms(gaps) < 1.2


@pytest.mark.slow
def test_what_is_known_of_friction_and_absent_rotors_leaves_the_scales_alone(lwr, columns):
    """The evidence is that of the log given what is known."""
    rng = np.random.default_rng(1)
    plant = perturbed_plant(columns, lwr, rng)
    true = plant.parameters.copy()
    true[columns.rotor_indices] = 0.0
    known = constraints_of([f"armature_{i} = 0" for i in range(1, 8)] + [f"offset_1 = {true[73]:.12g}"], columns.names)
    fit = consistent_fit(said_of(lwr, Plant(columns, true), rng), columns.own(lwr), constraints=known)
    free = consistent_fit(said_of(lwr, plant, rng), columns.own(lwr))
    for kind in ("shape", "tensor"):
        assert 0.4 < getattr(fit.scales, kind) / getattr(free.scales, kind) < 2.5
    assert fit.parameters[columns.rotor_indices] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.slow
def test_bodies_that_are_known_say_nothing_of_the_scales(known, lwr, columns):
    """Three links given whole, as the table has them: the scales are what the other four say."""
    links, table = columns.own(lwr), known[0].parameters.copy()
    table[:30] = links[:30]
    information = said_of(lwr, Plant(columns, table), np.random.default_rng(0))
    same = constraints_of([f"{columns.names[k]} = {links[k]:.17g}" for k in range(30)], columns.names)
    free, held = (consistent_fit(information, links, constraints=c) for c in (None, same))
    assert free.scales.shape <= held.scales.shape  # it sees three links that have not moved


def test_the_table_moves_least(prior, columns):
    """Against a general solver from the same start."""
    constraints = constraints_of(["m_1 + m_2 = 4", "Izz_1 - 0.5 Iyy_1 = 0.01"], columns.names)
    moved = constrained_prior(prior, constraints).table
    nearest = prior.distance(moved, 1.0)
    free = constraints.free(prior.units)
    assert np.abs(free.T @ prior.derivatives(moved, 1.0)[0]).max() < 1e-6
    found = minimize(lambda z: min(prior.distance(moved + free[:, :20] @ z, 1.0), 1e6), np.zeros(20), method="BFGS")
    assert found.fun == pytest.approx(nearest, abs=1e-6)
    assert nearest > 0.1


THIN = ["m_2 = 2", "mz_2 = 0.2", "Ixx_2 = 0.02"]
CONTRADICTIONS = (
    (["Izz_7 = -0.001"], []), (["total mass = 0"], []), (["armature_2 = -0.1"], ["m_2 = 1"]),
    (["Ixx_7 = 0.001", "Iyy_7 = 0.001", "Izz_7 = 0.003"], ["m_3 = 2"]), (["m_1 = 2", "m_1 = 3"], ["m_5 = 1"]),
    (["total mass = 10", "m_2 = 4", "m_3 = 5", "m_4 = 2"], ["m_1 = 3"]), (THIN, ["m_1 = 3"]),
)  # fmt: skip
"""What contradicts itself, each needed for it, and what stands beside it."""


@pytest.mark.parametrize(("named", "beside"), CONTRADICTIONS)
def test_contradictions_are_named_and_nothing_else(prior, columns, named, beside):
    texts = [*named[:1], *beside, *named[1:]]
    with pytest.raises(ConstraintError, match="values that bodies of positive mass can have") as caught:
        constrained_prior(prior, constraints_of(texts, columns.names))
    assert (list(caught.value.names), caught.value.exit_code) == (named, 2)
    for left in named if len(named) > 1 else ():
        constrained_prior(prior, constraints_of([text for text in named if text != left], columns.names))


NO_EQUATIONS = (
    "m_1, m_1 = two, = 3, m_1 + = 3, 0 m_1 = 3, m_1 = 1_0, total mass, m_1 = nan, 2-m_1=3, 1e m_1=2, 2.5.m_1=1, "
    "m_1 m_2 = 6, m_1m_2 = 6, * m_1 = 3, 1e999 m_1 = 1"
)


def test_equations_are_read_and_other_texts_and_names_refused(columns):
    row = constraints_of(["2e-1 * m_1 + mx_1 - Iyy_7 = -1e3"], columns.names)
    assert row.values.tolist() == [-1000.0]
    assert {k: row.matrix[0, k] for k in np.flatnonzero(row.matrix)} == {0: 0.2, 1: 1.0, 67: -1.0}
    for text in NO_EQUATIONS.split(", "):
        with pytest.raises(OptionError, match=r"constraint: '.*'; allowed: an equation such as 'total mass = 15.8'"):
            constraints_of([text], columns.names)
    with pytest.raises(UnknownNameError, match="no parameter named 'm_8'") as wrong:
        constraints_of(["m_8 = 3"], columns.names)
    assert "m_7" in wrong.value.known
    assert len(wrong.value.known) <= 8 < len(columns.names)


def test_a_body_that_cannot_be_is_raised_to_the_nearest_thin_one_and_what_lacks_is_guessed(lwr, columns):
    table = columns.own(lwr).copy()
    thin, absent, first, second = slice(20, 30), slice(30, 40), columns.of_joint(0), columns.of_joint(1)
    table[thin] = [2.0, np.nan, 0, 0, 0.02, np.nan, 0, 0.02, 0, 0.05]  # Izz exceeds Ixx + Iyy: P has -0.005 in z
    table[absent], table[columns.rotor_indices[4]] = 0.0, 0.0
    table[first.start + 1 : first.stop] = 10.0, 4.0, 0.2  # Coulomb, viscous, offset
    found = body_prior(columns, table)
    assert found.lifted == (3, 4)
    m, *_, Ixx, _, _, Iyy, _, Izz = found.table[thin]
    # P is diag(.025, .025, -.005, 2); in units of 0.1 m the largest is 2.5, so z rises to 2.5e-3 x 0.01
    assert (m, Ixx, Iyy, Izz) == pytest.approx((2.0, 0.025 + 2.5e-5, 0.025 + 2.5e-5, 0.05), rel=1e-9)
    lightest = 0.01 * table[: columns.bodies : 10].sum()
    assert found.table[absent][0] == pytest.approx(lightest)
    assert found.table[absent][[4, 7, 9]] == pytest.approx([lightest * 0.01 / 5.0] * 3)
    outward = found.table[: columns.bodies].reshape(7, 10)[:, [4, 7, 9]].mean(axis=1)[::-1].cumsum()[::-1]
    guess = 0.1 * np.sqrt(outward[4] * outward.mean())
    assert found.table[columns.rotor_indices[4]] == pytest.approx(guess)
    assert found.unknown_rotors.tolist() == [j == 4 for j in range(7)]
    assert found.spread[first.start + 1 : first.stop].tolist() == [3.0, 1.2, 1.0]  # 30 %, 30 %, 10 % of Coulomb's
    assert found.spread[second.start + 1 : second.stop].tolist() == [10.0] * 3  # no friction in the table
