"""Position stops: a joint that meets its limit stops there, and stays while it is pushed outward.

With s = +1 at an upper and -1 at a lower limit, and z >= 0 the push of the stop into the range:

    impact   w = -s dq+  >= 0,  z >= 0,  z w = 0,  dq+ = dq - B^-1 J^T S z     (inelastic: no joint leaves at a gain)
    resting  w = -s ddq  >= 0,  z >= 0,  z w = 0,  ddq = ddq_free - B^-1 J^T S z

Both are linear complementarity problems with the matrix S J B^-1 J^T S, which is positive definite: one solution.
For one joint the impact is dq+ = dq - B^-1 J^T (J B^-1 J^T)^-1 J dq.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array
from lwr_dyn.simulation.plant import Plant

Mask = NDArray[np.bool_]
"""One yes or no a joint, (n,)."""

SIGN = 1e-12
"""Share of the largest datum below which a sign counts as zero in the complementarity problem: two numbers that
should be zero must not turn each other on and off for ever."""


def complementary(M: Array, b: Array) -> Array:
    """z >= 0 with w = M z + b >= 0 and z w = 0, for a positive definite M (Murty's least-index pivoting).

    >>> complementary(np.array([[2.0]]), np.array([-4.0]))
    array([2.])
    """
    size = b.size
    slack_w = SIGN * float(np.abs(b).max(initial=0.0))
    slack_z = slack_w / float(M.diagonal().max(initial=1e-300))
    active = np.zeros(size, dtype=bool)
    z = np.zeros(size)
    for _ in range(2 ** (size + 1)):
        z = np.zeros(size)
        z[active] = np.linalg.solve(M[np.ix_(active, active)], -b[active])
        wrong = np.where(active, z < -slack_z, M @ z + b < -slack_w)
        if not wrong.any():
            break
        active[int(np.argmax(wrong))] ^= True
    return np.maximum(z, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Impact:
    """Speeds after an impact (n,), which joints were stopped (n,), the work of their stops (n,) [J]: none positive."""

    dq: Array
    stopped: Mask
    work: Array


def impact(plant: Plant, q: Array, dq: Array) -> Impact:
    """What the stops do to joints that reach their limits with outward speed; their work is told joint by joint.

    The work is impulse . (dq- + dq+) / 2, not the energy that went missing: so the audit can compare the two.
    """
    side = plant.at_limit(q)
    at = np.flatnonzero(side)
    B_inv = np.linalg.inv(plant.raw.mass_matrix(q))
    s = side[at]
    z = complementary(s[:, None] * B_inv[np.ix_(at, at)] * s, -s * dq[at])
    impulse = np.zeros(plant.n)
    impulse[at] = -s * z
    after = dq + B_inv @ impulse
    stopped = impulse != 0.0
    after[stopped] = 0.0
    return Impact(after, stopped, impulse * (dq + after) / 2)


def held_joints(plant: Plant, q: Array, dq: Array, tau: Array) -> Mask:
    """Which joints rest against their limits under the torque tau (motors less friction), (n,) bool."""
    side = np.where(dq == 0.0, plant.at_limit(q), 0.0)
    at = np.flatnonzero(side)
    held = np.zeros(plant.n, dtype=bool)
    if at.size:
        B_inv = np.linalg.inv(plant.raw.mass_matrix(q))
        free = B_inv @ (tau - plant.raw.bias_torque(q, dq))
        s = side[at]
        held[at] = complementary(s[:, None] * B_inv[np.ix_(at, at)] * s, -s * free[at]) > 0.0
    return held


def constrained(plant: Plant, q: Array, dq: Array, tau: Array, held: Mask) -> tuple[Array, Array]:
    """Accelerations with the held joints at rest, and the torque of the stops; (n,) each.

    B_ff ddq_f = (tau - n)_f; what is missing in the held rows is the stop's.
    """
    B, rest = plant.raw.mass_matrix(q), tau - plant.raw.bias_torque(q, dq)
    free = ~held
    ddq, push = np.zeros(plant.n), np.zeros(plant.n)
    ddq[free] = np.linalg.solve(B[np.ix_(free, free)], rest[free])
    push[held] = B[np.ix_(held, free)] @ ddq[free] - rest[held]
    return ddq, push
