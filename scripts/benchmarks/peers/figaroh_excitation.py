"""Runs in figaroh's environment: its exciting motion, by cubic splines at rest at waypoints and Ipopt.

figaroh_excitation.py FOLDER SEED ITERATIONS: arm.urdf, whose limits are those that a motion may use, in;
figaroh_SEED_ITERATIONS.npz (t, q, dq, ddq, seconds) out. No collisions: it would only have to do more.
"""

import json
import sys
import time
import warnings
from importlib.metadata import version
from pathlib import Path

import numpy as np

warnings.filterwarnings("ignore")
folder, seed, iterations = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
WAYPOINTS, SPACING, RATE = 6, 2.0, 50
"""Six waypoints 2 s apart: 10 s of motion; rows a second of its objective."""


def main() -> None:
    from figaroh.optimal.base_optimal_trajectory import BaseOptimalTrajectory, BaseTrajectoryIPOPTProblem
    from figaroh.optimal.config import COLLISION_DEFAULTS
    from figaroh.tools.robot import Robot

    robot = Robot(str(folder / "arm.urdf"), str(folder))
    joints = list(robot.model.names[1:])

    class Trajectory(BaseOptimalTrajectory):
        """Without a configuration file, whose reader leaves act_idxv out."""

        def __init__(self) -> None:
            self.robot, self.model, self.active_joints = robot, robot.model, joints
            self.logger = __import__("logging").getLogger("figaroh")
            self.trajectory_config = {
                "n_wps": WAYPOINTS, "freq": RATE, "t_s": SPACING, "soft_lim": 0.0, "max_attempts": 1000,
                "max_iterations": iterations, "segment_attempts": 1, **COLLISION_DEFAULTS,
            }  # fmt: skip
            self.identif_config = {
                "has_friction": True, "has_actuator_inertia": True, "has_joint_offset": True,
                "is_external_wrench": False, "force_torque": None, "act_idxv": list(range(robot.model.nv)),
            }  # fmt: skip
            names = ("T_F", "P_F", "V_F", "A_F", "iteration_data")
            self.results = {**{name: [] for name in names}, "final_regressor_shape": None}

        def create_ipopt_problem(self, *given: object) -> BaseTrajectoryIPOPTProblem:
            return BaseTrajectoryIPOPTProblem(self, *given)

    np.random.seed(seed)
    trajectory = Trajectory()
    start, processor = time.perf_counter(), time.process_time()
    trajectory.initialize()
    found = trajectory.solve(1)
    taken = {"seconds": time.perf_counter() - start, "processor": time.process_time() - processor}
    if found["T_F"]:
        t, q, dq, ddq = (np.asarray(found[name][0], dtype=float) for name in ("T_F", "P_F", "V_F", "A_F"))
        name = folder / f"figaroh_{seed}_{iterations}.npz"
        np.savez(name, t=t.ravel(), q=q, dq=dq, ddq=ddq, seconds=taken["processor"])
        values = found["iteration_data"][0]["obj_values"]
        taken |= {"first": float(values[0]), "last": float(values[-1]), "of": len(values)}
    print(json.dumps({"figaroh": version("figaroh"), "found": bool(found["T_F"]), **taken}), flush=True)


main()
