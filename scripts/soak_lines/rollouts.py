"""Ten thousand closed loops from arrays to metrics, in a process of its own, and some of them beside `simulate`."""

from __future__ import annotations

import multiprocessing
import resource
import time

import numpy as np

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.model.arm import Arm

RUNS, SECONDS, MEGABYTES, BESIDE = 10_000, 30.0, 500.0, 10


def rollouts() -> tuple[str, bool]:
    """10 000 IST runs of 14 s, masses within 20 %, inverse dynamics: processor time, memory, 10 runs by simulate."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        seconds, memory, flagged, off = pool.apply(_computed)
    holds = seconds <= SECONDS and memory <= MEGABYTES and flagged == 0 and off <= 1e-12
    words = f"{seconds:.1f} s of processor time, {memory:.0f} MB, {flagged} handed over"
    return f"{words}; {BESIDE} runs differ by {off:.1e} rad, m at most", holds


def _computed() -> tuple[float, float, int, float]:
    from lwr_dyn.codegen.rollouts.result import figures_of

    arm = lwr_dyn.load("lwr4plus")
    path, law = lwr_dyn.reference("ist-clear", arm), lwr_dyn.controller("inverse-dynamics", arm, omega_n=50.0)
    lwr_dyn.rollouts(arm, law, path, parameters=_masses(arm, 1), duration=0.1)  # compiled
    begun = time.process_time()
    done = lwr_dyn.rollouts(arm, law, path, parameters=_masses(arm, RUNS), threads=2)
    seconds = time.process_time() - begun
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    off = 0.0
    for i in np.linspace(0, RUNS - 1, BESIDE).astype(int).tolist():
        beside = figures_of(done.run(i), arm)
        names = ("tip_rms", "tip_max", "tip_final", "position_rms", "position_max", "limit_margin")
        off = max(off, *(float(np.abs(beside[name] - done.metrics[name][i]).max()) for name in names))
    return seconds, memory, sum(map(bool, done.flags)), off


def _masses(arm: Arm, runs: int) -> dict[str, np.ndarray]:
    """Each link's mass and inertia with a factor of its own."""
    factors = np.random.default_rng(0).uniform(0.8, 1.2, (runs, arm.n, 1))
    return {"inertia": factors * inertial_parameters(arm.chain)}
