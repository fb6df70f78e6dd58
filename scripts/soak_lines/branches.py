"""Closed forms of six-joint arms against a search from 300 starts."""

from __future__ import annotations

import time

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.tables import aligned

POSES, CALIBRATED, COARSE = 30, 1e-4, 1e-3
SAME = 1e-9
"""[rad] Median over the arms' largest difference between a branch and the same solution of the search."""


def branches() -> tuple[str, bool, str]:
    """All branches of six-joint arms, as the makers' numbers give them and calibrated, against a 300-start search."""
    from tests.kinematics.six_joints.six_joint_arms import PARALLEL, TABLES

    cases = [(name, error) for error in (0.0, CALIBRATED) for name in TABLES]
    cases += [(name, COARSE) for name in ("kr210", "ur10e")]
    rows, missed, extra, gaps = [], 0, 0, []
    for name, error in cases:
        found, shared, only_searched, gap, milliseconds = _counts(name, error)
        missed, extra, gaps = missed + only_searched, extra + found - shared, [*gaps, gap]
        kind = "three parallel axes" if name in PARALLEL else "spherical wrist"
        figures = (str(found), str(shared), str(only_searched), f"{gap:.1e}", f"{milliseconds:.1f}")
        rows.append((name, kind, f"{error:g}", str(POSES), *figures))
    heads = ("arm", "kind", "error", "poses", "branches", "searched too", "searched only", "gap, rad", "CPU ms")
    words = f"{len(cases)} cases of {POSES} poses: {missed} solutions missed, {extra} that the search lacks"
    holds = not missed and not extra and float(np.median(gaps)) <= SAME
    return words, holds, aligned(rows, heads)


def _counts(name: str, error: float) -> tuple[int, int, int, float, float]:
    """Sums over the poses; each pose of a disturbed arm has a disturbance of its own."""
    from tests.kinematics.six_joints.six_joint_arms import against_search, six_joint_arm

    rng, counts, gap, times = np.random.default_rng(3), np.zeros(3, dtype=int), 0.0, []
    for seed in range(POSES):
        arm = six_joint_arm(name, error, seed)
        T = lwr_dyn.forward_kinematics(arm, rng.uniform(-np.pi, np.pi, 6))
        *one, largest = against_search(arm, T)
        start = time.process_time()
        lwr_dyn.inverse_kinematics(arm, T)
        times.append(time.process_time() - start)
        counts, gap = counts + one, max(gap, largest)
    found, shared, only_searched = counts.tolist()
    return found, shared, only_searched, gap, 1e3 * float(np.median(times))
