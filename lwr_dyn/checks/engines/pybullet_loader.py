"""PyBullet's reading of a file: base fixed, inertia as written and not from the collision shapes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from lwr_dyn.checks.engines.engine import ArmInFile
from lwr_dyn.foundation.arrays import Array

STEP = 1e-5
"""[s] Length of the step that shows how the model moves: rates are returned in double precision, and damping of the
whole step is of its order."""


class BulletFile:
    """One multibody in a client of its own."""

    def __init__(self, path: Path, scope: ArmInFile, still: bool) -> None:
        import pybullet

        self.bullet = pybullet
        self.client, self.gravity = self.bullet.connect(self.bullet.DIRECT), scope.gravity
        flags = self.bullet.URDF_USE_INERTIA_FROM_FILE
        self.body = self.bullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=self.client)
        joints = range(self.bullet.getNumJoints(self.body, self.client))
        self.infos = {k: self.bullet.getJointInfo(self.body, k, self.client) for k in joints}
        names = {info[1].decode(): k for k, info in self.infos.items()}
        links = {info[12].decode(): k for k, info in self.infos.items()}
        self.moving = [k for k, info in self.infos.items() if info[2] != self.bullet.JOINT_FIXED]
        self.at = [names[name] for name in scope.joints]
        self.dofs = [self.moving.index(k) for k in self.at]
        self.held_at = {names[name]: value for name, value in scope.held.items() if names[name] in self.moving}
        self.tip, self.names = links[scope.tip], list(links)
        self.mass = float(sum(self.bullet.getDynamicsInfo(self.body, k, self.client)[0] for k in (-1, *joints)))
        base = self.bullet.getDynamicsInfo(self.body, -1, self.client)
        centre = self.bullet.getBasePositionAndOrientation(self.body, self.client)
        self.root = _pose(*centre) @ np.linalg.inv(_pose(base[3], base[4]))
        if still:
            none = {"linearDamping": 0.0, "angularDamping": 0.0, "physicsClientId": self.client}
            self.bullet.changeDynamics(self.body, -1, **none)
        self.names.append(self.bullet.getBodyInfo(self.body, self.client)[0].decode())

    def mass_matrix(self, q: Array) -> Array:
        """B."""
        matrix = self.bullet.calculateMassMatrix(self.body, self._whole(q), physicsClientId=self.client)
        return np.array(matrix)[np.ix_(self.dofs, self.dofs)]

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """C dq."""
        return self._inverse(q, dq, (0.0, 0.0, 0.0))

    def gravity_torque(self, q: Array) -> Array:
        """g."""
        return self._inverse(q, np.zeros_like(q), self.gravity)

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """B (ddq - ddq0), where ddq0 is how the model moves in one step without torque; its default motors are off."""
        self.bullet.setGravity(*self.gravity, physicsClientId=self.client)
        self.bullet.setTimeStep(STEP, physicsClientId=self.client)
        off, none = self.bullet.VELOCITY_CONTROL, [0.0] * len(self.moving)
        self.bullet.setJointMotorControlArray(self.body, self.moving, off, forces=none, physicsClientId=self.client)
        rates, wanted = self._rates(dq), np.array(self._rates(ddq))
        for k, position, rate in zip(self.moving, self._whole(q), rates, strict=True):
            self.bullet.resetJointState(self.body, k, position, rate, physicsClientId=self.client)
        self.bullet.stepSimulation(physicsClientId=self.client)
        after = [x[1] for x in self.bullet.getJointStates(self.body, self.moving, physicsClientId=self.client)]
        free = (np.array(after) - np.array(rates)) / STEP
        matrix = self.bullet.calculateMassMatrix(self.body, self._whole(q), physicsClientId=self.client)
        return np.asarray((np.array(matrix) @ (wanted - free))[self.dofs])

    def flange(self, q: Array) -> Array:
        """Pose of the tip."""
        for k, value in zip(self.moving, self._whole(q), strict=True):
            self.bullet.resetJointState(self.body, k, value, physicsClientId=self.client)
        state = self.bullet.getLinkState(self.body, self.tip, computeForwardKinematics=1, physicsClientId=self.client)
        return np.asarray(np.linalg.inv(self.root) @ _pose(state[4], state[5]))

    def held(self) -> dict[str, Array]:
        """What getJointInfo lists; an upper limit below the lower one is none."""
        rows = [self.infos[k] for k in self.at]
        columns = {"lower": 8, "upper": 9, "velocity": 11, "effort": 10, "viscous": 6, "coulomb": 7}
        out = {name: np.array([float(row[i]) for row in rows]) for name, i in columns.items()}
        endless = out["lower"] >= out["upper"]
        out["lower"], out["upper"] = np.where(endless, -np.inf, out["lower"]), np.where(endless, np.inf, out["upper"])
        return out

    def links(self) -> list[str]:
        """All links."""
        return self.names

    def _inverse(self, q: Array, dq: Array, gravity: tuple[float, ...]) -> Array:
        self.bullet.setGravity(*gravity, physicsClientId=self.client)
        zero = [0.0] * len(self.moving)
        torque = self.bullet.calculateInverseDynamics(
            self.body, self._whole(q), self._rates(dq), zero, physicsClientId=self.client
        )
        return np.array(torque)[self.dofs]

    def _whole(self, q: Array) -> list[float]:
        places = self.held_at | dict(zip(self.at, map(float, q), strict=True))
        return [places.get(k, 0.0) for k in self.moving]

    def _rates(self, values: Array) -> list[float]:
        rates = dict(zip(self.at, map(float, values), strict=True))
        return [rates.get(k, 0.0) for k in self.moving]


def _pose(position: tuple[float, ...], quaternion: tuple[float, ...]) -> Array:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    pose[:3, 3] = position
    return pose


def load(path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> BulletFile:
    """The file; `still` turns off the default damping of 0.04 of every link."""
    return BulletFile(path, scope, bool(options.get("still")))
