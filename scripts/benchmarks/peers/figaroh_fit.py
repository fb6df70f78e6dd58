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
from bodies import share_of_bodies
from figaroh.identification.physical_fit import (
    ComparatorProblem,
    PhysicalPolicy,
    build_problem,
    solve_direct_effort_fit,
    solve_per_link_projection,
)
from figaroh.tools.regressor import build_regressor_basic
from figaroh.tools.robot import Robot

KEYS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
WEIGHTS = (1e-6, 25.0)
"""figaroh's own weight of the table, and that of a table trusted to 20 %, for torques in units of their noise."""
warnings.filterwarnings("ignore")
folder = Path(sys.argv[1])
case = np.load(folder / "case.npz")
robot = Robot(str(folder / "arm.urdf"), str(folder))
n, rotors = robot.model.nv, bool(case["rotors"])


def columns(part: str) -> np.ndarray:
    """Its regressor on the log or on fresh motions, joint after joint."""
    states = (case[f"{part}_{name}"] for name in ("q", "dq", "ddq"))
    options = {"has_friction": True, "has_actuator_inertia": rotors, "has_joint_offset": True}
    return np.asarray(build_regressor_basic(robot, *states, {**options, "act_idxv": list(range(n))}))


joints, extras = list(robot.model.names[1:]), ["fv", "fs", *(["Ia"] if rotors else []), "off"]
names = [f"{key}_{j}" for j in joints for key in KEYS] + [f"{key}_{j}" for key in extras for j in joints]
bodies = [inertia.toDynamicParameters() for inertia in robot.model.inertias[1:]]
prior = np.concatenate([*bodies, *(case[key] if key in case else np.zeros(n) for key in extras)])
start = time.process_time()
log, tau = columns("log"), case["log_tau"].T.ravel()
regressor_seconds = time.process_time() - start
fresh, answers, torques = columns("fresh"), [], {}


def add(name: str, theta: np.ndarray | None, seconds: float) -> None:
    """A fit that ended with an answer."""
    if theta is None:
        return
    for part, matrix in (("log", log), ("fresh", fresh)):
        torques[f"{name}_{part}"] = (matrix @ theta).reshape(n, -1).T
    physical = share_of_bodies(theta[: 10 * n].reshape(n, 10), KEYS)
    answers.append({"name": name, "seconds": regressor_seconds + seconds, "physical": physical})


def problem_of(prior_weight: float) -> tuple[ComparatorProblem, float]:
    """The problem, and the time to build it."""
    start = time.process_time()
    weight = np.full(tau.size, 1.0 / float(case["noise"]))
    policy = PhysicalPolicy(prior_weight=prior_weight)
    made = build_problem(log, tau, names, joints, prior=prior, policy=policy, row_weight=weight)
    return made, time.process_time() - start


problem, building = problem_of(WEIGHTS[0])
plain = np.zeros(len(names))
plain[list(problem.base_indices)] = problem.phi_ols
add("least squares", plain, building)
start = time.process_time()
record = solve_per_link_projection(problem)
add("per-link projection", record.theta, building + time.process_time() - start)
for prior_weight in WEIGHTS:
    problem, building = problem_of(prior_weight)
    start = time.process_time()
    record = solve_direct_effort_fit(problem)
    add(f"direct, weight {prior_weight:g}", record.theta, building + time.process_time() - start)
np.savez(folder / "figaroh.npz", **torques)
print(json.dumps({"version": version("figaroh"), "answers": answers}))
