"""Laws on the motor side of elastic joints: what the inner law is given; slips planted in it are caught."""

from functools import cache

import numpy as np

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.gains import Linearised
from lwr_dyn.control.laws.motor_side import MotorSide
from lwr_dyn.control.paper_laws import PID
from lwr_dyn.control.protocol import JointReadings, WithJointSensors, describe, reset
from lwr_dyn.design.elastic_loop import ElasticArm, at_rest, continuous_poles
from tests.slips import uncaught

RNG = np.random.default_rng(27)
q, dq, theta, dtheta, gear, q_ref, dq_ref, ddq_ref = RNG.uniform(-1, 1, (8, 7))
REFERENCE = (q_ref, dq_ref, ddq_ref)
K = RNG.uniform(1e2, 1e3, 7)


@cache
def arm():
    return lwr_dyn.load("lwr4plus", reading="physical")


@cache
def dynamics():
    return lwr_dyn.dynamics_of(arm())


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


def check(module):
    kept = Kept()
    law = module.MotorSide(kept, dynamics(), K)
    elastic, rigid = JointReadings(theta, dtheta, q, dq, gear), JointReadings(q, dq, q, dq, gear)
    gravity = lwr_dyn.dynamics_of(arm(), "newton-euler").gravity_vector(q_ref)
    law.sense(elastic)
    assert kept.sensed is elastic
    for given_q, given_dq in ((q, dq), (theta, dtheta)):  # whatever the encoders read
        assert law(0.5, given_q, given_dq, *REFERENCE).tolist() == list(range(7))
        expected = (0.5, theta - gravity / K, dtheta, *REFERENCE)
        for found, value in zip(kept.given, expected, strict=True):
            np.testing.assert_allclose(found, value, rtol=1e-12, atol=1e-12)
    reset(law)
    assert kept.resets == 1
    for sensed in (None, rigid):
        if sensed is not None:
            law.sense(sensed)
        law(0.5, q, dq, *REFERENCE)
        np.testing.assert_array_equal(kept.given[1:3], (q, dq))
    by_model = module.MotorSide(make_controller("inverse-dynamics", arm()), dynamics(), K).linear_feedback(q[None])
    assert by_model.motor
    np.testing.assert_array_equal(
        by_model.position, make_controller("inverse-dynamics", arm()).linear_feedback(q[None]).position
    )


SLIPS = (
    ("seen.theta - self", "seen.q - self"),  # the wrong side of the gear
    ("seen.theta - self._gravity(q_ref) / self.stiffness", "seen.theta"),
    ("self._gravity(q_ref) /", "self._gravity(seen.theta) /"),
    (", seen.dtheta", ", seen.dq"),
    ("readings.theta is readings.q", "False"),
    ("motor=True", "motor=False"),
    ("        self._readings = None\n", ""),
    ("            self._hand_on(readings)", "            pass"),
)


def test_planted_slips_are_caught():
    assert not uncaught("lwr_dyn.control.laws.motor_side", SLIPS, check)


def test_the_reference_is_an_equilibrium_of_the_elastic_arm():
    """Inverse dynamics asks for g at rest on the reference, and its poles stay where they are without the wrapper."""
    law, plain = (make_controller(name, arm()) for name in ("inverse-dynamics+motor-side", "inverse-dynamics"))
    gravity, still = dynamics().gravity_vector(q), np.zeros(7)
    law.sense(JointReadings(q + gravity / arm().elasticity.stiffness, still, q, still, gravity))
    np.testing.assert_allclose(law(0.0, q, still, q, still, still), gravity, atol=1e-9)
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
