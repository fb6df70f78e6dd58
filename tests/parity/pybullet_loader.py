"""PyBullet's reading of a file: base fixed, inertia as written and not from the collision shapes."""

from pathlib import Path

import numpy as np
import pybullet


class _Model:
    def __init__(self, path: Path, gravity: np.ndarray, tip: str) -> None:
        self.client, self.gravity = pybullet.connect(pybullet.DIRECT), gravity
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        self.body = pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=self.client)
        joints = range(pybullet.getNumJoints(self.body, self.client))
        infos = [pybullet.getJointInfo(self.body, k, self.client) for k in joints]
        self.moving = [k for k, info in zip(joints, infos, strict=True) if info[2] != pybullet.JOINT_FIXED]
        self.tip = next(k for k, info in zip(joints, infos, strict=True) if info[12].decode() == tip)
        self.mass = sum(pybullet.getDynamicsInfo(self.body, k, self.client)[0] for k in (-1, *joints))

    def mass_matrix(self, q):
        return np.array(pybullet.calculateMassMatrix(self.body, list(q), physicsClientId=self.client))

    def velocity_torque(self, q, dq):
        return self._torque(q, dq, np.zeros(3))

    def gravity_torque(self, q):
        return self._torque(q, np.zeros_like(q), self.gravity)

    def flange(self, q):
        for k, value in zip(self.moving, q, strict=True):
            pybullet.resetJointState(self.body, k, value, physicsClientId=self.client)
        state = pybullet.getLinkState(self.body, self.tip, computeForwardKinematics=1, physicsClientId=self.client)
        pose = np.eye(4)
        pose[:3, :3] = np.reshape(pybullet.getMatrixFromQuaternion(state[5]), (3, 3))
        pose[:3, 3] = state[4]
        return pose

    def _torque(self, q, dq, gravity):
        pybullet.setGravity(*gravity, physicsClientId=self.client)
        zero = [0.0] * len(q)
        return np.array(
            pybullet.calculateInverseDynamics(self.body, list(q), list(dq), zero, physicsClientId=self.client)
        )


def load(path: Path, gravity: np.ndarray, tip: str) -> _Model:
    return _Model(path, gravity, tip)
