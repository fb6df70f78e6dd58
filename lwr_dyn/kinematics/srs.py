"""Closed-form inverse kinematics of an S-R-S arm for a flange pose, an arm angle psi and one of eight branches.

The wrist's distance from the shoulder fixes the elbow; the rest is a turn of the whole arm about the line S-W. With u
the unit vector from S to W and r the reference direction (by default the axis of joint 1),

    e_up = r - (r . u) u, normalised,      e(psi) = cos(psi) e_up + sin(psi) u x e_up

and psi [rad] is the angle at which e(psi) points from the line S-W to the elbow: 0 is the elbow on the side of r, in
the plane of r and S-W (whose normal is r x u); positive is right-handed about u, from shoulder to wrist. With the wrist
on the line of r (within `ON_AXIS`) that plane does not exist, and e_up is taken from the base axis most nearly
perpendicular to r (x where joint 1 turns about z). With the arm straight there is no elbow circle: psi is then the
limit from the bend of the branch.

Every entry of the shoulder's and the wrist's rotation is then a cos(psi) + b sin(psi) + c: the forms below.
(Shimizu, Kakuya, Yoon, Kitagaki, Kosuge, IEEE Trans. Robotics 24, 2008, for the idea; here from axes, not from tables.)
"""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.arm_geometry import Ball, SrsGeometry
from lwr_dyn.kinematics.branches import ALIGNED, REACH_SLACK, Branch, JointRanges, elbow_bend, wrap
from lwr_dyn.model.spatial import turn_about

ON_AXIS = 1e-9
"""Sine of the angle to the reference direction below which the wrist counts as being on it."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmTriangle:
    """Shoulder, elbow and wrist for k poses: what does not depend on psi."""

    u: Array
    """(k, 3) unit vector from shoulder to wrist."""
    up: Array
    """(k, 3) the elbow's direction at psi = 0."""
    reach_excess: Array
    """(k,) by how much the wrist is out of reach [m], 0 within."""
    bend: Array
    """(k,) the elbow's angle from straight, 0 to pi [rad]."""


def arm_triangle(geometry: SrsGeometry, T: Array) -> ArmTriangle:
    """The arm's triangle for flange poses T (k, 4, 4); out of reach the elbow is straight (or folded)."""
    to_wrist = T[:, :3, 3] + T[:, :3, :3] @ geometry.wrist_in_flange - geometry.shoulder
    distance = np.linalg.norm(to_wrist, axis=1)
    bend, excess = elbow_bend(geometry.lengths, distance)
    u = np.where(distance[:, None] > ON_AXIS, to_wrist / np.maximum(distance, ON_AXIS)[:, None], geometry.reference)
    return ArmTriangle(u, _upward(geometry, u), np.where(excess > REACH_SLACK, excess, 0.0), bend)


def _upward(geometry: SrsGeometry, u: Array) -> Array:
    r = geometry.reference
    up = r - (u @ r)[:, None] * u
    length = np.linalg.norm(up, axis=1, keepdims=True)
    if (length > ON_AXIS).all():
        return np.asarray(up / length)
    spare = np.eye(3)[int(np.argmin(np.abs(r)))]
    side = spare - (u @ spare)[:, None] * u
    side = side / np.maximum(np.linalg.norm(side, axis=1, keepdims=True), ON_AXIS)
    return np.asarray(np.where(length > ON_AXIS, up / np.maximum(length, ON_AXIS), side))


def elbow_angle(geometry: SrsGeometry, triangle: ArmTriangle, elbow: Array) -> Array:
    """q4 (k,) [rad] for elbow signs (k,)."""
    q4: Array = geometry.straight + elbow * triangle.bend
    return q4


def ball_forms(geometry: SrsGeometry, T: Array, triangle: ArmTriangle, elbow: Array) -> Array:
    """Rotations of both balls over psi, (k, 2, 3, 3, 3): coefficients of cos psi, sin psi, 1 by row and column.

    Each rotation is Rz(q_roll) Ry(q_tilt + offset) Rz(q_roll'). For poses T (k, 4, 4) and elbow signs (k,).
    """
    g = geometry
    bent = turn_about(g.elbow_axis, elbow_angle(g, triangle, elbow))
    reach = g.upper + bent @ g.fore
    u_home = reach / np.maximum(np.linalg.norm(reach, axis=1, keepdims=True), ON_AXIS)
    n_home = np.broadcast_to(g.elbow_axis, u_home.shape)
    side_home = np.cross(u_home, n_home)
    u, up = triangle.u, triangle.up
    across, sign = np.cross(u, up), elbow[:, None, None]
    # the elbow's direction is sign (u x n), so n = sign (sin(psi) up - cos(psi) across); R_shoulder turns home to it
    cosine = sign * (_outer(up, side_home) - _outer(across, n_home))
    sine = sign * (_outer(up, n_home) + _outer(across, side_home))
    shoulder = np.stack([cosine, sine, _outer(u, u_home)], axis=1)
    target = T[:, :3, :3] @ g.home_rotation.T @ g.last.back
    wrist = np.swapaxes(shoulder @ (bent @ g.last.basis)[:, None], -1, -2) @ target[:, None]
    return np.stack([g.first.basis.T @ shoulder @ g.first.back, wrist], axis=1)


def _outer(a: Array, b: Array) -> Array:
    outer: Array = a[:, :, None] * b[:, None, :]
    return outer


def closed_form(geometry: SrsGeometry, ranges: JointRanges, T: Array, psi: Array, branch: Branch | Array) -> Array:
    """q (k, 7) [rad], within half a turn of the middle of each joint's range; ungated.

    Parameters
    ----------
    T : (k, 4, 4) array
        Flange poses within reach.
    psi : (k,) array
        [rad]
    branch : Branch or (k, 3) array
        One for all poses, or the three signs row by row.
    """
    signs = np.broadcast_to(np.asarray(branch, dtype=np.float64), (len(T), 3))
    triangle = arm_triangle(geometry, T)
    forms = ball_forms(geometry, T, triangle, signs[:, 1])
    weights = np.stack([np.cos(psi), np.sin(psi), np.ones_like(psi)], axis=1)
    q = np.empty((len(T), 7))
    q[:, 3] = elbow_angle(geometry, triangle, signs[:, 1])
    rotations = np.einsum("kc,kbcij->bkij", weights, forms)
    for M, ball, at in zip(rotations, (geometry.first, geometry.last), (0, 4), strict=True):
        joints = slice(at, at + 3)
        q[:, joints] = _ball_angles(M, ball, signs[:, at // 2], ranges.middle[joints])
    return ranges.middle + wrap(q - ranges.middle)


def _ball_angles(M: Array, ball: Ball, sign: Array, middle: Array) -> Array:
    """Roll, tilt, roll (k, 3) of M (k, 3, 3), the tilt with the given sign.

    The second roll is that of Rz(-q1) M, which stays accurate where the tilt goes to zero. Aligned rolls share their
    sum evenly between their ranges.
    """
    aligned = np.hypot(M[:, 0, 2], M[:, 1, 2]) < ALIGNED
    side = np.where(M[:, 2, 2] > 0.0, 1.0, -1.0)
    together = wrap(np.arctan2(-M[:, 0, 1], M[:, 1, 1]) - middle[0] - side * middle[2])
    roll = np.where(aligned, middle[0] + together / 2.0, np.arctan2(sign * M[:, 1, 2], sign * M[:, 0, 2]))
    c, s = np.cos(roll), np.sin(roll)
    tilt = np.arctan2(c * M[:, 0, 2] + s * M[:, 1, 2], M[:, 2, 2])
    second = np.arctan2(c * M[:, 1, 0] - s * M[:, 0, 0], c * M[:, 1, 1] - s * M[:, 0, 1])
    return np.stack([roll, tilt - ball.offset, second], axis=1)
