"""Matrices of arms with elastic joints: poles at t = 5 s of IST, shares of the joint box, cases known by hand."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import LinearFeedback
from lwr_dyn.control.laws.motor_side import MotorSidePD
from lwr_dyn.control.paper_laws import tuned_inverse_dynamics
from lwr_dyn.design.elastic_loop import ElasticArm, at_rest, continuous_poles
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, Sampling
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.model.transmission import JointElasticity
from tests.design.margin_cases import BENT, arm, dynamics, law, springs

COLUMNS = (("pd-gravity", "link"), ("inverse-dynamics", "link"), ("motor-pd", "motor"), ("inverse-dynamics", "motor"))
AT_ONCE, LATE = Sampling(1000.0), Sampling(1000.0, 1)


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
    ("K", "damping_time", "expected"),
    [
        (1e4, 1e-3, [58.8, 12.4, -23.2, -29.2]),
        (1.5e4, 1e-3, [38.3, -4.0, -26.9, -37.4]),
        (2e4, 1e-3, [15.1, -20.8, -26.9, -38.4]),
        (3e4, 1e-3, [-27.0, -48.8, -26.9, -39.7]),
        (1e4, 0.0, [118.6, 50.0, -0.05, -0.05]),
        (1e4, 3e-4, [100.7, 36.6, -21.4, -28.9]),
        (1e4, 2e-3, [-1.2, -22.3, -25.5, -29.6]),
    ],
)
def test_poles_frozen_at_five_seconds_of_ist_hang_on_stiffness_and_damping(K, damping_time, expected):
    np.testing.assert_allclose(poles_of_the_moment(K, damping_time), expected, atol=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("K", [1e4, 3e4])
def test_unstable_shares_of_the_joint_box(K):
    """Of 300 poses, continuous and at 1 kHz: where joints are soft all on the link side; where all loops are stable at
    t = 5 s of IST, a tenth with PD there. On the motor side sampling spares PD, and not inverse dynamics."""
    q, shares = np.random.default_rng(0).uniform(arm().lower, arm().upper, (300, 7)), []
    for name, side in COLUMNS:
        loop = ElasticArm(dynamics(), springs(K), arm().armature, side).loop(law(name), q)
        growing = continuous_poles(loop)[:, 0].real > 0.0
        shares.append((growing.mean(), (loop.radius(AT_ONCE) > GROWS).mean()))
    pd, by_model, motor, model_at_motor = shares
    if K == 1e4:
        assert (pd, by_model) == ((1.0, 1.0), (1.0, 1.0))
    else:
        assert max(poles_of_the_moment(K)) < 0.0
        assert (0.05 < pd[0] < 0.17, 0.27 < pd[1] < 0.44, by_model) == (True, True, (0.0, 0.0))
    assert (motor, model_at_motor[0], 0.03 < model_at_motor[1] < 0.2) == ((0.0, 0.0), 0.0, True)


def test_one_late_sample_makes_motor_side_pd_unstable_at_these_gains_and_light_rotors_any():
    """The rotor alone, late by a sample, needs T Kd / B_m < 1, and Kd of joint 1 is 300 N m s/rad."""
    loop = ElasticArm(dynamics(), springs(1e4), arm().armature).loop(law("motor-pd"), moment().q)
    assert law("motor-pd").Kd[0] / arm().armature[0] > 1000.0
    assert loop.radius(AT_ONCE)[0] < 1.0 < loop.radius(LATE)[0]
    slower = law("motor-pd", omega_n=25.0)
    assert ElasticArm(dynamics(), springs(1e4), arm().armature).loop(slower, moment().q).radius(LATE)[0] < 1.0
    light = ElasticArm(dynamics("computed"), springs(1e4), arm("computed").armature)
    loop = light.loop(law("motor-pd", "computed"), moment().q)
    assert continuous_poles(loop)[0, 0].real < 0.0
    assert all(loop.radius(Sampling(rate))[0] > 10.0 for rate in (1e3, 1e4))


def test_torque_feedback_is_a_lighter_rotor():
    r, q = 2.5, moment().q
    shaped = MotorSidePD(dynamics(), law("motor-pd").Kp, law("motor-pd").Kd, 1e4, arm().armature, lighter=r)
    found = continuous_poles(ElasticArm(dynamics(), springs(1e4), arm().armature).loop(shaped, q))
    plant = ElasticArm(lighter_rotors(r), springs(1e4), arm().armature / r)
    np.testing.assert_allclose(found, continuous_poles(plant.loop(law("motor-pd"), q)), rtol=1e-7, atol=1e-5)


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
    for each in (law("pd-gravity"), law("pid"), tuned_inverse_dynamics(arm(), dynamics(), xi=0.7)):
        rigid = continuous_poles(RestingLoop.of(dynamics(), each, q))[0]
        gaps = []
        for K in (1e6, 1e7):
            elastic = continuous_poles(ElasticArm.of(arm(), springs(K), "motor").loop(each, q))[0]
            gaps.append(max(np.abs(elastic - pole).min() for pole in rigid if abs(pole) < 100.0))
        assert gaps[1] < 0.11 * gaps[0] + 1e-10  # the rounding of poles
        assert gaps[0] < 0.9
    rigid = RestingLoop.of(dynamics(), law("motor-pd"), q)
    shaped = MotorSidePD(dynamics(), law("motor-pd").Kp, law("motor-pd").Kd, 1e4, arm().armature, lighter=3.0)
    found = continuous_poles(RestingLoop.of(dynamics(), shaped, q))
    np.testing.assert_allclose(found, continuous_poles(rigid), rtol=1e-8)


def test_the_linear_form_at_rest_is_the_frozen_loop_there():
    """A law's `linear_feedback` against differences of its torque, on both sides of the gear."""
    still = at_rest(BENT[None])
    for name, side in (*COLUMNS[:3], ("pd-gravity", "motor")):
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
    spring = JointElasticity(np.array([24.0]), np.array([3.0]))
    free = ElasticArm(rigid, spring, rotor).plant(at_rest(q))
    poles = np.sort_complex(np.linalg.eigvals(free.A[0]))
    np.testing.assert_allclose(poles[:2], [-1 - 1j * np.sqrt(15), -1 + 1j * np.sqrt(15)], rtol=1e-7)
    np.testing.assert_allclose(poles[2:], 0.0, atol=1e-6)
    read = {side: ElasticArm(rigid, spring, rotor, side).plant(at_rest(q)) for side in ("motor", "link")}
    assert read["motor"].position.tolist() == [[0, 1, 0, 0]]
    assert read["link"].velocity.tolist() == [[0, 0, 1, 0]]
    np.testing.assert_array_equal(read["link"].torque[0], [[-24.0, 24.0, -3.0, 3.0]])
    # Kp on the motor side of a joint without damping is stable
    gain = LinearFeedback(np.full((1, 1, 1), 5.0), np.full((1, 1, 1), 1.0))
    assert continuous_poles(RestingLoop.of_plant(read["motor"], gain, q))[0, 0].real < 0.0


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: ElasticArm.of(arm(), encoders="both"), OptionError, "encoders"),
        (lambda: ElasticArm(dynamics(), springs(1e4), np.where(np.arange(7) == 2, 0.0, 0.16)), OptionError,
         "rotor inertia of joint 3: 0 kg"),
        (lambda: ElasticArm.of(lwr_dyn.load("wam7")), MissingDataError, "stiffness"),
        (lambda: ElasticArm.of(arm(), -1e4), OptionError, "stiffness"),
        (lambda: ElasticArm(FLAT, springs(1e4), arm().armature).plant(at_rest(BENT[None])), OptionError, "singular"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(make, error, words):
    with pytest.raises(error, match=words):
        make()


FLAT = SimpleNamespace(n=7, mass_matrix=lambda q: np.diag(arm().armature) + 0 * q[..., None])
