"""`law_form`: the right form by the controller, and clear refusals of what has none, or acts differently."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.law_forms import CLOSE, LAW_FORMS, NoKernelFormError, form_function, law_form, states_of
from lwr_dyn.control.controllers import CONTROLLERS, make_controller
from lwr_dyn.control.paper_laws import PID
from lwr_dyn.model.arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.chain import first_links
from tests.codegen.rollouts.beside import ARM, WHOLE, made
from tests.slips import uncaught

SMALL_WAM = ARM.with_chain(first_links(lwr_dyn.load("wam7").chain, 4))


@pytest.mark.parametrize("name", LAW_FORMS.names)
def test_every_form_is_found_by_its_controller(name):
    form = law_form(made(name), ARM)
    assert form.name == name
    assert type(form.law) is LAW_FORMS.load(name).takes


def test_wrappers_are_taken_off_one_by_one():
    law = made("pid+friction-measured")
    form = law_form(law, ARM)
    assert form.name == "pid+friction-measured"
    assert form.inner.name == "pid"
    assert law.inner.integral.tolist() == [0.0] * ARM.n  # the check leaves no memory behind


class Doubled(PID):
    """A user's own controller under a known name."""

    __slots__ = ()

    def __call__(self, *given):
        """Twice the torque."""
        return 2 * super().__call__(*given)


def changed(name, **attributes):
    law = made.__wrapped__(name)
    for attribute, value in attributes.items():
        setattr(law, attribute, value)
    return law


REFUSED = {
    "joint-impedance": (lambda: made("joint-impedance"), "joint impedance has no form that kernels take; allowed: pd"),
    "hand-guiding": (lambda: made("hand-guiding"), "has no form"),
    "cartesian-impedance": (lambda: made("cartesian-impedance", WHOLE), "has no form"),
    "pid+observer": (lambda: made("pid+observer"), "momentum observer has no form"),
    "pid+motor-side": (lambda: made("pid+motor-side", WHOLE), "on the motor side has no form"),
    "function": (lambda: lambda t, q, dq, q_ref, dq_ref, ddq_ref: -dq, r"<lambda> \(function\) has no form that"),
    "subclass": (lambda: Doubled(100.0, 10.0, ARM.effort), r"PID, damping on dq \(Doubled\) has no form"),
    "another arm": (lambda: made("pd-gravity", arm_with_payload(ARM, 1e-6)), r"not that of its kernel form"),
    "another robot": (lambda: made("inverse-dynamics", SMALL_WAM), r"form for lwr4plus \(computed\), by up to"),
    "another mass": (
        lambda: make_controller("adaptive", arm_with_scaled_inertia(ARM, 1 + 1e-7)), "allowed: a controller made for"
    ),
    "another rotor": (lambda: changed("robust", _armature=np.zeros(4)), "not that of its kernel form"),
    "another rule": (lambda: changed("pid", _model=lwr_dyn.dynamics_of(SMALL_WAM)), "not that of its kernel form"),
    "an engine of one's own": (
        lambda: make_controller("inverse-dynamics", ARM, lwr_dyn.dynamics_of(ARM, "newton-euler", rotors="full")),
        "not that of its kernel form",
    ),
    "not finite": (lambda: changed("pd-gravity", Kp=np.full(4, np.nan)), "not that of its kernel form"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_has_no_form_or_acts_differently_is_refused(case):
    make, words = REFUSED[case]
    with pytest.raises(NoKernelFormError, match=words):
        law_form(make(), ARM)


def test_every_controller_by_name_has_a_form_or_is_named_here():
    assert set(CONTROLLERS.rows) - set(LAW_FORMS.rows) == {"joint-impedance", "cartesian-impedance", "hand-guiding"}


def is_refused(module, form, law):
    """Whether the check refuses a controller; a `Failed` of pytest is no `Exception`."""
    try:
        module.check_form(form, law, ARM)
    except NoKernelFormError:
        return True
    return False


def check_check(module):
    """It passes the law itself, sees a hundred-millionth of a gain, thousandths of what moves the memory, and NaN."""
    law = made("pid")
    form = LAW_FORMS.load("pid").of(law, ARM)
    step, values, states = form_function(form, ARM), form.values(), states_of(ARM)

    def share(**given):
        return module.differences(step, {**values, **given}, form.start(), law, states)[1]

    assert share() < 1e-13
    for name in ("Kp", "Kd", "Ki", "tracking_time"):
        assert share(**{name: values[name] * (1 + 1e-3)}) > CLOSE, name
        assert share(**{name: np.full(4, np.nan)}) == np.inf
    module.check_form(form, law, ARM)
    assert is_refused(module, form, made("pid", omega_n=50.0 * (1 + 1e-8)))
    states = module.states_of(ARM)
    assert states.shape == (3, 4, 5, 4)
    assert (states[..., 2, :] > ARM.lower).all()
    assert (states[..., 2, :] < ARM.upper).all()
    errors = np.abs(states[..., 0, :] - states[..., 2, :]).max(axis=(1, 2))
    np.testing.assert_allclose(errors, [1e-4, 1e-2, 1], rtol=0.2)


SLIPS = [
    ("tau, memory = step(", "tau, _ = step("),
    ("if not isfinite(apart / size)", "if False"),
    ("if not share <= CLOSE", "if not share <= 1.0"),
    ("max(share, apart / size)", "min(share, apart / size)"),
    ("(r + error * rng", "(r + 0 * rng"),
    ("(0.5 + 0.4 * q_ref)", "(0.5 + 0.8 * q_ref)"),
    ("        reset(controller)\n        memory = start", "        memory = start"),
]


def test_planted_slips_in_the_check_are_caught():
    assert not uncaught("lwr_dyn.codegen.rollouts.law_forms", SLIPS, check_check)
