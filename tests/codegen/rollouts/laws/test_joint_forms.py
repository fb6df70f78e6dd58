"""Kernel forms of PD with gravity, PID, inverse dynamics and motor-side PD: torque after torque as the controllers."""

import numpy as np
import pytest

from lwr_dyn.codegen.rollouts import joint_law_forms
from lwr_dyn.control.paper_laws import PDGravity
from tests.codegen.rollouts.laws.beside import ARM, MODEL, check_beside, made
from tests.slips import uncaught


def check_pd(module):
    for velocity_error in (False, True):
        law = made("pd-gravity", velocity_error=velocity_error)
        check_beside(module.PDGravityForm.of(law, ARM), law)
    own = PDGravity(MODEL, 900.0, 40.0, gains="of the file")
    check_beside(module.PDGravityForm.of(own, ARM), own)


def check_pid(module):
    """With limits that some samples exceed, so that the integral is drawn back."""
    for options in ({}, {"velocity_error": True, "xi": 0.7}, {"gravity": False}):
        law = made("pid", **options)
        form = module.PIDForm.of(law, ARM)
        limits = np.linspace(200.0, 10.0, ARM.n)
        cases = {"law_effort": limits}, {"law_effort": limits, "Ki": 1e6}
        check_beside(form, law, *cases, knows_arm=options.get("gravity", True))


def check_inverse_dynamics(module):
    for options in ({}, {"feedforward": False}, {"gravity": False}, {"feedforward": False, "gravity": False}):
        law = made("inverse-dynamics", **options)
        check_beside(module.InverseDynamicsForm.of(law, ARM), law)


def check_motor_pd(module):
    for options in ({}, {"feedforward": False}, {"lighter": 4.0}):
        law = made("motor-pd", **options)
        check_beside(module.MotorSidePDForm.of(law, ARM), law)


PD_SLIPS = [
    ("x.dq - x.dq_ref if velocity_error else x.dq", "x.dq if velocity_error else x.dq - x.dq_ref"),
    ("x.dq - x.dq_ref if", "x.dq + x.dq_ref if"),
    ('model.gravity(x.q) + p["Kp"] *', 'model.gravity(x.q) - p["Kp"] *'),
    ('tau = model.gravity(x.q) + p["Kp"]', 'tau = model.gravity(x.q_ref) + p["Kp"]'),
    ('(x.q_ref - x.q) - p["Kd"] * speed_error', '(x.q_ref - x.q) + p["Kd"] * speed_error'),
    ('values["Kd"], law.velocity_error, law.gains', 'values["Kd"], False, law.gains'),
    ("law.velocity_error, law.gains", "law.velocity_error"),
    (
        'return PDGravity(dynamics_of(arm), values["Kp"], values["Kd"]',
        "return PDGravity(dynamics_of(arm), law.Kp, law.Kd",
    ),
]
PID_SLIPS = [
    ('p["Kp"] * error + x.memory', 'p["Kp"] * error'),
    ('x.memory - p["Kd"] * speed_error', 'x.memory + p["Kd"] * speed_error'),
    ("if self.has_gravity:\n            tau", "if True:\n            tau"),
    ('casadi.fmax(casadi.fmin(tau, p["law_effort"]), -p["law_effort"])', 'casadi.fmin(tau, p["law_effort"])'),
    ('(within - tau) / p["tracking_time"]', '(tau - within) / p["tracking_time"]'),
    ('(within - tau) / p["tracking_time"]', '(within - tau) * p["tracking_time"]'),
    ('x.h * (p["Ki"] * error', 'x.h * (p["Kp"] * error'),
    ("return tau, x.memory + x.h *", "return tau, x.memory +"),
    ("return tau, x.memory + x.h", "return tau, x.h"),
    ('v["law_effort"], v["Ki"]', 'v["law_effort"], self.law.Ki'),
    ("np.inf if x is None else x for x", "1.0 if x is None else x / 2 for x"),
]
INVERSE_DYNAMICS_SLIPS = [
    ('x.parameters["Kp"] * (x.q_ref - x.q)', 'x.parameters["Kp"] * (x.q - x.q_ref)'),
    ('x.parameters["Kd"] * (x.dq_ref - x.dq)', 'x.parameters["Kd"] * -x.dq'),
    ("y = y + x.ddq_ref", "y = y - x.ddq_ref"),
    ("if self.law.feedforward:\n            y", "if True:\n            y"),
    ("y, gravity=self.law.gravity)", "y)"),
    ("inverse_dynamics(x.q, x.dq, y", "inverse_dynamics(x.q_ref, x.dq, y"),
    ("law.feedforward, law.gravity)", "law.feedforward)"),
]
MOTOR_PD_SLIPS = [
    ("inverse_dynamics(x.q_ref, x.dq_ref, x.ddq_ref)", "inverse_dynamics(x.q, x.dq_ref, x.ddq_ref)"),
    ("inverse_dynamics(x.q_ref, x.dq_ref, x.ddq_ref)", "inverse_dynamics(x.q_ref, x.dq, x.ddq_ref)"),
    ("carried = model.gravity(x.q_ref)", "carried = model.gravity(x.q)"),
    ('carried + p["Kp"]', 'carried - p["Kp"]'),
    ('p["Kd"] * (x.dq_ref - x.dq), NOTHING', 'p["Kd"] * -x.dq, NOTHING'),
    ("law.rotor, law.feedforward, law.lighter", "law.rotor, True, law.lighter"),
    ("law.feedforward, law.lighter", "law.feedforward"),
]
CHECKS = {
    "pd-gravity": (check_pd, PD_SLIPS),
    "pid": (check_pid, PID_SLIPS),
    "inverse-dynamics": (check_inverse_dynamics, INVERSE_DYNAMICS_SLIPS),
    "motor-pd": (check_motor_pd, MOTOR_PD_SLIPS),
}


@pytest.mark.parametrize("law", CHECKS)
def test_planted_slips_are_caught(law):
    check, slips = CHECKS[law]
    assert not uncaught(joint_law_forms.__name__, slips, check)
