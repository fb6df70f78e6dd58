"""What makes a chain a six-joint arm with a spherical wrist, read off its axes at q = 0.

Axis 2 is square to axis 1, axis 3 parallel to axis 2, and axes 4, 5, 6 meet in the wrist centre W, neighbours among
them square. Nothing else is asked: the shoulder and the elbow may stand off, W may stand beside the arm's plane, zero
may be counted from anywhere, and any axis either way round.

Axes of the arm's plane: e = w2 x w1 ahead, n = w2 across, w1 along axis 1, a right-handed triad at q1 = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lwr_dyn.arrays import Array, read_only
from lwr_dyn.errors import OptionError
from lwr_dyn.kinematics.jacobian import joint_axes
from lwr_dyn.kinematics.srs_geometry import MEETING, Ball, ball_of, meeting_point
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.dh import JointKind


@dataclass(frozen=True, slots=True, eq=False)
class WristArmGeometry:
    """Constants of a six-joint arm with spherical wrist at q = 0: lengths [m], angles [rad].

    In the arm's plane a point is (along w1, along e); a positive turn about n takes the first towards the second.
    """

    frame: Array
    """(3, 3), columns e, n, w1 in the base."""
    origin: Array
    """(3,) A point of axis 1 in the base [m]."""
    lateral: float
    """How far W stands beside the plane of axis 1, along n [m]."""
    shoulder: Array
    """(2,) Axis 2 in the arm's plane, from `origin`."""
    upper: Array
    """(2,) From axis 2 to axis 3."""
    fore: Array
    """(2,) From axis 3 to W."""
    elbow_sign: int
    """+1 when axis 3 points as axis 2 does, else -1."""
    front: int
    """+1 when W stands on the side of e at q = 0 (axis 1 to W), -1 on the other: what `front` branches mean."""
    wrist_in_flange: Array
    home_rotation: Array
    ball: Ball

    @property
    def lengths(self) -> tuple[float, float]:
        """Upper arm and forearm, both in the arm's plane [m]."""
        return float(np.hypot(*self.upper)), float(np.hypot(*self.fore))

    @property
    def straight(self) -> float:
        """q3 at which axis 2, axis 3 and W lie in line [rad], within half a turn of zero."""
        (a, b), (c, d) = self.upper, self.fore
        return float(-self.elbow_sign * np.arctan2(a * d - b * c, a * c + b * d))


def wrist_arm_geometry(chain: Chain) -> WristArmGeometry | None:
    """The constants of the arm, or None when the chain is another one."""
    return _read_off(chain)


def require_wrist_arm(arm: Arm) -> WristArmGeometry:
    """As `wrist_arm_geometry`; raises `OptionError` when the arm is something else."""
    found = wrist_arm_geometry(arm.chain)
    if found is None:
        raise OptionError(
            "arm", arm.name, "a six-joint arm with axis 2 square to 1, 3 parallel to 2, a spherical wrist"
        )
    return found


@lru_cache(maxsize=32)
def _read_off(chain: Chain) -> WristArmGeometry | None:
    if chain.n != 6 or any(link.kind is not JointKind.REVOLUTE for link in chain.links):
        return None
    axes = joint_axes(chain, np.zeros(6))
    z, p, flange = axes.z, axes.p, axes.flange
    wrist, ball = meeting_point(z[3:], p[3:]), ball_of(z[3:])
    parallel = float(z[1] @ z[2])
    if wrist is None or ball is None or abs(z[0] @ z[1]) > MEETING or 1.0 - abs(parallel) > MEETING:
        return None
    frame = np.column_stack([np.cross(z[1], z[0]), z[1], z[0]])
    e, n, w1 = frame.T
    upper, fore = p[2] - p[1], wrist - p[2]
    plane = np.stack([w1, e])
    if min(np.hypot(*(plane @ upper)), np.hypot(*(plane @ fore))) < MEETING:
        return None
    origin = p[0]
    return WristArmGeometry(
        frame=read_only(frame),
        origin=read_only(origin),
        lateral=float(n @ (wrist - origin)),
        shoulder=read_only(plane @ (p[1] - origin)),
        upper=read_only(plane @ upper),
        fore=read_only(plane @ fore),
        elbow_sign=1 if parallel > 0.0 else -1,
        front=1 if e @ (wrist - origin) >= 0.0 else -1,
        wrist_in_flange=read_only(flange[:3, :3].T @ (wrist - flange[:3, 3])),
        home_rotation=read_only(flange[:3, :3]),
        ball=ball,
    )
