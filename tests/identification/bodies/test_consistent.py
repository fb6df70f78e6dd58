"""The consistent fit: the optimum that a cone solver finds, bodies only, nearer to the truth than least squares."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.identification.bodies.body_prior import body_prior
from lwr_dyn.identification.bodies.consistent import LEVEL, Price, Target, consistent_fit, nearest_bodies
from lwr_dyn.identification.bodies.possible_bodies import are_bodies
from lwr_dyn.identification.bodies.table_posterior import USUAL
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.inertial_parameters import pseudo_inertias
from tests.identification.consistency_study import cases, summary
from tests.identification.cover_truths import cover_arm
from tests.identification.plants import perturbed_plant, random_motion, simulated_samples


def informed(lwr, columns, seconds=5.0, noise=0.1, seed=0):
    rng = np.random.default_rng(seed)
    plant = perturbed_plant(columns, lwr, rng)
    return plant, information_of(simulated_samples(plant, random_motion(lwr, seconds, rng), noise, rng, 0.05), columns)


@pytest.fixture(scope="module")
def known(lwr, columns):
    return informed(lwr, columns)


def test_the_distance_is_that_of_log_det_and_its_derivatives_those_of_differences(lwr, columns):
    prior = body_prior(columns, columns.own(lwr))
    at = perturbed_plant(columns, lwr, np.random.default_rng(2)).parameters
    slope, curvature = prior.derivatives(at, 7.0)
    links, table = (pseudo_inertias(x[: columns.bodies].reshape(-1, 10)) for x in (at, prior.table))
    ratio, rotors = np.linalg.solve(table, links), at[prior.rotors] / prior.table[prior.rotors]
    bodies = np.trace(ratio, axis1=1, axis2=2) - np.linalg.slogdet(ratio)[1] - 4.0
    friction = ((at - prior.table) / prior.spread)[prior.friction]
    wanted = 7.0 * (bodies.sum() + (rotors - np.log(rotors) - 1.0).sum()) + 0.5 * friction @ friction
    assert prior.distance(at, 7.0) == pytest.approx(wanted)
    assert np.abs(prior.derivatives(prior.table, 7.0)[0]).max() < 1e-9
    assert prior.distance(prior.table, 7.0) == pytest.approx(0.0, abs=1e-10)
    for k, step in enumerate(np.diag(1e-5 * prior.units)):
        ahead, behind = (prior.derivatives(at + s, 7.0)[0] for s in (step, -step))
        rise = prior.distance(at + step, 7.0) - prior.distance(at - step, 7.0)
        assert rise / (2 * step[k]) == pytest.approx(slope[k], rel=1e-5, abs=1e-5 / prior.units[k])
        column = (ahead - behind) / (2 * step[k])
        assert np.abs((column - curvature[:, k]) * prior.units * prior.units[k]).max() < 1e-5
    assert prior.distance(at - 2.0 * at[0] * np.eye(columns.count)[0], 7.0) == np.inf  # a mass below 0


def test_under_constraints_no_free_direction_leads_further_down_and_no_other_is_taken(known, lwr, columns):
    _, information = known
    prior = body_prior(columns, columns.own(lwr))
    target, free = Target(information.values, information.precision, information.base.grouping), np.diag(prior.units)
    found = nearest_bodies(target, prior, 1e6, prior.table, free[:, ::2])
    slope, curvature = prior.derivatives(found.parameters, 1e6)
    down = prior.units * (slope + target.slope(found.parameters))
    assert np.abs(down[::2]).max() < 1e-6 * np.abs(down).max()
    moved = found.parameters != prior.table
    assert moved[::2].any()
    assert not moved[1::2].any()
    inverse = np.linalg.inv((curvature + target.curvature)[::2, ::2])
    np.testing.assert_allclose(found.covariance[::2, ::2], inverse, rtol=1e-3, atol=1e-6 * np.abs(inverse).max())
    assert not found.covariance[1::2].any()


@pytest.mark.slow
def test_the_optimum_is_that_of_a_cone_solver(known, lwr, columns):
    """Clarabel by cvxpy, which knows nothing of Newton's method here."""
    import cvxpy as cp

    _, information = known
    table, weight, links = columns.own(lwr), 25.0, columns.n
    prior = body_prior(columns, table)
    target = Target(information.values, information.precision, information.base.grouping)
    found = nearest_bodies(target, prior, weight, prior.table)
    roots = np.linalg.cholesky(pseudo_inertias(prior.table[: columns.bodies].reshape(-1, 10)))
    x = cp.Variable(columns.count)  # in units of the prior
    pi = cp.multiply(prior.units, x)
    cost = 0.5 * cp.sum_squares(information.factor @ (information.base.grouping @ pi - information.values))
    rotors = cp.multiply(1.0 / table[prior.rotors], pi[prior.rotors])
    cost += weight * cp.sum(rotors - cp.log(rotors))
    cost += 0.5 * cp.sum_squares(cp.multiply(1.0 / prior.spread[prior.friction], (pi - table)[prior.friction]))
    units = pseudo_inertias(np.eye(10))
    for i in range(links):
        inverse = np.linalg.inv(roots[i])
        scaled = sum(pi[10 * i + k] * (inverse @ units[k] @ inverse.T) for k in range(10))
        cost += weight * (cp.trace(scaled) - cp.log_det(scaled))
    cp.Problem(cp.Minimize(cost)).solve(solver=cp.CLARABEL)
    gap = np.abs(pi.value - found.parameters) / np.sqrt(np.diag(found.covariance))
    assert gap.max() < 1e-3
    torque = lambda a, b: np.sqrt(np.mean(np.square((a - b) @ information.factor.T)))  # noqa: E731
    of = information.base.of
    assert torque(of(pi.value), of(found.parameters)) < 1e-4
    assert torque(information.values, of(found.parameters)) > 0.1


@pytest.mark.slow
def test_constraints_hold_and_the_price_is_what_is_said(known, lwr, columns):
    _, information = known
    fit = consistent_fit(information, columns.own(lwr))
    base = information.base.of(fit.parameters)
    assert fit.physical.all()
    left = information.normal.residual_rms
    squares = left(base) ** 2 - left(information.values) ** 2
    assert fit.price.chi2 == pytest.approx((squares * information.equations / information.noise**2).sum(), rel=1e-6)
    # the residuals of least squares are not quite orthogonal joint by joint, only in the weighted sum
    weights = information.equations / information.noise**2
    assert weights @ fit.price.rms**2 == pytest.approx(weights @ squares, rel=1e-4)
    assert fit.chosen
    pulls = (base - information.values) / information.sigma
    assert abs(pulls[fit.price.parameter]) == pytest.approx(fit.price.pull) == np.abs(pulls).max()
    assert fit.price.probability > LEVEL
    assert not fit.price.refused


def test_bodies_of_another_arm_are_refused(known, columns):
    """A mass of link 7 that is 40 standard errors of a base parameter off; the truth itself is not refused.

    Chance: that of the largest pull (Bonferroni) or that of chi^2, the smaller one doubled.
    """
    plant, information = known
    other = plant.parameters.copy()
    other[columns.names.index("mx_7")] += 40.0 * information.sigma.min()
    of_joints, count = information.normal.matrices, information.equations
    for parameters, refused in ((plant.parameters, False), (other, True)):
        price, off = Price.of(information, parameters), information.base.of(parameters) - information.values
        pulls = np.abs(off) / information.sigma
        assert (price.parameter, price.pull) == (pulls.argmax(), pytest.approx(pulls.max()))
        assert price.chi2 == pytest.approx(off @ information.precision @ off)
        moved = [np.sqrt(off @ M @ off / k) for M, k in zip(of_joints, count, strict=True)]
        assert price.rms == pytest.approx(moved)
        chances = 2.0 * off.size * stats.norm.sf(pulls.max()), stats.chi2.sf(price.chi2, off.size)
        assert price.probability == pytest.approx(min(1.0, 2.0 * min(chances)))
        assert price.refused == (price.probability < 1e-3) == refused
    assert (price.pull > 5.0, "mx_7" in information.base.statements()[price.parameter]) == (True, True)


def test_a_log_that_says_nothing_leaves_the_table_and_the_usual_scales(lwr, columns):
    """No joint moves: all that is known is the table. The doubt of the scales makes the errors larger."""
    rng = np.random.default_rng(0)
    still = random_motion(lwr, 5.0, rng)
    still = replace(still, q=np.repeat(still.q[:1], len(still.q), 0), dq=0.0 * still.dq, ddq=0.0 * still.ddq)
    plant = perturbed_plant(columns, lwr, rng)
    fit = consistent_fit(information_of(simulated_samples(plant, still, 0.1, rng, 0.05), columns), columns.own(lwr))
    assert fit.scales.mass == pytest.approx(USUAL.mass)
    assert fit.left == pytest.approx(1.0)
    assert (np.abs(fit.parameters - columns.own(lwr)) < 0.02 * fit.sigma).all()
    assert (np.abs(fit.parameters - plant.parameters) < 5.0 * fit.sigma).all()


def test_rotors_off_by_the_square_of_a_gear_leave_the_bodies_their_weight(lwr, columns):
    """The reading `computed` has a hundredth of the rotors: bodies keep the weight they have with the right ones."""
    plant, information = informed(lwr, columns, 10.0, 0.05)
    table = columns.own(lwr)
    right = consistent_fit(information, table)
    table[columns.rotor_indices] /= 100.0
    slipped = consistent_fit(information, table)
    assert right.scales.rotor < 0.5 < 2.0 < slipped.scales.rotor
    assert 0.5 < slipped.scales.mass / right.scales.mass < 2.0
    assert (np.abs(slipped.parameters - plant.parameters) < 4.5 * slipped.sigma).all()
    assert slipped.sigma[0] < 2.0 * right.sigma[0]
    again = consistent_fit(information, table, like=slipped)
    assert (np.abs(again.parameters - slipped.parameters) < 0.5 * slipped.sigma).all()
    assert not again.chosen


@pytest.mark.slow
def test_a_table_without_bodies_is_thickened_and_said(known, lwr, columns):
    plant, information = known
    table = columns.own(lwr)
    table[60:70] = 0.0
    table[30:40] = np.nan
    table[29] = -0.5
    table[columns.rotor_indices[2]] = 0.0
    fit = consistent_fit(information, table)
    assert fit.lifted == (3, 4, 7)
    assert fit.physical.all()
    assert (fit.parameters[columns.rotor_indices] > 0.0).all()
    unknown = columns.rotor_indices[2]
    assert fit.parameters[unknown] == pytest.approx(plant.parameters[unknown], abs=4.0 * fit.sigma[unknown])
    assert 0.001 < fit.sigma[unknown] < 0.5
    thick = body_prior(columns, table).table
    assert thick[60] == pytest.approx(0.01 * np.nansum(np.maximum(table[0:70:10], 0.0)))
    assert are_bodies(fit.parameters[: columns.bodies].reshape(-1, 10)).all()


@pytest.mark.slow
def test_friction_far_from_a_small_one_in_the_table_is_believed():
    """The WAM's wrist has 0.05 N m in the table: an offset of 0.3 N m, six times that, is what the log says."""
    wam = lwr_dyn.load("wam7")
    columns = TorqueColumns(wam.chain)
    plant, information = informed(wam, columns, 10.0, 0.05)
    fit = consistent_fit(information, columns.own(wam))
    prior = body_prior(columns, columns.own(wam))
    assert prior.spread[prior.friction].min() >= 1.0
    wrist = columns.names.index("offset_7")
    assert fit.parameters[wrist] == pytest.approx(plant.parameters[wrist], abs=0.02)
    assert (np.abs(fit.parameters - plant.parameters) < 4.0 * fit.sigma).all()


@pytest.mark.slow
def test_short_logs_gain_and_every_link_is_a_body():
    """A share of the study in `scripts/soak.py`: 9 of its 60 plants."""
    found = cases(5.0, 0.5, range(9), series=10.0)
    median, worse, _ = summary(found)
    assert median > 2.0
    assert worse <= 0.1
    assert all(case.physical for case in found)


@pytest.mark.slow
def test_tables_and_deviations_that_cannot_be(known, lwr, columns):
    own, words = columns.own(lwr), r"deviation from the table: .*; allowed: a number above 0"
    for table, options, error, match in (
        *((own, {"deviation": x}, OptionError, words) for x in (0.0, -1.0, np.nan, np.inf)),
        (own[:70], {}, ShapeError, r"table: an array \(70,\); allowed: 98 numbers, one a column"),
        (np.append(own[:-1], np.inf), {}, ShapeError, "table: values that are not finite"),
    ):
        with pytest.raises(error, match=match):
            consistent_fit(known[1], table, **options)


@pytest.mark.slow
def test_a_log_without_noise_has_bodies():
    """A short move of all joints alike, simulated: between its directions there are more digits than a number has."""
    arm = cover_arm("iiwa14")
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), lwr_dyn.reference("move", arm))
    log = JointLog("run", tuple(range(1, 8)), run.t, run.q, run.tau_applied)
    found = identify_motion([log], arm)
    assert are_bodies(found.consistent.parameters[:70].reshape(7, 10)).all()
    assert found.contradiction
