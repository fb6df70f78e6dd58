"""Kernel forms of the adaptive and the robust law: torque after torque as the controllers, with bounds and limits."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts import passivity_law_forms
from lwr_dyn.control.controllers import make_controller
from tests.codegen.rollouts.beside import ARM, check_beside, made, other_values
from tests.random_arms import random_arm
from tests.slips import uncaught

FREE = 1e300
QUICK = {"adaptation_gains": 1e3, "law_effort": FREE}
"""A load that is learnt so fast that it passes its bounds within the samples."""
TIGHT = {"lower_load": -1e-2, "upper_load": 1e-2, "law_effort": FREE}
LEARNT = {"friction_gains": 1e3, "friction_start": [[0.3], [0.1]], **TIGHT}


def check_adaptive(module):
    plain = made("adaptive", adapt_gain=100.0)
    form = module.AdaptiveForm.of(plain, ARM)
    check_beside(form, plain, QUICK, {**QUICK, **TIGHT})
    whole = made("adaptive", adapt="base", adapt_friction=True)
    form = module.AdaptiveForm.of(whole, ARM)
    check_beside(form, whole, {"law_effort": FREE, "friction_gains": 1e3, "friction_start": 0.3})
    check_signals(form, whole)
    law = made("adaptive", adapt_friction=True, omega_n=30.0)
    form = module.AdaptiveForm.of(law, ARM)
    limited = [{**LEARNT, "law_effort": limit} for limit in (10.0, 50.0, 150.0)]
    check_beside(form, law, LEARNT, *limited, {**LEARNT, "friction_gains": 1e6, "law_effort": 1e4})
    law = form.controller(ARM, other_values(form, **LEARNT))
    check_signals(module.AdaptiveForm.of(law, ARM), law)


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


def check_robust(module):
    for options in ({}, {"layer": 5.0, "largest_load": 3.0}):
        law = made("robust", **options)
        check_beside(module.RobustForm.of(law, ARM), law, {"layer": 1e-3}, {"layer": 1e4})


ADAPTIVE_SLIPS = [
    ("x.memory[: self.bodies]), self", "0 * x.memory[: self.bodies]), self"),
    (", self.added.power(model, at)\n", ", -self.added.power(model, at)\n"),
    ("AddedBodies.combined(arm.chain, W)", "AddedBodies.combined(arm.chain, 2 * W)"),
    ("else of_bodies @ adapted.W.T", "else of_bodies @ -adapted.W.T"),
    ("shape = casadi.tanh(x.dq_ref / FRICTION_WIDTH)", "shape = casadi.tanh(x.dq / FRICTION_WIDTH)"),
    ("+ coulomb * shape + viscous", "+ coulomb + viscous"),
    ("viscous * at.dq_r\n", "viscous * x.dq\n"),
    ('p["friction_start"] + x.memory[self.bodies :]', 'p["friction_start"] - x.memory[self.bodies :]'),
    ("shape * at.s, at.dq_r * at.s", "at.dq_r * at.s, shape * at.s"),
    ('casadi.vertcat(lower, -p["friction_start"])', 'casadi.vertcat(lower, p["friction_start"] * 0)'),
    (
        'vertcat(upper, p["law_effort"], p["law_effort"])',
        'vertcat(upper, 0 * p["law_effort"], p["law_effort"])',
    ),
    ("moves = 1 - (", "moves = 1 - 0 * ("),
    ("casadi.fabs(tau)", "tau"),
    ("x.memory - x.h * (moves", "x.memory + x.h * (moves"),
    ("x.memory - x.h * (moves", "x.memory - (moves"),
    ("casadi.fmin(casadi.fmax(moved, lower), upper)", "casadi.fmin(moved, upper)"),
    ("casadi.fmin(casadi.fmax(moved, lower), upper)", "casadi.fmax(moved, lower)"),
    (
        'v["adaptation_gains"], v["lower_load"], v["upper_load"]',
        'v["adaptation_gains"], v["lower_load"], -v["lower_load"]',
    ),
    ('friction[0], v["law_effort"]', 'friction[0], self.values()["law_effort"]'),
    ("adaptive.SlotineLiRegressor(arm), dynamics_of(arm), float", "self.law._regressor, dynamics_of(arm), float"),
    ('["friction_start"][i] + memory', '["friction_start"][1 - i] + memory'),
]
ROBUST_SLIPS = [
    ('z = p["scale"] * casadi', "z = casadi"),
    ("casadi.sqrt(casadi.dot(z, z))", "casadi.dot(z, z)"),
    ("casadi.fmax(casadi.sqrt", "casadi.fmin(casadi.sqrt"),
    ('p["middle_load"] - (p["rho"]', 'p["middle_load"] + (p["rho"]'),
    ('p["middle_load"] - (p["rho"]', '-(p["rho"]'),
    ('(p["rho"] / size) * p["scale"] * z', '(p["rho"] / size) * z'),
    ('regressor.parameters[-LOAD:] += v["middle_load"]', 'regressor.parameters[-LOAD:] -= v["middle_load"]'),
    ("law._parameters - SlotineLiRegressor(arm).parameters", "law._parameters"),
]
ARMS = {
    "wam7": lwr_dyn.load("wam7"),
    "RPR": random_arm(5, "RPR"),
    "PRRP": random_arm(8, "PRRP"),
    "R": random_arm(0, "R"),
}
CHECKS = {"adaptive": (check_adaptive, ADAPTIVE_SLIPS), "robust": (check_robust, ROBUST_SLIPS)}


@pytest.mark.slow
@pytest.mark.parametrize("law", CHECKS)
def test_planted_slips_are_caught(law):
    check, slips = CHECKS[law]
    assert not uncaught(passivity_law_forms.__name__, slips, check)


@pytest.mark.parametrize("name", ["adaptive", "robust"])
@pytest.mark.parametrize("arm", ARMS)
def test_on_other_arms(arm, name):
    """Sliding joints, gravity anywhere, frames that are slid along the last axis."""
    arm = ARMS[arm]
    law = make_controller(name, arm)
    kind = {"adaptive": passivity_law_forms.AdaptiveForm, "robust": passivity_law_forms.RobustForm}[name]
    check_beside(kind.of(law, arm), law, arm=arm)
