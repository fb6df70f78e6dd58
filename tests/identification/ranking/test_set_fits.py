"""What is fitted beside a set is found again where it was put in."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.identification.ranking.filtered_log import FilteredLog
from lwr_dyn.identification.ranking.set_fits import Torques, fit_set, floor_of, joint_columns
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.model.transmission import Transmission

ARM = lwr_dyn.load("ur10")
ROTORS = np.array([5.0, 4.0, 2.0, 0.6, 0.5, 0.4])
GAINS = np.array([1.1, 0.9, 1.05, 0.95, 1.2, 0.8])
COULOMB, VISCOUS, OFFSET = 3.0, 2.0, 0.5
LOAD = Body(2.0, np.array([0.05, -0.02, 0.1]), np.diag([0.01, 0.012, 0.015]))


def motion(seed, count=250, step=0.02):
    """Random sines, with torques to come; the first row stands, so that the offset is not that of both directions."""
    rng, t = np.random.default_rng(seed), np.arange(count) * step
    a, w, p = rng.uniform(0.3, 1.0, (3, 3, 6)) * np.array([1.0, 4.0, 6.0])[:, None, None]
    phase = w[:, None] * t[:, None] + p[:, None]
    q, dq, ddq = ((a[:, None] * x).sum(0) for x in (
        np.sin(phase), w[:, None] * np.cos(phase), -np.square(w[:, None]) * np.sin(phase)))  # fmt: skip
    dq[0] = 0.0
    return FilteredLog(t, q, dq, ddq, np.zeros_like(q))


def measured(log, arm=ARM, gains=1.0, rotors=0.0, noise=0.0, friction=True):
    model = lwr_dyn.dynamics_of(arm).inverse_dynamics(log.q, log.dq, log.ddq)
    moving = np.abs(log.dq) > 0.01
    tau = gains * model + rotors * log.ddq
    tau += friction * (COULOMB * np.sign(log.dq) * moving + VISCOUS * log.dq + OFFSET)
    tau = tau + noise * np.random.default_rng(9).normal(size=tau.shape)
    return FilteredLog(log.t, log.q, log.dq, log.ddq, tau)


def loaded():
    bodies = list(ARM.chain.bodies)
    return ARM.with_chain(with_bodies(ARM.chain, [*bodies[:-1], bodies[-1] + LOAD]))


def torques(**given):
    return Torques(measured(motion(1), **given), measured(motion(2), **given))


def test_friction_is_found_whatever_its_size():
    fit = fit_set(torques().of(ARM), ())
    assert fit.total < 1e-9
    assert (fit.rms.shape, fit.load, fit.gains, fit.rotors) == ((6,), None, None, None)


@pytest.mark.parametrize("gains", [1.0, GAINS])
def test_rotors_and_gains_are_found(gains):
    free = ("rotor", "gain") if gains is GAINS else ("rotor",)
    both = torques(rotors=ROTORS, gains=gains).of(ARM)
    fit = fit_set(both, free)
    assert fit.total < 1e-8 < 1e-2 < fit_set(both, ()).total
    np.testing.assert_allclose(fit.rotors, ROTORS, rtol=1e-6)
    if gains is GAINS:
        np.testing.assert_allclose(fit.gains[:5], GAINS[:5], rtol=1e-6)
        assert np.isnan(fit.gains[5]) or fit.gains[5] == pytest.approx(GAINS[5])


def test_a_free_load_is_found():
    fit = fit_set(torques(arm=loaded()).of(ARM), ("load",))
    assert fit.total < 1e-6
    np.testing.assert_allclose(fit.load, body_parameters(LOAD), atol=1e-6)


def test_load_and_gains_are_found_together():
    both = torques(arm=loaded(), gains=GAINS).of(ARM)
    fit = fit_set(both, ("load", "gain"))
    assert fit.total < 0.02 * min(fit_set(both, (one,)).total for one in ("load", "gain"))
    np.testing.assert_allclose(fit.load[0], LOAD.mass, rtol=0.05)


@pytest.mark.parametrize("noise", [0.5, 5.0])
def test_a_gain_is_said_where_its_standard_error_is_at_most_a_tenth(noise):
    """By residuals taken as white, of the model's torque beyond what the joint's friction explains."""
    both = torques(noise=noise).of(ARM)
    gains, train = fit_set(both, ("gain",)).gains, both[0]
    for j, gain in enumerate(gains):
        X = np.column_stack([joint_columns(train.log, j, (), None), train.model[:, j]])
        left = train.log.tau[:, j] - X @ np.linalg.lstsq(X, train.log.tau[:, j])[0]
        error = np.sqrt(np.mean(left**2) * np.linalg.inv(X.T @ X)[-1, -1])
        assert np.isnan(gain) == (error > 0.1)
    assert np.isnan(gains).any()
    assert not np.isnan(gains).all()


def test_a_coupled_motor_adds_the_speeds_of_the_other_joint():
    matrix = np.diag([32.0, 32, 45, -48, 45, 32])
    matrix[5, 4] = 32.0
    log, coupled = motion(3), Transmission(matrix)
    columns = joint_columns(log, 4, ("coupling", "rotor"), coupled)
    assert columns.shape[1] == 5 + 3
    np.testing.assert_array_equal(columns[:, 5], log.dq[:, 5])
    np.testing.assert_array_equal(columns[:, 6], np.sign(log.dq[:, 4] + log.dq[:, 5]))
    np.testing.assert_array_equal(columns[:, 7], log.ddq[:, 5])
    assert joint_columns(log, 1, ("coupling", "rotor"), coupled).shape[1] == 5


def test_the_floor_is_that_of_any_bodies():
    wrong = ARM.with_chain(with_bodies(ARM.chain, [replace(b, mass=1.3 * b.mass) for b in ARM.chain.bodies]))
    of = torques(arm=wrong, noise=0.1)
    floor = np.sqrt(np.mean(np.square(floor_of(of, ARM, ()))))
    assert 0.09 < floor < 0.12 < 1.0 < fit_set(of.of(ARM), ()).total
