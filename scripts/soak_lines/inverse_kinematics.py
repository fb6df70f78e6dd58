"""One solution of every pose: public arms, random, singular, and at their limits."""

from __future__ import annotations

import numpy as np

import lwr_dyn
from lwr_dyn.model.arm import Arm

RANDOM, SINGULAR, AT_LIMITS = 5000, 300, 300


def ik() -> tuple[str, bool, str]:
    """One solution to 1e-9 m and rad inside the limits: 5000 random, 300 singular, 300 poses at limits on nine arms."""
    from tests.public_arms import NAMES, positions_at_limits, public_arm, random_positions, singular_positions

    rows, good = [], True
    for name in NAMES:
        arm = public_arm(name)
        families = ((random_positions, RANDOM), (singular_positions, SINGULAR), (positions_at_limits, AT_LIMITS))
        results = [_reached(arm, family(arm, count, seed=10)) for family, count in families]
        good = good and all(reached == count for reached, (_, count) in zip(results, families, strict=True))
        rows.append(f"| {name} | " + " | ".join(map(str, results)) + " |")
    head = f"| arm | of {RANDOM} random | of {SINGULAR} singular | of {AT_LIMITS} at limits |\n|---|---|---|---|"
    return f"{len(rows)} arms", good, "\n".join([head, *rows])


def _reached(arm: Arm, q: np.ndarray) -> int:
    """How many poses of these positions are reached, as forward kinematics sees it."""
    T = lwr_dyn.forward_kinematics(arm, q)
    found = lwr_dyn.ik_solver(arm, search="kernel").batch(T)
    inside = ((found.q >= arm.lower) & (found.q <= arm.upper)).all(axis=-1)
    back = lwr_dyn.forward_kinematics(arm, np.where(found.found[:, None], found.q, 0.0))
    place = np.linalg.norm(back[:, :3, 3] - T[:, :3, 3], axis=-1)
    angle = np.linalg.norm(back[:, :3, :3] - T[:, :3, :3], axis=(1, 2)) / np.sqrt(2.0)
    return int((found.found & inside & (place <= 1e-9) & (angle <= 1e-9)).sum())
