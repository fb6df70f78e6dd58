"""Which base parameters bodies cannot have below 0, and mass matrices that no bodies give."""

import numpy as np
import pytest
from scipy.optimize import minimize

import lwr_dyn
from lwr_dyn.dynamics.regressor import INERTIAL, body_parameters
from lwr_dyn.identification.bodies import possible_bodies
from lwr_dyn.identification.regression.least_squares import Estimate
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model import inertial_parameters
from lwr_dyn.model.chain import Body, is_physical


def estimate_of(values, error):
    return Estimate(np.array(values), error**2 * np.eye(len(values)), np.zeros(10), 1000)


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "form"), [("lwr4plus", "directions"), ("wam7", "symmetric")])
def test_never_negative_is_what_point_masses_anywhere_say(robot, form):
    """Any body is a sum of point masses: a parameter is bounded if no point mass on any link makes it negative."""
    arm = lwr_dyn.load(robot)
    columns = TorqueColumns(arm.chain, form, [0.1] * arm.n if form == "symmetric" else None)
    base = columns.base()
    words = ("coulomb", "viscous", "offset", "stribeck")
    friction = [k for k, name in enumerate(base.names) if name.startswith(words)]
    rotors = base.grouping[:, columns.rotor_indices]
    for row, rotor, bounded in zip(base.grouping, rotors, possible_bodies.never_negative(columns), strict=True):
        links = row[: len(INERTIAL) * arm.n].reshape(arm.n, len(INERTIAL))
        least = min(least_of_a_point_mass(factors) for factors in links)
        assert bounded == (least > -1e-9 and rotor.min() >= 0.0 and not row[friction].any())
    assert possible_bodies.never_negative(columns)[base.statements().index("Izz_7")]


def least_of_a_point_mass(factors):
    """Smallest sum of factors and parameters of 1 kg at one place, looked for from random places."""
    if not factors.any():
        return 0.0

    def value(place):
        return factors @ body_parameters(Body(1.0, place, np.zeros((3, 3))))

    rng = np.random.default_rng(0)
    places = rng.normal(size=(40, 3)) * 10.0 ** rng.uniform(-2, 1, (40, 1))
    start = min(places, key=value)
    if value(start) < -1e-9:
        return value(start)
    return minimize(value, start, method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-12}).fun


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["lwr4plus", "wam7"])
def test_the_columns_give_the_mass_matrix_and_true_values_are_possible(robot):
    arm = lwr_dyn.load(robot)
    columns, q = TorqueColumns(arm.chain, "symmetric"), np.random.default_rng(1).uniform(-2, 2, (5, arm.n))
    values = columns.base().of(columns.own(arm))
    B = possible_bodies.mass_matrix_columns(columns, q) @ values
    assert np.abs(B - lwr_dyn.dynamics_of(arm).mass_matrix(q)).max() < 1e-12 * np.abs(B).max()
    assert not possible_bodies.judge_bodies(arm, columns, estimate_of(values, 1e-6)).impossible


@pytest.fixture(scope="module")
def lwr_with():
    """Verdicts on base values of the LWR with one of them changed, by their standard error."""
    arm = lwr_dyn.load("lwr4plus")
    columns = TorqueColumns(arm.chain, "directions")

    def judged(name, value, *errors):
        values = columns.base().of(columns.own(arm))
        values[columns.base().statements().index(name)] = value
        verdicts = [possible_bodies.judge_bodies(arm, columns, estimate_of(values, error)) for error in errors]
        return columns, values, verdicts

    return judged


def test_a_negative_moment_is_named_with_its_link_and_whether_noise_explains_it(lwr_with):
    _, _, verdicts = lwr_with("Izz_7", -0.00088, 0.001, 0.0001)
    said = (
        "Izz_7 = -0.00088 +- 0.003 (99.73 %), never below 0 for any bodies (link 7); noise can",
        "noise cannot explain it: look at geometry",
    )
    for verdict, explained, words in zip(verdicts, (True, False), said, strict=True):
        (found,) = verdict.negative
        assert (found.parameter, found.links, found.value) == ("Izz_7", (7,), -0.00088)
        assert found.noise_can_explain == explained
        assert (verdict.impossible, verdict.mass_matrix) == (True, None)
        assert words in possible_bodies.body_lines(verdict)[0]


def test_a_mass_matrix_that_is_not_positive_definite_is_named_with_its_configuration(lwr_with):
    """A product of inertia above all moments."""
    columns, values, (verdict, unsure) = lwr_with("Ixy_4", 0.7, 1e-4, 10.0)
    found = verdict.mass_matrix
    B = possible_bodies.mass_matrix_columns(columns, found.q[None])[0] @ values
    lowest, motion = np.linalg.eigh(B)
    assert found.lowest == pytest.approx(lowest[0])
    assert found.lowest < 0 < found.share < 1  # at some configurations only
    assert found.joint == np.argmax(np.abs(motion[:, 0])) + 1
    assert (verdict.negative, found.noise_can_explain, unsure.mass_matrix.noise_can_explain) == ((), False, True)
    assert "B(q) is not positive definite at" in possible_bodies.body_lines(verdict)[0]


def test_the_pseudo_inertia_is_the_sum_of_second_moments_and_the_dual_of_its_weights():
    rng = np.random.default_rng(3)
    places, masses, factors = rng.normal(size=(6, 3)), rng.uniform(1, 2, 6), rng.normal(size=10)
    points = np.column_stack([places, np.ones(6)])
    total = sum(body_parameters(Body(m, place, np.zeros((3, 3)))) for m, place in zip(masses, places, strict=True))
    P = inertial_parameters.pseudo_inertias(total)
    assert np.abs(P - np.einsum("k,ki,kj->ij", masses, points, points)).max() < 1e-12
    assert np.abs(inertial_parameters.inertial_parameters(P) - total).max() < 1e-12
    weights = inertial_parameters.pseudo_inertia_weights(factors)
    assert (weights == weights.T).all()
    assert np.trace(weights @ P) == pytest.approx(total @ factors, abs=1e-12)


@pytest.mark.parametrize("reading", ["printed", "computed", "physical"])
def test_the_same_verdict_as_principal_moments(reading):
    bodies = [link.body for link in lwr_dyn.load("lwr4plus", reading).chain.links]
    bodies += [Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.1])), Body(-1.0, np.zeros(3), np.diag([1.0, 1.0, 1.5]))]
    verdict = possible_bodies.are_bodies(np.array([body_parameters(body) for body in bodies]))
    assert verdict.tolist() == [*map(is_physical, bodies[:-2]), False, False]
    assert not possible_bodies.are_bodies(np.full(10, np.nan))
