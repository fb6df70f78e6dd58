"""Logs of arms with elastic joints, with a known truth: the motion is given, deflections and torques follow."""

from __future__ import annotations

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.regression.least_squares import BaseParameters
from lwr_dyn.model.transmission import JointElasticity
from tests.identification.plants import Motion, Plant, torques


def elastic_truth(plant: Plant, gears: JointElasticity, base: BaseParameters, zero: Array | float = 0.0) -> Array:
    """All parameters of the plant as they are fitted."""
    columns, K = plant.columns, gears.stiffness
    own = [plant.parameters[columns.of_joint(j)] for j in range(columns.n)]
    bends = np.array([K, gears.damping, -K * zero]).T
    joints = [np.concatenate(pair) for pair in zip(own, bends, strict=True)]
    return np.concatenate([base.of(plant.parameters[: columns.bodies]), *joints])


def elastic_log(
    plant: Plant, gears: JointElasticity, motion: Motion, noise: float, rng: np.random.Generator,
    encoder: float = 0.0, zero: Array | float = 0.0,
) -> JointLog:  # fmt: skip
    """Both encoders with white noise [rad], torques of the motors with white noise [N m].

    s = Y pi of the links alone bends the gear, D d' + K d = s with s linear from row to row; the motor needs s and what
    turns its rotor and its friction at theta = q + d. `zero` (n,) is where the motors' encoders show 0 [rad].
    """
    columns, K, D = plant.columns, gears.stiffness, gears.damping
    links = plant.parameters.copy()
    links[columns.bodies :] = 0.0
    s, h = torques(columns, links, motion), float(motion.t[1] - motion.t[0])
    stay, late = np.exp(-K / D * h), D / K
    bend = np.empty_like(s)
    bend[0] = s[0] / K
    for i, slope in enumerate(np.diff(s, axis=0) / h):
        bend[i + 1] = (s[i + 1] - slope * late) / K + stay * (bend[i] - (s[i] - slope * late) / K)
    rate = (s - K * bend) / D
    speed, acceleration = motion.dq + rate, motion.ddq + np.gradient(rate, h, axis=0, edge_order=2)
    own = [
        joint(speed[:, j], acceleration[:, j]) @ plant.parameters[columns.of_joint(j)]
        for j, joint in enumerate(columns.joints)
    ]
    tau = s + np.array(own).T + rng.normal(size=s.shape) * noise
    q, theta = (x + rng.normal(size=s.shape) * encoder for x in (motion.q, motion.q + bend + zero))
    return JointLog("elastic", tuple(range(1, columns.n + 1)), motion.t, q, tau, motor_q=theta)
