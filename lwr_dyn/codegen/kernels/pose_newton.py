"""The last steps to a pose by Newton's method, where the search by damped least squares has come near and stays there.

Where an arm is stretched and its axes are aligned at once, the pose error is a definite quadratic form of q, with
coefficients that differ by a thousand and more: J falls with the error, and steps by J alone go to and fro across a
narrow valley. The second derivatives see the valley. With E = |e|^2 / 2 (Newton's method on it falls by a constant
factor a step there, whatever the coefficients are):

    dE/dq = -J^T e,    d2E/dq_i dq_j = J_i . J_j - e_p . (z_i x Jv_j) - e_r . (z_i x z_j) / 2    for i <= j

up to |e|^2, with z_i the axis of joint i (0 where it slides). Eigenvalues count by their magnitude: no way to a saddle.
"""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import jacobian_at, joint_axes
from lwr_dyn.kinematics.pose_search import pose_error, with_turns
from lwr_dyn.kinematics.pose_solver import FOUND, OUTSIDE, TOLERANCE, SearchRanges
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import pose_array

_STEPS, _LONGEST, _LEAST, _SETTLED = 60, 0.3, 1e-15, 1e-3
"""Steps at most; the longest [rad or m]; the least eigenvalue, above the rounding of J^T J; at a minimum of E above 0
the slope along the next step falls below this share of 2 E."""


def curvature(J: Array, e: Array) -> Array:
    """Second derivatives (n, n) of E at a Jacobian (6, n) and an error (6,)."""
    axes = J[3:].T[:, None]
    bend = np.triu(np.cross(axes, J[:3].T) @ e[:3] + np.cross(axes, J[3:].T) @ e[3:] / 2.0)
    out: Array = J.T @ J - bend - np.triu(bend, 1).T
    return out


def finish(chain: Chain, ranges: SearchRanges, T: Array, row: Array, near: Array | None) -> Array:
    """The row of a pose that was not reached, after these steps: solved, reached outside the limits, or as it was.

    Solutions are moved by whole turns next to `near` (n,), if it is given.
    """
    n = len(ranges.middle)
    T, q = pose_array("T", T), row[:n]
    for step in range(_STEPS):
        axes = joint_axes(chain, q)
        e, sizes = pose_error(T, axes.flange)
        if sizes[0] <= TOLERANCE**2 and sizes[1] <= TOLERANCE**2 and sizes[2] > 0.0:
            q = q if near is None else with_turns(q, near, ranges)
            outside = bool(((q < ranges.lower) | (q > ranges.upper)).any())
            return np.array([*q, OUTSIDE if outside else FOUND, *sizes, row[-2], row[-1] + step])
        J = jacobian_at(axes, axes.flange[:3, 3])
        values, directions = np.linalg.eigh(curvature(J, e))
        dq = directions @ (directions.T @ (J.T @ e) / np.maximum(np.abs(values), _LEAST))
        if (J @ dq) @ e < _SETTLED * (e @ e):
            break
        q = q + dq * min(1.0, _LONGEST / max(float(np.linalg.norm(dq)), 1e-300))
    return row
