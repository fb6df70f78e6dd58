"""Speed as ratios against named peers, measured in one run: medians over pairs A B A B, since machines are noisy.

Peers that are not installed are left out with a note:  pip install mujoco roboticstoolbox-python
"""

from __future__ import annotations

import argparse
import importlib.util
import platform
import statistics
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import version

import numpy as np
import pinocchio as pin
from benchmarks.control_laws import control_laws
from benchmarks.dynamics_peers import mujoco_calls, mujoco_loop, toolbox_calls
from benchmarks.emitted_code import emitted
from benchmarks.friction import with_friction
from benchmarks.front import front
from benchmarks.identification import identification
from benchmarks.inverse_kinematics import all_solutions
from benchmarks.kernels import kernels
from benchmarks.pinocchio_cpp import beside_cpp
from benchmarks.pose_solver import one_solution
from benchmarks.rollouts import closed_loops
from benchmarks.timing import Call, head, installed, paired, row, seconds, use_processor_time

import lwr_dyn
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.ist import ist_reference

PEERS = (
    "pin", "mujoco", "roboticstoolbox-python", "numpy", "scipy", "llvmlite", "casadi", "jax", "eaik", "ssik",
    "dynibo", "lwr_dyn",
)  # fmt: skip
METHODS = ("mass_matrix", "coriolis_matrix", "gravity_vector", "inverse_dynamics", "forward_dynamics")


def single_calls(pairs: int) -> None:
    """B, C, g, inverse and forward dynamics of one state through `import lwr_dyn`."""
    arm = lwr_dyn.load("lwr4plus")
    dyn = lwr_dyn.dynamics_of(arm)
    q, dq, ddq = np.random.default_rng(0).uniform(-1, 1, (3, arm.n))
    model, data = dyn.ungated.model, dyn.ungated.data
    raw: dict[str, Call] = {
        "mass_matrix": lambda: pin.crba(model, data, q),
        "coriolis_matrix": lambda: pin.computeCoriolisMatrix(model, data, q, dq),
        "gravity_vector": lambda: pin.computeGeneralizedGravity(model, data, q),
        "inverse_dynamics": lambda: pin.rnea(model, data, q, dq, ddq),
        "forward_dynamics": lambda: pin.aba(model, data, q, dq, ddq),
    }
    ours: dict[str, Call] = {
        "mass_matrix": lambda: dyn.mass_matrix(q),
        "coriolis_matrix": lambda: dyn.coriolis_matrix(q, dq),
        "gravity_vector": lambda: dyn.gravity_vector(q),
        "inverse_dynamics": lambda: dyn.inverse_dynamics(q, dq, ddq),
        "forward_dynamics": lambda: dyn.forward_dynamics(q, dq, ddq),
    }
    head("One state, lwr_dyn against raw Pinocchio")
    for name in METHODS:
        row(name, "pinocchio", paired(ours[name], raw[name], pairs, 20000))
    if installed("mujoco"):
        head("One state against MuJoCo (MJCF of the same arm)")
        for name, (call, check) in mujoco_calls(arm, q, dq, ddq).items():
            row(name, "mujoco", paired(ours[name], call, pairs, 20000), f"differ by {check(dyn):.1e}")
    if installed("roboticstoolbox"):
        head("One state against robotics-toolbox-python (DHRobot of the same table)")
        for name, (call, check, number) in toolbox_calls(arm, q, dq, ddq).items():
            row(name, "rtb", paired(ours[name], call, pairs, number), f"differ by {check(dyn):.1e}")


def batches(pairs: int) -> None:
    """The hand-written recursion over many states at once against a loop of raw Pinocchio calls."""
    arm = lwr_dyn.load("lwr4plus")
    dyn, road_b = lwr_dyn.dynamics_of(arm), lwr_dyn.dynamics_of(arm, "newton-euler")
    model, data, count = dyn.ungated.model, dyn.ungated.data, 10000
    q, dq, ddq = np.random.default_rng(1).uniform(-1, 1, (3, count, arm.n))

    def loop() -> None:
        for i in range(count):
            pin.rnea(model, data, q[i], dq[i], ddq[i])

    head(f"Road B over {count} states at once (time for all)")
    row("inverse_dynamics", "pinocchio in a loop", paired(lambda: road_b.inverse_dynamics(q, dq, ddq), loop, pairs, 3))
    one = q[0], dq[0], ddq[0]
    result = paired(lambda: road_b.inverse_dynamics(*one), lambda: pin.rnea(model, data, *one), pairs, 200)
    row("inverse_dynamics, one state", "pinocchio", result)


def closed_loop(pairs: int) -> None:
    """14 s of IST at 1 kHz: our loop with limits, log and audit against a bare one, and against MuJoCo."""
    arm = lwr_dyn.load("lwr4plus")
    dyn, reference = lwr_dyn.dynamics_of(arm), ist_reference(arm)
    motion = reference.sample(np.arange(14000) / 1000.0)
    controller = InverseDynamics(dyn, 2500.0, 100.0)
    model, data, h = dyn.ungated.model, dyn.ungated.data, 1e-3

    def bare() -> None:
        q, v = motion.q[0].copy(), motion.dq[0].copy()
        for k in range(14000):
            y = 2500.0 * (motion.q[k] - q) + 100.0 * (motion.dq[k] - v) + motion.ddq[k]
            tau = pin.rnea(model, data, q, v, y)
            a1 = pin.aba(model, data, q, v, tau)
            v2 = v + (h / 2) * a1
            a2 = pin.aba(model, data, q + (h / 2) * v, v2, tau)
            v3 = v + (h / 2) * a2
            a3 = pin.aba(model, data, q + (h / 2) * v2, v3, tau)
            v4 = v + h * a3
            a4 = pin.aba(model, data, q + h * v3, v4, tau)
            q = q + (h / 6) * (v + 2 * v2 + 2 * v3 + v4)
            v = v + (h / 6) * (a1 + 2 * a2 + 2 * a3 + a4)

    head("Closed loop, inverse dynamics, 14 s at 1 kHz (time for the whole run)")
    ours: Call = lambda: simulate(arm, controller, reference)  # noqa: E731
    row("RK4, limits, log, audit", "bare loop: one rnea, four aba", paired(ours, bare, pairs, 1))
    if installed("mujoco"):
        for name in ("Euler", "RK4"):
            row("RK4, limits, log, audit", f"mujoco {name}", paired(ours, mujoco_loop(arm, motion, name), pairs, 1))


def starts(pairs: int) -> None:
    """Whole processes: import, --help, check, and the inverse kinematics of the IST path in this one."""
    commands = {
        "import lwr_dyn": [sys.executable, "-c", "import lwr_dyn"],
        "lwr-dyn --help": [sys.executable, "-m", "lwr_dyn", "--help"],
        "lwr-dyn check lwr4plus": [sys.executable, "-m", "lwr_dyn", "check", "lwr4plus"],
        "(python -c pass)": [sys.executable, "-c", "pass"],
    }
    print("\n### Whole processes, median seconds\n\n| command | s |\n|---|---|")
    for name, command in commands.items():
        times = [seconds(lambda c=command: subprocess.run(c, check=True, capture_output=True), 1) for _ in range(pairs)]
        print(f"| {name} | {statistics.median(times):.3f} |")
    arm = lwr_dyn.load("lwr4plus")
    times = [seconds(lambda: ist_reference(arm), 1) for _ in range(pairs)]
    print(f"| IK of the IST path, 1401 poses, best arm angle | {statistics.median(times):.3f} |")


PARTS: dict[str, Callable[[int], None]] = {
    "calls": single_calls,
    "batches": batches,
    "loop": closed_loop,
    "control": control_laws,
    "friction": with_friction,
    "front": front,
    "processes": starts,
    "kernels": kernels,
    "emitted": emitted,
    "emitted-cpp": beside_cpp,
    "branches": all_solutions,
    "ik": one_solution,
    "rollouts": closed_loops,
    "identification": identification,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"{', '.join(PARTS)}; all of them if not given")
    parser.add_argument("--pairs", type=int, default=9, help="pairs of measurements a line (at least 7 to quote)")
    parser.add_argument("--processor-time", action="store_true", help="not the wall's clock: for a busy machine")
    parser.add_argument("--threads", type=int, help="of kernels: 1, and this many (all cores if not given)")
    parser.add_argument(
        "--peers",
        metavar="FOLDER",
        help="rollouts: environments of mjbatch and Drake, made there with pip if not there",
    )
    options = parser.parse_args()
    unknown = [part for part in options.parts if part not in PARTS]
    if unknown:
        parser.error(f"no part named {unknown[0]!r}; allowed: {', '.join(PARTS)}")
    names = [p for p in PEERS if importlib.util.find_spec(p.replace("-python", "").replace("pin", "pinocchio"))]
    versions = ", ".join(f"{name} {version(name)}" for name in names)
    print(f"Python {platform.python_version()}, {platform.machine()}; {versions}; medians of {options.pairs} pairs")
    if options.processor_time:
        print("(times are processor time of one process)")
        use_processor_time()
    for part in options.parts or PARTS:
        if part == "rollouts":
            closed_loops(options.pairs, options.peers)
        elif part == "kernels":
            kernels(options.pairs, options.threads)
        else:
            PARTS[part](options.pairs)


if __name__ == "__main__":
    main()
