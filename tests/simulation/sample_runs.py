"""References, arms and controllers small enough to know the answer."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

import lwr_dyn
from lwr_dyn.control.paper_laws import PID, InverseDynamics, PDGravity
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind
from lwr_dyn.model.run import Motion
from lwr_dyn.model.spatial import Pose

WORST_CASE = np.array([2.92437, 2.90821, 0.49035, 0.47419, 0.01127, 0.00539, 0.00176])
"""Table IV as the reading `computed` gives it."""
MIDDLE = np.array([0.0, 1.2, 0.0, -1.4, 0.0, 0.6, 0.0])
"""A pose far from all limits where joints 1, 3 and 5 are not in line."""


@dataclass(frozen=True)
class Sinusoids:
    """q = middle + amplitude (1 - cos(w t)): begins at rest, goes on for ever."""

    middle: np.ndarray
    amplitude: np.ndarray
    w: np.ndarray
    duration: float = 14.0

    def sample(self, t):
        phase = np.outer(t, self.w)
        wave = self.amplitude * self.w
        return Motion(
            t, self.middle + self.amplitude * (1 - np.cos(phase)), wave * np.sin(phase), wave * self.w * np.cos(phase)
        )


@dataclass(frozen=True)
class Still:
    """A reference that stands still at q, for any number of joints."""

    q: np.ndarray
    duration: float

    def sample(self, t):
        still = np.zeros((t.size, self.q.size))
        return Motion(t, still + self.q, still, still)


def joint_waves(duration=14.0):
    """A movement of all seven joints inside every limit of the LWR 4+, slow enough for its torques."""
    turns = np.array([1, 2, 2, 1, 3, 2, 3])
    return Sinusoids(MIDDLE, np.array([0.3, -0.2, 0.2, 0.3, 0.4, -0.3, 0.4]), 2 * np.pi / 14 * turns, duration)


@cache
def lwr():
    return lwr_dyn.load("lwr4plus", "computed")


@cache
def lwr_dynamics(engine="pinocchio"):
    return lwr_dyn.dynamics_of(lwr(), engine)


def controllers():
    """Fresh controllers by name."""
    dynamics, Kp, Kd = lwr_dynamics(), 2500 * WORST_CASE, 100 * WORST_CASE
    return {
        "pd-gravity": PDGravity(dynamics, Kp, Kd),
        "pd-velocity-error": PDGravity(dynamics, Kp, Kd, velocity_error=True),
        "pid": PID(Kp, Kd, lwr().effort),
        "pid-gravity": PID(Kp, Kd, lwr().effort, dynamics=dynamics),
        "inverse-dynamics": InverseDynamics(dynamics, 2500, 100),
        "inverse-dynamics-paper": InverseDynamics(dynamics, 2500, 100, feedforward=False),
        "inverse-dynamics-no-gravity": InverseDynamics(dynamics, 2500, 100, gravity=False),
    }


def one_joint(kind=JointKind.PRISMATIC, mass=2.0, lever=0.0, gravity=(0.0, 0.0, 0.0), **limits):
    """A slider, or a wheel or pendulum about z with its mass `lever` out: B = mass, or mass (lever^2 + 0.01)."""
    body = Body(mass, np.array([lever, 0.0, 0.0]), mass * 0.01 * np.eye(3))
    link = ChainLink("joint_1", "link_1", kind, Pose.identity(), Pose.identity(), body)
    chain = Chain((link,), Pose.identity(), np.array(gravity))
    return Arm("one", "none", "one joint", chain, (JointLimits(**limits),))


def with_limits(arm, **changed):
    """The arm with some limits of every joint replaced."""
    return replace(arm, limits=tuple(replace(limit, **changed) for limit in arm.limits))
