"""Motor-side PD against its equations, written out with the recursion of road B; slips planted in it are caught."""

from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.gains import Linearised
from lwr_dyn.control.laws import motor_side
from lwr_dyn.control.laws.motor_side import MotorSidePD, tuned_motor_side_pd
from lwr_dyn.control.protocol import JointReadings, WithJointSensors, WithMemory
from lwr_dyn.design.elastic_loop import ElasticArm, continuous_poles
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.transmission import JointElasticity
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import joint_waves
from tests.slips import uncaught

WORST_CASE = np.array([3.00451, 2.99244, 0.60745, 0.59539, 0.16877, 0.16404, 0.16048])
LAW = "lwr_dyn.control.laws.motor_side"
RNG = np.random.default_rng(26)
q, dq, theta, dtheta, gear = RNG.uniform(-1, 1, (5, 7)) * [[1.0], [1.0], [1.0], [1.0], [30.0]]
FIRST, SECOND = RNG.uniform(-1, 1, (2, 3, 7))
"""Two samples of a reference, q, dq and ddq each."""
Kp, Kd, K = RNG.uniform(1, 100, (3, 7)) * [[10.0], [1.0], [100.0]]


@cache
def arm():
    return lwr_dyn.load("lwr4plus", reading="physical")


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


def check(law):
    for feedforward in (True, False):
        for r in (1.0, 2.5):
            found = law.MotorSidePD(lwr_dyn.dynamics_of(arm()), Kp, Kd, K, arm().armature, feedforward, r)
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
    weak = law.MotorSidePD(lwr_dyn.dynamics_of(arm()), Kp, Kd, K)
    series = 1 / (1 / Kp + 1 / K)
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


def test_the_law_is_the_written_one():
    check(motor_side)


SLIPS = (
    ("q_ref + bend - seen.theta", "q_ref - seen.theta"),
    ("bend - seen.theta)", "bend - seen.q)"),  # the wrong side of the gear
    ("self._bend_rate - seen.dtheta", "self._bend_rate - seen.dq"),
    ("dq_ref + self._bend_rate", "dq_ref"),
    ("bend -= self.rotor * self._compliance * ddq_ref", "bend -= 0.0"),  # the link does not carry its rotor
    ("readings.theta is readings.q", "readings.theta is not readings.q"),
    ("self.Kp * (q_ref - q)", "self.Kp * (q - q_ref)"),
    ("diagonal(r * self.Kp, k)", "diagonal(self.Kp, k)"),
    ("diagonal(r * self.Kd, k)", "diagonal(self.Kd / r, k)"),
    (", motor=True", ", motor=False"),
    ("1.0 / self.Kp + self._compliance", "1.0 / self.Kp"),
)


@pytest.mark.slow
def test_planted_slips_are_caught():
    assert not uncaught(LAW, SLIPS, check)


def test_at_rest_the_reference_is_an_equilibrium_of_the_elastic_arm():
    law = tuned_motor_side_pd(arm(), lwr_dyn.dynamics_of(arm()), inertia=WORST_CASE, lighter=2.0)
    pose, still = q, np.zeros(7)
    gravity = links().gravity_vector(pose)
    law.sense(JointReadings(pose + gravity / arm().elasticity.stiffness, still, pose, still, gravity))
    close(law(0.0, pose, still, pose, still, still), gravity)


def test_where_the_statement_ends_the_pole_crosses():
    """`static_margin` is above 0 where all poles of the continuous loop lie in the left half, for soft springs too."""
    dynamics, rotor = lwr_dyn.dynamics_of(arm()), arm().armature
    poses = RNG.uniform(arm().lower, arm().upper, (40, 7))
    signs = []
    for stiffness, Kp in ((1e4, 25.0), (60.0, 60.0), (25.0, 300.0)):
        law = MotorSidePD(dynamics, Kp, 5.0, stiffness, rotor)
        plant = ElasticArm(dynamics, JointElasticity(np.full(7, stiffness), np.full(7, 1e-3 * stiffness)), rotor)
        largest = continuous_poles(plant.loop(law, poses))[:, 0].real
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
        return tuned_motor_side_pd(arm(), lwr_dyn.dynamics_of(arm()), inertia=WORST_CASE, **options)

    law, lighter = tuned(omega_n=20.0, gear_stiffness=3e4), tuned(omega_n=20.0, lighter=2.0)
    assert law.stiffness.tolist() == [3e4] * 4 + [1.8e4] * 3
    close(law.Kp, 400.0 * WORST_CASE)
    close(lighter.Kp, 400.0 * (WORST_CASE - arm().armature / 2))
    wam = lwr_dyn.load("wam7")  # its file gives no stiffness
    given = make_controller("motor-pd", wam, gear_stiffness=1e4, inertia=np.ones(wam.n))
    assert given.stiffness.tolist() == [1e4] * wam.n


def test_rotors_without_inertia_bear_no_torque_feedback():
    with pytest.raises(OptionError, match="lighter"):
        MotorSidePD(lwr_dyn.dynamics_of(arm()), 1.0, 1.0, 1e4, lighter=2.0)
