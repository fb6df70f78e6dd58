"""The reduced model: its slopes, its energy, its two sides against the rigid arm, two engines."""

import numpy as np
import pytest

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.simulation.elastic.plant import ElasticDynamics
from tests.simulation.elastic.elastic_arms import physical, states

TAU = np.concatenate([np.linspace(-1.0, 1.0, 7), np.linspace(20.0, -3.0, 7)])


def model(engine="pinocchio"):
    return ElasticDynamics(physical(), physical().elasticity, engine)


def test_two_engines_agree():
    one, other = model(), model("newton-euler")
    for x, dx in states():
        expected = other.forward_dynamics(x, dx, TAU)
        assert one.forward_dynamics(x, dx, TAU) == pytest.approx(expected, rel=1e-10, abs=1e-9)
        rows = np.zeros((2, 7, 28))
        for each, out in zip((one, other), rows, strict=True):
            each.link_rows(x, dx, TAU, out)
        assert np.abs(rows[0] - rows[1]).max() <= 1e-6 * np.abs(rows[0]).max()


def test_slopes_are_those_of_the_accelerations():
    elastic, step = model(), 1e-6
    for x, dx in states(1):
        numeric = np.zeros((14, 28))
        for j in range(28):
            e = step * np.eye(28)[j]
            ahead = elastic.forward_dynamics(x + e[:14], dx + e[14:], TAU)
            numeric[:, j] = (ahead - elastic.forward_dynamics(x - e[:14], dx - e[14:], TAU)) / (2 * step)
        out = np.zeros((7, 28))
        elastic.link_rows(x, dx, TAU, out)
        assert np.abs(out - numeric[:7]).max() <= 1e-7 * np.abs(out).max()
        motors = np.zeros((7, 4, 7))
        motors[np.arange(7), :, np.arange(7)] = elastic.motor_slopes().T
        assert np.abs(motors.reshape(7, 28) - numeric[7:]).max() <= 1e-7 * np.abs(motors).max()


def test_the_power_is_that_of_the_torques_and_the_dampers():
    elastic, step = model(), 1e-6
    for x, dx in states(2):
        ddx = elastic.forward_dynamics(x, dx, TAU)
        ahead, behind = (elastic.energies((x + s * dx)[None], (dx + s * ddx)[None])[0] for s in (step, -step))
        assert (ahead - behind) / (2 * step) == pytest.approx(TAU @ dx + elastic.damper_power(dx), rel=1e-6)


def test_both_sides_together_are_the_rigid_arm():
    elastic, rigid = model(), dynamics_of(physical())
    for x, dx in states(3):
        q, dq, ddq = x[:7], dx[:7], np.ones(7)
        same, still = np.tile(q, 2), np.tile(dq, 2)
        sides = elastic.mass_matrix(same) @ np.tile(ddq, 2) + elastic.bias_torque(same, still)
        assert sides[:7] + sides[7:] == pytest.approx(rigid.inverse_dynamics(q, dq, ddq), rel=1e-11, abs=1e-11)
