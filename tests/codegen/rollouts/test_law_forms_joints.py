"""Joint laws on symbols: torque after torque as the controllers whose text they are, and as their equations say."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts import law_forms
from lwr_dyn.codegen.rollouts.law_forms import form_function
from lwr_dyn.control import paper_laws
from lwr_dyn.control.laws import motor_side
from tests.codegen.rollouts.beside import ARM, INERTIA, MODEL, OTHER, STATES, check_beside, made, other_values
from tests.slips import uncaught

pytestmark = pytest.mark.slow

STEP, B = 1e-3, np.array(INERTIA[: ARM.n])
GAINS = 900.0 * B, 60.0 * B
SAME = 1e-12
"""Of the largest torque: a form and its equations written out, on the same model."""


def check_equations(form, equations, **given):
    """The form's torque and memory, of its own values and of others, are those of the equations."""
    step = form_function(form, ARM)
    for values in (form.values(), other_values(form, **given)):
        memory = np.linspace(-3.0, 3.0, form.memory)
        for state in STATES.reshape(-1, 5, ARM.n):
            tau, after = step(*state, memory, values, STEP)
            expected, kept = equations(values, memory, *state)
            np.testing.assert_allclose(tau, expected, rtol=0, atol=SAME * max(1.0, np.abs(expected).max()))
            np.testing.assert_allclose(after, kept, rtol=0, atol=SAME * max(1.0, np.abs(kept).max(initial=0.0)))


def weight(q):
    return MODEL.gravity_vector(q)


def check_pd(forms, laws):
    for velocity_error in (False, True):
        law = laws.PDGravity(MODEL, *GAINS, velocity_error)
        form = forms.JointLaw(laws.PDGravity, switches=("velocity_error",)).of(law, ARM)
        check_beside(form, law)

        def equations(v, memory, q, dq, q_ref, dq_ref, ddq_ref, damped=velocity_error):
            return weight(q) + v["Kp"] * (q_ref - q) - v["Kd"] * (dq - dq_ref if damped else dq), memory

        check_equations(form, equations)
        assert form.digest == f"pd-gravity velocity_error={velocity_error}"
    own = laws.PDGravity(MODEL, 900.0, 40.0, gains="of the file")
    again = forms.PD_GRAVITY.of(own, ARM).controller(OTHER, {"Kp": own.Kp, "Kd": own.Kd})
    assert again.label == own.label
    q = np.full((1, ARM.n), 0.3)
    carried = lwr_dyn.dynamics_of(OTHER).gravity_vector(q)
    np.testing.assert_array_equal(again.linear_feedback(q).gravity.gravity_vector(q), carried)


def check_pid(forms, laws):
    """With limits that some samples exceed, so that the integral is drawn back."""
    limits = np.linspace(200.0, 10.0, ARM.n)
    for velocity_error, gravity in ((False, True), (True, True), (False, False)):
        law = laws.PID(*GAINS, ARM.effort, dynamics=MODEL if gravity else None, velocity_error=velocity_error)
        form = forms.JointLaw(laws.PID, forms.PID_LAW.gains, forms.PID_LAW.switches).of(law, ARM)
        cases = {"law_effort": limits}, {"law_effort": limits, "Ki": 1e6}
        check_beside(form, law, *cases, knows_arm=gravity)

        def equations(v, memory, q, dq, q_ref, dq_ref, ddq_ref, damped=velocity_error, carried=gravity):
            tau = v["Kp"] * (q_ref - q) + memory - v["Kd"] * (dq - dq_ref if damped else dq)
            tau = tau + weight(q) if carried else tau
            over = tau - np.clip(tau, -v["law_effort"], v["law_effort"])
            return tau, memory + STEP * (v["Ki"] * (q_ref - q) - over / v["tracking_time"])

        check_equations(form, equations, law_effort=limits)
        assert form.digest == f"pid velocity_error={velocity_error} gravity={gravity}"


def check_inverse_dynamics(forms, laws):
    for feedforward, gravity in ((True, True), (False, True), (True, False), (False, False)):
        law = laws.InverseDynamics(MODEL, 900.0, 60.0, feedforward, gravity)
        form = forms.JointLaw(laws.InverseDynamics, switches=("feedforward", "gravity")).of(law, ARM)
        check_beside(form, law)

        def equations(v, memory, q, dq, q_ref, dq_ref, ddq_ref, forward=feedforward, carried=gravity):
            y = v["Kp"] * (q_ref - q) + v["Kd"] * (dq_ref - dq) + forward * ddq_ref
            return MODEL.inverse_dynamics(q, dq, y) - (0.0 if carried else weight(q)), memory

        check_equations(form, equations)
        assert form.digest == f"inverse-dynamics feedforward={feedforward} gravity={gravity}"


def check_motor_pd(forms, laws):
    """As it acts on rigid joints: no spring, no torque feedback."""
    for feedforward, lighter in ((True, 1.0), (False, 1.0), (True, 4.0)):
        law = laws.MotorSidePD(MODEL, *GAINS, 1e4, ARM.armature, feedforward, lighter)
        form = forms.JointLaw(laws.MotorSidePD, switches=("feedforward",)).of(law, ARM)
        check_beside(form, law)

        def equations(v, memory, q, dq, q_ref, dq_ref, ddq_ref, forward=feedforward):
            carried = MODEL.inverse_dynamics(q_ref, dq_ref, ddq_ref) if forward else weight(q_ref)
            return carried + v["Kp"] * (q_ref - q) + v["Kd"] * (dq_ref - dq), memory

        check_equations(form, equations)
        assert form.digest == f"motor-pd feedforward={feedforward}"


PD_SLIPS = [
    ("dq = dq - dq_ref\n        tau: Array", "dq = dq + dq_ref\n        tau: Array"),
    ("gravity_vector(q) + self.Kp * (q_ref - q) -", "gravity_vector(q) - self.Kp * (q_ref - q) -"),
    ("gravity_vector(q) + self.Kp", "gravity_vector(q_ref) + self.Kp"),
    ("(q_ref - q) - self.Kd * dq", "(q_ref - q) + self.Kd * dq"),
]
PID_SLIPS = [
    ("self.Kp * error + memory", "self.Kp * error"),
    ("+ memory - self.Kd * dq", "+ memory + self.Kd * dq"),
    ("tau = tau + self._model.gravity_vector(q)", "tau = tau - self._model.gravity_vector(q)"),
    ("(saturate(tau, self._effort) - tau)", "(tau - saturate(tau, self._effort))"),
    ("- tau) / self.tracking_time", "- tau) * self.tracking_time"),
    ("self.Ki * error +", "self.Kp * error +"),
]
INVERSE_DYNAMICS_SLIPS = [
    ("y = self.Kp * (q_ref - q)", "y = self.Kp * (q - q_ref)"),
    ("self.Kd * (dq_ref - dq)", "self.Kd * -dq"),
    ("y += ddq_ref", "y -= ddq_ref"),
    ("if self.feedforward:\n            y", "if True:\n            y"),
    ("return tau if self.gravity else", "return tau if True else"),
    ("self._model.inverse_dynamics(q, dq, y)", "self._model.inverse_dynamics(q_ref, dq, y)"),
]
MOTOR_PD_SLIPS = [
    ("model.inverse_dynamics(q_ref, dq_ref, ddq_ref) if", "model.inverse_dynamics(q_ref, 0 * dq_ref, ddq_ref) if"),
    ("else model.gravity_vector(q_ref)", "else -model.gravity_vector(q_ref)"),
    ("ddq_ref) + self.Kp * (q_ref - q)", "ddq_ref) - self.Kp * (q_ref - q)"),
    ("(q_ref - q) + self.Kd * (dq_ref - dq)", "(q_ref - q) - self.Kd * dq"),
]
CHECKS = {
    "pd-gravity": (check_pd, paper_laws, PD_SLIPS),
    "pid": (check_pid, paper_laws, PID_SLIPS),
    "inverse-dynamics": (check_inverse_dynamics, paper_laws, INVERSE_DYNAMICS_SLIPS),
    "motor-pd": (check_motor_pd, motor_side, MOTOR_PD_SLIPS),
}
FORM_SLIPS = [
    ("        reset(law)\n        for name", "        for name"),
    ("gains[name])", "getattr(self.law, _ATTRIBUTES.get(name, name)))"),
    ("_model, law._dynamics = model, dynamics", "_model = model"),
    ("if law._model is not None:", "if True:"),
    ("return tau, x.memory + x.h * rate", "return tau, x.memory + rate"),
    ("return tau, x.memory + x.h * rate", "return tau, x.h * rate"),
    ("finite_limits(value) if name", "value / 2 if name"),
    ('return " ".join((self.name, *switches))', "return self.name"),
]


@pytest.mark.parametrize("law", CHECKS)
def test_planted_slips_in_the_equations_are_caught(law):
    check, module, slips = CHECKS[law]
    assert not uncaught(module.__name__, slips, lambda laws: check(law_forms, laws))


def check_forms(forms):
    for check, module, _ in CHECKS.values():
        check(forms, module)
    law, dynamic = made("pid"), np.full(ARM.n, 0.1)
    law(0.0, *np.zeros((5, ARM.n)))
    law(0.1, dynamic, *np.zeros((4, ARM.n)))
    kept = law.integral.copy()
    again = forms.PID_LAW.of(law, ARM).controller(ARM, forms.PID_LAW.of(law, ARM).values())
    assert not again.integral.any()
    assert (law.integral == kept).all()


def test_planted_slips_in_the_forms_are_caught():
    assert not uncaught(law_forms.__name__, FORM_SLIPS, check_forms)
