"""Inverse kinematics over many poses, and the search for the shift of a task."""

from __future__ import annotations

import numpy as np

import lwr_dyn
from lwr_dyn.kinematics.inverse import inverse_kinematics

METRES = 1e-12


def poses() -> tuple[str, bool]:
    """Closed-form inverse kinematics of the LWR over 20 000 random poses inside the limits."""
    arm, rng = lwr_dyn.load("lwr4plus"), np.random.default_rng(5)
    solved, residual = 0, 0.0
    for q in rng.uniform(arm.lower, arm.upper, (20_000, arm.n)):
        T = lwr_dyn.forward_kinematics(arm, q)
        result = inverse_kinematics(arm, T)
        solved += result.status == "solved"
        back = [np.abs(lwr_dyn.forward_kinematics(arm, s.q) - T).max() for s in result.solutions]
        residual = max([residual, *map(float, back)])
    return f"{solved} of 20000 solved, residual {residual:.1e}", solved == 20_000 and residual <= METRES


def ist_clear() -> tuple[str, bool]:
    """The shift of `ist-clear` is the best of its grid."""
    from ist_clear import line

    return line()
