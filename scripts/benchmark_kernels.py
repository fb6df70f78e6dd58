"""Generated kernels against Pinocchio, NumPy, JAX and CasADi over a batch of states; their agreement, compile times,
memory, and how far they are from what the machine's arithmetic allows.

    python scripts/benchmark_kernels.py            # or as the last part of benchmark.py
"""

from __future__ import annotations

import argparse
import operator
import os
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np
import pinocchio as pin
from kernel_peers import pinocchio_answers, relative_difference
from timing import Call, head, installed, paired, row, seconds

import lwr_dyn
from lwr_dyn.arm import Arm
from lwr_dyn.checks.states import random_states
from lwr_dyn.dynamics.engine import pinocchio_model
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.recursion import inverse_dynamics
from lwr_dyn.kernels.functions import FUNCTIONS

COUNT = 100_000


def arms() -> list[Arm]:
    """Robots with inertias, in their default readings."""
    found = [lwr_dyn.load(robot) for robot in lwr_dyn.robots()]
    return [arm for arm in found if arm.chain.bodies is not None]


def rows_of(function: str, x: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    """The states that a function takes."""
    return x[: len(FUNCTIONS[function].states)]


def against_pinocchio(arm: Arm, threads: int, pairs: int) -> None:
    """Inverse and forward dynamics and B on the same number of threads, results into memory that is there."""
    batch = lwr_dyn.batch_dynamics(arm, threads=threads)
    model = pinocchio_model(arm)
    data, pool = model.createData(), pin.ModelPool(model, threads)
    states = random_states(arm, COUNT, seed=1)
    x = (states.q, states.dq, states.ddq)
    columns = [np.asfortranarray(a.T) for a in x]
    there, out = np.zeros((arm.n, COUNT), order="F"), np.empty((COUNT, arm.n))
    B = np.empty((COUNT, arm.n, arm.n))

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


def clock() -> float:
    """Clock of this core [Hz]: a chain of x = x x + c on integers takes 3 + 1 cycles a step on today's processors."""
    from numba import njit

    @njit
    def chain(n: int, x: int) -> int:
        for _ in range(n):
            x = x * x + 12345
        return x

    chain(10, 3)
    steps = 5_000_000
    return 4 * steps / min(seconds(lambda: chain(steps, 3), 1) for _ in range(9))


def arithmetic_limit(arm: Arm, pairs: int) -> None:
    """Operations of a state over lanes, two vector instructions a clock, against the time it takes inside the cache."""
    hertz, count = clock(), 4096
    batch, states = lwr_dyn.batch_dynamics(arm), random_states(arm, count, seed=2)
    x = (states.q, states.dq, states.ddq)
    print(f"\n### {arm.name}: distance from the arithmetic limit, one thread, {count} states\n")
    lanes = batch.kernel("gravity_vector").description.lanes
    print(f"(limit = fused operations / (2 x {lanes} lanes x {hertz / 1e9:.2f} GHz))\n")
    print(
        "| function | operations | fused | limit [ns] | measured [ns] | measured / limit |\n|---|---|---|---|---|---|"
    )
    for function in FUNCTIONS:
        known = batch.kernel(function).description
        call: Call = lambda f=function: getattr(batch, f)(*rows_of(f, x))  # noqa: E731
        call()
        took = statistics.median(seconds(call, 5) for _ in range(2 * pairs)) / count
        limit = known.fused / (2 * lanes * hertz)
        print(
            f"| {function} | {known.operations} | {known.fused} | {limit * 1e9:.1f} | {took * 1e9:.1f} "
            f"| {took / limit:.2f} |"
        )


def other_peers(arm: Arm, pairs: int) -> None:
    """Inverse dynamics by the same recursion in NumPy, in JAX (jitted, batched), and as CasADi's compiled map."""
    batch, states = lwr_dyn.batch_dynamics(arm), random_states(arm, COUNT, seed=3)
    x, out = (states.q, states.dq, states.ddq), np.empty((COUNT, arm.n))
    ours: Call = lambda: batch.inverse_dynamics(*x, out=out)  # noqa: E731
    recursion = Recursion.of(arm.chain)
    head(f"{arm.name}: inverse dynamics of {COUNT} states, one thread, the same recursion elsewhere")
    peers: dict[str, Call] = {"NumPy, batched": lambda: recursion.inverse_dynamics(*x)}
    if installed("jax"):
        peers["JAX, jit and vmap"] = jax_call(recursion, x)
    if installed("casadi"):
        peers["CasADi, map of compiled C"] = casadi_call(arm, x)
    for name, theirs in peers.items():
        result = paired(ours, theirs, pairs, 1)
        row(
            "inverse_dynamics",
            name,
            result,
            f"{1 / result[2]:.0f} times faster, {result[1] / COUNT * 1e9:.0f} ns a state",
        )


def jax_call(recursion: Recursion, x: tuple[np.ndarray, ...]) -> Call:
    """The recursion jitted over a batch, on arrays already on the device."""
    import jax

    jax.config.update("jax_enable_x64", True)
    numbers = jax.numpy

    def one(*state: object) -> object:
        given = [[JaxNumber(v[i]) for i in range(len(recursion.links))] for v in state]
        torque = inverse_dynamics(recursion.links, recursion.gravity, *given)
        return numbers.stack([getattr(t, "value", t) for t in torque])

    arrays = [numbers.asarray(a) for a in x]
    compiled = jax.jit(jax.vmap(one))
    assert relative_difference(np.asarray(compiled(*arrays)), recursion.inverse_dynamics(*x)) < 1e-12
    return lambda: compiled(*arrays).block_until_ready()


class JaxNumber:
    """A traced number of JAX whose sine and cosine NumPy finds."""

    def __init__(self, value: object) -> None:
        self.value = value

    def _with(self, other: object, name: str) -> JaxNumber:
        return JaxNumber(getattr(operator, name)(self.value, getattr(other, "value", other)))

    def __add__(self, other: object) -> JaxNumber:
        return self._with(other, "add")

    def __sub__(self, other: object) -> JaxNumber:
        return self._with(other, "sub")

    def __mul__(self, other: object) -> JaxNumber:
        return self._with(other, "mul")

    def __neg__(self) -> JaxNumber:
        return JaxNumber(-self.value)

    def __rsub__(self, other: object) -> JaxNumber:
        return -self + other

    __radd__, __rmul__ = __add__, __mul__

    def cos(self) -> JaxNumber:
        """For numpy.cos."""
        from jax import numpy

        return JaxNumber(numpy.cos(self.value))

    def sin(self) -> JaxNumber:
        """For numpy.sin."""
        from jax import numpy

        return JaxNumber(numpy.sin(self.value))


def casadi_call(arm: Arm, x: tuple[np.ndarray, ...]) -> Call:
    """CasADi's own C code for one state, compiled with -O3, mapped over the batch in memory it owns."""
    import casadi

    from lwr_dyn.kernels.form import form_of
    from lwr_dyn.kernels.trace import trace

    function = trace(form_of(arm), "inverse_dynamics")
    folder = tempfile.mkdtemp()
    here = os.getcwd()
    os.chdir(folder)
    try:
        name = function.generate("inverse.c")
        flags = ["-O3", "-march=native", "-ffast-math", "-fPIC", "-shared"]
        subprocess.run(["cc", *flags, name, "-o", "inverse.so", "-lm"], check=True)
        mapped = casadi.external("inverse_dynamics", os.path.join(folder, "inverse.so")).map(COUNT)
    finally:
        os.chdir(here)
    buffer, evaluate = mapped.buffer()
    arguments, out = [np.ascontiguousarray(a) for a in x], np.zeros((COUNT, arm.n))  # its columns are our rows
    for i, a in enumerate(arguments):
        buffer.set_arg(i, memoryview(a))
    buffer.set_res(0, memoryview(out))
    evaluate()
    assert relative_difference(out, Recursion.of(arm.chain).inverse_dynamics(*x)) < 1e-12
    buffers = (arguments, out, buffer)
    return lambda: evaluate() if buffers else None  # keeps the memory alive


def agreement(arm: Arm) -> None:
    """Every function against Pinocchio over all states, in pieces, float64."""
    states = random_states(arm, COUNT, seed=4)
    x = (states.q, states.dq, states.ddq)
    batch, answers = lwr_dyn.batch_dynamics(arm), pinocchio_answers(arm)
    print(f"\n### {arm.name}: agreement with Pinocchio over {COUNT} states (share of the largest value)\n")
    print("| function | largest difference |\n|---|---|")
    for function in FUNCTIONS:
        offset, scale, worst = None, 0.0, 0.0
        for start in range(0, COUNT, 10_000):
            part = tuple(a[start : start + 10_000] for a in rows_of(function, x))
            found = getattr(batch, function)(*part)
            if function.endswith("_derivatives"):
                last = found.by_ddq if function.startswith("inverse") else found.by_tau
                found = np.stack([found.by_q, found.by_dq, last], axis=1)
            expected = np.array([answers[function](*state) for state in zip(*part, strict=True)])
            if function == "potential_energy":  # only differences mean something
                offset = found[0] - expected[0] if offset is None else offset
                expected = expected + offset
            worst = max(worst, float(np.abs(found - expected).max()))
            scale = max(scale, float(np.abs(expected).max()))
        print(f"| {function} | {worst / scale:.1e} |", flush=True)


_ONE = """
import sys, time, lwr_dyn
from lwr_dyn.kernels.kernel import kernel_of
form = lwr_dyn.batch_dynamics(lwr_dyn.load(sys.argv[1])).form
start = time.perf_counter()
kernel_of(form, sys.argv[2])
print(time.perf_counter() - start)
"""


def compile_times(arm: Arm) -> None:
    """Seconds to the first result of every kernel in a new process: compiled, then from the cache."""
    print(f"\n### {arm.name}: a kernel in a new process [s], importing the compilers included\n")
    print("| function | compiled | from the cache |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "LWR_DYN_CACHE": folder}
        for function in FUNCTIONS:
            command = [sys.executable, "-c", _ONE, arm.name, function]
            runs = [subprocess.run(command, env=environment, check=True, capture_output=True) for _ in range(2)]
            first, second = (float(run.stdout) for run in runs)
            print(f"| {function} | {first:.2f} | {second:.3f} |", flush=True)


_MEMORY = """
import sys, numpy as np, lwr_dyn
from pathlib import Path
from lwr_dyn.kernels.functions import FUNCTIONS
name, function, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
arm = lwr_dyn.load(name)
batch, width = lwr_dyn.batch_dynamics(arm, threads=2), len(FUNCTIONS[function].states)
call = getattr(batch, function)
call(*np.zeros((width, 4096, arm.n)))
peak = lambda: int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0])
before = peak()
x = [np.random.default_rng(i).uniform(-1, 1, (count, arm.n)) for i in range(width)]
out = call(*x)
grown = 1024 * (peak() - before)
print(grown / (sum(a.nbytes for a in x) + out.nbytes))
"""


def memory(arm: Arm) -> None:
    """Growth of a process's peak memory over a batch, as a share of what its inputs and outputs take."""
    print(f"\n### {arm.name}: memory of a batch of 1 000 000 states over its inputs and outputs\n")
    print("| function | ratio |\n|---|---|")
    for function in ("inverse_dynamics", "forward_dynamics", "mass_matrix"):
        command = [sys.executable, "-c", _MEMORY, arm.name, function, "1000000"]
        print(f"| {function} | {float(subprocess.run(command, check=True, capture_output=True).stdout):.2f} |")


def kernels(pairs: int) -> None:
    """All of it, for every robot with inertias."""
    begin = time.perf_counter()
    for arm in arms():
        for threads in sorted({1, os.cpu_count() or 1}):
            against_pinocchio(arm, threads, pairs)
        arithmetic_limit(arm, pairs)
        agreement(arm)
        compile_times(arm)
        memory(arm)
    other_peers(lwr_dyn.load("lwr4plus"), pairs)
    print(f"\n({time.perf_counter() - begin:.0f} s for this part)")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=9, help="pairs of measurements a line (at least 7 to quote)")
    kernels(parser.parse_args().pairs)


if __name__ == "__main__":
    main()
