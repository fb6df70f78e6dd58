"""Base parameters of a chain for its kernels: the torque depends on the inertial parameters through these alone.

The dependent ones are folded into them once, when the kernel is generated, so that most masses and many moments are
zero in its recursion.

References
----------
Gautier, Khalil, "Direct calculation of minimum set of inertial parameters of serial robots", IEEE T-RA 6 (1990).
"""

from collections.abc import Sequence

import numpy as np

from lwr_dyn.codegen.kernels.axis_frames import AxisFrame
from lwr_dyn.codegen.kernels.lean_recursion import inverse_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.vectors import Vector

ORDER = (9, 1, 2, 4, 5, 7, 8, 6, 3, 0)
"""Places in `PER_LINK` as they are tried: Izz, mx, my, Ixx, Ixy, Ixz, Iyz first; then Iyy, mz and m, which thus go."""
STATES = 12
"""Random states a joint, from which the dependence is found."""
SEED = 0
INDEPENDENT = 1e-8
"""Share of a column that must be left for it to be independent of those before; rounding leaves 1e-14."""
NO_TORQUE = 1e-9
ZERO = 1e-10
"""Coefficients below this are zero: they are sums of products of lengths [m, m^2] and of 1."""


def base_matrix(frames: Sequence[AxisFrame], gravity: Array | None) -> Array:
    """K (10 n, 10 n): inertial parameters in `frames` -> those of the same torques, with zeros for all that can be.

    Parameters
    ----------
    gravity : (3,) array or None
        [m/s^2]; None for any gravity.
    """
    Y, n = _columns(frames, gravity), len(frames)
    kept: list[int] = []
    Q = np.zeros((len(Y), 0))
    for at in (10 * i + k for k in ORDER for i in range(n)):
        size, rest = float(np.linalg.norm(Y[:, at])), Y[:, at]
        for _ in range(2):  # twice is enough
            rest = rest - Q @ (Q.T @ rest)
        left = float(np.linalg.norm(rest))
        if size > NO_TORQUE and left > INDEPENDENT * size:
            kept.append(at)
            Q = np.column_stack([Q, rest / left])
    K = np.zeros((10 * n, 10 * n))
    folded = np.linalg.lstsq(Y[:, kept], Y, rcond=None)[0]
    K[kept] = np.where(np.abs(folded) < ZERO, 0.0, folded)
    return K


def _columns(frames: Sequence[AxisFrame], gravity: Array | None) -> Array:
    """The torque of each parameter alone at random states, (rows, 10 n)."""
    n = len(frames)
    rng = np.random.default_rng(SEED)
    q, dq, ddq = rng.uniform(-np.pi, np.pi, (3, n, STATES * n))
    pull = Vector.of(gravity) if gravity is not None else Vector(*rng.normal(0.0, 10.0, (3, STATES * n)))
    units = np.eye(10 * n).reshape(10 * n, n, 10, 1)
    bodies = [[units[:, i, k] for k in range(10)] for i in range(n)]
    torque = inverse_dynamics(frames, bodies, pull, q, dq, ddq)  # (10 n, states) each
    return np.concatenate([np.broadcast_to(x, (10 * n, STATES * n)) for x in torque], axis=1).T
