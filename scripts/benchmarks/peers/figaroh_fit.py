"""Runs in figaroh's environment: its fits of a log, judged on motions that it does not see.

figaroh_fit.py FOLDER: arm.urdf and case.npz in, figaroh.npz out; the variants' names are on stdout.
"""

import json
import sys
import time
import warnings
from importlib.metadata import version
from pathlib import Path

import numpy as np

warnings.filterwarnings("ignore")
folder = Path(sys.argv[1])
case = np.load(folder / "case.npz")
KEYS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
WEIGHTS = (1e-6, 25.0)
"""figaroh's own weight of the table, and that of a table trusted to 20 %, for torques in units of their noise."""


def main() -> None:
    from figaroh.identification.physical_fit import (
        PhysicalPolicy,
        build_problem,
        solve_direct_effort_fit,
        solve_per_link_projection,
    )
    from figaroh.tools.regressor import build_regressor_basic
    from figaroh.tools.robot import Robot

    robot = Robot(str(folder / "arm.urdf"), str(folder))
    n = robot.model.nv
    rotors = bool(case["rotors"])
    options = {"has_friction": True, "has_actuator_inertia": rotors, "has_joint_offset": True, "act_idxv": list(range(n))}

    def columns(part: str) -> np.ndarray:
        states = (case[f"{part}_{name}"] for name in ("q", "dq", "ddq"))
        return np.asarray(build_regressor_basic(robot, *states, options))

    joints = list(robot.model.names[1:])
    extras = ["fv", "fs", *(["Ia"] if rotors else []), "off"]
    names = [f"{key}_{j}" for j in joints for key in KEYS] + [f"{key}_{j}" for key in extras for j in joints]
    table = np.concatenate([inertia.toDynamicParameters() for inertia in robot.model.inertias[1:]])
    prior = np.concatenate([table, np.zeros(len(extras) * n)])
    if rotors:
        prior[10 * n + 2 * n : 10 * n + 3 * n] = case["armature"]
    start = time.process_time()
    Y, tau = columns("log"), case["log_tau"].T.ravel()
    weight = np.full(tau.size, 1.0 / float(case["noise"]))
    regressor_seconds = time.process_time() - start
    fresh, answers, out = columns("fresh"), [], {}

    def add(name: str, theta: np.ndarray, seconds: float) -> None:
        pseudo = [pseudo_inertia(theta[10 * i : 10 * i + 10]) for i in range(n)]
        physical = [bool(np.linalg.eigvalsh(P)[0] > 0.0) for P in pseudo]
        for part, matrix in (("log", Y), ("fresh", fresh)):
            out[f"{name}_{part}"] = (matrix @ theta).reshape(n, -1).T
        answers.append({"name": name, "seconds": regressor_seconds + seconds, "physical": float(np.mean(physical))})

    for prior_weight in WEIGHTS:
        start = time.process_time()
        problem = build_problem(
            Y, tau, names, joints, prior=prior, policy=PhysicalPolicy(prior_weight=prior_weight), row_weight=weight
        )
        building = time.process_time() - start
        if prior_weight == WEIGHTS[0]:
            theta = np.zeros(len(names))
            theta[list(problem.base_indices)] = problem.phi_ols
            add("least squares", theta, building)
            start = time.process_time()
            record = solve_per_link_projection(problem)
            if record.theta is not None:
                add("per-link projection", record.theta, building + time.process_time() - start)
        start = time.process_time()
        record = solve_direct_effort_fit(problem)
        if record.theta is not None:
            add(f"direct, weight {prior_weight:g}", record.theta, building + time.process_time() - start)
    np.savez(folder / "figaroh.npz", **out)
    print(json.dumps({"version": version("figaroh"), "answers": answers}))


def pseudo_inertia(p: np.ndarray) -> np.ndarray:
    m, mx, my, mz, xx, xy, yy, xz, yz, zz = p
    half = (xx + yy + zz) / 2
    return np.array([[half - xx, -xy, -xz, mx], [-xy, half - yy, -yz, my], [-xz, -yz, half - zz, mz], [mx, my, mz, m]])


main()
