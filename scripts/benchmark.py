"""Speed as ratios against named peers, measured in one run: medians over pairs A B A B, since machines are noisy.

Peers that are not installed are left out and said so:  pip install mujoco roboticstoolbox-python
"""

from __future__ import annotations

import argparse
import importlib.util
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.metadata import version

import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp

import lwr_dyn
from lwr_dyn.arm import Arm
from lwr_dyn.control.inverse_dynamics import InverseDynamics
from lwr_dyn.control.pd_gravity import PDGravity
from lwr_dyn.friction.models import friction_of
from lwr_dyn.friction.smooth import smooth_friction
from lwr_dyn.motion import Motion
from lwr_dyn.reproduction.wam7.runs import BLEND, DURATION, START, TRAVEL, manufacturers_pd, move, weightless
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.tasks.ist import ist_reference
from lwr_dyn.urdf.mjcf import mjcf_text

Call = Callable[[], object]
PEERS = ("pin", "mujoco", "roboticstoolbox-python", "numpy", "scipy", "lwr_dyn")
METHODS = ("mass_matrix", "coriolis_matrix", "gravity_vector", "inverse_dynamics", "forward_dynamics")


def seconds(call: Call, number: int) -> float:
    """Seconds a call, over `number` calls."""
    start = time.perf_counter()
    for _ in range(number):
        call()
    return (time.perf_counter() - start) / number


def paired(ours: Call, theirs: Call, pairs: int, number: int) -> tuple[float, float, float]:
    """Medians of both [s] and of the ratio ours / theirs, pair by pair, after one warm-up each."""
    ours(), theirs()
    times = [(seconds(ours, number), seconds(theirs, number)) for _ in range(pairs)]
    ratio = statistics.median(a / b for a, b in times)
    return statistics.median(a for a, _ in times), statistics.median(b for _, b in times), ratio


def row(what: str, peer: str, result: tuple[float, float, float], note: str = "") -> None:
    """One line of the table: times in microseconds, the ratio."""
    ours, theirs, ratio = result
    print(f"| {what} | {ours * 1e6:.3g} | {peer} | {theirs * 1e6:.3g} | {ratio:.3g} | {note} |", flush=True)


def head(title: str) -> None:
    """A heading and the head of a table."""
    print(f"\n### {title}\n\n| what | ours [us] | peer | peer [us] | ours / peer | |\n|---|---|---|---|---|---|")


def installed(module: str) -> bool:
    """Whether a peer is there; says so when it is not."""
    there = importlib.util.find_spec(module) is not None
    if not there:
        print(f"({module} is not installed: left out)")
    return there


def single_calls(arm: Arm, pairs: int) -> None:
    """B, C, g, inverse and forward dynamics of one state through the front door."""
    dyn = lwr_dyn.dynamics_of(arm)
    q, dq, ddq = np.random.default_rng(0).uniform(-1, 1, (3, arm.n))
    model, data = dyn.model, dyn.data
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
    head("One state, front door against raw Pinocchio")
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


def mujoco_calls(arm: Arm, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> dict[str, tuple]:
    """MuJoCo's inverse and forward dynamics at the state, with the difference from ours."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf_text(arm))
    data = mujoco.MjData(model)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
    data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq

    def inverse() -> np.ndarray:
        data.qacc[:] = ddq
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse

    def forward() -> np.ndarray:
        data.qfrc_applied[:] = ddq
        mujoco.mj_forward(model, data)
        return data.qacc

    return {
        "inverse_dynamics": (inverse, lambda dyn: np.abs(inverse() - dyn.inverse_dynamics(q, dq, ddq)).max()),
        "forward_dynamics": (forward, lambda dyn: np.abs(forward() - dyn.forward_dynamics(q, dq, ddq)).max()),
    }


def toolbox_calls(arm: Arm, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> dict[str, tuple]:
    """robotics-toolbox-python on a DHRobot made from our own table."""
    import roboticstoolbox as rtb

    from lwr_dyn.assembly import dh_rows
    from lwr_dyn.papers.catalog import open_paper

    rows, links = dh_rows(open_paper(arm.name)), []
    for dh, link in zip(rows, arm.chain.links, strict=True):
        body, rotor = link.body, link.rotor
        inertia = {"m": body.mass, "r": body.com, "I": body.inertia_com, "Jm": rotor.inertia, "G": rotor.gear_ratio}
        links.append(rtb.RevoluteDH(d=dh.d, a=dh.a, alpha=dh.alpha, B=0, Tc=[0, 0], **inertia))
    robot = rtb.DHRobot(links, gravity=np.array(arm.chain.gravity))
    calls = {
        "mass_matrix": (lambda: robot.inertia(q), lambda d: d.mass_matrix(q), 200),
        "coriolis_matrix": (lambda: robot.coriolis(q, dq), lambda d: d.coriolis_matrix(q, dq), 50),
        "gravity_vector": (lambda: robot.gravload(q), lambda d: d.gravity_vector(q), 500),
        "inverse_dynamics": (lambda: robot.rne(q, dq, ddq), lambda d: d.inverse_dynamics(q, dq, ddq), 500),
        "forward_dynamics": (lambda: robot.accel(q, dq, ddq), lambda d: d.forward_dynamics(q, dq, ddq), 200),
    }
    out = {}
    for name, (theirs, mine, number) in calls.items():
        # rtb's Coriolis matrix is not the Christoffel one: compare what both mean, C dq
        right = (lambda x: x @ dq) if name == "coriolis_matrix" else (lambda x: x)
        check = lambda d, t=theirs, m=mine, r=right: np.abs(r(np.asarray(t())) - r(m(d))).max()  # noqa: E731
        out[name] = (theirs, check, number)
    return out


def batches(arm: Arm, pairs: int) -> None:
    """The hand-written recursion over many states at once against a loop of raw Pinocchio calls."""
    dyn, road_b = lwr_dyn.dynamics_of(arm), lwr_dyn.dynamics_of(arm, "newton-euler")
    model, data, count = dyn.model, dyn.data, 10000
    q, dq, ddq = np.random.default_rng(1).uniform(-1, 1, (3, count, arm.n))

    def loop() -> None:
        for i in range(count):
            pin.rnea(model, data, q[i], dq[i], ddq[i])

    head(f"Road B over {count} states at once (time for all)")
    row("inverse_dynamics", "pinocchio in a loop", paired(lambda: road_b.inverse_dynamics(q, dq, ddq), loop, pairs, 3))
    one = q[0], dq[0], ddq[0]
    result = paired(lambda: road_b.inverse_dynamics(*one), lambda: pin.rnea(model, data, *one), pairs, 200)
    row("inverse_dynamics, one state", "pinocchio", result)


def closed_loop(arm: Arm, pairs: int) -> None:
    """14 s of IST at 1 kHz: our loop with limits, log and audit against a bare one, and against MuJoCo."""
    dyn, reference = lwr_dyn.dynamics_of(arm), ist_reference(arm)
    motion = reference.sample(np.arange(14000) / 1000.0)
    controller = InverseDynamics(dyn, 2500.0, 100.0)
    model, data, h = dyn.model, dyn.data, 1e-3

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


def mujoco_loop(arm: Arm, motion: Motion, integrator: str) -> Call:
    """The same closed loop in MuJoCo: mj_inverse for the torque, mj_step for the motion."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf_text(arm))
    model.opt.timestep = 1e-3
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    data = mujoco.MjData(model)

    def loop() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = motion.q[0], motion.dq[0]
        for k in range(14000):
            data.qacc[:] = 2500.0 * (motion.q[k] - data.qpos) + 100.0 * (motion.dq[k] - data.qvel) + motion.ddq[k]
            mujoco.mj_inverse(model, data)
            data.qfrc_applied[:] = data.qfrc_inverse
            mujoco.mj_step(model, data)

    return loop


def with_friction(pairs: int) -> None:
    """The WAM with its friction, all joints 0.5 rad in 7 s: true stick against tanh friction in scipy's solvers.

    Errors are the largest |q - reference| over the samples, the reference being true stick by DOP853 at 1e-12 with
    the same control (sampled, or asked all the time). Joint 4 is apart: it sticks and slips in a limit cycle.
    """
    arm = weightless(lwr_dyn.load("wam7"))
    reference, law = move(arm, None), manufacturers_pd(arm)
    print("\n### 7 s of the WAM with friction, all joints\n")
    print("| friction, control | method | s | evaluations | error, joint 4 apart [mrad] | joint 4 [mrad] |")
    print("|---|---|---|---|---|---|")

    def tell(what: str, method: str, took: float, evaluations: int, q: np.ndarray, best: np.ndarray) -> None:
        error = 1e3 * np.abs(q - best).max(axis=0)
        others = np.delete(error, 3).max()
        print(f"| {what} | {method} | {took:.3f} | {evaluations} | {others:.2g} | {error[3]:.2g} |", flush=True)

    for continuous, what in ((False, "true stick, 1 kHz"), (True, "true stick, continuous")):
        best = simulate(arm, law, reference, method="dop853", continuous=continuous)
        for substeps in (1, 2):
            run = simulate(arm, law, reference, substeps=substeps, continuous=continuous)
            ours: Call = lambda m=substeps, c=continuous: simulate(arm, law, reference, substeps=m, continuous=c)  # noqa: E731
            took = statistics.median(seconds(ours, 1) for _ in range(pairs))
            tell(what, f"RK4, {substeps} a sample", took, run.meta["evaluations"], run.q, best.q)
    for method, width in (("Radau", 1e-2), ("RK45", 1e-2), ("Radau", 1e-3)):
        begin = time.perf_counter()
        found = tanh_run(arm, law, method, width, best.t)
        what = f"tanh(dq / {width:g}), continuous"
        tell(what, f"scipy {method}, rtol 1e-6", time.perf_counter() - begin, found.nfev, found.y[: arm.n].T, best.q)


def tanh_run(arm: Arm, law: PDGravity, method: str, width: float, t: np.ndarray) -> object:
    """The same movement with tanh friction by a solver of scipy; the controller and its LSPB written out for speed."""
    friction, forward, start = (
        smooth_friction(friction_of(arm), width),
        lwr_dyn.dynamics_of(arm).ungated,
        np.array(START),
    )
    Kp, Kd, n, v = law.Kp, law.Kd, arm.n, TRAVEL / (DURATION - BLEND)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        q, dq = y[:n], y[n:]
        up, down = min(t, BLEND), max(0.0, t - DURATION + BLEND)
        travel, speed = v * (up**2 / (2 * BLEND) + max(0.0, t - BLEND) - down**2 / (2 * BLEND)), v * (up - down) / BLEND
        tau = Kp * (start + travel - q) + Kd * (speed - dq) - friction(dq)
        return np.concatenate([dq, forward(q, dq, tau)])

    begin = np.concatenate([start, np.zeros(n)])
    return solve_ivp(rates, (0.0, t[-1]), begin, method, t_eval=t, rtol=1e-6, atol=1e-9)


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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=9, help="pairs of measurements a line (at least 7 to quote)")
    options = parser.parse_args()
    names = [p for p in PEERS if importlib.util.find_spec(p.replace("-python", "").replace("pin", "pinocchio"))]
    found = ", ".join(f"{name} {version(name)}" for name in names)
    print(f"Python {platform.python_version()}, {platform.machine()}; {found}; medians of {options.pairs} pairs")
    arm = lwr_dyn.load("lwr4plus")
    single_calls(arm, options.pairs)
    batches(arm, options.pairs)
    closed_loop(arm, max(3, options.pairs))
    with_friction(options.pairs)
    starts(options.pairs)


if __name__ == "__main__":
    main()
