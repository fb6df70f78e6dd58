"""A URDF file as an arm, the states it is tried at, and the torque that the file asks for, by our own recursion."""

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lwr_dyn.arms.urdf.parse import parse_urdf
from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.arms.urdf.tree import KINDS, build_tree, with_held_joints
from lwr_dyn.arms.urdf.xacro_file import expand_xacro
from lwr_dyn.checks.arm.identities import random_states
from lwr_dyn.checks.engines.child_process import TriedStates
from lwr_dyn.checks.engines.engine import ArmInFile
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.files import ends_in, write_file
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm

STATES, SEED = 20, 7


@dataclass(frozen=True, slots=True, eq=False)
class FileReference:
    """An arm as its file says; without masses every torque is empty."""

    arm: Arm
    scope: ArmInFile
    states: TriedStates

    @property
    def has_dynamics(self) -> bool:
        """Whether every moving link has a body."""
        return self.arm.chain.bodies is not None

    def torque(self, arm: Arm | None = None) -> Array:
        """B ddq + C dq + g with armature, and the friction of the joints, (k, n), of this arm or of a changed file."""
        arm, x = self.arm if arm is None else arm, self.states
        tau = newton_euler_dynamics(arm.chain).inverse_dynamics(x.q, x.dq, x.ddq)
        return np.asarray(tau + self.friction(arm))

    def friction(self, arm: Arm) -> Array:
        """Friction torque (k, n), 0 where it is not known."""
        rows = [
            np.zeros(len(self.states.dq)) if model is None else model.torque(self.states.dq[:, k])
            for k, model in enumerate(arm.friction_models())
        ]
        return np.array(rows).T

    def flange(self) -> Array:
        """Poses (k, 4, 4)."""
        return flange_pose(self.arm.chain, self.states.q)

    def held(self) -> dict[str, Array]:
        """The numbers beside the dynamics, infinite where a limit is not known."""
        arm = self.arm
        pairs = {name: [getattr(x, name) or 0.0 for x in arm.limits] for name in ("viscous", "coulomb")}
        limits = {"lower": arm.lower, "upper": arm.upper, "velocity": arm.velocity, "effort": arm.effort}
        return limits | {name: np.array(values) for name, values in pairs.items()}


@contextmanager
def as_urdf(path: Path, xacro_args: Mapping[str, str]) -> Iterator[Path]:
    """The file itself, or what a `.xacro` expands to, as a file for a while; raises as `expand_xacro`."""
    if not ends_in(path, ".xacro"):
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        expanded = Path(folder) / f"{path.name.partition('.')[0]}.urdf"
        write_file(expanded, expand_xacro(path, xacro_args))
        yield expanded


def reference_of(path: Path, tip: str | None, lock: Mapping[str, float], count: int = STATES) -> FileReference:
    """The arm in a file at random states; raises as `read_urdf`."""
    arm = read_urdf(path, tip=tip, lock=lock)
    urdf, end = parse_urdf(path), arm.layout.tip if arm.layout is not None else tip or ""
    locked = with_held_joints(build_tree(urdf, lock), end)[0].locked
    held = {name: value for name, value in locked.items() if urdf.joints[name].type in KINDS}
    scope = ArmInFile(arm.joint_names, end, tuple(float(x) for x in arm.chain.gravity), held)
    x = random_states(arm, count, SEED)
    return FileReference(arm, scope, TriedStates(x.q, x.dq, x.ddq))
