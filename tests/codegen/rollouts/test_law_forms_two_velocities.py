"""The torque with two velocities on symbols, and its power, against the regressor of Slotine and Li in NumPy."""

from types import SimpleNamespace

import casadi
import numpy as np
import pytest

from lwr_dyn.codegen.rollouts import passivity_law_forms
from lwr_dyn.codegen.rollouts.symbolic_arm import SymbolicModel
from lwr_dyn.control.laws.adaptive import SlotineLiRegressor
from tests.codegen.rollouts.beside import ARM
from tests.random_arms import random_arm
from tests.slips import uncaught

RNG = np.random.default_rng(1)


def check(module):
    for arm in (ARM, random_arm(8, "PRRP")):
        regressor, n = SlotineLiRegressor(arm), arm.n
        W = RNG.normal(size=(10 * n, 3))
        unit = np.eye(10 * n)[:, -10:]
        load, combined = module.AddedBodies.load(arm.chain), module.AddedBodies.combined(arm.chain, W)
        for added, basis in ((load, unit), (combined, W)):
            state = RNG.uniform(-2.0, 2.0, (4, n))
            theta = RNG.normal(size=basis.shape[1])
            symbols = [casadi.SX.sym(name, n) for name in ("q", "dq", "dq_r", "ddq_r")]
            values = casadi.SX.sym("theta", theta.size)
            q, dq, dq_r, ddq_r = symbols
            at, model = module.Sliding(q, dq, dq_r, dq - dq_r, ddq_r), SymbolicModel.of(arm.chain)
            out = [added.torque(model, at, values), added.power(model, at)]
            tau, power = (np.array(x).ravel() for x in casadi.Function("f", [*symbols, values], out)(*state, theta))
            Y = regressor(*state)
            expected = Y @ (regressor.parameters + basis @ theta) + regressor.armature * state[3]
            np.testing.assert_allclose(tau, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
            np.testing.assert_allclose(power, (Y @ basis).T @ (state[1] - state[2]), rtol=1e-9, atol=1e-9)
    check_sliding(module)


def check_sliding(module):
    q, dq, q_ref, dq_ref, ddq_ref = RNG.normal(size=(5, 3))
    x = SimpleNamespace(q=q, dq=dq, q_ref=q_ref, dq_ref=dq_ref, ddq_ref=ddq_ref)
    at = module.Sliding.of(x, 7.0)
    dq_r = dq_ref + 7.0 * (q_ref - q)
    ddq_r = ddq_ref + 7.0 * (dq_ref - dq)
    np.testing.assert_allclose(at.dq_r, dq_r)
    np.testing.assert_allclose(at.s, dq - dq_r)
    np.testing.assert_allclose(at.a, ddq_r - 7.0 * (dq - dq_r))
    np.testing.assert_array_equal([at.q, at.dq], [q, dq])


SLIPS = [
    ("half - at.dq_r, None, gravity=False", "half - at.dq_r, None, gravity=True"),
    ("half - at.dq_r, None", "half, None"),
    ("0.5 * (at.dq + at.dq_r)", "0.5 * (at.dq - at.dq_r)"),
    ("at.q, half, at.a) - model", "at.q, half, at.a) + model"),
    ("*sliding(omega_n, x.q, x.dq, x.q_ref", "*sliding(omega_n, x.q_ref, x.dq, x.q"),
    ("*sliding(omega_n, x.q", "*sliding(-omega_n, x.q"),
    ("axis_frames(chain)[-1].link.position - chain.links[-1].after.position", "np.zeros(3)"),
    ("to_parent(link.after.inverse())", "to_parent(link.after)"),
    ("[add(a, b) for a, b in zip(*pair", "[a for a, b in zip(*pair"),
    ("casadi.mtimes(self._constants.T, slope)", "-casadi.mtimes(self._constants.T, slope)"),
    ("placed_bodies(self.n, self.places, ", "placed_bodies(self.n, self.places // 10 * 10 + (self.places + 1) % 10, "),
]


@pytest.mark.slow
def test_planted_slips_are_caught():
    assert not uncaught(passivity_law_forms.__name__, SLIPS, check)
