"""Friction compensation and hand guiding: the formulas, what passes through a wrapper, the names, what it is worth."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import CONTROLLERS, make_controller, split_name
from lwr_dyn.control.gains import Linearised
from lwr_dyn.control.laws.friction_compensation import (
    FrictionCompensation,
    HandGuiding,
    with_friction,
    with_measured_friction,
)
from lwr_dyn.control.protocol import WithMemory, describe, reset
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.model.friction import Direction, JointFriction, smooth_friction, symmetric
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.control.laws.written_out import REGULAR, states

BARE = lwr_dyn.load("lwr4plus", reading="physical")
LEVELS = np.linspace(2.0, 0.5, 7)
ARM = replace(BARE, friction=tuple(symmetric(level, 0.5) for level in LEVELS))
DYNAMICS = lwr_dyn.dynamics_of(ARM)
RNG = np.random.default_rng(5)
STATE = RNG.uniform(-1, 1, (5, 7))


def inner(name="inverse-dynamics", **options):
    return make_controller(name, ARM, DYNAMICS, **options)


def test_friction_of_the_wrapped_law_is_by_the_formula():
    """Both forms against friction written out, for a joint with an offset and two directions."""
    one = JointFriction(Direction(2.0, 0.3), Direction(1.0, 0.7), offset=0.25)
    law, width, v = inner(), 0.05, STATE[[1, 3]]
    for measured, speed in ((False, v[1]), (True, v[0])):
        given = FrictionCompensation(law, [one] * 7, width, measured)
        coulomb, viscous = (np.where(speed > 0, a, b) for a, b in ((2.0, 1.0), (0.3, 0.7)))
        expected = law(0.0, *STATE) + 0.25 + coulomb * np.tanh(speed / width) + viscous * speed
        np.testing.assert_allclose(given(0.0, *STATE), expected, rtol=0, atol=1e-12)
    form, q = given.linear_feedback(STATE[:2]), law.linear_feedback(STATE[:2])
    np.testing.assert_allclose(q.velocity - form.velocity, [np.eye(7) * (1.5 / width + 0.5)] * 2, rtol=1e-5, atol=1e-12)
    np.testing.assert_array_equal(form.position, q.position)
    by_name = with_friction(law, ARM, DYNAMICS)
    for plain in (by_name, FrictionCompensation(law, ARM.friction)):
        assert (plain.measured, plain.width) == (False, 1e-3)
    np.testing.assert_array_equal(by_name.torque(np.ones(7)), LEVELS + 0.5)
    assert with_measured_friction(law, ARM, DYNAMICS).measured


@pytest.mark.parametrize("name", ["pd-gravity", "pid", "inverse-dynamics"])
def test_any_law_can_be_wrapped(name):
    known = {} if name == "inverse-dynamics" else {"inertia": np.ones(7)}
    law, wrapped = inner(name, **known), inner(f"{name}+friction", **known)
    assert isinstance(wrapped, FrictionCompensation)
    for t in (0.0, 0.5):  # with what it remembers
        added = wrapped(t, *STATE) - law(t, *STATE)
        np.testing.assert_allclose(added, wrapped.torque(STATE[3]), rtol=0, atol=1e-9)
    reset(wrapped)
    reset(law)
    np.testing.assert_allclose(wrapped(0.7, *STATE) - law(0.7, *STATE), added, rtol=0, atol=1e-9)
    assert isinstance(wrapped, Linearised)
    for test in (lambda x: isinstance(x, WithMemory), lambda x: hasattr(x, "reset")):
        assert test(wrapped) == test(law)
    record = json.loads(json.dumps(describe(wrapped)))
    assert record["name"] == f"{name}+friction"
    assert record["parameters"]["friction"]["joints"][0]["positive"]["coulomb"] == 2.0
    np.testing.assert_array_equal(wrapped.Kp, law.Kp)


def test_names_with_wrappers():
    assert split_name("pid") == ("pid", ())
    assert split_name("pid+friction+observer") == ("pid", ("friction", "observer"))
    assert split_name("a+b/mine.py") == ("a+b/mine.py", ())
    assert split_name("a+b/mine.py+friction") == ("a+b/mine.py", ("friction",))
    both = {"friction_width": 0.5, "observer_gain": 30.0}
    twice = make_controller("inverse-dynamics+friction+observer", ARM, omega_n=20.0, **both)
    assert twice.name == "inverse-dynamics+friction+observer"
    assert (twice.width, twice.inner.width, twice.Kp[0]) == (0.5, 0.5, 400.0)
    assert twice.parameters["observer"]["gain"] == [30.0] * ARM.n
    with pytest.raises(AttributeError):
        twice.nothing  # noqa: B018
    assert set(split_name(name)[0] for name in CONTROLLERS.names) == set(CONTROLLERS.names)


def test_a_file_can_be_wrapped_and_friction_that_is_given_takes_the_place_of_the_arms(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("def controller(t, q, dq, q_ref, dq_ref, ddq_ref):\n    return 0 * q\n")
    wrapped = make_controller(f"{path}+friction", ARM)
    assert describe(wrapped)["name"] == "mine.py+friction"
    np.testing.assert_array_equal(wrapped(0.0, *STATE), wrapped.torque(STATE[3]))
    law = make_controller("inverse-dynamics+friction", BARE, friction=[symmetric(1.0, 0.0)] * 7)
    np.testing.assert_allclose(law.torque(np.ones(7)), 1.0)


@pytest.mark.slow
def test_the_reference_side_wins_where_joints_turn_round():
    """Dry friction with true stick, inverse dynamics: error of the joints on a move there and back."""
    points = np.array([np.zeros(7), np.full(7, 0.6), np.zeros(7)])
    move = point_to_point(ARM, points, [1.0, 1.0])
    error = {}
    for name in ("inverse-dynamics", "inverse-dynamics+friction", "inverse-dynamics+friction-measured"):
        run = lwr_dyn.simulate(ARM, make_controller(name, ARM, DYNAMICS), move)
        error[name.rpartition("+")[2]] = np.sqrt(np.mean((run.q - run.q_ref) ** 2))
    assert error["friction"] < 0.05 * error["inverse-dynamics"]
    assert error["friction"] < error["friction-measured"] < 0.5 * error["inverse-dynamics"]


WAM = lwr_dyn.load("wam7")
ROAD_A, ROAD_B = (lwr_dyn.dynamics_of(WAM, engine) for engine in ("pinocchio", "newton-euler"))


def test_hand_guiding_is_gravity_friction_and_damping():
    controller = HandGuiding(WAM, ROAD_A, fading=2.0, share=0.7, width=0.05)
    friction = smooth_friction(WAM.friction_models(), 0.05)
    for q, dq, *rest in states(WAM):
        expected = ROAD_B.gravity_vector(q) + 0.7 * friction(dq) - 2.0 * ROAD_B.mass_matrix(q) @ dq
        np.testing.assert_allclose(controller(0.0, q, dq, *rest), expected, atol=1e-10)
    partly = replace(WAM, friction=(WAM.friction[0], *[None] * 6))
    assert [HandGuiding(x, ROAD_A).share for x in (WAM, partly, BARE)] == [0.8, 0.8, 0.0]  # as far as it is known
    with pytest.raises(ShapeError, match="fading"):
        HandGuiding(WAM, ROAD_A, fading=[1.0, 2.0])


@pytest.mark.slow
def test_a_motion_left_alone_fades_at_the_rate_and_the_arm_stays_where_it_is_left(arm):
    hold = lwr_dyn.reference("hold", arm, q=REGULAR, duration=0.5)
    law = lwr_dyn.controller("hand-guiding", arm, fading=3.0)
    run = lwr_dyn.simulate(arm, law, hold, dq0=[0.05] * 7, continuous=True, friction="none")
    energy = np.einsum("ki,kij,kj->k", run.dq, lwr_dyn.dynamics_of(arm).mass_matrix(run.q), run.dq)
    np.testing.assert_allclose(energy, energy[0] * np.exp(-6.0 * run.t), rtol=1e-6)
    np.testing.assert_allclose(lwr_dyn.simulate(arm, law, hold).q[-1], REGULAR, atol=1e-9)


def test_compensated_friction_brakes_less():
    start = dict(q0=[0.0, -1.5, 0.0, 1.5, 0.0, 0.0, 0.0], dq0=[0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], duration=0.4)
    hold = lwr_dyn.reference("hold", WAM, q=start["q0"], duration=1.0)
    left = []
    for share in (0.0, 0.5, 0.9):
        law = HandGuiding(WAM, ROAD_A, fading=0.1, share=share)
        left.append(lwr_dyn.simulate(WAM, law, hold, **start, position_limits=False).q[-1, 0])
    assert left[0] < left[1] < left[2]


def test_joints_without_friction_are_left_alone():
    one, rest = symmetric(2.0, 0.5), (None,) * (ARM.n - 1)
    law = with_friction(inner(), ARM, DYNAMICS, friction=(one, *rest))
    state = [np.full(ARM.n, 0.3)] * 5
    torque = law(0.0, *state) - inner()(0.0, *state)
    assert torque[0] == pytest.approx(2.0 + 0.5 * 0.3, rel=1e-6)
    assert torque[1:] == pytest.approx(np.zeros(ARM.n - 1), abs=1e-12)
