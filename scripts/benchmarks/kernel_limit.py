"""How far generated kernels are from what the arithmetic of this machine allows in the same moment."""

from __future__ import annotations

import statistics

import lwr_dyn
from benchmarks.fused_rate import fused_rate
from benchmarks.timing import Call, seconds
from lwr_dyn.checks.arm.model_laws import random_states
from lwr_dyn.codegen.kernels.batch import BatchDynamics
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS
from lwr_dyn.model.arm import Arm

_MOST_STATES, _MOST_BYTES = 4096, 1 << 20
"""Results of more bytes would leave the cache of a core."""
FORMS = (("rows", "dense"), ("padded", "dense"), ("blocks", "dense"), ("rows", "compact"), ("blocks", "compact"))


def kernel_call(batch: BatchDynamics, function: str, arm: Arm, count: int) -> Call:
    """The kernel alone: into memory that is there, without a look at the arguments."""
    states = random_states(arm, count, seed=2)
    x = (states.q, states.dq, states.ddq)[: len(FUNCTIONS[function].states)]
    out = batch.form(function).empty(count)
    kernel = batch.kernel(function)
    rows = [(a.__array_interface__["data"][0], arm.n) for a in x]
    place = out.__array_interface__["data"][0]

    def call() -> object:
        return kernel.run(rows, place, count), x, out

    return call


def distance(call: Call, fused: int, count: int, pairs: int) -> tuple[float, float, float]:
    """Medians: seconds a state, its limit in the same round, and their quotient."""
    call()
    rounds = [(seconds(call, 3) / count, fused / fused_rate()) for _ in range(pairs)]
    return (
        statistics.median(took for took, _ in rounds),
        statistics.median(limit for _, limit in rounds),
        statistics.median(took / limit for took, limit in rounds),
    )


def arithmetic_limit(arm: Arm, pairs: int) -> None:
    """Every function, inside the cache, against fused operations at the rate of a loop of nothing else."""
    print(f"\n### {arm.name}: distance from the arithmetic limit, one thread\n")
    print("(limit = fused operations at the rate of a loop of nothing else, measured in the same round)\n")
    print("| function | result | states | operations | fused | limit [ns] | measured [ns] | measured / limit |")
    print("|---|---|---|---|---|---|---|---|")
    for function in FUNCTIONS:
        has_forms = function in ("mass_matrix", "torque_regressor")
        for layout, structure in FORMS if has_forms else FORMS[:1]:
            batch = lwr_dyn.batch_dynamics(arm, layout=layout, structure=structure)
            known = batch.kernel(function).interface
            count = min(_MOST_STATES, _MOST_BYTES // (8 * known.width) // 64 * 64)
            took, limit, ratio = distance(kernel_call(batch, function, arm, count), known.fused, count, pairs)
            print(
                f"| {function} | {layout}, {structure} | {count} | {known.operations} | {known.fused} "
                f"| {limit * 1e9:.1f} | {took * 1e9:.1f} | {ratio:.2f} |",
                flush=True,
            )
