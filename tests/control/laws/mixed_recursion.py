"""The Slotine-Li regressor a second time: one recursion with both velocities in it, no polar form, in base axes.

Spatial vectors (angular, linear) at the base. A_i is the mixed acceleration of link i, the sum over the
joints before it of S_j a_j + (V_j(u) x S_j w_j + V_j(w) x S_j u_j) / 2, minus gravity; the wrench of a body with
spatial inertia I is I A + (V(u) x* I V(w) + V(w) x* I V(u)) / 2.
"""

import numpy as np

ORDER = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
"""Entries of the tensor in Pinocchio's order."""


def cross(a):
    """a x as a matrix."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def motion_cross(V):
    """V x of motions; -(V x)^T is V x* of forces."""
    return np.block([[cross(V[:3]), np.zeros((3, 3))], [cross(V[3:]), cross(V[:3])]])


def unit_inertias():
    """Spatial inertias of ten bodies, each with one parameter of 1, about the origin of their frame."""
    out = np.zeros((10, 6, 6))
    out[0, 3:, 3:] = np.eye(3)
    for i in range(3):
        out[1 + i, :3, 3:], out[1 + i, 3:, :3] = cross(np.eye(3)[i]), cross(np.eye(3)[i]).T
    for k, (i, j) in enumerate(ORDER):
        out[4 + k, i, j] = out[4 + k, j, i] = 1.0
    return out


def mixed_regressor(frames, revolute, gravity, u, w, a):
    """Y (n, 10 n) for joint frames (n, 4, 4) in the base, each moving about or along its own z."""
    n, V, W, A = len(u), np.zeros(6), np.zeros(6), np.r_[0.0, 0.0, 0.0, -np.asarray(gravity)]
    axes, Y = np.zeros((n, 6)), np.zeros((n, 10 * n))
    for i, T in enumerate(frames):
        R, p = T[:3, :3], T[:3, 3]
        z = R[:, 2]
        S = axes[i] = np.r_[z, np.cross(p, z)] if revolute[i] else np.r_[np.zeros(3), z]
        A = A + S * a[i] + (motion_cross(V) @ S * w[i] + motion_cross(W) @ S * u[i]) / 2
        V, W = V + S * u[i], W + S * w[i]
        X = np.block([[R.T, np.zeros((3, 3))], [-R.T @ cross(p), R.T]])  # motions from the base's origin to the frame
        v, second, acceleration = X @ V, X @ W, X @ A
        for k, inertia in enumerate(unit_inertias()):
            turning = motion_cross(v).T @ inertia @ second + motion_cross(second).T @ inertia @ v
            wrench = X.T @ (inertia @ acceleration - turning / 2)
            Y[: i + 1, 10 * i + k] = axes[: i + 1] @ wrench
    return Y
