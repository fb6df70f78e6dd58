"""Closed-form inverse kinematics of an S-R-S arm for a flange pose, an arm angle psi and one of eight branches.

The wrist's distance from the shoulder fixes the elbow; the rest is a turn of the whole arm about the line S-W. With u
the unit vector from S to W and r the reference direction (by default the axis of joint 1),

    e_up = r - (r . u) u, normalised,      e(psi) = cos(psi) e_up + sin(psi) u x e_up

and psi [rad] is the angle at which e(psi) points from the line S-W to the elbow: 0 is the elbow on the side of r, in
the plane of r and S-W (whose normal is r x u); positive is right-handed about u, from shoulder to wrist. With the wrist
on the line of r (within `ON_AXIS`) that plane does not exist, and e_up is taken from the base axis most nearly
perpendicular to r (x where joint 1 turns about z). With the arm straight there is no elbow circle: psi is then the
limit from the bend of the branch.

Every entry of the shoulder's and the wrist's rotation is then a cos(psi) + b sin(psi) + c: the forms below. (Shimizu,
Kakuya, Yoon, Kitagaki, Kosuge, IEEE Trans. Robotics 24, 2008, for the idea; here from axes, not from tables.)

Along a path q comes from the closed form, dq and ddq from the extended Jacobian, exactly. The arm angle is a seventh
task row under the Jacobian. With w from shoulder to wrist, rho = |w|, the elbow axis n and the reference direction r,

    tan(psi) = P / C,    P = rho (n . r),    C = n . (r x w)        (plus half a turn on the other elbow branch)
    [J; psi_row] dq  = [v; omega; dpsi]
    [J; psi_row] ddq = [a; domega; ddpsi] - [dJ/dt dq; psi's own second derivative at ddq = 0]
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import OutOfReachError, ShapeError, SingularArmError
from lwr_dyn.kinematics.arm_geometry import Ball, SrsGeometry, require_srs
from lwr_dyn.kinematics.forward import JointAxes, jacobian_at, joint_axes, velocity_product_at
from lwr_dyn.kinematics.solution import ALIGNED, REACH_SLACK, Branch, JointRanges, elbow_bend, joint_ranges, wrap
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import cross, pose_array, turn_about

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
    side_home = cross(u_home, n_home)
    u, up = triangle.u, triangle.up
    across, sign = cross(u, up), elbow[:, None, None]
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


SINGULAR = 1e-7
"""Sine of a tilt, of the elbow's bend, or of the wrist's angle to the reference, below which rates are not determined:
their relative error would exceed 1e-9."""


def follow(
    arm: Arm,
    branch: Branch,
    T: ArrayLike,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    psi: ArrayLike,
    dpsi: ArrayLike,
    ddpsi: ArrayLike,
    *,
    reference: ArrayLike | None = None,
) -> tuple[Array, Array, Array]:
    """q, dq, ddq (k, 7) [rad, per s, per s^2] along a path of the flange: exact derivatives, no differences.

    Every q lies within half a turn of the middle of its range, row by row, whatever the rows before.

    Parameters
    ----------
    arm : Arm
        An S-R-S arm.
    branch : Branch
    T : (k, 4, 4) array_like
        Flange poses in the base.
    velocity, acceleration : (k, 6) array_like
        Of the flange: linear of its origin, then angular, base frame [m/s, rad/s, per s].
    psi, dpsi, ddpsi : (k,) array_like
        Arm angle and its derivatives along time [rad, per s, per s^2].
    reference : (3,) array_like, optional
        Direction psi is counted from, as `ArmAngleCurve.reference`; the axis of joint 1 if not given.

    Raises
    ------
    ShapeError, OptionError
        Wrong shapes, T not poses, not an S-R-S arm.
    OutOfReachError
        `.at` is the row of the pose furthest out of reach.
    SingularArmError
        At row `.index` the arm is stretched or folded, a ball's rolls are aligned, or the wrist is on the
        reference, and velocity or acceleration is not zero there (where both are zero, dq = ddq = 0).

    References
    ----------
    Siciliano et al., Robotics, eqs. 3.78 (extended Jacobian) and 3.97 (second order).
    """
    geometry, ranges = require_srs(arm, reference), joint_ranges(arm)
    poses = pose_array("T", T)
    if poses.ndim != 3:
        raise ShapeError("T", f"shape {poses.shape}", "(k, 4, 4)")
    k = len(poses)
    angles = [fixed_array(name, x, (k,)) for name, x in (("psi", psi), ("dpsi", dpsi), ("ddpsi", ddpsi))]
    rate = np.column_stack([fixed_array("velocity", velocity, (k, 6)), angles[1]])
    change = np.column_stack([fixed_array("acceleration", acceleration, (k, 6)), angles[2]])
    excess = arm_triangle(geometry, poses).reach_excess
    if excess.any():
        raise OutOfReachError(arm.name, float(np.argmax(excess)), float(excess.max()), parameter="row")
    q = closed_form(geometry, ranges, poses, angles[0], branch)
    resting = ~(np.any(rate != 0.0, axis=1) | np.any(change != 0.0, axis=1))
    dq, ddq = np.zeros_like(q), np.zeros_like(q)
    if not resting.all():
        moving = np.flatnonzero(~resting)
        dq[moving], ddq[moving] = _rates(geometry, arm, q[moving], rate[moving], change[moving], moving)
    return q, dq, ddq


def _rates(
    geometry: SrsGeometry, arm: Arm, q: Array, rate: Array, change: Array, rows: NDArray[np.intp]
) -> tuple[Array, Array]:
    axes = joint_axes(arm.chain, q)
    task = _arm_angle_task(geometry, axes)
    _require_regular(geometry, axes, task, q, rows)
    tip = axes.flange[:, :3, 3]
    extended = np.concatenate([jacobian_at(axes, tip), task.row[:, None]], axis=1)
    dq = np.linalg.solve(extended, rate[..., None])[..., 0]
    own = np.column_stack([velocity_product_at(axes, tip, dq), _own_change(geometry, axes, task, dq)])
    return dq, np.linalg.solve(extended, (change - own)[..., None])[..., 0]


@dataclass(frozen=True, slots=True, eq=False)
class _ArmAngleTask:
    """The terms of psi for k rows, as in the module's docstring; wrist_jacobian and n_jacobian are (k, 3, 7)."""

    w: Array
    n: Array
    rho: Array
    P: Array
    C: Array
    wrist_jacobian: Array
    n_jacobian: Array
    row: Array
    """(k, 7) dpsi = row dq."""


def _arm_angle_task(geometry: SrsGeometry, axes: JointAxes) -> _ArmAngleTask:
    r, n = geometry.reference, axes.z[:, 3]
    wrist = _wrist(geometry, axes)
    w = wrist - geometry.shoulder
    rho = np.linalg.norm(w, axis=1)
    P, C = rho * (n @ r), _dot(n, cross(r, w))
    wrist_jacobian = jacobian_at(axes, wrist)[:, :3]
    n_jacobian = np.zeros_like(wrist_jacobian)
    n_jacobian[:, :, :3] = np.swapaxes(cross(axes.z[:, :3], n[:, None]), 1, 2)
    of_rho = np.einsum("ki,kij->kj", w / rho[:, None], wrist_jacobian)
    of_P = (n @ r)[:, None] * of_rho + rho[:, None] * np.einsum("i,kij->kj", r, n_jacobian)
    of_C = np.einsum("ki,kij->kj", cross(r, w), n_jacobian) + np.einsum("ki,kij->kj", cross(n, r), wrist_jacobian)
    row = (C[:, None] * of_P - P[:, None] * of_C) / np.maximum(P**2 + C**2, np.finfo(float).tiny)[:, None]
    return _ArmAngleTask(w, n, rho, P, C, wrist_jacobian, n_jacobian, row)


def _own_change(geometry: SrsGeometry, axes: JointAxes, task: _ArmAngleTask, dq: Array) -> Array:
    """d2psi/dt2 (k,) at constant joint speeds dq: quotient rule twice on P and C."""
    r, n, w, rho = geometry.reference, task.n, task.w, task.rho
    dw = np.einsum("kij,kj->ki", task.wrist_jacobian, dq)
    ddw = velocity_product_at(axes, _wrist(geometry, axes), dq)[:, :3]
    dn, ddn = np.einsum("kij,kj->ki", task.n_jacobian, dq), _turning_change(axes, n, dq)
    drho = _dot(w, dw) / rho
    ddrho = (_dot(dw, dw) + _dot(w, ddw) - drho**2) / rho
    dP = drho * (n @ r) + rho * (dn @ r)
    ddP = ddrho * (n @ r) + 2.0 * drho * (dn @ r) + rho * (ddn @ r)
    dC = _dot(dn, cross(r, w)) + _dot(n, cross(r, dw))
    ddC = _dot(ddn, cross(r, w)) + 2.0 * _dot(dn, cross(r, dw)) + _dot(n, cross(r, ddw))
    size = task.P**2 + task.C**2
    dpsi = (task.C * dP - task.P * dC) / size
    change: Array = (task.C * ddP - task.P * ddC) / size - 2.0 * dpsi * (task.P * dP + task.C * dC) / size
    return change


def _turning_change(axes: JointAxes, n: Array, dq: Array) -> Array:
    """Second derivative (k, 3) of a direction on the upper arm at constant speeds of joints 1 to 3."""
    omega, domega = np.zeros_like(n), np.zeros_like(n)
    for i in range(3):
        turn = axes.z[:, i] * dq[:, i, None]
        domega = domega + cross(omega, turn)
        omega = omega + turn
    change: Array = cross(domega, n) + cross(omega, cross(omega, n))
    return change


def _wrist(geometry: SrsGeometry, axes: JointAxes) -> Array:
    wrist: Array = axes.flange[:, :3, 3] + axes.flange[:, :3, :3] @ geometry.wrist_in_flange
    return wrist


def _dot(a: Array, b: Array) -> Array:
    product: Array = np.einsum("ki,ki->k", a, b)
    return product


def _require_regular(
    geometry: SrsGeometry, axes: JointAxes, task: _ArmAngleTask, q: Array, rows: NDArray[np.intp]
) -> None:
    """Raises `SingularArmError` with the alignment that makes the extended Jacobian singular."""
    sines = {
        "the arm is stretched or folded": np.sin(q[:, 3] - geometry.straight),
        "the rolls of the shoulder are aligned": np.sin(q[:, 1] + geometry.first.offset),
        "the rolls of the wrist are aligned": np.sin(q[:, 5] + geometry.last.offset),
        "the wrist stands on the reference direction": np.hypot(task.P, task.C) / task.rho,
    }
    for why, sine in sines.items():
        if (low := np.abs(sine) < SINGULAR).any():
            raise SingularArmError(int(rows[int(np.argmax(low))]), why)
