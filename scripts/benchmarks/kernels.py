"""Generated kernels against Pinocchio, NumPy, JAX and CasADi over a batch of states; their agreement, compile times,
memory, and how far they are from what the machine's arithmetic allows.
"""

from __future__ import annotations

import os
import time

import numpy as np
import pinocchio as pin

import lwr_dyn
from benchmarks.kernel_forms import kernel_forms
from benchmarks.kernel_limit import arithmetic_limit
from benchmarks.kernel_peers import agreement
from benchmarks.kernel_processes import compile_times, memory
from benchmarks.recursion_peers import other_peers
from benchmarks.timing import Call, head, installed, paired, row
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.checks.arm.model_laws import random_states
from lwr_dyn.dynamics.pinocchio_engine import pinocchio_model
from lwr_dyn.model.arm import Arm

COUNT = 100_000


def arms() -> list[Arm]:
    """Robots with inertias, in their default readings."""
    robots = [lwr_dyn.load(robot) for robot in studied()]
    return [arm for arm in robots if arm.chain.bodies is not None]


def against_pinocchio(arm: Arm, threads: int, pairs: int) -> None:
    """Inverse and forward dynamics and B on the same number of threads, results into memory that is there."""
    batch = lwr_dyn.batch_dynamics(arm, threads=threads)
    model = pinocchio_model(arm)
    data, pool = model.createData(), pin.ModelPool(model, threads)
    states = random_states(arm, COUNT, seed=1)
    x = (states.q, states.dq, states.ddq)
    columns = [np.asfortranarray(a.T) for a in x]
    there = np.zeros((arm.n, COUNT), order="F")
    out, B = (batch.form(function).empty(COUNT) for function in ("inverse_dynamics", "mass_matrix"))

    def crba() -> None:
        for q in states.q:
            pin.crba(model, data, q)

    head(f"{arm.name}: {COUNT} states on {threads} thread(s) (time for all)")
    calls: dict[str, tuple[Call, str, Call]] = {
        "inverse_dynamics": (
            lambda: batch.inverse_dynamics(*x, out=out),
            "rneaInParallel",
            lambda: pin.rneaInParallel(threads, pool, *columns, there),
        ),
        "forward_dynamics": (
            lambda: batch.forward_dynamics(*x, out=out),
            "abaInParallel",
            lambda: pin.abaInParallel(threads, pool, *columns, there),
        ),
        "mass_matrix": (lambda: batch.mass_matrix(states.q, out=B), "crba in a loop (1 thread)", crba),
    }
    for function, (ours, peer, theirs) in calls.items():
        mine, other, ratio = paired(ours, theirs, pairs, 1)
        note = f"{1 / ratio:.1f} times faster, {mine / COUNT * 1e9:.1f} ns a state"
        row(function, peer, (mine, other, ratio), note)


def print_agreement(arm: Arm) -> None:
    """Every function against Pinocchio, float64."""
    print(f"\n### {arm.name}: agreement with Pinocchio over {COUNT} states (share of the largest value)\n")
    print("| function | largest difference |\n|---|---|")
    for function, worst in agreement(arm, COUNT).items():
        print(f"| {function} | {worst:.1e} |", flush=True)


def kernels(pairs: int, most_threads: int | None = None) -> None:
    """All of it, for every robot with inertias."""
    if not installed("llvmlite"):
        return
    begin = time.perf_counter()
    for arm in arms():
        for threads in sorted({1, most_threads or os.cpu_count() or 1}):
            against_pinocchio(arm, threads, pairs)
        arithmetic_limit(arm, pairs)
        kernel_forms(arm, pairs)
        print_agreement(arm)
        compile_times(arm)
        memory(arm)
    other_peers(lwr_dyn.load("lwr4plus"), COUNT, pairs)
    print(f"\n({time.perf_counter() - begin:.0f} s for this part)")
