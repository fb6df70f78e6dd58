"""How far generated kernels are from what the arithmetic of this machine allows."""

from __future__ import annotations

import statistics
import time

import lwr_dyn
from benchmarks.timing import Call, seconds
from lwr_dyn.checks.identities import random_states
from lwr_dyn.codegen.kernel_spec import FUNCTIONS
from lwr_dyn.model.arm import Arm


def clock() -> float:
    """Clock of this core [Hz]: a chain of x = x x + c on integers takes 3 + 1 cycles a step on today's processors.

    In processor time: another process on the core does not make it slower.
    """
    from numba import njit

    @njit
    def chain(n: int, x: int) -> int:
        for _ in range(n):
            x = x * x + 12345
        return x

    chain(10, 3)
    steps = 5_000_000
    took = []
    for _ in range(9):
        start = time.process_time()
        chain(steps, 3)
        took.append(time.process_time() - start)
    return 4 * steps / min(took)


def arithmetic_limit(arm: Arm, pairs: int) -> None:
    """Operations of a state over lanes, two vector instructions a clock, against the time it takes inside the cache."""
    hertz, count = clock(), 4096
    batch, states = lwr_dyn.batch_dynamics(arm), random_states(arm, count, seed=2)
    x = (states.q, states.dq, states.ddq)
    print(f"\n### {arm.name}: distance from the arithmetic limit, one thread, {count} states\n")
    lanes = batch.kernel("gravity_vector").interface.lanes
    print(f"(limit = fused operations / (2 x {lanes} lanes x {hertz / 1e9:.2f} GHz))\n")
    print(
        "| function | operations | fused | limit [ns] | measured [ns] | measured / limit |\n|---|---|---|---|---|---|"
    )
    for function in FUNCTIONS:
        known = batch.kernel(function).interface
        call: Call = lambda f=function: getattr(batch, f)(*x[: len(FUNCTIONS[f].states)])  # noqa: E731
        call()
        took = statistics.median(seconds(call, 5) for _ in range(2 * pairs)) / count
        limit = known.fused / (2 * lanes * hertz)
        print(
            f"| {function} | {known.operations} | {known.fused} | {limit * 1e9:.1f} | {took * 1e9:.1f} "
            f"| {took / limit:.2f} |"
        )
