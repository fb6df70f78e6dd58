"""MuJoCo's reading of a file. From a URDF it merges fixed links; the tip is then found in a second, unmerged model."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from lwr_dyn.checks.engines.engine import ArmInFile
from lwr_dyn.foundation.arrays import Array

_OFF = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
"""Contacts and stops push too, and are not part of an arm's equation."""


class MujocoFile:
    """The model as MuJoCo compiles it."""

    def __init__(self, path: Path, scope: ArmInFile, whole: bool) -> None:
        spec = mujoco.MjSpec.from_file(str(path))
        spec.compiler.fusestatic = False
        self.whole = spec.compile()
        self.model = self.whole if whole else mujoco.MjModel.from_xml_path(str(path))
        self.data, self.whole_data = mujoco.MjData(self.model), mujoco.MjData(self.whole)
        self.model.opt.disableflags |= _OFF
        self.gravity, self.tip, self.scope = np.array(scope.gravity), scope.tip, scope
        self.joints = [self.model.joint(name) for name in scope.joints]
        self.dofs = [int(joint.dofadr[0]) for joint in self.joints]
        self.mass = float(self.model.body_mass.sum())

    def mass_matrix(self, q: Array) -> Array:
        """B, a column a unit acceleration."""
        self._at(q, np.zeros_like(q), np.zeros(3))
        out, unit = np.zeros((len(q), self.model.nv)), np.zeros(self.model.nv)
        for row, dof in zip(out, self.dofs, strict=True):
            unit[:] = 0.0
            unit[dof] = 1.0
            mujoco.mj_mulM(self.model, self.data, row, unit)
        return out.T[self.dofs]

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """qfrc_bias without gravity."""
        self._at(q, dq, np.zeros(3))
        return np.array(self.data.qfrc_bias)[self.dofs]

    def gravity_torque(self, q: Array) -> Array:
        """qfrc_bias at rest."""
        self._at(q, np.zeros_like(q), self.gravity)
        return np.array(self.data.qfrc_bias)[self.dofs]

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """mj_inverse, which counts damping and dry friction (the latter as a soft constraint)."""
        self._at(q, dq, self.gravity)
        self.data.qacc[:] = 0.0
        self.data.qacc[self.dofs] = ddq
        mujoco.mj_inverse(self.model, self.data)
        return np.array(self.data.qfrc_inverse)[self.dofs]

    def flange(self, q: Array) -> Array:
        """Pose of the tip, by the unmerged model."""
        self._place(self.whole, self.whole_data, q)
        mujoco.mj_kinematics(self.whole, self.whole_data)
        body = self.whole_data.body(self.tip)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        return pose

    def held(self) -> dict[str, Array]:
        """Ranges, damping, dry friction, and efforts of joints or of their motors; there is no speed limit."""
        m, ids = self.model, [joint.id for joint in self.joints]
        limited = m.jnt_limited[ids].astype(bool)
        effort = np.where(m.jnt_actfrclimited[ids].astype(bool), m.jnt_actfrcrange[ids, 1], np.inf)
        for k in range(m.nu):
            if m.actuator_ctrllimited[k] and int(m.actuator_trnid[k, 0]) in ids:
                effort[ids.index(int(m.actuator_trnid[k, 0]))] = m.actuator_ctrlrange[k, 1]
        return {
            "lower": np.where(limited, m.jnt_range[ids, 0], -np.inf),
            "upper": np.where(limited, m.jnt_range[ids, 1], np.inf),
            "effort": effort,
            "viscous": m.dof_damping[self.dofs],
            "coulomb": m.dof_frictionloss[self.dofs],
        }

    def links(self) -> list[str]:
        """Bodies that are left after merging."""
        return [self.model.body(k).name for k in range(self.model.nbody)]

    def _at(self, q: Array, dq: Array, gravity: Array) -> None:
        self.model.opt.gravity[:] = gravity
        self._place(self.model, self.data, q)
        self.data.qvel[:] = 0.0
        self.data.qvel[self.dofs] = dq
        mujoco.mj_forward(self.model, self.data)

    def _place(self, model: Any, data: Any, q: Array) -> None:
        for name, value in (*self.scope.held.items(), *zip(self.scope.joints, q, strict=True)):
            data.qpos[model.joint(name).qposadr[0]] = value


def load(path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> MujocoFile:
    """The file; `whole` is the compiler's option fusestatic="false"."""
    return MujocoFile(path, scope, bool(options.get("whole")))
