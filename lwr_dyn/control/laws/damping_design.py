"""Damping of an impedance from inertia and stiffness: every mode of (inertia, stiffness) gets the damping ratio xi.

With B = L L^T and X = L^-1 J^T K^(1/2) (J is 1 in joint space), the singular values of X are the natural frequencies
of the modes. X = A S U^T gives the factorisation of the effective inertia and of the stiffness that the design asks
for, Lambda = (J B^-1 J^T)^-1 = Q Q^T and K = Q S^2 Q^T with Q = K^(1/2) U S^-1, hence D = 2 xi Q S Q^T; and in the
joints

    J^T D = 2 xi L A U^T K^(1/2),   J^T D J = 2 xi L A S A^T L^T,   1 - J^T Jbar^T = L (1 - A A^T) L^-1

without an inverse of J, of Lambda or of S: nothing grows near a singular pose. J^T D J is positive semidefinite
whatever inertia the model has.

References
----------
Albu-Schaeffer, Ott, Frese, Hirzinger, "Cartesian impedance control of redundant robots", ICRA 2003 (double
diagonalisation); Khatib, IEEE J. Robotics and Automation 3 (1987), for Lambda and Jbar = B^-1 J^T Lambda.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dgesdd, dpotrf, dtrtrs

from lwr_dyn.foundation.arrays import Array


class Modes(NamedTuple):
    """L (n, n), lower; A (n, m), S (m,) [rad/s] from large to small, U^T (m, m), with m = min(n, rows of J).

    A named tuple, since it is made at every sample.
    """

    root: Array
    joint: Array
    frequency: Array
    task: Array


def modes(B: Array, weighted: Array) -> Modes | None:
    """The modes of a mass matrix B (n, n) and `weighted` = J^T K^(1/2) (n, m); None if B is not positive definite."""
    root, fault = dpotrf(B, lower=1, clean=1)
    if fault:
        return None
    reduced = dtrtrs(root, weighted, lower=1)[0]
    joint, frequency, task, fault = dgesdd(reduced, full_matrices=0)
    return None if fault else Modes(root, joint, frequency, task)


def no_torque_known(n: int) -> Array:
    """NaN (n,): the torque where the model has no positive definite B; a run ends there with its `DivergenceError`."""
    return np.full(n, np.nan)
