"""How many fused products and sums of float64 a core does just now: a loop of nothing else, beside what is measured."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from benchmarks.timing import seconds
from lwr_dyn.codegen.kernels.loop_code import KernelLoop, LaneBody
from lwr_dyn.codegen.kernels.machine_code import lanes_of, load
from lwr_dyn.kinematics.closed_forms.text_parser import parsed

_CHAINS, _ROUNDS, _TURNS = 16, 8, 2000
"""Chains that do not wait for each other; operations of each chain before it is stored; turns of the loop."""
_TEXT = """
int turns(double *out, double *b, int start, int stop)
{
    for (int s = start; s < stop; s++) {
        body(b);
    }
    return 0;
}
"""


@cache
def _loop() -> tuple[Callable[[], object], int]:
    """The loop, and its fused operations on single numbers."""
    lanes = lanes_of("float64")
    lines = [f"x{i} = b[{i * lanes} + k]" for i in range(_CHAINS)]
    lines += [f"c = b[{_CHAINS * lanes} + k]", f"d = b[{(_CHAINS + 1) * lanes} + k]"]
    names = [f"x{i}" for i in range(_CHAINS)]
    for j in range(_ROUNDS):
        for i in range(_CHAINS):
            lines += [f"p{i}_{j} = {names[i]} * c", f"y{i}_{j} = p{i}_{j} + d"]
            names[i] = f"y{i}_{j}"
    lines += [f"b[{i * lanes} + k] = {names[i]}" for i in range(_CHAINS)]
    size = (_CHAINS + 2) * lanes
    body = "\n".join([f"def body(b):\n    for k in range({lanes}):", *(f"        {line}" for line in lines)])
    loop = KernelLoop(parsed(_TEXT, {}), "turns", (LaneBody("body", body),))
    code = load(loop.machine_code(), "kernel", inputs=0)
    memory = np.full(size + 8, 0.5)
    place = memory.__array_interface__["data"][0]

    def call() -> object:
        return code.call(place, place + -place % 64, 0, _TURNS), memory

    return call, lanes * _CHAINS * _ROUNDS * _TURNS


def fused_rate() -> float:
    """Fused operations a second on single numbers, the best of three short loops."""
    call, operations = _loop()
    return operations / min(seconds(call, 1) for _ in range(3))
