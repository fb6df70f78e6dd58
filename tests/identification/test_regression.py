"""The regressor gives the recursion's torques back, its base parameters are as many as theory says, a fit predicts."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.regressor import INERTIAL, JOINT, Regressor, chain_parameters
from lwr_dyn.errors import OptionError
from lwr_dyn.identification.friction.torque_model import ModelTorque
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.log_columns import LogError
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.identification.motion.motion_fit import MotionRule, chain_base, identify_motion
from lwr_dyn.identification.regression.base_parameters import base_parameters

NOISE = 0.05


def truth(arm, friction):
    full = chain_parameters(arm.chain).copy()
    for j, model in enumerate(friction):
        values = [model.positive.coulomb, model.positive.viscous, model.negative.coulomb, model.negative.viscous]
        full[len(INERTIAL) * arm.n + len(JOINT) * j + 1 :][:4] = values
    return full


def test_a_seven_joint_arm_on_a_vertical_axis_has_43_base_parameters():
    """The count that is known for this structure, friction and rotors apart."""
    arm = lwr_dyn.load("lwr4plus")
    regressor = Regressor(arm.chain)
    q, dq, ddq = np.random.default_rng(0).uniform(-2, 2, (3, 100, 7))
    Y = regressor(q, dq, ddq)[:, :, : 10 * arm.n].reshape(-1, 10 * arm.n)
    base = base_parameters(Y, regressor.names[: 10 * arm.n])
    assert base.count == 43
    assert "mx_2" in base.statements()


def test_base_parameters_carry_all_the_torque(wam):
    base, regressor = chain_base(wam), Regressor(wam.chain)
    full = truth(wam, wam.friction)
    q, dq, ddq = np.random.default_rng(5).uniform(-2, 2, (3, 20, 7))
    Y = regressor(q, dq, ddq)
    assert np.abs(Y[:, :, base.kept] @ base.of(full) - Y @ full).max() < 1e-11
    other = full + np.linalg.svd(base.grouping)[2][base.count :].T @ np.ones(full.size - base.count)
    assert np.abs(other - full).max() > 0.1
    assert np.abs(Y @ other - Y @ full).max() < 1e-11


def test_any_motion_returns_inertia_and_friction_and_predicts_other_motions(wam, fourier):
    log = LogSensors(NOISE, 1e-5).through(fourier(wam, wam.friction), 3)
    found = identify_motion([log], wam)
    gap = np.abs(found.estimate.values - found.base.of(truth(wam, wam.friction)))
    assert np.mean(gap < found.estimate.half_widths) > 0.95
    assert found.condition < 1000
    for one in found.validation:
        assert one.held_out < NOISE  # a local cubic over 11 rows halves the noise
        assert one.model > 2 * one.held_out
        assert one.measured >= one.model * 0.5
    names = dict(zip(found.base.statements(), found.estimate.values, strict=True))
    assert names["viscous+_4"] == pytest.approx(-2.7045, abs=0.15)


def test_the_fit_never_sees_the_held_out_time(wam, fourier):
    log = fourier(wam, wam.friction)
    tau = log.tau.copy()
    tau[1510:] += 10.0  # beyond the last window of the first three quarters
    spoilt = JointLog("fourier", log.joints, log.t, log.q, tau)
    a, b = identify_motion([log], wam), identify_motion([spoilt], wam)
    assert (a.estimate.values == b.estimate.values).all()
    assert b.validation[0].held_out > 5.0 > a.validation[0].held_out


def test_a_wrong_geometry_shows_on_the_held_out_time(wam, fourier):
    """The LWR's frames cannot explain the WAM's torques, and validation shows it."""
    found = identify_motion([fourier(wam, wam.friction)], lwr_dyn.load("lwr4plus"))
    right = identify_motion([fourier(wam, wam.friction)], wam)
    assert found.validation[1].held_out > 20 * right.validation[1].held_out


def test_a_motion_that_excites_too_little_is_refused_by_name(wam, fourier):
    with pytest.raises(
        LogError, match=r"fourier: columns q1..q7: .*coulomb\+_3.* not determined; needed: motion of every"
    ):
        identify_motion([fourier(wam, wam.friction, joints=(0, 1, 3, 4, 5, 6))], wam)
    with pytest.raises(LogError, match=r"coulomb-_2, .* not determined"):
        identify_motion([fourier(wam, wam.friction, seconds=1.0)], wam)


def test_uneven_rows_have_no_accelerations(wam, fourier):
    log = fourier(wam, wam.friction, seconds=3.0)
    t = log.t.copy()
    t[50:] += 0.004
    with pytest.raises(LogError, match=r"fourier: rows 50 and 51: 0.014 s apart, 0.01 s as a rule; needed: evenly"):
        identify_motion([JointLog("fourier", log.joints, t, log.q, log.tau)], wam)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: MotionRule(window=0.0), "motion window: 0.0; allowed: a number above 0"),
        (lambda: MotionRule(held_out=1.0), "held out share: 1.0; allowed: a number between 0 and 1"),
        (lambda: ModelTorque(lwr_dyn.load("wam7"), "friction"), "subtract: 'friction'; allowed: none, gravity"),
    ],
)
def test_options_outside_what_is_allowed(call, message):
    with pytest.raises(OptionError, match=message):
        call()
