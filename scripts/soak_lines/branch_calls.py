"""All branches of a pose at C level: poses in every form, refused or right; two million calls, and the memory."""

from __future__ import annotations

import resource

import numpy as np

import lwr_dyn
from soak_lines.single_states import CALLS, GROWTH
from tests.kinematics.wrong_poses import refused_or_right

POSES = 1_000_000

ARMS = ("kr30ha", "ur10", "lwr4plus")


def branch_arrays() -> tuple[str, bool]:
    """Poses of wrong shape, type, order, stride, class ... into inverse kinematics."""
    refused, answered = 0, 0
    for seed, name in enumerate(ARMS):
        more = refused_or_right(lwr_dyn.load(name), POSES // len(ARMS), seed)
        refused, answered = refused + more[0], answered + more[1]
    return f"{refused + answered} poses: {refused} refused, {answered} right", True


def branch_memory() -> tuple[str, bool]:
    """Calls of inverse kinematics of three arms, every third one's rows read, and the memory before and after."""

    def calls(times: int) -> None:
        for name in ARMS:
            arm = lwr_dyn.load(name)
            middle = np.clip(np.full(arm.n, 0.4), arm.lower, arm.upper)
            T, angle = lwr_dyn.forward_kinematics(arm, middle), 0.3 if arm.n == 7 else None
            far = T + np.array([0.0, 0.0, 0.0, 9.0]) * np.array([[1.0], [0.0], [0.0], [0.0]])
            for k in range(times):
                result = lwr_dyn.inverse_kinematics(arm, far if k % 5 == 0 else T, arm_angle=angle)
                if k % 3 == 0 and len(result.solutions):
                    _ = result.solutions[0].q

    calls(10_000)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    calls(CALLS // len(ARMS))
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    return f"{CALLS} calls: the largest memory grew by {grown} kB", grown < GROWTH
