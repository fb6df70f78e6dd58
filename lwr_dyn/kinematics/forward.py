"""Forward kinematics of the native chain: poses, joint axes, geometric Jacobian and its rate.

[v; omega] = J(q) dq          [a; domega] = J(q) ddq + dJ/dt dq

All in the base frame; a Jacobian has its linear rows over its angular rows.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, arm_argument, joint_array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain, JointKind, followed_by, link_frames
from lwr_dyn.model.spatial import cross


def frames(chain: Chain, q: ArrayLike) -> Array:
    """T_{0,1} ... T_{0,n}, T_{0,flange}: (..., n + 1, 4, 4) for q (..., n) [rad or m]; raises `ShapeError`."""
    return np.stack(list(link_frames(chain, joint_array("q", q, chain.n))), axis=-3)


def forward_kinematics(arm: Arm, q: ArrayLike) -> Array:
    """Pose of the flange in the base, (..., 4, 4), for q (..., n) [rad or m]; raises `ShapeError`.

    Of a mounted arm with a tool it is the pose of the tool centre point in the world.

    >>> import lwr_dyn
    >>> forward_kinematics(lwr_dyn.load("lwr4plus"), [0] * 7)[2, 3].round(3)
    np.float64(0.868)
    """
    return flange_pose(arm_argument(arm).chain, q)


def flange_pose(chain: Chain, q: ArrayLike) -> Array:
    """T_{0,flange}, (..., 4, 4), for q (..., n) [rad or m]; raises `ShapeError`."""
    (pose,) = deque(link_frames(chain, joint_array("q", q, chain.n)), maxlen=1)
    return pose


@dataclass(frozen=True, slots=True, eq=False)
class JointAxes:
    """The joint axes in the base: directions z and points p, each (..., n, 3), and the flange pose (..., 4, 4)."""

    z: Array
    p: Array
    flange: Array
    revolute: tuple[bool, ...]


def joint_axes(chain: Chain, q: Array) -> JointAxes:
    """Axes of all joints at q (..., n); ungated."""
    poses = list(link_frames(chain, q))
    before = [np.broadcast_to(np.eye(4), poses[0].shape), *poses[:-2]]
    frames_ahead = [followed_by(pose, link.before) for pose, link in zip(before, chain.links, strict=True)]
    stacked = np.stack(frames_ahead, axis=-3)
    revolute = tuple(link.kind is JointKind.REVOLUTE for link in chain.links)
    return JointAxes(stacked[..., :3, 2], stacked[..., :3, 3], poses[-1], revolute)


def jacobian_at(axes: JointAxes, point: Array) -> Array:
    """Jacobian (..., 6, n) of the point (..., 3) [m] of the last link; ungated.

    Column i is (z_i x (point - p_i), z_i) for a revolute joint and (z_i, 0) for a prismatic one
    (Siciliano et al., Robotics, eqs. 3.26 to 3.30).
    """
    linear, angular = cross(axes.z, point[..., None, :] - axes.p), axes.z
    if not all(axes.revolute):
        turning = np.array(axes.revolute)[:, None]
        linear, angular = np.where(turning, linear, axes.z), np.where(turning, axes.z, 0.0)
    return np.swapaxes(np.concatenate([linear, angular], axis=-1), -1, -2)


def velocity_product_at(axes: JointAxes, point: Array, dq: Array) -> Array:
    """dJ/dt dq (..., 6) of the point (..., 3) [m] of the last link: its acceleration when ddq = 0; ungated.

    The column of joint i changes because its axis moves with the link before it, and because the lever changes:
    d/dt [z x (point - p)] = (omega x z) x (point - p) + z x (dpoint - dp).
    """
    z, p = axes.z, axes.p
    tip_speed = np.einsum("...ij,...j->...i", jacobian_at(axes, point)[..., :3, :], dq)
    omega, speed, place = np.zeros_like(tip_speed), np.zeros_like(tip_speed), p[..., 0, :]
    linear, angular = np.zeros_like(tip_speed), np.zeros_like(tip_speed)
    for i, revolute in enumerate(axes.revolute):
        axis, rate = z[..., i, :], dq[..., i, None]
        speed = speed + cross(omega, p[..., i, :] - place)
        place = p[..., i, :]
        axis_rate = cross(omega, axis)
        if revolute:
            change = cross(axis_rate, point - place) + cross(axis, tip_speed - speed)
            linear, angular = linear + change * rate, angular + axis_rate * rate
            omega = omega + axis * rate
        else:
            linear = linear + axis_rate * rate
            speed = speed + axis * rate
    return np.concatenate([linear, angular], axis=-1)


def jacobian(chain: Chain, q: ArrayLike) -> Array:
    """Jacobian of the flange, (..., 6, n), for q (..., n) [rad or m]; raises `ShapeError`."""
    axes = joint_axes(chain, joint_array("q", q, chain.n))
    return jacobian_at(axes, axes.flange[..., :3, 3])
