"""Is a damping too strong for the sampling? -Kd dq held over T grows instead of braking where B^-1 Kd is above 2/T.

Gains drawn from the worst-case inertia are the largest a joint ever needs; where the arm feels light they are too
large for slow samples, and the loop chatters between its torque limits.
"""

from __future__ import annotations

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.dynamics.protocol import Dynamics

UNSTABLE = 2.0
"""dq_{k+1} = (1 - T lambda) dq_k for each eigenvalue lambda of B^-1 Kd: it grows where T lambda > 2."""
PLACES = 200
"""Configurations of a run that are looked at."""


def sampled_damping(dynamics: Dynamics, Kd: Array, q: Array, rate: float) -> float:
    """Largest T lambda_max(B(q)^-1 Kd) over configurations q (k, n), for torque gains Kd (n,) [N m s/rad].

    The chatter threshold is `UNSTABLE`; a position gain lowers it a little, so a value just below is no promise.
    """
    rows = q[np.unique(np.linspace(0, len(q) - 1, min(PLACES, len(q))).astype(int))]
    root = np.sqrt(Kd)
    inverse = np.linalg.inv(dynamics.mass_matrix(rows))
    return float(np.linalg.eigvalsh(root[:, None] * inverse * root).max()) / rate
