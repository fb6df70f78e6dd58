"""Geometric Jacobian of the native chain and its rate: base frame, linear rows over angular rows.

[v; omega] = J(q) dq          [a; domega] = J(q) ddq + dJ/dt dq
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array
from lwr_dyn.model.chain import Chain, link_frames
from lwr_dyn.model.dh import JointKind


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
    stands = np.stack([pose @ link.before.matrix() for pose, link in zip(before, chain.links, strict=True)], axis=-3)
    revolute = tuple(link.kind is JointKind.REVOLUTE for link in chain.links)
    return JointAxes(stands[..., :3, 2], stands[..., :3, 3], poses[-1], revolute)


def jacobian_at(axes: JointAxes, point: Array) -> Array:
    """Jacobian (..., 6, n) of the point (..., 3) [m] of the last link; ungated.

    Column i is (z_i x (point - p_i), z_i) for a revolute joint and (z_i, 0) for a prismatic one
    (Siciliano et al., Robotics, eqs. 3.26 to 3.30).
    """
    turning = np.array(axes.revolute)[:, None]
    linear = np.where(turning, np.cross(axes.z, point[..., None, :] - axes.p), axes.z)
    angular = np.where(turning, axes.z, 0.0)
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
        speed = speed + np.cross(omega, p[..., i, :] - place)
        place = p[..., i, :]
        axis_rate = np.cross(omega, axis)
        if revolute:
            change = np.cross(axis_rate, point - place) + np.cross(axis, tip_speed - speed)
            linear, angular = linear + change * rate, angular + axis_rate * rate
            omega = omega + axis * rate
        else:
            linear = linear + axis_rate * rate
            speed = speed + axis * rate
    return np.concatenate([linear, angular], axis=-1)


def jacobian(chain: Chain, q: ArrayLike) -> Array:
    """Jacobian of the flange, (..., 6, n), linear rows over angular rows, base frame.

    Parameters
    ----------
    chain : Chain
    q : (..., n) array_like
        [rad or m]

    Raises
    ------
    ShapeError

    References
    ----------
    Siciliano et al., Robotics, eq. 3.30.
    """
    axes = joint_axes(chain, joint_array("q", q, chain.n))
    return jacobian_at(axes, axes.flange[..., :3, 3])
