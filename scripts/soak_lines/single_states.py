"""Single states at C level: a million random arrays, refused or right; two million calls, and the memory after them."""

from __future__ import annotations

import resource

import numpy as np

import lwr_dyn
from lwr_dyn.dynamics.protocol import FUNCTIONS
from tests.codegen.kernels.wrong_arrays import refused_or_right

ARRAYS, CALLS = 1_000_000, 2_000_000
GROWTH = 2_000
"""[kB] of the largest memory that is no growth: one array a call would be 300 MB."""


def single_arrays() -> tuple[str, bool]:
    """Arguments of wrong shape, type, order, stride, class ... into every function."""
    arm = lwr_dyn.load("lwr4plus")
    engine, refused, answered = lwr_dyn.dynamics_of(arm, "kernels"), 0, 0
    for seed, (function, (arguments, _)) in enumerate(FUNCTIONS.items()):
        count = len(arguments)
        more = refused_or_right(getattr(engine, function), count, arm.n, ARRAYS // len(FUNCTIONS), seed)
        refused, answered = refused + more[0], answered + more[1]
    return f"{ARRAYS} arrays in {refused + answered} calls: {refused} refused, {answered} right", True


def single_memory() -> tuple[str, bool]:
    """Calls of every function, good and refused, and the memory before and after."""
    arm = lwr_dyn.load("lwr4plus")
    engine = lwr_dyn.dynamics_of(arm, "kernels")
    q, dq, x = np.random.default_rng(0).uniform(-2.0, 2.0, (3, arm.n))

    def calls(times: int) -> None:
        for function, (arguments, _) in FUNCTIONS.items():
            call, given = getattr(engine, function), (q, dq, x)[: len(arguments)]
            for _ in range(times):
                call(*given)

    calls(20_000)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    calls(CALLS // len(FUNCTIONS))
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    return f"{CALLS} calls: the largest memory grew by {grown} kB", grown < GROWTH
