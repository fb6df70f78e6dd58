"""How often a plus-minus holds the truth, in logs of joints whose motors turn several of them.

The torques come by a road of their own: Newton-Euler of the bodies, and the rotor and friction of one motor after the
other at the sum of the speeds of its joints.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

import lwr_dyn
from lwr_dyn.dynamics.regressor import INERTIAL, body_parameters
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import DEFAULT_MOTION, MotionIdentification, MotionRule
from lwr_dyn.identification.payload.identify_load import body_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body
from lwr_dyn.model.run import Motion
from tests.identification.plants import of_load, perturbed_plant, random_motion

MOTORS = {
    "tx40": {1: {1: 1.0}, 2: {2: 1.0}, 3: {3: 1.0}, 4: {4: 1.0}, 5: {5: 1.0}, 6: {5: 1.0, 6: 1.0}},
    "wam7": {
        1: {1: 1.0}, 2: {2: 1.0, 3: -1.0 / 1.68}, 3: {2: 1.68, 3: 1.0}, 4: {4: 1.0},
        5: {5: 1.0, 6: -1.0}, 6: {5: 1.0, 6: 1.0}, 7: {7: 1.0},
    },
}  # fmt: skip
"""Speed of each motor for that of joints, as the sources have it: q_m6 = 32 (q_5 + q_6) of the TX40; cables of the WAM
over pulleys of 1.68 (User's Manual, Equations 8 and 9)."""
SECONDS, NOISE, ENCODER, RATE = 12.0, 0.05, 1e-5, 250.0
LEVEL = 0.1
"""Of the bodies, off the table."""


@dataclass(frozen=True, slots=True, eq=False)
class CoupledArm:
    """A truth: bodies (n, 10); of each motor, seen at its joint, rotor, Coulomb and viscous friction up and down."""

    arm: Arm
    bodies: Array
    rotors: Array
    friction: Array

    @property
    def parameters(self) -> Array:
        """In the order of the columns with friction of each direction."""
        return np.concatenate([self.bodies.ravel(), np.column_stack([self.rotors, self.friction]).ravel()])

    def torque(self, motion: Motion) -> Array:
        """(k, n) [N m]."""
        own = zip(self.arm.chain.links, self.bodies, strict=True)
        chain = replace(self.arm.chain, links=tuple(replace(link, body=body_of(pi), rotor=None) for link, pi in own))
        bare = lwr_dyn.dynamics_of(self.arm.with_chain(chain), engine="newton-euler")
        out = np.array(bare.inverse_dynamics(motion.q, motion.dq, motion.ddq))
        for motor, joints in MOTORS[self.arm.name].items():
            speed, rate = (sum(r * x[:, j - 1] for j, r in joints.items()) for x in (motion.dq, motion.ddq))
            up, slope_up, down, slope_down = self.friction[motor - 1]
            rub = np.where(speed > 0.0, up + slope_up * speed, -down + slope_down * speed)
            for j, r in joints.items():
                out[:, j - 1] += r * (self.rotors[motor - 1] * rate + rub)
        return out


def coupled_arm(name: str, run: int) -> CoupledArm:
    """A truth off the table of an arm, with motors that rub unlike each other."""
    arm, rng = lwr_dyn.load(name), np.random.default_rng([run, 51, *map(ord, name)])
    plant = perturbed_plant(TorqueColumns(arm.chain, "directions"), arm, rng, LEVEL)
    bodies = plant.parameters[: len(INERTIAL) * arm.n].reshape(arm.n, -1)
    rotors = 0.7 * arm.armature * np.exp(rng.normal(0.0, 0.3, arm.n))
    levels = np.column_stack([rng.uniform(0.5, 4.0, arm.n), rng.uniform(0.3, 3.0, arm.n)])  # N m, N m s/rad
    friction = np.hstack([levels, levels]) * np.exp(rng.normal(0.0, 0.2, (arm.n, 4)))
    return CoupledArm(arm, bodies, rotors, friction)


LOAD = body_parameters(Body(1.2, np.array([0.02, -0.01, 0.06]), np.diag([0.003, 0.003, 0.002])))
"""Of a load, about the origin of the flange."""


def with_load(truth: CoupledArm) -> CoupledArm:
    """The truth with the load, through the chain."""
    body, bodies = body_of(LOAD), truth.bodies.copy()
    bodies[-1] += of_load(truth.arm.chain, body.mass, body.com, body.inertia_com)
    return replace(truth, bodies=bodies)


def coupled_log(truth: CoupledArm, run: int) -> JointLog:
    """Positions with white encoder noise, torques of the joints with white noise."""
    rng = np.random.default_rng([run, 52, *map(ord, truth.arm.name)])
    motion = random_motion(truth.arm, SECONDS, rng, rate=RATE)
    tau = truth.torque(motion)
    q = motion.q + rng.normal(0.0, ENCODER, motion.q.shape)
    joints = tuple(range(1, truth.arm.n + 1))
    return JointLog("simulated", joints, motion.t, q, tau + rng.normal(0.0, NOISE, tau.shape))


def identified(name: str, run: int, rule: MotionRule = DEFAULT_MOTION) -> tuple[CoupledArm, MotionIdentification]:
    """A truth and what its log says; the arm is that of the data file."""
    truth = coupled_arm(name, run)
    return truth, identify_motion([coupled_log(truth, run)], truth.arm, rule)


def misses(name: str, runs: Iterable[int]) -> tuple[Array, Array]:
    """In standard errors: of all base parameters (runs, b), and of bodies, rotors and friction (runs, p)."""
    base, whole = [], []
    for run in runs:
        truth, found = identified(name, run)
        assert found.consistent is not None
        base.append((found.information.values - found.base.of(truth.parameters)) / found.information.sigma)
        whole.append((found.consistent.parameters - truth.parameters) / found.consistent.sigma)
    return np.array(base), np.array(whole)
