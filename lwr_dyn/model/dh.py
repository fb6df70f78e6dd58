"""Denavit-Hartenberg rows in both conventions, as constant poses before and after the joint's motion.

standard  T_{i-1,i} = Rz(theta) Tz(d) Tx(a) Rx(alpha)        (Denavit and Hartenberg 1955; Siciliano eq. 2.52)
modified  T_{i-1,i} = Rx(alpha) Tx(a) Rz(theta) Tz(d)        (Craig, Introduction to Robotics, eq. 3.6)

theta = sign q + theta_offset for a revolute joint, d = sign q + d for a prismatic one. `sign` is -1 where the source's
positive direction is against the DH axis; half turns about x before and after the motion express it. `beta` follows
alpha, Rx(alpha) Ry(beta) (Hayati and Mirmirani 1985): axes that are almost parallel meet too far away for DH alone.
"""

import enum
from dataclasses import dataclass

import numpy as np

from lwr_dyn.model.spatial import Pose, rot_x, rot_y, rot_z


class Convention(enum.Enum):
    """The DH convention of a table; there is no default."""

    STANDARD = "standard"
    MODIFIED = "modified"


class JointKind(enum.Enum):
    """The motion of a joint: about its axis or along it."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"


@dataclass(frozen=True, slots=True)
class DHRow:
    """One row of a DH table: angles [rad], lengths [m]."""

    alpha: float
    a: float
    d: float
    theta_offset: float = 0.0
    sign: int = 1
    beta: float = 0.0

    def fixed_poses(self, convention: Convention) -> tuple[Pose, Pose]:
        """The constant poses around the motion: T_{i-1,i}(q) = before @ motion_z(q) @ after.

        >>> before, after = DHRow(alpha=0.0, a=0.5, d=0.2).fixed_poses(Convention.STANDARD)
        >>> before.is_identity(), after.position
        (True, array([0.5, 0. , 0.2]))
        """
        bend = Pose(rot_x(self.alpha) @ rot_y(self.beta), np.array([self.a, 0.0, 0.0]))
        rise = Pose(rot_z(self.theta_offset), np.array([0.0, 0.0, self.d]))
        if convention is Convention.STANDARD:
            before, after = Pose.identity(), rise @ bend
        else:
            before, after = bend, rise
        if self.sign < 0:
            half_turn = Pose(rot_x(np.pi), np.zeros(3))
            before, after = before @ half_turn, half_turn @ after
        return before, after
