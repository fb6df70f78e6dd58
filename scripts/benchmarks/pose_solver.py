"""One solution of a pose: `ik_solver` against robotics-toolbox-python's C (ik_LM) at the same tolerance, call by call.

Both stop at 1e-9 m and rad (the toolbox's `tol` is on E = |e|^2 / 2) and give solutions inside the limits. The arms are
those of `tests/public_arms.toml`. The toolbox: pip install roboticstoolbox-python==1.5.0
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import lwr_dyn
from benchmarks.timing import installed
from lwr_dyn.foundation.errors import PoseNotReachedError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.spatial import pose_array

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.public_arms import NAMES, public_arm, random_positions

COUNT, BATCH = 1000, 20_000
TOLERANCE = 1e-9
Solve = Callable[[NDArray[np.float64], NDArray[np.float64] | None], NDArray[np.float64] | None]


def toolbox(arm: Arm) -> Solve:
    """The toolbox's C solver on the same chain; None where it gives up."""
    from roboticstoolbox import ET

    chain = ET.SE3(np.eye(4))
    low = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    up = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    for i, link in enumerate(arm.chain.links):
        moving = ET.Rz if link.kind is JointKind.REVOLUTE else ET.tz
        chain = chain * ET.SE3(link.before.matrix()) * moving(qlim=[low[i], up[i]]) * ET.SE3(link.after.matrix())
    chain = (chain * ET.SE3(arm.chain.flange.matrix())).compile()

    def solve(T: NDArray[np.float64], q0: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
        answer = chain.ik_LM(T, q0=q0, tol=TOLERANCE**2 / 2.0, slimit=300)
        return answer.q if answer.success else None

    return solve


def ours(arm: Arm, search: str) -> Solve:
    """Our solver; None where it gives up."""
    solver = lwr_dyn.ik_solver(arm, search=search)

    def solve(T: NDArray[np.float64], q0: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
        try:
            return solver(T, q0)
        except PoseNotReachedError:
            return None

    return solve


def measured(solve: Solve, poses: NDArray[np.float64], near: NDArray[np.float64] | None) -> str:
    """Median / 99 % of the time of a call [us], and how many poses were missed."""
    seconds, missed = [], 0
    solve(poses[0], None if near is None else near[0])
    for k, T in enumerate(poses):
        q0 = None if near is None else near[k]
        start = time.perf_counter()
        q = solve(T, q0)
        seconds.append(time.perf_counter() - start)
        missed += q is None
    share = f"{1e6 * statistics.median(seconds):.1f} / {1e6 * np.quantile(seconds, 0.99):.0f}"
    return share + (f" ({missed} missed)" if missed else "")


def _batch(arm: Arm, near: bool) -> str:
    """Processor time a pose of a batch on one thread [us], the least of five."""
    solver, q = lwr_dyn.ik_solver(arm, search="kernel"), random_positions(arm, BATCH, seed=1)
    T = lwr_dyn.forward_kinematics(arm, q)
    q0 = np.clip(q + np.random.default_rng(2).uniform(-0.05, 0.05, q.shape), arm.lower, arm.upper) if near else None
    seconds = []
    for _ in range(5):
        start = time.process_time()
        missed = int((~solver.batch(T, q0).found).sum())
        seconds.append(time.process_time() - start)
    return f"{1e6 * min(seconds) / BATCH:.2f}" + (f" ({missed} missed)" if missed else "")


def _out_of_reach(arm: Arm) -> float:
    """Median time to give a pose up that lies beyond the arm [ms], over ten poses."""
    solve, times = ours(arm, "kernel"), []
    for T in lwr_dyn.forward_kinematics(arm, random_positions(arm, 10, seed=3)):
        T[:3, 3] *= 10.0 / np.linalg.norm(T[:3, 3])
        start = time.perf_counter()
        assert solve(T, None) is None
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def one_solution(pairs: int) -> None:
    """Cold and from 0.05 rad away, single calls and batches; ours and the toolbox's in turn, arm by arm."""
    peer = installed("roboticstoolbox")
    print(f"\n### One solution of a pose to 1e-9 m and rad: median / 99 % of {COUNT} calls from Python [us]\n")
    print("| arm | ours, cold | toolbox, cold | ours, near | toolbox, near | on Pinocchio, cold | near "
          "| batch, cold, a pose | batch, near | out of reach [ms] |\n|" + "---|" * 10)  # fmt: skip
    for name in NAMES:
        arm = public_arm(name)
        q = random_positions(arm, COUNT, seed=0)
        T = lwr_dyn.forward_kinematics(arm, q)
        near = np.clip(q + np.random.default_rng(1).uniform(-0.05, 0.05, q.shape), arm.lower, arm.upper)
        kernel, pinocchio = ours(arm, "kernel"), ours(arm, "pinocchio")
        theirs = toolbox(arm) if peer else None
        cells = [name]
        for start in (None, near):
            cells += [measured(kernel, T, start), measured(theirs, T, start) if theirs else "-"]
        cells += [measured(pinocchio, T[:200], start if start is None else start[:200]) for start in (None, near)]
        cells += [_batch(arm, False), _batch(arm, True), f"{_out_of_reach(arm):.2f}"]
        print(f"| {' | '.join(cells)} |", flush=True)
    T = lwr_dyn.forward_kinematics(public_arm("ur10e"), np.full(6, 0.3))
    print(f"\nThe check of a pose by NumPy, which the kernel does itself: {_check(T):.1f} us")


def _check(T: NDArray[np.float64]) -> float:
    start = time.perf_counter()
    for _ in range(COUNT):
        pose_array("T", T)
    return 1e6 * (time.perf_counter() - start) / COUNT
