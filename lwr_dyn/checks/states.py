"""Random states inside an arm's limits, the same for the same seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.model.arm import Arm

SPEED, ACCELERATION = 2.0, 10.0
"""Half-widths of the random joint speeds and accelerations [rad/s, rad/s^2]."""


@dataclass(frozen=True, slots=True, eq=False)
class States:
    """q, dq, ddq, (count, n) each."""

    q: Array
    dq: Array
    ddq: Array


def random_states(arm: Arm, count: int, seed: int) -> States:
    """Joint positions uniform inside the limits (+-pi where unknown), speeds and accelerations uniform."""
    rng = np.random.default_rng(seed)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    q = rng.uniform(lower, upper, (count, arm.n))
    dq = rng.uniform(-SPEED, SPEED, (count, arm.n))
    return States(q, dq, rng.uniform(-ACCELERATION, ACCELERATION, (count, arm.n)))
