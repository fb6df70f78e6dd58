"""`law_form`: the right form by the controller, and clear refusals of what has none, or acts differently."""

from types import SimpleNamespace

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts import law_forms, passivity_law_forms
from lwr_dyn.codegen.rollouts.law_forms import (
    CLOSE,
    INVERSE_DYNAMICS,
    LAW_FORMS,
    PID_LAW,
    FrictionForm,
    NoKernelFormError,
    form_function,
    law_form,
    states_of,
)
from lwr_dyn.codegen.rollouts.loop_setup import ABOVE_ZERO, NOT_NEGATIVE, RULES, check_gains
from lwr_dyn.codegen.rollouts.passivity_law_forms import AdaptiveForm
from lwr_dyn.codegen.rollouts.symbolic_arm import SymbolicModel
from lwr_dyn.control.controllers import CONTROLLERS, make_controller
from lwr_dyn.control.laws.adaptive import SlotineLiRegressor
from lwr_dyn.control.laws.friction_compensation import FrictionCompensation
from lwr_dyn.control.paper_laws import PID
from lwr_dyn.foundation.errors import LwrDynError, OptionError
from lwr_dyn.model.arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.chain import first_links
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.codegen.rollouts.beside import ARM, WHOLE, check_beside, made
from tests.random_arms import random_arm
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
    "function": (lambda: lambda t, q, dq, q_ref, dq_ref, ddq_ref: -dq, r"own controller \(function\) has no form that"),
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


BAD = {
    **{name: ([1.0, 0.0], "0 in run 1; allowed: numbers above 0") for name in ABOVE_ZERO},
    **{name: ([1.0, -2.5], "-2.5 in run 1; allowed: numbers from 0 on") for name in NOT_NEGATIVE},
    "lower_load": ([0.5, -1.0], "0.5 in run 0; allowed: numbers up to 0"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_gain_that_no_controller_has_is_refused(name):
    column, words = BAD[name]
    with pytest.raises(OptionError, match=rf"parameter {name}: {words}"):
        check_gains({name: np.repeat(np.array(column)[:, None], 3, axis=1)})
    check_gains({name: np.full((2, 3), -1.0 if name == "lower_load" else 1.0)})


def test_friction_of_a_law_has_no_negative_coulomb_level():
    table = np.zeros((3, 5, 4))
    table[:, [1, 3, 4]] = -1.0  # viscous friction and offsets may be negative
    check_gains({"law_friction": table})
    table[2, 2, 1] = -0.1
    with pytest.raises(OptionError, match=r"parameter law_friction: -0\.1 in run 2; allowed: levels from 0 on"):
        check_gains({"law_friction": table})


def test_every_gain_of_every_form_has_a_rule_or_none_is_needed():
    names = set()
    for name in LAW_FORMS.names:
        law = made(name, adapt_friction=True) if name == "adaptive" else made(name)
        form = LAW_FORMS.load(name).of(law, ARM)
        names |= form.parameters.keys() | FrictionForm(FrictionCompensation(law, ARM.friction), form).parameters.keys()
    assert names - RULES.keys() == {"scale", "middle_load", "friction_start"}
    assert RULES.keys() <= names


def test_rollouts_refuse_such_gains():
    move = point_to_point(ARM, [[0.1] * 4, [0.2] * 4], [0.1])
    with pytest.raises(LwrDynError, match="parameter Kp: -1 in run 1; allowed: numbers above 0"):
        lwr_dyn.rollouts(ARM, made("pd-gravity"), move, parameters={"Kp": [[900.0], [-1.0]]})


FRICTION = tuple(JointFriction(Direction(2.0 + i, 0.5), Direction(1.0, 0.2 + i), 0.3 * i) for i in range(ARM.n))


def check_law(module):
    for measured in (False, True):
        for name, kind in (("inverse-dynamics", INVERSE_DYNAMICS), ("pid", PID_LAW)):
            inner = made(name)
            law = FrictionCompensation(inner, FRICTION, 0.5, measured)  # so wide that the speeds show its shape
            form = module.FrictionForm(law, kind.of(inner, ARM))
            check_beside(form, law, {"law_effort": 50.0})
    adaptive = made("adaptive")
    wrapped = module.FrictionForm(FrictionCompensation(adaptive, FRICTION), AdaptiveForm.of(adaptive, ARM))
    assert wrapped.signals(np.zeros((3, 10))).keys() == {"adapted_payload"}
    assert not hasattr(form, "signals")
    assert form.digest != module.FrictionForm(replace_measured(law), form.inner).digest


def replace_measured(law):
    """The same on the speed of the reference."""
    return FrictionCompensation(law.inner, law.models, law.width)


FRICTION_SLIPS = [
    ("x.dq if self.law.measured else x.dq_ref", "x.dq"),
    ("x.dq if self.law.measured else x.dq_ref", "x.dq_ref if self.law.measured else x.dq"),
    ("return tau + friction_column", "return tau - friction_column"),
    ('x.parameters["law_friction_width"]), memory', '2 * x.parameters["law_friction_width"]), memory'),
    ('x.parameters["law_friction_width"]), memory', 'x.parameters["law_friction_width"]), 2 * memory'),
    ('"law_friction_width": np.array(self.law.width)', '"law_friction_width": np.array(1e-3)'),
    ('float(values["law_friction_width"]), self.law.measured', 'float(values["law_friction_width"])'),
    ("return self.inner.start()", "return self.inner.start()[:3]"),
    ('f"{self.inner.digest} + {self.law.word}"', "self.inner.digest"),
]


@pytest.mark.slow
def test_planted_slips_are_caught():
    assert not uncaught(law_forms.__name__, FRICTION_SLIPS, check_law)


def test_a_stribeck_curve_is_refused():
    falling = JointFriction(*(Direction(1.0, 0.1, 2.0, 0.05),) * 2)
    inner = made("inverse-dynamics")
    with pytest.raises(OptionError, match="friction of joint 3: a Stribeck curve; allowed: in kernels Coulomb"):
        law_forms.FrictionForm(
            FrictionCompensation(inner, (*FRICTION[:2], falling, *FRICTION[3:])), INVERSE_DYNAMICS.of(inner, ARM)
        )


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


TWO_VELOCITIES_SLIPS = [
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
def test_planted_slips_of_two_velocities_are_caught():
    assert not uncaught(passivity_law_forms.__name__, TWO_VELOCITIES_SLIPS, check)
