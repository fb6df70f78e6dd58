"""Pinocchio's own reading of a file, without anything of lwr_dyn."""

from pathlib import Path

import numpy as np
import pinocchio as pin


class _Model:
    def __init__(self, path: Path, gravity: np.ndarray, tip: str) -> None:
        self.model = pin.buildModelFromUrdf(str(path))
        self.model.gravity.linear = gravity
        self.data, self.tip = self.model.createData(), self.model.getFrameId(tip, pin.FrameType.BODY)
        self.mass = sum(inertia.mass for inertia in self.model.inertias)

    def mass_matrix(self, q):
        return pin.crba(self.model, self.data, self._turned(q)).copy()

    def velocity_torque(self, q, dq):
        return pin.nonLinearEffects(self.model, self.data, self._turned(q), dq) - self.gravity_torque(q)

    def gravity_torque(self, q):
        return pin.computeGeneralizedGravity(self.model, self.data, self._turned(q))

    def flange(self, q):
        pin.forwardKinematics(self.model, self.data, self._turned(q))
        return pin.updateFramePlacement(self.model, self.data, self.tip).homogeneous.copy()

    def _turned(self, q):
        """The state in Pinocchio's coordinates: a continuous joint has a cosine and a sine."""
        return pin.integrate(self.model, pin.neutral(self.model), q)


def load(path: Path, gravity: np.ndarray, tip: str) -> _Model:
    return _Model(path, gravity, tip)
