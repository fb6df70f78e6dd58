"""All solutions of a pose: our closed forms against a search from 300 starts and against EAIK."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import lwr_dyn
from benchmarks.timing import Call, head, installed, paired, row
from lwr_dyn.kinematics.inverse import IK_SOLVERS, inverse_kinematics, search

POSES, STARTS = 20, 300


def all_solutions(pairs: int) -> None:
    """One pose with all its branches (and whole turns inside +-180 deg, so one copy each), a mean over poses."""
    sys.path.append(str(Path(__file__).resolve().parents[2]))  # the arms are those of `tests`
    from tests.kinematics.six_joints.six_joint_arms import six_joint_arm

    with_eaik, anywhere = installed("eaik"), np.full(6, np.inf)
    head(f"All solutions of one pose (mean of {POSES} poses)")
    for name, error in (("ur10e", 0.0), ("ur10e", 1e-4), ("kr210", 0.0), ("kr210", 1e-4), ("m1013", 0.0)):
        arm = six_joint_arm(name, error, reach=np.pi)
        poses = lwr_dyn.forward_kinematics(arm, np.random.default_rng(3).uniform(-np.pi, np.pi, (POSES, 6)))
        ours = every(poses, lambda T, arm=arm: inverse_kinematics(arm, T, limits=False))
        what = f"{name}, numbers off by {error:g}" if error else name
        peers: dict[str, Call] = {
            f"search from {STARTS} starts": every(
                poses[:2], lambda T, arm=arm: search(arm.chain, -anywhere, anywhere, T, STARTS, 0)
            )
        }
        if with_eaik and (eaik := IK_SOLVERS.load("eaik").recognise(arm.chain)) is not None:
            peers["EAIK's own call, unfiltered"] = every(poses, eaik.robot.IK)
            peers["solver eaik, filtered"] = every(
                poses, lambda T, arm=arm: inverse_kinematics(arm, T, limits=False, solver="eaik")
            )
        for peer, theirs in peers.items():
            count = 2 if peer.startswith("search") else POSES
            a, b, _ = paired(ours, theirs, pairs, 1)
            row(what, peer, (a / POSES, b / count, a / POSES / (b / count)))


def every(poses: np.ndarray, one: Call) -> Call:
    """A call over all poses."""
    return lambda: [one(T) for T in poses]
