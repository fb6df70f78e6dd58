"""The matrices of elastic joints against differences of their equations by road B; planted slips are caught."""

from functools import cache
from types import ModuleType

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import LinearFeedback
from lwr_dyn.design.sampled_loop import RestingLoop
from lwr_dyn.model.run import Motion
from tests.design.test_elastic_loop import arm, law, springs
from tests.slips import uncaught

RNG = np.random.default_rng(28)
q, dq, ddq = RNG.uniform(-1, 1, (3, 7))
MOTION = Motion(np.zeros(1), q[None], dq[None], ddq[None])
LINKS = lwr_dyn.dynamics_of(arm(), "newton-euler", rotors="none")
SPRINGS, ROTOR = springs(100.0, 0.1), arm().armature  # soft, so that no term is small beside them


def rates(z, u):
    """dz/dt of z = (q, theta, dq, dtheta) under the motors' torques u."""
    x, theta, v, dtheta = z.reshape(4, 7)
    gear = SPRINGS.stiffness * (theta - x) + SPRINGS.damping * (dtheta - v)
    return np.concatenate([v, dtheta, LINKS.forward_dynamics(x, v, gear), (u - gear) / ROTOR])


def differences(function, at, step=1e-5):
    """The matrix of derivatives of a function of a vector."""
    return np.array([(function(at + step * e) - function(at - step * e)) / (2 * step) for e in np.eye(at.size)]).T


THETA = q + LINKS.inverse_dynamics(q, dq, ddq) / SPRINGS.stiffness
Z, STILL = np.concatenate([q, THETA, dq, dq]), np.zeros(7)


@cache
def of_the_plant():
    """A and B."""
    return differences(lambda x: rates(x, STILL), Z), differences(lambda u: rates(Z, u), STILL)


@cache
def of_the_loop(side):
    """A of the loop with PD."""
    seen = [1, 3] if side == "motor" else [0, 2]
    return differences(lambda x: rates(x, law("pd")(0.0, *x.reshape(4, 7)[seen], q, dq, ddq)), Z)


def check(module: ModuleType):
    A, B = of_the_plant()
    any_z = np.arange(28.0)
    for side, first in (("motor", 7), ("link", 0)):
        elastic = module.ElasticArm(lwr_dyn.dynamics_of(arm()), SPRINGS, ROTOR, side)
        plant = elastic.plant(MOTION)
        close(plant.A[0], A)
        close(plant.B[0], B)
        close(plant.position @ any_z, any_z[first : first + 7])
        close(plant.velocity @ any_z, any_z[first + 14 : first + 21])
        close(plant.torque[0] @ Z, SPRINGS.stiffness * (THETA - q))
        close(elastic.spring_side(MOTION)[0], THETA)
        found = elastic.frozen_poles(law("pd"), MOTION)[0]
        close(found, np.linalg.eigvals(of_the_loop(side)), any_order=True)
    gains = RNG.uniform(1, 9, (3, 1, 7, 7))
    form = LinearFeedback(*gains[:2], integral=np.arange(1.0, 8.0), torque=gains[2])
    back = gains[0, 0] @ plant.position + gains[1, 0] @ plant.velocity + gains[2, 0] @ plant.torque[0]
    by_hand = np.zeros((35, 35))
    by_hand[:28, :28], by_hand[:28, 28:] = plant.A[0] - plant.B[0] @ back, plant.B[0]
    by_hand[28:, :28] = -np.diag(form.integral) @ plant.position
    found = module.continuous_poles(RestingLoop(plant, form))[0]
    close(found, np.linalg.eigvals(by_hand), any_order=True)
    assert (np.diff(found.real) <= 0.0).all()
    reads = elastic.loop(law("motor"), q[None])  # the motor side, whatever the encoders are
    close(reads.plant.position @ any_z, any_z[7:14])


def close(found, expected, any_order=False):
    if any_order:
        assert max(np.abs(expected - pole).min() for pole in found) <= 1e-5 * np.abs(expected).max()
        return
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())


SLIPS = (
    ("- np.diag(self.rotor)", "+ np.diag(self.rotor)"),
    ("np.hstack([-K, K, -D, D])", "np.hstack([K, -K, -D, D])"),
    ("np.hstack([-K, K, -D, D])", "np.hstack([-K, K, D, -D])"),
    (":n] -= inverse @ by_q", ":n] += inverse @ by_q"),
    (" -= inverse @ by_dq", " -= 0.0"),
    ("= -gear / self.rotor", "= gear / self.rotor"),
    (", one / self.rotor[:, None]", ", one"),
    ("n * motor), np", "n * (not motor)), np"),
    ("n * (2 + motor))", "n * (3 - motor))"),
    ("- self.rotor * motion.ddq", "+ self.rotor * motion.ddq"),
    ("torque / self.elasticity.stiffness", "torque * 0.0"),
    ('(theta, dtheta) if self.encoders == "motor"', '(theta, dtheta) if self.encoders == "link"'),
    ("plant.A[k] += plant.B[k]", "plant.A[k] -= plant.B[k]"),
    ("back = back + law.torque @ plant.torque", "back = back - law.torque @ plant.torque"),
    ("closed = np.asarray(plant.A - plant.B", "closed = np.asarray(plant.A + plant.B"),
    ("= -integral @ plant.position", "= integral @ plant.position"),
    ("by_q = torque(q + step, dq, ddq) - torque(q - step, dq, ddq)", "by_q = 0 * torque(q + step, dq, ddq)"),
    ("argsort(-poles.real", "argsort(poles.real"),
    ('motor = self.encoders == "motor" or', 'motor = self.encoders == "motor" and'),
)


@pytest.mark.slow
def test_planted_slips_are_caught():
    assert not uncaught("lwr_dyn.design.elastic_loop", SLIPS, check)
