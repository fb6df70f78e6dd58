"""The geometry of six-joint arms with a closed form of inverse kinematics, read off their axes at q = 0.

With a spherical wrist axis 2 is perpendicular to axis 1, axis 3 parallel to axis 2, and axes 4, 5, 6 meet
in the wrist centre W, neighbours among them perpendicular. In the arm's plane at q1 = 0, e = w2 x w1 (ahead),
n = w2 (across) and w1 (along axis 1) are a right-handed triad.

With three parallel axes it is the same, but axis 4 is parallel to axes 2 and 3, and W is where axes 5 and 6 meet.

Shoulder, elbow and wrist may be offset, the flange may be anywhere, and zero and direction of each joint are free.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.kinematics.arm_geometry import MEETING, Ball, ball_of, meeting_point, required
from lwr_dyn.kinematics.forward import JointAxes, joint_axes
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.dh import JointKind

WRIST_ARM = "a six-joint arm with axis 2 perpendicular to 1, 3 parallel to 2, a spherical wrist"


@dataclass(frozen=True, slots=True, eq=False)
class SixJointGeometry:
    """Constants of a six-joint arm with spherical wrist or three parallel axes at q = 0: lengths [m], angles [rad].

    In the arm's plane a point is (along w1, along e); a positive turn about n takes the first towards the second.
    """

    frame: Array
    """(3, 3), columns e, n, w1 in the base."""
    origin: Array
    """(3,) A point of axis 1 in the base [m]."""
    lateral: float
    """Offset of W from the plane of axis 1, along n [m]."""
    shoulder: Array
    """(2,) Axis 2 in the arm's plane, from `origin`."""
    upper: Array
    """(2,) From axis 2 to axis 3."""
    fore: Array
    """(2,) From axis 3 to W; with three parallel axes to axis 4."""
    lever: Array
    """(2,) From the end of `fore` to W: zero with a spherical wrist."""
    elbow_sign: int
    """+1 when axis 3 points as axis 2 does, else -1."""
    front: int
    """+1 when W is on the side of e at q = 0, -1 on the other: ahead of axis 1 in the sense of `Branch`."""
    wrist_in_flange: Array
    home_rotation: Array
    ball: Ball

    @property
    def lengths(self) -> tuple[float, float]:
        """Upper arm and forearm, both in the arm's plane [m]."""
        return float(np.hypot(*self.upper)), float(np.hypot(*self.fore))

    @property
    def straight(self) -> float:
        """q3 at which axis 2, axis 3 and the end of `fore` lie in line, -pi to pi [rad]."""
        (a, b), (c, d) = self.upper, self.fore
        return float(-self.elbow_sign * np.arctan2(a * d - b * c, a * c + b * d))


@lru_cache(maxsize=32)
def wrist_arm_geometry(chain: Chain) -> SixJointGeometry | None:
    """The constants of the arm, or None when the chain is not a six-joint arm with spherical wrist."""
    axes = six_axes(chain)
    return None if axes is None else planar_arm(axes, ball_starts=3)


def six_axes(chain: Chain) -> JointAxes | None:
    """The axes at q = 0, or None when the chain has not six revolute joints."""
    revolute = chain.n == 6 and all(link.kind is JointKind.REVOLUTE for link in chain.links)
    return joint_axes(chain, np.zeros(6)) if revolute else None


def planar_arm(axes: JointAxes, ball_starts: int) -> SixJointGeometry | None:
    """Of the arm whose axes from `ball_starts` (0-based: 3, or 4 with three parallel axes) on meet, or None."""
    z, p, flange = axes.z, axes.p, axes.flange
    wrist, ball = meeting_point(z[ball_starts:], p[ball_starts:]), ball_of(z[3:])
    parallel = z[1] @ z[2:ball_starts].T
    if wrist is None or ball is None or abs(z[0] @ z[1]) > MEETING or (1.0 - abs(parallel) > MEETING).any():
        return None
    frame = np.column_stack([np.cross(z[1], z[0]), z[1], z[0]])
    e, n, w1 = frame.T
    plane, end = np.stack([w1, e]), wrist if ball_starts == 3 else p[3]
    upper, fore = plane @ (p[2] - p[1]), plane @ (end - p[2])
    if min(np.hypot(*upper), np.hypot(*fore)) < MEETING:
        return None
    origin = p[0]
    return SixJointGeometry(
        frame=read_only(frame),
        origin=read_only(origin),
        lateral=float(n @ (wrist - origin)),
        shoulder=read_only(plane @ (p[1] - origin)),
        upper=read_only(upper),
        fore=read_only(fore),
        lever=read_only(plane @ (wrist - end)),
        elbow_sign=1 if parallel[0] > 0.0 else -1,
        front=1 if e @ (wrist - origin) >= 0.0 else -1,
        wrist_in_flange=read_only(flange[:3, :3].T @ (wrist - flange[:3, 3])),
        home_rotation=read_only(flange[:3, :3]),
        ball=ball,
    )


def require_wrist_arm(arm: Arm) -> SixJointGeometry:
    """As `wrist_arm_geometry`; raises `OptionError` when the arm is another one."""
    return required(arm, wrist_arm_geometry(arm.chain), WRIST_ARM)
