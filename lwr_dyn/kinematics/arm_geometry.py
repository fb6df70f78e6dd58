"""The geometry of the arms that have a closed form of inverse kinematics, read off their axes at q = 0.

S-R-S arm (spherical, roll, spherical): axes 1, 2, 3 meet at the shoulder S, axes 5, 6, 7 at the wrist W, neighbours
among them perpendicular; joint 4 is the elbow, whose axis is perpendicular to the plane of S and W.

    R_flange = R_shoulder(q1, q2, q3) Rot(w4, q4) R_wrist(q5, q6, q7) R_home

Six joints with a spherical wrist: axis 2 is perpendicular to axis 1, axis 3 parallel to axis 2, and axes 4, 5, 6 meet
in the wrist centre W, neighbours among them perpendicular. In the arm's plane at q1 = 0, e = w2 x w1 (ahead),
n = w2 (across) and w1 (along axis 1) are a right-handed triad.

Shoulder, elbow and wrist may be offset, the flange may be anywhere, and zero and direction of each joint are free.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, fixed_array, read_only
from lwr_dyn.errors import OptionError
from lwr_dyn.kinematics.forward import joint_axes
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.dh import JointKind

MEETING = 1e-9
"""[m, or sine] Axes this near to each other meet; directions this near to a right angle are perpendicular."""

SRS_ARM = "a seven-joint arm with a spherical shoulder, an elbow and a spherical wrist"
WRIST_ARM = "a six-joint arm with axis 2 perpendicular to 1, 3 parallel to 2, a spherical wrist"
Geometry = TypeVar("Geometry")


@dataclass(frozen=True, slots=True, eq=False)
class Ball:
    """Three axes through one point, each perpendicular to the next: roll, tilt and roll (a spherical joint).

    Rot(w1, q1) Rot(w2, q2) Rot(w3, q3) = basis Rz(q1) Ry(q2 + offset) Rz(q3) back^T
    """

    basis: Array
    """(3, 3), columns w2 x w1, w2, w1 in the base at q = 0."""
    offset: float
    """Tilt between the two rolls at q = 0 [rad]: w3 is w1 turned by it about w2."""
    back: Array
    """(3, 3) basis turned by `offset` about w2."""


@dataclass(frozen=True, slots=True, eq=False)
class SrsGeometry:
    """Constants of an S-R-S arm in the base at q = 0: lengths [m], angles [rad]."""

    shoulder: Array
    upper: Array
    """(3,) From the shoulder to the elbow point (the foot of S on axis 4)."""
    fore: Array
    """(3,) From the elbow point to the wrist."""
    elbow_axis: Array
    straight: float
    """q4 at which shoulder, elbow and wrist lie in line [rad]."""
    wrist_in_flange: Array
    home_rotation: Array
    first: Ball
    last: Ball
    reference: Array
    """(3,) The unit vector that fixes the zero of the arm angle; by default the axis of joint 1."""

    @property
    def lengths(self) -> tuple[float, float]:
        """Upper arm and forearm [m]."""
        return float(np.linalg.norm(self.upper)), float(np.linalg.norm(self.fore))

    def with_reference(self, reference: ArrayLike | None) -> Self:
        """The same arm with the arm angle counted from another direction of the base; raises as `fixed_array`."""
        if reference is None:
            return self
        direction = fixed_array("reference", reference, (3,))
        length = float(np.linalg.norm(direction))
        if length < MEETING:
            raise OptionError("reference", direction.tolist(), "a direction, not zero")
        return replace(self, reference=read_only(direction / length))


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
    """Offset of W from the plane of axis 1, along n [m]."""
    shoulder: Array
    """(2,) Axis 2 in the arm's plane, from `origin`."""
    upper: Array
    """(2,) From axis 2 to axis 3."""
    fore: Array
    """(2,) From axis 3 to W."""
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
        """q3 at which axis 2, axis 3 and W lie in line, -pi to pi [rad]."""
        (a, b), (c, d) = self.upper, self.fore
        return float(-self.elbow_sign * np.arctan2(a * d - b * c, a * c + b * d))


@lru_cache(maxsize=32)
def srs_geometry(chain: Chain) -> SrsGeometry | None:
    """The constants of the arm, or None when the chain is not S-R-S."""
    if chain.n != 7 or any(link.kind is not JointKind.REVOLUTE for link in chain.links):
        return None
    axes = joint_axes(chain, np.zeros(7))
    z, p, flange = axes.z, axes.p, axes.flange
    shoulder, wrist = meeting_point(z[:3], p[:3]), meeting_point(z[4:], p[4:])
    first, last = ball_of(z[:3]), ball_of(z[4:])
    if shoulder is None or wrist is None or first is None or last is None:
        return None
    w4 = z[3]
    elbow = p[3] + w4 * (w4 @ (shoulder - p[3]))
    upper, fore = elbow - shoulder, wrist - elbow
    if abs(w4 @ fore) > MEETING or min(np.linalg.norm(upper), np.linalg.norm(fore)) < MEETING:
        return None
    return SrsGeometry(
        shoulder=read_only(shoulder),
        upper=read_only(upper),
        fore=read_only(fore),
        elbow_axis=read_only(w4),
        straight=float(np.arctan2(w4 @ np.cross(fore, upper), fore @ upper)),
        wrist_in_flange=read_only(flange[:3, :3].T @ (wrist - flange[:3, 3])),
        home_rotation=read_only(flange[:3, :3]),
        first=first,
        last=last,
        reference=read_only(z[0]),
    )


@lru_cache(maxsize=32)
def wrist_arm_geometry(chain: Chain) -> WristArmGeometry | None:
    """The constants of the arm, or None when the chain is not a six-joint arm with spherical wrist."""
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


def require_srs(arm: Arm, reference: ArrayLike | None = None) -> SrsGeometry:
    """As `srs_geometry`, with another `reference` of the arm angle; raises `OptionError` when the arm is not S-R-S."""
    return _required(arm, srs_geometry(arm.chain), SRS_ARM).with_reference(reference)


def require_wrist_arm(arm: Arm) -> WristArmGeometry:
    """As `wrist_arm_geometry`; raises `OptionError` when the arm is another one."""
    return _required(arm, wrist_arm_geometry(arm.chain), WRIST_ARM)


def _required(arm: Arm, geometry: Geometry | None, allowed: str) -> Geometry:
    if geometry is None:
        raise OptionError("arm", arm.name, allowed)
    return geometry


def meeting_point(z: Array, p: Array) -> Array | None:
    """The point where three lines meet, or None."""
    across = np.eye(3) - z[:, :, None] * z[:, None, :]
    point = np.linalg.lstsq(across.reshape(9, 3), np.einsum("nij,nj->ni", across, p).reshape(9), rcond=None)[0]
    away = np.einsum("nij,nj->ni", across, point - p)
    return point if np.linalg.norm(away, axis=1).max() < MEETING else None


def ball_of(z: Array) -> Ball | None:
    """The ball of three axis directions, or None where neighbours are not perpendicular."""
    w1, w2, w3 = z
    if max(abs(w1 @ w2), abs(w2 @ w3)) > MEETING:
        return None
    basis = np.column_stack([np.cross(w2, w1), w2, w1])
    offset = float(np.arctan2(w2 @ np.cross(w1, w3), w1 @ w3))
    back = np.column_stack([np.cross(w2, w3), w2, w3])
    return Ball(read_only(basis), offset, read_only(back))
