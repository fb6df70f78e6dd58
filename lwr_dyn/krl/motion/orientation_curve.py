"""Orientation along a path through given rotations: a cubic curve of quaternions, made unit, with exact derivatives.

U = Q / |Q|,  w = 2 U' U*,  dw = 2 U'' U*       as functions of the parameter of the path
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.trajectory.pose_path import RotationSample, Slerp, slerp

OPPOSITE = 0.1
"""Cosine of half the turn from one point to the next (168 deg): beyond, either way is nearly as short."""


@dataclass(frozen=True, slots=True, eq=False)
class QuaternionCurve:
    """A cubic curve through quaternions (x, y, z, w)."""

    curve: CubicSpline

    def at(self, s: Array) -> RotationSample:
        """At s (k,)."""
        Q, dQ, ddQ = (np.asarray(self.curve(s, i), dtype=np.float64) for i in range(3))
        n = np.linalg.norm(Q, axis=1)[:, None]
        U = Q / n
        along = _dot(U, dQ)
        dU = (dQ - U * along) / n
        change = ddQ - dU * along - U * (_dot(dU, dQ) + _dot(U, ddQ))
        ddU = change / n - dU * along / n
        R = np.asarray(Rotation.from_quat(U).as_matrix(), dtype=np.float64)
        return RotationSample(R, 2.0 * _vector_of_product(dU, U), 2.0 * _vector_of_product(ddU, U))


def orientation_through(s: Array, R: Array) -> Slerp | QuaternionCurve:
    """The orientation through rotations R (k, 3, 3) at s (k,); raises `ExecutionError` for nearly half a turn."""
    hint = "put a point in between: either way is as short"
    if len(s) == 2:
        try:
            return slerp(R[0], R[1], float(s[1]))
        except OptionError:
            raise ExecutionError("half-turn", "the orientation turns by 180 deg", hint) from None
    Q = np.asarray(Rotation.from_matrix(R).as_quat(), dtype=np.float64)
    for i in range(1, len(Q)):
        cosine = float(Q[i] @ Q[i - 1])
        if abs(cosine) < OPPOSITE:
            raise ExecutionError("half-turn", "the orientation turns by nearly 180 deg", hint)
        if cosine < 0.0:
            Q[i] = -Q[i]
    return QuaternionCurve(CubicSpline(s, Q, bc_type="natural"))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=1, keepdims=True))


def _vector_of_product(a: Array, b: Array) -> Array:
    """The vector part (k, 3) of a b* for quaternions (k, 4)."""
    u, v = a[:, :3], b[:, :3]
    return np.asarray(b[:, 3:] * u - a[:, 3:] * v - np.cross(u, v))
