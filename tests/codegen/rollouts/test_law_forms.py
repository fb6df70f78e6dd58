"""`law_form`: the right form by the controller, torque after torque as the controller and as its equations say; clear
refusals of what has none, or acts differently."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts import law_forms
from lwr_dyn.codegen.rollouts.loop_setup import ABOVE_ZERO, NOT_NEGATIVE, RULES, check_gains
from lwr_dyn.codegen.rollouts.passivity_law_forms import AdaptiveForm
from lwr_dyn.control.controllers import CONTROLLERS, make_controller
from lwr_dyn.control.laws.friction_compensation import FrictionCompensation
from lwr_dyn.control.laws.motor_side import MotorSidePD
from lwr_dyn.control.paper_laws import PID, InverseDynamics, PDGravity
from lwr_dyn.foundation.errors import LwrDynError, OptionError
from lwr_dyn.model.arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.chain import first_links
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.codegen.rollouts.beside import ARM, INERTIA, MODEL, OTHER, STATES, WHOLE, check_beside, made, other_values

SMALL_WAM = ARM.with_chain(first_links(lwr_dyn.load("wam7").chain, 4))


@pytest.mark.parametrize("name", law_forms.LAW_FORMS.names)
def test_every_form_is_found_by_its_controller(name):
    form = law_forms.law_form(made(name), ARM)
    assert form.name == name
    assert type(form.law) is law_forms.LAW_FORMS.load(name).takes


def test_wrappers_are_taken_off_one_by_one():
    law = made("pid+friction-measured")
    form = law_forms.law_form(law, ARM)
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
    with pytest.raises(law_forms.NoKernelFormError, match=words):
        law_forms.law_form(make(), ARM)


def test_every_controller_by_name_has_a_form_or_is_named_here():
    assert set(CONTROLLERS.rows) - set(law_forms.LAW_FORMS.rows) == {
        "joint-impedance",
        "cartesian-impedance",
        "hand-guiding",
    }


def test_the_check_sees_a_hundred_millionth_of_a_gain_thousandths_of_what_moves_the_memory_and_nan():
    law, form = made("pid"), law_forms.LAW_FORMS.load("pid").of(made("pid"), ARM)
    step, values, states = law_forms.form_function(form, ARM), form.values(), law_forms.states_of(ARM)

    def share(**given):
        return law_forms.differences(step, {**values, **given}, form.start(), law, states)[1]

    law(0.0, *states[2, 0])  # a memory that is left over is reset
    assert share() < 1e-13
    for name in ("Kp", "Kd", "Ki", "tracking_time"):
        assert share(**{name: values[name] * (1 + 1e-3)}) > law_forms.CLOSE, name
        assert law_forms.differences(step, {**values, name: np.full(4, np.nan)}, form.start(), law, states) == (
            np.inf,
            np.inf,
        )
    law_forms.check_form(form, law, ARM)
    with pytest.raises(law_forms.NoKernelFormError):
        law_forms.check_form(form, made("pid", omega_n=50.0 * (1 + 1e-8)), ARM)


@pytest.mark.parametrize(("size", "share"), [(1.0, 0.02), (0.01, 0.2)])
def test_differences_count_as_shares_of_the_largest_torque_of_their_sample_from_1_on(size, share):
    """Torques of 10, 20 and 30 times the size; the form is off by 0.1 in one sequence and by 0.2 in the other."""
    sequences = np.zeros((2, 3, 5, 2))
    sequences[:, :, 0] = size * np.outer([1.0, 2.0, 3.0], [10.0, 1.0])
    sequences[1, :, 1] = 0.1  # dq

    def step(q, dq, *others):
        return q + np.array([0.0, 0.1]) + dq * [0.0, 1.0], others[3]

    found = law_forms.differences(step, {}, np.zeros(0), lambda t, q, *_: q, sequences)
    np.testing.assert_allclose(found, (0.2, share), rtol=1e-12)


def test_the_check_looks_at_small_and_large_errors_within_the_joint_box():
    states = law_forms.states_of(ARM)
    assert states.shape == (3, 4, 5, 4)
    assert (states[..., 2, :] > ARM.lower).all()
    assert (states[..., 2, :] < ARM.upper).all()
    errors = states[..., :2, :] - states[..., 2:4, :]
    assert {-1.0, 1.0} == set(np.unique(np.sign([*errors, *states[..., 3:, :]])))
    errors = np.abs(errors).max(axis=(1, 3))
    np.testing.assert_allclose(errors, np.outer([1e-4, 1e-2, 1], [1, 1]), rtol=0.2)


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
    for name in law_forms.LAW_FORMS.names:
        law = made(name, adapt_friction=True) if name == "adaptive" else made(name)
        form = law_forms.LAW_FORMS.load(name).of(law, ARM)
        names |= (
            form.parameters.keys()
            | law_forms.FrictionForm(FrictionCompensation(law, ARM.friction), form).parameters.keys()
        )
    assert names - RULES.keys() == {"scale", "middle_load", "friction_start"}
    assert RULES.keys() <= names


def test_rollouts_refuse_such_gains():
    move = point_to_point(ARM, [[0.1] * 4, [0.2] * 4], [0.1])
    with pytest.raises(LwrDynError, match="parameter Kp: -1 in run 1; allowed: numbers above 0"):
        lwr_dyn.rollouts(ARM, made("pd-gravity"), move, parameters={"Kp": [[900.0], [-1.0]]})


STEP, B = 1e-3, np.array(INERTIA[: ARM.n])
GAINS = 900.0 * B, 60.0 * B
SAME = 1e-12
"""Of the largest torque: a form and its equations written out, on the same model."""


def check_law(form, law, equations, *cases, knows_arm=True, **given):
    """The form is the controller, and its torque and memory are those of the equations, of its values and of others."""
    check_beside(form, law, *cases, knows_arm=knows_arm)
    step = law_forms.form_function(form, ARM)
    for values in (form.values(), other_values(form, **given)):
        memory = np.linspace(-3.0, 3.0, form.memory)
        for state in STATES.reshape(-1, 5, ARM.n):
            for found, expected in zip(
                step(*state, memory, values, STEP), equations(values, memory, *state), strict=True
            ):
                np.testing.assert_allclose(
                    found, expected, rtol=0, atol=SAME * max(1.0, np.abs(expected).max(initial=0.0))
                )


def weight(q):
    return MODEL.gravity_vector(q)


@pytest.mark.parametrize("damped", [False, True])
def test_pd_with_gravity(damped):
    def equations(v, memory, q, dq, q_ref, dq_ref, ddq_ref):
        return weight(q) + v["Kp"] * (q_ref - q) - v["Kd"] * (dq - dq_ref if damped else dq), memory

    law = PDGravity(MODEL, *GAINS, damped)
    form = law_forms.PD_GRAVITY.of(law, ARM)
    check_law(form, law, equations)
    assert form.digest == f"pd-gravity velocity_error={damped}"


def test_another_arms_pd_keeps_its_label_and_carries_that_arm():
    own = PDGravity(MODEL, 900.0, 40.0, gains="of the file")
    again = law_forms.PD_GRAVITY.of(own, ARM).controller(OTHER, {"Kp": own.Kp, "Kd": own.Kd})
    q = np.full((1, ARM.n), 0.3)
    carried = lwr_dyn.dynamics_of(OTHER).gravity_vector(q)
    assert again.label == own.label
    np.testing.assert_array_equal(again.linear_feedback(q).gravity.gravity_vector(q), carried)


@pytest.mark.parametrize(("damped", "carried"), [(False, True), (True, True), (False, False)])
def test_pid_draws_its_integral_back_where_torques_are_cut(damped, carried):
    def equations(v, memory, q, dq, q_ref, dq_ref, ddq_ref):
        tau = v["Kp"] * (q_ref - q) + memory - v["Kd"] * (dq - dq_ref if damped else dq)
        tau = tau + weight(q) if carried else tau
        over = tau - np.clip(tau, -v["law_effort"], v["law_effort"])
        return tau, memory + STEP * (v["Ki"] * (q_ref - q) - over / v["tracking_time"])

    limits = np.linspace(200.0, 10.0, ARM.n)  # some samples exceed them
    law = PID(*GAINS, ARM.effort, dynamics=MODEL if carried else None, velocity_error=damped)
    form = law_forms.PID_LAW.of(law, ARM)
    cases = {"law_effort": limits}, {"law_effort": limits, "Ki": 1e6}
    check_law(form, law, equations, *cases, knows_arm=carried, law_effort=limits)
    assert form.digest == f"pid velocity_error={damped} gravity={carried}"


def test_a_form_of_a_pid_has_an_integral_of_its_own():
    law = made.__wrapped__("pid")
    for t in (0.0, 0.1, 0.2):
        law(t, np.full(ARM.n, 0.1), *np.zeros((4, ARM.n)))
    kept, form = law.integral.copy(), law_forms.PID_LAW.of(law, ARM)
    assert kept.any()
    assert not form.controller(ARM, form.values()).integral.any()
    assert (law.integral == kept).all()


@pytest.mark.parametrize(("forward", "carried"), [(True, True), (False, True), (True, False), (False, False)])
def test_inverse_dynamics(forward, carried):
    def equations(v, memory, q, dq, q_ref, dq_ref, ddq_ref):
        y = v["Kp"] * (q_ref - q) + v["Kd"] * (dq_ref - dq) + forward * ddq_ref
        return MODEL.inverse_dynamics(q, dq, y) - (0.0 if carried else weight(q)), memory

    law = InverseDynamics(MODEL, 900.0, 60.0, forward, carried)
    form = law_forms.INVERSE_DYNAMICS.of(law, ARM)
    check_law(form, law, equations)
    assert form.digest == f"inverse-dynamics feedforward={forward} gravity={carried}"


@pytest.mark.parametrize(("forward", "lighter"), [(True, 1.0), (False, 1.0), (True, 4.0)])
def test_motor_side_pd_as_it_acts_on_rigid_joints(forward, lighter):
    """No spring, no torque feedback."""

    def equations(v, memory, q, dq, q_ref, dq_ref, ddq_ref):
        carried = MODEL.inverse_dynamics(q_ref, dq_ref, ddq_ref) if forward else weight(q_ref)
        return carried + v["Kp"] * (q_ref - q) + v["Kd"] * (dq_ref - dq), memory

    law = MotorSidePD(MODEL, *GAINS, 1e4, ARM.armature, forward, lighter)
    form = law_forms.MOTOR_PD.of(law, ARM)
    check_law(form, law, equations)
    assert form.digest == f"motor-pd feedforward={forward}"


FRICTION = tuple(JointFriction(Direction(2.0 + i, 0.5), Direction(1.0, 0.2 + i), 0.3 * i) for i in range(ARM.n))


@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize(
    ("name", "kind"), [("inverse-dynamics", law_forms.INVERSE_DYNAMICS), ("pid", law_forms.PID_LAW)]
)
def test_friction_around_a_law(name, kind, measured):
    inner = made(name)
    law = FrictionCompensation(inner, FRICTION, 0.5, measured)  # so wide that the speeds show its shape
    form = law_forms.FrictionForm(law, kind.of(inner, ARM))
    check_beside(form, law, {"law_effort": 50.0})
    assert form.digest == f"{form.inner.digest} + {'friction-measured' if measured else 'friction'}"
    assert not hasattr(form, "signals")


def test_friction_around_a_law_has_its_signals():
    adaptive = made("adaptive")
    wrapped = law_forms.FrictionForm(FrictionCompensation(adaptive, FRICTION), AdaptiveForm.of(adaptive, ARM))
    assert wrapped.signals(np.zeros((3, 10))).keys() == {"adapted_payload"}


def test_a_stribeck_curve_is_refused():
    falling = JointFriction(*(Direction(1.0, 0.1, 2.0, 0.05),) * 2)
    law = FrictionCompensation(made("inverse-dynamics"), (*FRICTION[:2], falling, *FRICTION[3:]))
    with pytest.raises(OptionError, match="friction of joint 3: a Stribeck curve; allowed: in kernels Coulomb"):
        law_forms.law_form(law, ARM)
