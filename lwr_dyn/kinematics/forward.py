"""Forward kinematics on the native chain: the product of the paper's own matrices; and the gate for poses."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array, real_array
from lwr_dyn.errors import OptionError, ShapeError
from lwr_dyn.model.chain import Chain, link_frames

ORTHONORMAL = 1e-6
"""Entries of R^T R - 1 up to here are rounding of typed or printed numbers; the nearest rotation is taken."""


def frames(chain: Chain, q: ArrayLike) -> Array:
    """T_{0,1} ... T_{0,n}, T_{0,flange}: (..., n + 1, 4, 4) for q (..., n) [rad or m]; raises `ShapeError`."""
    return np.stack(list(link_frames(chain, joint_array("q", q, chain.n))), axis=-3)


def forward_kinematics(chain: Chain, q: ArrayLike) -> Array:
    """T_{0,flange}, (..., 4, 4), for q (..., n) [rad or m]; raises `ShapeError`."""
    (pose,) = deque(link_frames(chain, joint_array("q", q, chain.n)), maxlen=1)
    return pose


def pose_array(name: str, value: ArrayLike) -> Array:
    """Poses (..., 4, 4) with rotations made exact; each with last row 0 0 0 1, lengths in metres.

    Raises
    ------
    ShapeError
        Not (..., 4, 4), or not finite.
    OptionError
        The last row is not 0 0 0 1, or the rotation is not one (to `ORTHONORMAL`).

    >>> pose_array("T", np.eye(4)).shape
    (4, 4)
    """
    T = real_array(name, value)
    if T.ndim < 2 or T.shape[-2:] != (4, 4):
        raise ShapeError(name, f"shape {T.shape}", "(..., 4, 4), a homogeneous matrix")
    if not (T[..., 3, :] == np.array([0.0, 0.0, 0.0, 1.0])).all():
        raise OptionError(name, "last row is not 0 0 0 1", "a homogeneous matrix")
    R = T[..., :3, :3]
    error = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max(initial=0.0)
    if error > ORTHONORMAL:
        raise OptionError(name, f"R^T R differs from 1 by {error:.3g}", f"a rotation (to {ORTHONORMAL:g})")
    if (np.linalg.det(R) < 0.0).any():
        raise OptionError(name, "a mirror image (det R = -1)", "a rotation, det R = +1")
    out = T.copy()
    out[..., :3, :3] = nearest_rotation(R)
    return out


def nearest_rotation(R: Array) -> Array:
    """The nearest rotations to nearly orthonormal R (..., 3, 3): two Newton steps of the polar decomposition."""
    for _ in range(2):
        R = 1.5 * R - 0.5 * R @ np.swapaxes(R, -1, -2) @ R
    return R
