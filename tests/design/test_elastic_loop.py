"""Matrices of arms with elastic joints: poles at t = 5 s of IST, shares of the joint box, cases known by hand."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import LinearFeedback
from lwr_dyn.control.laws.motor_side import MotorSidePD, tuned_motor_side_pd
from lwr_dyn.control.paper_laws import tuned_inverse_dynamics, tuned_pd_gravity, tuned_pid
from lwr_dyn.design.elastic_loop import ElasticArm, at_rest, continuous_poles
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, Sampling
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.model.transmission import JointElasticity

B_MAX = np.array([3.00451, 2.99244, 0.60745, 0.59539, 0.16877, 0.16404, 0.16048])
"""Largest inertias of the reading `physical` [kg m^2], as `lwr-dyn gains` finds them."""
COLUMNS = (("pd", "link"), ("id", "link"), ("motor", "motor"), ("id", "motor"))


@cache
def arm(reading="physical"):
    return lwr_dyn.load("lwr4plus", reading=reading)


@cache
def dynamics():
    return lwr_dyn.dynamics_of(arm())


@cache
def law(name):
    if name == "id":
        return tuned_inverse_dynamics(arm(), dynamics())
    return {"pd": tuned_pd_gravity, "pid": tuned_pid, "motor": tuned_motor_side_pd}[name](
        arm(), dynamics(), inertia=B_MAX
    )


def springs(K, damping_time=1e-3):
    """K, 0.6 of it on the wrist, D = damping_time K: all three pinned here, as the signs below hang on them."""
    stiffness = K * np.array([1, 1, 1, 1, 0.6, 0.6, 0.6])
    return JointElasticity(stiffness, damping_time * stiffness)


@cache
def moment():
    return lwr_dyn.reference("ist", arm()).sample(np.array([5.0]))


def poles_of_the_moment(K, damping_time=1e-3):
    """The largest real part [1/s] at t = 5 s of IST of each of `COLUMNS`."""
    found = []
    for name, side in COLUMNS:
        law(name).__class__ is MotorSidePD and law(name).reset()
        plant = ElasticArm(dynamics(), springs(K, damping_time), arm().armature, side)
        found.append(plant.frozen_poles(law(name), moment())[0, 0].real)
    return found


@pytest.mark.parametrize(
    ("K", "expected"),
    [
        (1e4, [58.8, 12.4, -23.2, -29.2]),
        (1.5e4, [38.3, -4.0, -26.9, -37.4]),
        (2e4, [15.1, -20.8, -26.9, -38.4]),
        (3e4, [-27.0, -48.8, -26.9, -39.7]),
    ],
)
def test_poles_frozen_at_five_seconds_of_ist(K, expected):
    np.testing.assert_allclose(poles_of_the_moment(K), expected, atol=0.06)


@pytest.mark.parametrize(
    ("damping_time", "expected"),
    [(0.0, [118.6, 50.0, -0.05, -0.05]), (3e-4, [100.7, 36.6, -21.4, -28.9]), (2e-3, [-1.2, -22.3, -25.5, -29.6])],
)
def test_the_signs_hang_on_the_damping(damping_time, expected):
    np.testing.assert_allclose(poles_of_the_moment(1e4, damping_time), expected, atol=0.06)


@cache
def box_shares(K):
    """Unstable shares of 300 poses of the joint box, continuous and at 1 kHz, of each of `COLUMNS`."""
    q = np.random.default_rng(0).uniform(arm().lower, arm().upper, (300, 7))
    out = []
    for name, side in COLUMNS:
        loop = ElasticArm(dynamics(), springs(K), arm().armature, side).loop(law(name), q)
        growing = continuous_poles(loop)[:, 0].real > 0.0
        out.append((growing.mean(), (loop.radius(Sampling(1000.0)) > GROWS).mean()))
    return out


@pytest.mark.slow
def test_on_the_link_side_all_of_the_box_is_unstable_where_joints_are_soft():
    assert box_shares(1e4)[:2] == [(1.0, 1.0)] * 2


@pytest.mark.slow
def test_stable_at_one_pose_is_not_stable_in_the_box():
    """At 3e4 every loop is stable at t = 5 s of IST, and PD on the link side is unstable in a tenth of the box."""
    assert max(poles_of_the_moment(3e4)) < 0.0
    (pd_continuous, pd_sampled), by_model = box_shares(3e4)[:2]
    assert 0.05 < pd_continuous < 0.17
    assert 0.27 < pd_sampled < 0.44
    assert by_model == (0.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("K", [1e4, 3e4])
def test_on_the_motor_side_sampling_makes_inverse_dynamics_unstable_and_spares_pd(K):
    pd, by_model = box_shares(K)[2:]
    assert pd == (0.0, 0.0)
    assert by_model[0] == 0.0
    assert 0.03 < by_model[1] < 0.2


def test_one_late_sample_makes_motor_side_pd_unstable_at_these_gains():
    """The rotor alone, late by a sample, needs T Kd / B_m < 1, and Kd of joint 1 is 300 N m s/rad."""
    loop = ElasticArm(dynamics(), springs(1e4), arm().armature).loop(law("motor"), moment().q)
    assert law("motor").Kd[0] / arm().armature[0] > 1000.0
    assert loop.radius(Sampling(1000.0))[0] < 1.0 < loop.radius(Sampling(1000.0, 1))[0]
    slower = tuned_motor_side_pd(arm(), dynamics(), inertia=B_MAX, omega_n=25.0)
    loop = ElasticArm(dynamics(), springs(1e4), arm().armature).loop(slower, moment().q)
    assert loop.radius(Sampling(1000.0, 1))[0] < 1.0


def test_rotors_too_light_for_the_step_explode_when_sampled():
    light = arm("computed")
    held = tuned_motor_side_pd(light, lwr_dyn.dynamics_of(light), inertia=B_MAX)
    loop = ElasticArm(lwr_dyn.dynamics_of(light), springs(1e4), light.armature).loop(held, moment().q)
    assert continuous_poles(loop)[0, 0].real < 0.0
    assert loop.radius(Sampling(1000.0))[0] > 10.0
    assert loop.radius(Sampling(10000.0))[0] > 10.0


def test_torque_feedback_is_a_lighter_rotor():
    r, q = 2.5, moment().q
    shaped = MotorSidePD(dynamics(), law("motor").Kp, law("motor").Kd, 1e4, arm().armature, lighter=r)
    found = continuous_poles(ElasticArm(dynamics(), springs(1e4), arm().armature).loop(shaped, q))
    plant = ElasticArm(lighter_rotors(r), springs(1e4), arm().armature / r)
    np.testing.assert_allclose(found, continuous_poles(plant.loop(law("motor"), q)), rtol=1e-7, atol=1e-5)


def lighter_rotors(r):
    """The dynamics of the arm with rotors lighter by r."""
    less = arm().armature * (1 - 1 / r)
    return SimpleNamespace(
        n=7, gravity_vector=dynamics().gravity_vector, mass_matrix=lambda q: dynamics().mass_matrix(q) - np.diag(less),
        inverse_dynamics=lambda q, dq, ddq: dynamics().inverse_dynamics(q, dq, ddq) - less * ddq,
    )  # fmt: skip


def test_stiff_joints_are_a_rigid_arm():
    """The slow poles differ from the rigid ones by order 1/K, with an integral too; torque feedback drops out there."""
    q = moment().q
    for each in (law("pd"), law("pid"), tuned_inverse_dynamics(arm(), dynamics(), xi=0.7)):
        rigid = continuous_poles(RestingLoop.of(dynamics(), each, q))[0]
        gaps = []
        for K in (1e6, 1e7):
            elastic = continuous_poles(ElasticArm.of(arm(), springs(K), "motor").loop(each, q))[0]
            gaps.append(max(np.abs(elastic - pole).min() for pole in rigid if abs(pole) < 100.0))
        assert gaps[1] < 0.11 * gaps[0] + 1e-10  # the rounding of poles
        assert gaps[0] < 0.9
    rigid = RestingLoop.of(dynamics(), law("motor"), q)
    shaped = MotorSidePD(dynamics(), law("motor").Kp, law("motor").Kd, 1e4, arm().armature, lighter=3.0)
    found = continuous_poles(RestingLoop.of(dynamics(), shaped, q))
    np.testing.assert_allclose(found, continuous_poles(rigid), rtol=1e-8)


def test_the_linear_form_at_rest_is_the_frozen_loop_there():
    """A law's `linear_feedback` against differences of its torque, on both sides of the gear."""
    still = at_rest(np.array([[0.3, 1.0, -0.5, -1.4, 0.8, 0.9, 0.0]]))
    for name, side in (("pd", "link"), ("id", "link"), ("motor", "motor"), ("pd", "motor")):
        plant = ElasticArm(dynamics(), springs(1e4), arm().armature, side)
        frozen, formal = plant.frozen_poles(law(name), still), continuous_poles(plant.loop(law(name), still.q))
        np.testing.assert_allclose(frozen, formal, rtol=1e-5, atol=1e-3)


def test_one_joint_known_by_hand():
    """Rotor and link of 2 and 6 kg m^2 on a spring of 24 N m/rad: they swing at sqrt(24 (1/2 + 1/6)) = 4 rad/s."""
    rigid = SimpleNamespace(
        n=1, mass_matrix=lambda q: np.full((*q.shape[:-1], 1, 1), 8.0), gravity_vector=lambda q: 0.0 * q,
        inverse_dynamics=lambda q, dq, ddq: 8.0 * ddq + 0.0 * q * dq,
    )  # fmt: skip
    q, rotor = np.zeros((1, 1)), np.array([2.0])
    free = ElasticArm(rigid, JointElasticity(np.array([24.0]), np.array([3.0])), rotor).plant(at_rest(q))
    poles = np.sort_complex(np.linalg.eigvals(free.A[0]))
    np.testing.assert_allclose(poles[:2], [-1 - 1j * np.sqrt(15), -1 + 1j * np.sqrt(15)], rtol=1e-7)
    np.testing.assert_allclose(poles[2:], 0.0, atol=1e-6)
    read = {side: ElasticArm(rigid, springs_of_one(), rotor, side).plant(at_rest(q)) for side in ("motor", "link")}
    assert read["motor"].position.tolist() == [[0, 1, 0, 0]]
    assert read["link"].velocity.tolist() == [[0, 0, 1, 0]]
    np.testing.assert_array_equal(read["link"].torque[0], [[-24.0, 24.0, -3.0, 3.0]])
    # Kp on the link side of a joint without damping is unstable, on the motor side it is not
    gain = LinearFeedback(np.full((1, 1, 1), 5.0), np.full((1, 1, 1), 1.0))
    growth = {side: continuous_poles(RestingLoop.of_plant(read[side], gain, q))[0, 0].real for side in read}
    assert growth["motor"] < 0.0


def springs_of_one():
    return JointElasticity(np.array([24.0]), np.array([3.0]))


def test_what_cannot_be_is_refused():
    q = moment().q
    with pytest.raises(OptionError, match="encoders"):
        ElasticArm.of(arm(), encoders="both")
    with pytest.raises(OptionError, match="rotor inertia of joint 3: 0 kg"):
        ElasticArm(dynamics(), springs(1e4), np.where(np.arange(7) == 2, 0.0, 0.16))
    with pytest.raises(MissingDataError, match="stiffness"):
        ElasticArm.of(lwr_dyn.load("wam7"))
    with pytest.raises(OptionError, match="stiffness"):
        ElasticArm.of(arm(), -1e4)
    flat = SimpleNamespace(n=7, mass_matrix=lambda q: np.diag(arm().armature) + 0 * q[..., None])
    with pytest.raises(OptionError, match="singular"):
        ElasticArm(flat, springs(1e4), arm().armature).plant(at_rest(q))
