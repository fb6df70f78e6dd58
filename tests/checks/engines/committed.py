"""Every committed model file in every engine that reads such files, against the data file that it was made from."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import lwr_dyn
from lwr_dyn.arms.urdf.model_files import model_stem
from lwr_dyn.checks.arm.model_laws import random_states
from lwr_dyn.checks.engines.child_process import Job, TriedStates, load_here, quiet
from lwr_dyn.checks.engines.engine import EXACT, ArmInFile, is_installed
from lwr_dyn.checks.engines.losses import Agreement, FileReference, agreement
from lwr_dyn.model.arm import Arm

MODELS = Path(__file__).resolve().parents[3] / "models"
KEEPS_ROTORS = {
    ("pinocchio", ".urdf"): False,
    ("mujoco", ".urdf"): False,
    ("mujoco", ".xml"): True,
    ("drake", ".urdf"): True,
    ("drake", ".xml"): True,
    ("pybullet", ".urdf"): False,
}
"""Engine and kind of file -> whether it takes the rotors from it."""


@dataclass(frozen=True)
class Pair:
    """A committed file, its arm, an engine."""

    path: Path
    arm: Arm
    engine: str

    def __str__(self) -> str:
        return f"{self.path.name}-{self.engine}"


def committed_models() -> dict[Path, Arm]:
    """Every committed .urdf and .xml, and the arm whose data file it was made from."""
    out = {}
    for robot in lwr_dyn.robots():
        for reading in lwr_dyn.readings(robot):
            arm = lwr_dyn.load(robot, reading=reading)
            paths = [MODELS / robot / f"{model_stem(arm)}{ending}" for ending in (".urdf", ".xml")]
            out |= {path: arm for path in paths if path.exists()}
    return out


COUPLED = {"tx40"}
"""Arms whose motors turn several joints: no file that an engine reads holds what their rotors add between joints."""


def pairs() -> list[Pair]:
    """Every committed file with every engine that reads such files.

    The moments of a moving link without mass Pinocchio alone reads from a URDF: MuJoCo refuses the link, PyBullet
    leaves them out, Drake gives it 1 kg. Its stand-in in our MJCF is weighed in tests/arms/export/test_mjcf.py.
    """
    return [
        Pair(path, arm, engine)
        for path, arm in committed_models().items()
        for engine, ending in KEEPS_ROTORS
        if path.suffix == ending and arm.name not in COUPLED and (engine == "pinocchio" or _all_weigh(arm))
    ]


def _all_weigh(arm: Arm) -> bool:
    return arm.chain.bodies is not None and all(body.mass > 0.0 for body in arm.chain.bodies)


def compared(pair: Pair, states: int) -> tuple[Agreement, list[str]]:
    """The differences, and which are beyond tolerance, the mass included; one-sided friction is in no file."""
    arm = replace(pair.arm, friction=())
    x = random_states(arm, states, seed=7)
    scope = ArmInFile(arm.joint_names, "flange", tuple(arm.chain.gravity.tolist()))
    reference = FileReference(arm, scope, TriedStates(x.q, x.dq, x.ddq))
    with quiet():
        loaded = load_here(pair.engine, Job(pair.path, scope, {"still": True}), reference.states)
    rotors = KEEPS_ROTORS[pair.engine, pair.path.suffix]
    found = agreement(pair.engine, loaded, reference, rotors)
    weight = sum(body.mass for body in arm.chain.bodies or ())
    heavy = weight and abs(loaded.mass - weight) > EXACT * weight
    return found, found.beyond() + (["mass"] if heavy else [])


def summary(states: int) -> tuple[str, bool]:
    """All pairs: a line each on stderr, the result as a sentence, and whether everything was there and agreed."""
    missing = sorted({pair.engine for pair in pairs() if not is_installed(pair.engine)})
    wrong, count = [], 0
    for pair in (x for x in pairs() if x.engine not in missing):
        found, beyond = compared(pair, states)
        cells = " ".join(f"{name} {value:.1e}" for name, value in found.relative.items())
        print(f"{pair}: {cells} flange {found.absolute['flange']:.1e} m", file=sys.stderr)
        wrong += [f"{pair}: {', '.join(beyond)}"] if beyond else []
        count += 1
    words = f"{count} pairs of file and engine; beyond tolerance: {'; '.join(wrong) or 'none'}"
    return f"{words}; not installed: {', '.join(missing) or 'none'}", not wrong and not missing
