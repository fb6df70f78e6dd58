"""Figures of a reading without motion: gravity torques over poses, largest inertias, gains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lwr_dyn.control.gains import Gains, second_order_gains
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True, eq=False)
class Statics:
    """One reading: gravity torques at the sampled poses (k, n), largest inertias and gains (n,)."""

    gravity: Array
    """[N m]"""
    b: Array
    """max B_ii over the joint box [kg m^2]."""
    gains: Gains

    def gravity_off(self, other: Statics) -> Array:
        """Largest |g - g'| of each joint over the poses, (n,) [N m]."""
        return read_only(np.abs(self.gravity - other.gravity).max(axis=0))


def shared_poses(arms: Mapping[str, Arm], count: int, seed: int) -> Array:
    """Joint positions uniform in the box that all arms allow (+-pi where nothing is known), (count, n).

    A joint whose ranges do not overlap is sampled over the first arm's range.
    """
    lower = np.array([np.where(np.isfinite(a.lower), a.lower, -np.pi) for a in arms.values()])
    upper = np.array([np.where(np.isfinite(a.upper), a.upper, np.pi) for a in arms.values()])
    low, high = lower.max(axis=0), upper.min(axis=0)
    disjoint = low >= high
    low, high = np.where(disjoint, lower[0], low), np.where(disjoint, upper[0], high)
    return np.random.default_rng(seed).uniform(low, high, (count, lower.shape[1]))


def statics_of(arms: Mapping[str, Arm], poses: int, seed: int, omega_n: float, xi: float) -> dict[str, Statics]:
    """The statics of every arm at the same poses; raises `MissingDataError` for one without inertias."""
    q = shared_poses(arms, poses, seed)
    out = {}
    for name, arm in arms.items():
        b = np.array([w.value for w in worst_case_inertias(arm)])
        gravity = dynamics_of(arm, "newton-euler").gravity_vector(q)
        out[name] = Statics(read_only(gravity), read_only(b), second_order_gains(b, omega_n, xi))
    return out
