"""A joint that sticks, as it is against smoothed by tanh: time and error of a run of the WAM."""

from __future__ import annotations

import statistics
import time

import numpy as np
from scipy.integrate import solve_ivp

import lwr_dyn
from benchmarks.timing import Call, seconds
from lwr_dyn.control.paper_laws import PDGravity, tuned_pd_gravity
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import smooth_friction
from lwr_dyn.reproduction.wam7.runs import BLEND, DURATION, PD, START, TRAVEL, move, weightless
from lwr_dyn.simulation.simulate import simulate


def with_friction(pairs: int) -> None:
    """The WAM with its friction, all joints 0.5 rad in 7 s: true stick against tanh friction in scipy's solvers.

    Errors are the largest |q - reference| over the samples, the reference being true stick by DOP853 at 1e-12 with
    the same control (sampled, or evaluated all the time). Joint 4 is apart: it sticks and slips in a limit cycle.
    """
    arm = weightless(lwr_dyn.load("wam7"))
    reference, law = move(arm, None), tuned_pd_gravity(arm, lwr_dyn.dynamics_of(arm), **PD)
    print("\n### 7 s of the WAM with friction, all joints\n")
    print("| friction, control | method | s | evaluations | error, joint 4 apart [mrad] | joint 4 [mrad] |")
    print("|---|---|---|---|---|---|")

    def row(what: str, method: str, took: float, evaluations: int, q: np.ndarray, best: np.ndarray) -> None:
        error = 1e3 * np.abs(q - best).max(axis=0)
        others = np.delete(error, 3).max()
        print(f"| {what} | {method} | {took:.3f} | {evaluations} | {others:.2g} | {error[3]:.2g} |", flush=True)

    for continuous, what in ((False, "true stick, 1 kHz"), (True, "true stick, continuous")):
        best = simulate(arm, law, reference, method="dop853", continuous=continuous)
        for substeps in (1, 2):
            run = simulate(arm, law, reference, substeps=substeps, continuous=continuous)
            ours: Call = lambda m=substeps, c=continuous: simulate(arm, law, reference, substeps=m, continuous=c)  # noqa: E731
            took = statistics.median(seconds(ours, 1) for _ in range(pairs))
            row(what, f"RK4, {substeps} a sample", took, run.meta["evaluations"], run.q, best.q)
    for method, width in (("Radau", 1e-2), ("RK45", 1e-2), ("Radau", 1e-3)):
        begin = time.perf_counter()
        solution = tanh_run(arm, law, method, width, best.t)
        what = f"tanh(dq / {width:g}), continuous"
        row(
            what,
            f"scipy {method}, rtol 1e-6",
            time.perf_counter() - begin,
            solution.nfev,
            solution.y[: arm.n].T,
            best.q,
        )


def tanh_run(arm: Arm, law: PDGravity, method: str, width: float, t: np.ndarray) -> object:
    """The same movement with tanh friction by a solver of scipy; the controller and its LSPB written out for speed."""
    friction, forward, start = (
        smooth_friction(arm.friction_models(), width),
        lwr_dyn.dynamics_of(arm).ungated.forward_dynamics,
        np.array(START),
    )
    Kp, Kd, n, v = law.Kp, law.Kd, arm.n, TRAVEL / (DURATION - BLEND)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        q, dq = y[:n], y[n:]
        up, down = min(t, BLEND), max(0.0, t - DURATION + BLEND)
        travel, speed = v * (up**2 / (2 * BLEND) + max(0.0, t - BLEND) - down**2 / (2 * BLEND)), v * (up - down) / BLEND
        tau = Kp * (start + travel - q) + Kd * (speed - dq) - friction(dq)
        return np.concatenate([dq, forward(q, dq, tau)])

    begin = np.concatenate([start, np.zeros(n)])
    return solve_ivp(rates, (0.0, t[-1]), begin, method, t_eval=t, rtol=1e-6, atol=1e-9)
