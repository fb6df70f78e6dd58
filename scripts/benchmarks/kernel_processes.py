"""Generated kernels in processes of their own: seconds to the first result, memory of a large batch."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS
from lwr_dyn.model.arm import Arm

_ONE = """
import sys, time, lwr_dyn
from lwr_dyn.codegen.kernels.kernel import kernel_of
spec = lwr_dyn.batch_dynamics(lwr_dyn.load(sys.argv[1])).spec
start = time.perf_counter()
kernel_of(spec, sys.argv[2])
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
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS
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
