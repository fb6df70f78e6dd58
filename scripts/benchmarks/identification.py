"""Identification of long logs: a million rows of seven joints in a process of its own, time and memory."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys

ROWS = 1_000_000

_ONE = """
import json, sys, time, numpy as np, lwr_dyn
from pathlib import Path
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule, exact_samples, sample_parts
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.plants import perturbed_plant, random_motion

robot, form, rows = sys.argv[1], sys.argv[2], int(sys.argv[3])
arm, rng = lwr_dyn.load(robot), np.random.default_rng(0)
columns = TorqueColumns(arm.chain)
plant, base = perturbed_plant(columns, arm, rng), columns.base()
once = random_motion(arm, 100.0, rng)
tau = plant.torque(once)
at = np.arange(rows) % (len(once.t) - 1)
t = np.arange(rows) / 100.0
noisy = tau[at] + 0.1 * rng.normal(size=(rows, arm.n))
if form == "states":
    samples = exact_samples(t, once.q[at], once.dq[at], once.ddq[at], noisy, 0.05)
    size, call = 29 * 8 * rows, lambda: information_of(samples, columns)
else:
    log = JointLog("long", tuple(range(1, arm.n + 1)), t, once.q[at], noisy)
    size, call = 15 * 8 * rows, lambda: information_of(sample_parts([log]), columns)
del noisy
peak = lambda: int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) * 1024
now = lambda: int(Path("/proc/self/status").read_text().split("VmRSS:")[1].split()[0]) * 1024
Path("/proc/self/clear_refs").write_text("5")  # the peak starts again from what is held now
before, start, load = now(), time.perf_counter(), time.process_time()
info = call()
took, used = time.perf_counter() - start, time.process_time() - load
away = np.abs(info.values - plant.base) / info.sigma
print(json.dumps({"wall": took, "processor": used, "beyond": peak() - before, "log": size, "z": float(away.max()),
                  "dof": info.dof, "noise": float(info.noise.mean())}))
"""


def long_log(robot: str, form: str, rows: int = ROWS) -> dict[str, float]:
    """Seconds and bytes beyond the log of base parameters and sigma, from states or from positions; one thread."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": "."}
    command = [sys.executable, "-c", _ONE, robot, form, str(rows)]
    done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    result: dict[str, float] = json.loads(done.stdout)
    return result


def identification(pairs: int) -> None:
    """A million rows of every arm with seven joints, the median of `pairs` processes."""
    print("\n### Base parameters and sigma of 1 000 000 rows of 7 joints, one thread\n")
    print("| robot | from | s (wall) | s (processor) | MB beyond the log | MB of the log | largest miss [sigma] |")
    print("|---|---|---|---|---|---|---|")
    for robot in ("lwr4plus", "wam7"):
        for form, what in (("states", "q, dq, ddq, tau"), ("positions", "q, tau: filter, differences")):
            runs = [long_log(robot, form) for _ in range(pairs)]
            m = {key: statistics.median(run[key] for run in runs) for key in runs[0]}
            cells = f"{m['wall']:.2f} | {m['processor']:.2f} | {m['beyond'] / 1e6:.0f} | {m['log'] / 1e6:.0f}"
            print(f"| {robot} | {what} | {cells} | {m['z']:.2f} |", flush=True)
