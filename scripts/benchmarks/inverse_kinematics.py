"""All solutions of a pose: our closed forms against a search from 300 starts, EAIK and ssik."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import lwr_dyn
from benchmarks.timing import Call, head, installed, paired, row
from lwr_dyn.kinematics.closed_forms.lazy_solutions import LazySolutions
from lwr_dyn.kinematics.inverse import IK_SOLVERS, inverse_kinematics, search
from lwr_dyn.kinematics.solution import InverseResult

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

    as_called(pairs)


def as_called(pairs: int) -> None:
    """One pose inside the limits as a user calls it: the result, all rows read, in plain Python; EAIK and ssik.

    EAIK gives the eight branches of a pose without limits, residuals or whole turns; ssik all, one object each.
    """
    from lwr_dyn.kinematics.closed_forms.runners import python_runner
    from lwr_dyn.kinematics.inverse import _ready

    head(f"All solutions of one pose inside the limits, as called (mean of {POSES} poses)")
    with_eaik, with_ssik = installed("eaik"), installed("ssik")
    for name in ("kr30ha", "ur10", "ur5e", "lwr4plus", "iiwa14"):
        arm = lwr_dyn.load(name)
        rng, low, up = np.random.default_rng(3), np.maximum(arm.lower, -6.0), np.minimum(arm.upper, 6.0)
        poses = lwr_dyn.forward_kinematics(arm, rng.uniform(low, up, (POSES, arm.n)))
        ours = every(poses, lambda T, arm=arm: lwr_dyn.inverse_kinematics(arm, T))
        peers: dict[str, Call] = {
            "and all rows read": every(poses, lambda T, arm=arm: rows(lwr_dyn.inverse_kinematics(arm, T)))
        }
        if arm.n == 7:
            peers["at a given arm angle"] = every(
                poses, lambda T, arm=arm: lwr_dyn.inverse_kinematics(arm, T, arm_angle=0.3)
            )
        else:
            solver = _ready(arm, None)
            plain = replace(solver, run=python_runner(solver.texts, solver.numbers).run)
            peers["in plain Python"] = every(poses, lambda T, plain=plain: plain(T, True))
        if with_eaik and arm.n == 6:
            peers["EAIK's own call"] = every(poses, IK_SOLVERS.load("eaik").recognise(arm.chain).robot.IK)
        if with_ssik:
            import ssik

            urdf = Path(__file__).resolve().parents[2] / "models" / name / f"{name}.urdf"
            peers["ssik"] = every(poses, ssik.Manipulator.from_urdf(urdf, base="base", ee="flange").solve)
        for peer, theirs in peers.items():
            a, b, ratio = paired(ours, theirs, pairs, 1)
            row(name, peer, (a / POSES, b / POSES, ratio))


def rows(result: InverseResult) -> None:
    """Every solution's numbers."""
    for each in (result.solutions, result.outside):
        if isinstance(each, LazySolutions):
            _ = each.q


def every(poses: np.ndarray, one: Call) -> Call:
    """A call over all poses."""
    return lambda: [one(T) for T in poses]
