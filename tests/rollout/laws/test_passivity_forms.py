"""Kernel forms of the adaptive and the robust law: torque after torque as the controllers, with bounds and limits."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.rollout.laws import passivity_forms
from lwr_dyn.rollout.laws.no_form import NoKernelFormError
from tests.arms import random_arm
from tests.rollout.laws.beside import ARM, MODEL, check_beside, made, other_values
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
    law = made("adaptive", adapt_friction=True, omega_n=30.0)
    form = module.AdaptiveForm.of(law, ARM)
    limited = [{**LEARNT, "law_effort": limit} for limit in (10.0, 50.0, 150.0)]
    check_beside(form, law, LEARNT, *limited, {**LEARNT, "friction_gains": 1e6, "law_effort": 1e4})
    law = form.controller(ARM, other_values(form, **LEARNT))
    form = module.AdaptiveForm.of(law, ARM)
    stored = np.arange(36.0).reshape(2, 18)
    law._theta = stored[1]
    shown = form.signals(stored)
    assert shown.keys() == law.signals.keys()
    for name, values in law.signals.items():
        np.testing.assert_array_equal(shown[name][1], values)


def check_robust(module):
    for options in ({}, {"layer": 5.0, "largest_load": 3.0}):
        law = made("robust", **options)
        check_beside(module.RobustForm.of(law, ARM), law, {"layer": 1e-3}, {"layer": 1e4})


ADAPTIVE_SLIPS = [
    ("casadi.mtimes(to_axis, x.memory[:LOAD])", "None"),
    ("slope = casadi.mtimes(to_axis.T, load_power", "slope = -casadi.mtimes(to_axis.T, load_power"),
    ("shape = casadi.tanh(x.dq_ref / FRICTION_WIDTH)", "shape = casadi.tanh(x.dq / FRICTION_WIDTH)"),
    ("+ coulomb * shape + viscous", "+ coulomb + viscous"),
    ("viscous * at.dq_r\n", "viscous * x.dq\n"),
    ('p["friction_start"] + x.memory[LOAD:]', 'p["friction_start"] - x.memory[LOAD:]'),
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
    ("SlotineLiRegressor(arm), dynamics_of(arm), float", "self.law._regressor, dynamics_of(arm), float"),
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
ARMS = {"wam7": lwr_dyn.load("wam7"), "RPR": random_arm(5, "RPR"), "PRRP": random_arm(8, "PRRP")}
CHECKS = {"adaptive": (check_adaptive, ADAPTIVE_SLIPS), "robust": (check_robust, ROBUST_SLIPS)}


@pytest.mark.parametrize("law", CHECKS)
def test_planted_slips_are_caught(law):
    check, slips = CHECKS[law]
    assert not uncaught(passivity_forms.__name__, slips, check)


@pytest.mark.parametrize("name", ["adaptive", "robust"])
@pytest.mark.parametrize("arm", ARMS)
def test_on_other_arms(arm, name):
    """Sliding joints, gravity anywhere, frames that are slid along the last axis."""
    arm = ARMS[arm]
    law = make_controller(name, arm)
    kind = {"adaptive": passivity_forms.AdaptiveForm, "robust": passivity_forms.RobustForm}[name]
    check_beside(kind.of(law, arm), law, arm=arm)


def test_a_law_that_adapts_all_links_has_no_form():
    with pytest.raises(NoKernelFormError, match=r"\(base\): no form that kernels take; allowed: adapt: payload"):
        passivity_forms.AdaptiveForm.of(make_controller("adaptive", ARM, MODEL, adapt="base"), ARM)
