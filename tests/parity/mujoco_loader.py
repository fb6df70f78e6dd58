"""MuJoCo's reading of a file. From a URDF it merges fixed links; the tip is then found in a second, unmerged model."""

from pathlib import Path

import mujoco
import numpy as np


class _Model:
    def __init__(self, path: Path, gravity: np.ndarray, tip: str) -> None:
        self.model = mujoco.MjModel.from_xml_path(str(path))
        self.data = mujoco.MjData(self.model)
        self.gravity, self.tip = gravity, tip
        self.mass = float(self.model.body_mass.sum())
        spec = mujoco.MjSpec.from_file(str(path))
        spec.compiler.fusestatic = False
        self.whole = spec.compile()
        self.whole_data = mujoco.MjData(self.whole)

    def mass_matrix(self, q):
        self._at(q, np.zeros_like(q), np.zeros(3))
        out = np.zeros((q.size, q.size))
        for k, unit in enumerate(np.eye(q.size)):
            mujoco.mj_mulM(self.model, self.data, out[k], unit)
        return out.T

    def velocity_torque(self, q, dq):
        return self._at(q, dq, np.zeros(3))

    def gravity_torque(self, q):
        return self._at(q, np.zeros_like(q), self.gravity)

    def flange(self, q):
        self.whole_data.qpos[:] = q
        mujoco.mj_kinematics(self.whole, self.whole_data)
        body = self.whole_data.body(self.tip)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        return pose

    def _at(self, q, dq, gravity):
        self.model.opt.gravity[:] = gravity
        self.data.qpos[:], self.data.qvel[:] = q, dq
        mujoco.mj_forward(self.model, self.data)
        return self.data.qfrc_bias.copy()


def load(path: Path, gravity: np.ndarray, tip: str) -> _Model:
    return _Model(path, gravity, tip)
