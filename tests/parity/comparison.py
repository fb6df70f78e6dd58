"""A model file in an engine against the hand-written recursion on the data file: mass, B, C dq, g and the flange."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.model.arm import Arm
from lwr_dyn.urdf.model_files import model_stem
from tests.parity.engine import ENGINES, Engine
from tests.tolerances import EXACT

MODELS = Path(__file__).resolve().parents[2] / "models"


@dataclass(frozen=True)
class Parity:
    """Largest differences of an engine from ours, relative to the largest value; the flange in m."""

    file: str
    engine: Engine
    mass: float | None
    """What the file weighs in the engine [kg]; None for an arm without masses, as all but `flange`."""
    differences: dict[str, float]

    def beyond(self) -> dict[str, float]:
        """The differences above the tolerance of the engine."""
        allowed = {"B": self.engine.inertia, "C dq": self.engine.inertia, "flange": self.engine.pose}
        return {name: x for name, x in self.differences.items() if not x <= allowed.get(name, EXACT)}

    def row(self) -> str:
        """A row of the table that `scripts/soak.py parity` prints."""
        cells = [f"{self.differences[x]:.1e}" if x in self.differences else "-" for x in QUANTITIES]
        mass = "-" if self.mass is None else f"{self.mass:.4f}"
        return f"| {self.file} | {self.engine.name} | {mass} | {' | '.join(cells)} |"


QUANTITIES = ("mass", "B", "C dq", "g", "flange")
HEADING = f"| file | engine | kg | {' | '.join(QUANTITIES)} |\n|{'---|' * (len(QUANTITIES) + 3)}"


def committed_models() -> dict[Path, Arm]:
    """Every committed .urdf and .xml, and the arm whose data file it was made from."""
    out = {}
    for robot in lwr_dyn.robots():
        for reading in lwr_dyn.readings(robot):
            arm = lwr_dyn.load(robot, reading=reading)
            paths = [MODELS / robot / f"{model_stem(arm)}{ending}" for ending in (".urdf", ".xml")]
            out |= {path: arm for path in paths if path.exists()}
    return out


def pairs() -> list[tuple[Path, Arm, Engine]]:
    """Every committed file with every engine that reads such files."""
    return [
        (path, arm, engine)
        for path, arm in committed_models().items()
        for engine in ENGINES.values()
        if engine.reads(path, with_masses=arm.chain.bodies is not None)
    ]


def parity(path: Path, arm: Arm, engine: Engine, states: int) -> Parity:
    """Load the file and compare; with the rotors where the engine takes them from this kind of file."""
    model = engine.load(path, np.array(arm.chain.gravity))
    q, dq = np.random.default_rng(7).uniform(-2.0, 2.0, (2, states, arm.n))
    T = lwr_dyn.forward_kinematics(arm, q)
    found = {"flange": float(np.abs(np.array([model.flange(x) for x in q]) - T).max())}
    if arm.chain.bodies is None:
        return Parity(path.name, engine, None, found)
    ours = newton_euler_dynamics(arm.chain)
    armature = np.diag(arm.armature) if not engine.keeps_rotors[path.suffix] else 0.0
    weight = sum(body.mass for body in arm.chain.bodies)
    found |= {
        "mass": abs(model.mass - weight) / weight,
        "B": _relative([model.mass_matrix(x) for x in q], ours.mass_matrix(q) - armature),
        "C dq": _relative(
            [model.velocity_torque(x, v) for x, v in zip(q, dq, strict=True)],
            ours.bias_torque(q, dq) - ours.gravity_vector(q),
        ),
        "g": _relative([model.gravity_torque(x) for x in q], ours.gravity_vector(q)),
    }
    return Parity(path.name, engine, float(model.mass), found)


def summary(states: int) -> tuple[str, bool]:
    """All pairs: the table on stderr, the result as a sentence, and whether everything was there and agreed."""
    missing = [engine.name for engine in ENGINES.values() if not engine.installed()]
    rows = [parity(*pair, states) for pair in pairs() if pair[2].name not in missing]
    print(f"\n{HEADING}\n" + "\n".join(row.row() for row in rows) + "\n", file=sys.stderr)
    wrong = [f"{row.file} in {row.engine.name}: {', '.join(row.beyond())}" for row in rows if row.beyond()]
    words = f"{len(rows)} pairs of file and engine; beyond tolerance: {'; '.join(wrong) or 'none'}"
    return f"{words}; not installed: {', '.join(missing) or 'none'}", not wrong and not missing


def _relative(theirs: list[np.ndarray], ours: np.ndarray) -> float:
    return float(np.abs(np.array(theirs) - ours).max() / np.abs(ours).max())
