"""Kernel forms of the adaptive and the robust law: torque after torque as the controllers, with bounds and limits."""

from types import SimpleNamespace

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.passivity_law_forms import AdaptiveForm, AddedBodies, RobustForm, Sliding
from lwr_dyn.codegen.rollouts.symbolic_arm import SymbolicModel
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.laws.adaptive import FRICTION_WIDTH, SlotineLiRegressor
from tests.codegen.rollouts.beside import ARM, check_beside, made, other_values
from tests.random_arms import random_arm

FREE = 1e300
QUICK = {"adaptation_gains": 1e3, "law_effort": FREE}
"""A load that is learnt so fast that it passes its bounds within the samples."""
TIGHT = {"lower_load": -1e-2, "upper_load": 1e-2, "law_effort": FREE}
LEARNT = {"friction_gains": 1e3, "friction_start": [[0.3], [0.1]], **TIGHT}
LIMITED = [{**LEARNT, "law_effort": limit} for limit in (10.0, 50.0, 150.0)]


@pytest.mark.parametrize(
    ("options", "cases", "variant"),
    [
        ({"adapt_gain": 100.0}, [QUICK, {**QUICK, **TIGHT}], False),
        (
            {"adapt": "base", "adapt_friction": True},
            [{"law_effort": FREE, "friction_gains": 1e3, "friction_start": 0.3}], True,
        ),
        (
            {"adapt_friction": True, "omega_n": 30.0},
            [LEARNT, *LIMITED, {**LEARNT, "friction_gains": 1e6, "law_effort": 1e4}], True,
        ),
    ],
    ids=["a load", "all links and friction", "a load and friction"],
)  # fmt: skip
def test_the_adaptive_law(options, cases, variant):
    law = made("adaptive", **options)
    form = AdaptiveForm.of(law, ARM)
    check_beside(form, law, *cases)
    check_signals(form, law)
    assert form.digest.startswith(f"adaptive friction={variant} width={FRICTION_WIDTH!r} bodies=")


def check_signals(form, law):
    """Those of the law, at each of several samples."""
    stored = np.arange(3.0 * form.memory).reshape(3, form.memory)
    shown = form.signals(stored)
    for k, memory in enumerate(stored):
        law._theta = memory
        assert shown.keys() == law.signals.keys()
        for name, values in law.signals.items():
            np.testing.assert_allclose(shown[name][k], values, rtol=1e-12, atol=1e-12)
    law.reset()


def test_signals_of_friction_begin_at_that_of_the_law():
    form = AdaptiveForm.of(made("adaptive", adapt_friction=True, omega_n=30.0), ARM)
    law = form.controller(ARM, other_values(form, **LEARNT))
    check_signals(AdaptiveForm.of(law, ARM), law)


@pytest.mark.parametrize("options", [{}, {"layer": 5.0, "largest_load": 3.0}])
def test_the_robust_law(options):
    law = made("robust", **options)
    check_beside(RobustForm.of(law, ARM), law, {"layer": 1e-3}, {"layer": 1e4})


ARMS = {
    "wam7": lwr_dyn.load("wam7"),
    "RPR": random_arm(5, "RPR"),
    "PRRP": random_arm(8, "PRRP"),
    "R": random_arm(0, "R"),
}


@pytest.mark.parametrize(("name", "kind"), [("adaptive", AdaptiveForm), ("robust", RobustForm)])
@pytest.mark.parametrize("arm", ARMS)
def test_on_other_arms(arm, name, kind):
    """Sliding joints, gravity anywhere, frames that are slid along the last axis."""
    law = make_controller(name, ARMS[arm])
    check_beside(kind.of(law, ARMS[arm]), law, arm=ARMS[arm])


@pytest.mark.parametrize("arm", [ARM, ARMS["PRRP"]], ids=["RRRR", "PRRP"])
@pytest.mark.parametrize("which", ["load", "combined"])
def test_added_bodies_give_the_torque_and_the_power_of_the_regressor(arm, which):
    """Torque with two velocities: Y (theta_0 + W theta) + armature ddq_r; power of the slope by theta: (Y W)^T s."""
    rng, n, regressor = np.random.default_rng(1), arm.n, SlotineLiRegressor(arm)
    W = rng.normal(size=(10 * n, 3)) if which == "combined" else np.eye(10 * n)[:, -10:]
    added = AddedBodies.load(arm.chain) if which == "load" else AddedBodies.combined(arm.chain, W)
    state, theta = rng.uniform(-2.0, 2.0, (4, n)), rng.normal(size=W.shape[1])
    symbols = [casadi.SX.sym(name, n) for name in ("q", "dq", "dq_r", "ddq_r")]
    values = casadi.SX.sym("theta", theta.size)
    q, dq, dq_r, ddq_r = symbols
    at, model = Sliding(q, dq, dq_r, dq - dq_r, ddq_r), SymbolicModel.of(arm.chain)
    out = [added.torque(model, at, values), added.power(model, at)]
    tau, power = (np.array(x).ravel() for x in casadi.Function("f", [*symbols, values], out)(*state, theta))
    Y = regressor(*state)
    expected = Y @ (regressor.parameters + W @ theta) + regressor.armature * state[3]
    np.testing.assert_allclose(tau, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(power, (Y @ W).T @ (state[1] - state[2]), rtol=1e-9, atol=1e-9)


def test_a_state_with_two_velocities():
    q, dq, q_ref, dq_ref, ddq_ref = np.random.default_rng(1).normal(size=(5, 3))
    at = Sliding.of(SimpleNamespace(q=q, dq=dq, q_ref=q_ref, dq_ref=dq_ref, ddq_ref=ddq_ref), 7.0)
    dq_r, ddq_r = dq_ref + 7.0 * (q_ref - q), ddq_ref + 7.0 * (dq_ref - dq)
    expected = [q, dq, dq_r, dq - dq_r, ddq_r - 7.0 * (dq - dq_r)]
    np.testing.assert_allclose([at.q, at.dq, at.dq_r, at.s, at.a], expected, rtol=1e-14)
