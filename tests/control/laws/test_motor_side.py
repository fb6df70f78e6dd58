"""Laws on the motor side of elastic joints: PD against its equations, and what the wrapper gives an inner law."""

from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.gains import Linearised
from lwr_dyn.control.laws.motor_side import MotorSide, MotorSidePD, tuned_motor_side_pd
from lwr_dyn.control.paper_laws import PID
from lwr_dyn.control.protocol import JointReadings, WithJointSensors, WithMemory, describe, reset
from lwr_dyn.design.elastic_loop import ElasticArm, at_rest, continuous_poles
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.transmission import JointElasticity
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import joint_waves

WORST_CASE = np.array([3.00451, 2.99244, 0.60745, 0.59539, 0.16877, 0.16404, 0.16048])
RNG = np.random.default_rng(26)
q, dq, theta, dtheta, gear = RNG.uniform(-1, 1, (5, 7)) * [[1.0], [1.0], [1.0], [1.0], [30.0]]
FIRST, SECOND = RNG.uniform(-1, 1, (2, 3, 7))
"""Two samples of a reference, q, dq and ddq each."""
Kp, Kd, K = RNG.uniform(1, 100, (3, 7)) * [[10.0], [1.0], [100.0]]


@cache
def arm():
    return lwr_dyn.load("lwr4plus", reading="physical")


@cache
def dynamics():
    return lwr_dyn.dynamics_of(arm())


@cache
def links():
    """Dynamics of the links alone, by road B."""
    return lwr_dyn.dynamics_of(arm(), "newton-euler", rotors="none")


def written_out(reference, bend_rate, feedforward, r):
    """The law's torque for one sample of the reference."""
    q_d, dq_d, ddq_d = reference
    B = arm().armature
    tau_d = links().inverse_dynamics(q_d, dq_d, ddq_d) if feedforward else links().gravity_vector(q_d)
    u = tau_d + feedforward * B / r * ddq_d + Kp * (q_d + tau_d / K - theta) + Kd * (dq_d + bend_rate - dtheta)
    return u + (r - 1) * (u - gear)


def test_the_torque_of_the_motor_side_pd_is_that_written_out():
    for feedforward in (True, False):
        for r in (1.0, 2.5):
            found = MotorSidePD(dynamics(), Kp, Kd, K, arm().armature, feedforward, r)
            for _ in range(2):  # the second time after a reset
                rigid = B_y(FIRST, feedforward) + Kp * (FIRST[0] - q) + Kd * (FIRST[1] - dq)
                found.sense(JointReadings(q, dq, q, dq, gear))
                close(found(0.0, q, dq, *FIRST), rigid)
                found.sense(JointReadings(theta, dtheta, q, dq, gear))
                close(found(0.0, q, dq, *FIRST), written_out(FIRST, 0.0, feedforward, r))
                bends = [links().inverse_dynamics(*x) / K for x in (FIRST, SECOND)]
                rate = feedforward * (bends[1] - bends[0]) / 0.25
                for t in (0.25, 0.25):  # the same sample once more
                    close(found(t, q, dq, *SECOND), written_out(SECOND, rate, feedforward, r))
                found.reset()
            check_linear_form(found)
    poses = RNG.uniform(-1, 1, (3, 7))
    weak = MotorSidePD(dynamics(), Kp, Kd, K)
    series = 1 / (1 / Kp + 1 / K)
    assert (weak.feedforward, weak.lighter, weak.rotor.tolist()) == (True, 1.0, [0.0] * 7)
    for pose, margin in zip(poses, weak.static_margin(poses), strict=True):
        step = 1e-5 * np.eye(7)
        slope = (links().gravity_vector(pose + step) - links().gravity_vector(pose - step)) / 2e-5
        assert margin == pytest.approx(np.linalg.eigvalsh((slope + slope.T) / 2 + np.diag(series))[0], abs=1e-4)


def check_linear_form(law):
    """The torque near rest is linear in the motor's side and in the torque sensor, as `linear_feedback` says."""
    form = law.linear_feedback(q[None])
    assert form.motor
    rest = (q, np.zeros(7), np.zeros(7))
    x, v, s = RNG.uniform(-1, 1, (3, 7))

    def torque(sign):
        law.reset()
        law.sense(JointReadings(theta + sign * x, dtheta + sign * v, q, dq, gear + sign * s))
        return law(0.0, q, dq, *rest)

    expected = -form.position[0] @ x - form.velocity[0] @ v
    expected -= 0.0 if form.torque is None else form.torque[0] @ s
    close((torque(1.0) - torque(-1.0)) / 2, expected)


def B_y(reference, feedforward):
    q_d, dq_d, ddq_d = reference
    if not feedforward:
        return links().gravity_vector(q_d)
    return links().inverse_dynamics(q_d, dq_d, ddq_d) + arm().armature * ddq_d


def close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-9)


def test_where_the_statement_ends_the_pole_crosses():
    """`static_margin` is above 0 where all poles of the continuous loop lie in the left half, for soft springs too."""
    poses, signs = RNG.uniform(arm().lower, arm().upper, (40, 7)), []
    for stiffness, Kp in ((1e4, 25.0), (60.0, 60.0), (25.0, 300.0)):
        law = MotorSidePD(dynamics(), Kp, 5.0, stiffness, arm().armature)
        springs = JointElasticity(np.full(7, stiffness), np.full(7, 1e-3 * stiffness))
        largest = continuous_poles(ElasticArm(dynamics(), springs, arm().armature).loop(law, poses))[:, 0].real
        np.testing.assert_array_equal(law.static_margin(poses) > 0.0, largest < 0.0)
        signs += (largest < 0.0).tolist()
    assert 0.2 < np.mean(signs) < 0.8


@pytest.mark.parametrize("continuous", [False, True])
def test_a_rigid_arm_is_followed_without_deflection(continuous):
    law = make_controller("motor-pd", arm(), inertia=WORST_CASE, lighter=3.0)
    assert isinstance(law, WithMemory)
    assert isinstance(law, WithJointSensors)
    assert isinstance(law, Linearised)
    run = simulate(arm(), law, joint_waves(0.5), continuous=continuous)
    assert np.abs(run.q - run.q_ref).max() < (1e-10 if continuous else 1e-5)


def test_what_it_is_made_of_is_told():
    def tuned(**options):
        return tuned_motor_side_pd(arm(), dynamics(), inertia=WORST_CASE, **options)

    law, lighter = tuned(omega_n=20.0, gear_stiffness=3e4), tuned(omega_n=20.0, lighter=2.0)
    assert law.stiffness.tolist() == [3e4] * 4 + [1.8e4] * 3
    close(law.Kp, 400.0 * WORST_CASE)
    close(lighter.Kp, 400.0 * (WORST_CASE - arm().armature / 2))
    wam = lwr_dyn.load("wam7")  # its file gives no stiffness
    given = make_controller("motor-pd", wam, gear_stiffness=1e4, inertia=np.ones(wam.n))
    assert given.stiffness.tolist() == [1e4] * wam.n


def test_rotors_without_inertia_bear_no_torque_feedback():
    with pytest.raises(OptionError, match="lighter"):
        MotorSidePD(dynamics(), 1.0, 1.0, 1e4, lighter=2.0)


GEAR = RNG.uniform(1e2, 1e3, 7)


class Kept:
    """A law that keeps what it is given and sensed, and counts resets."""

    name = "kept"

    def __init__(self):
        self.given, self.sensed, self.resets = None, None, 0

    def __call__(self, t, *state):
        self.given = (t, *state)
        return np.arange(7.0)

    def sense(self, readings):
        self.sensed = readings

    def reset(self):
        self.resets += 1


def test_the_inner_law_is_given_the_links_whatever_the_encoders_read():
    kept = Kept()
    law = MotorSide(kept, dynamics(), GEAR)
    elastic, rigid = JointReadings(theta, dtheta, q, dq, gear), JointReadings(q, dq, q, dq, gear)
    gravity = lwr_dyn.dynamics_of(arm(), "newton-euler").gravity_vector(FIRST[0])
    law.sense(elastic)
    assert kept.sensed is elastic
    for given_q, given_dq in ((q, dq), (theta, dtheta)):  # whatever the encoders read
        assert law(0.5, given_q, given_dq, *FIRST).tolist() == list(range(7))
        expected = (0.5, theta - gravity / GEAR, dtheta, *FIRST)
        for found, value in zip(kept.given, expected, strict=True):
            np.testing.assert_allclose(found, value, rtol=1e-12, atol=1e-12)
    reset(law)
    assert kept.resets == 1
    for sensed in (None, rigid):
        if sensed is not None:
            law.sense(sensed)
        law(0.5, q, dq, *FIRST)
        np.testing.assert_array_equal(kept.given[1:3], (q, dq))
    by_model = MotorSide(make_controller("inverse-dynamics", arm()), dynamics(), GEAR).linear_feedback(q[None])
    assert by_model.motor
    np.testing.assert_array_equal(
        by_model.position, make_controller("inverse-dynamics", arm()).linear_feedback(q[None]).position
    )


def test_the_reference_is_an_equilibrium_of_the_elastic_arm():
    """Both laws ask for g at rest on it; poles of inverse dynamics stay where they are without the wrapper."""
    law, plain = (make_controller(name, arm()) for name in ("inverse-dynamics+motor-side", "inverse-dynamics"))
    gravity, still = links().gravity_vector(q), np.zeros(7)
    for each in (law, tuned_motor_side_pd(arm(), dynamics(), inertia=WORST_CASE, lighter=2.0)):
        each.sense(JointReadings(q + gravity / arm().elasticity.stiffness, still, q, still, gravity))
        close(each(0.0, q, still, q, still, still), gravity)
    loops = [ElasticArm.of(arm()).loop(each, at_rest(q[None]).q) for each in (law, plain)]
    np.testing.assert_allclose(*(continuous_poles(loop) for loop in loops))


def test_interfaces_of_the_inner_law_stay():
    assert not isinstance(MotorSide(lambda *_: np.zeros(7), dynamics(), 1e4), Linearised)
    law = make_controller("pid+motor-side+motor-side", arm(), inertia=np.ones(7), gear_stiffness=3e4)
    assert isinstance(law, WithJointSensors)
    assert law.memory_size == 7
    assert law.torque_and_rate.__func__ is PID.torque_and_rate
    assert describe(law)["name"] == "pid+motor-side+motor-side"
    assert describe(law)["parameters"]["gear_stiffness"] == [3e4] * 4 + [1.8e4] * 3
