"""The regressor gives the recursion's torques back, its base parameters are as many as theory says, a fit predicts."""

import numpy as np

import lwr_dyn
from lwr_dyn.dynamics.regressor import INERTIAL, JOINT, Regressor, chain_parameters
from lwr_dyn.identification.regression.least_squares import base_parameters
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

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
    base, regressor = TorqueColumns(wam.chain, "directions").base(), Regressor(wam.chain)
    full = truth(wam, wam.friction)
    q, dq, ddq = np.random.default_rng(5).uniform(-2, 2, (3, 20, 7))
    Y = regressor(q, dq, ddq)
    assert np.abs(Y[:, :, base.kept] @ base.of(full) - Y @ full).max() < 1e-11
    other = full + np.linalg.svd(base.grouping)[2][base.count :].T @ np.ones(full.size - base.count)
    assert np.abs(other - full).max() > 0.1
    assert np.abs(Y @ other - Y @ full).max() < 1e-11
