"""From machine data to an `Arm` in KUKA's own axes: A1 to A6 count and turn as on the controller. No masses are known.

    T = ROBROOT TIRORO R(A1) X(LENGTH_A) R(A2) X(LENGTH_B) R(A3) TX3P3 R(A4) DH_4 R(A5) DH_5 R(A6) TFLWP

Axis 1 turns about z, axes 2 and 3 about y, axes 4 to 6 about z of their frames, each in the sense of `$AXIS_DIR`.
"""

import math
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.krl.robot.kuka_pose import KukaPose
from lwr_dyn.krl.robot.machine_data import MachineRecord, read_machine_record
from lwr_dyn.model.arm import Arm, JointLimits, Source
from lwr_dyn.model.chain import Chain, ChainLink
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.spatial import Pose, rot_x

MACHINE_DATA = "machine data"
"""Stands for the reading of a paper."""
GRAVITY = (0.0, 0.0, -9.81)
"""[m/s^2] In the world."""


def load_machine_arm(path: str | Path, reading: str | None = None, lock: Mapping[str, float] | None = None) -> Arm:
    """The arm of a `$machine.dat` or of a `.kuka.toml` with its words; machine data have no readings.

    Raises `FileAccessError`, `PaperError`; `UnknownNameError` for a reading; as `Arm.with_locked_joint` for a lock.
    """
    if reading is not None:
        raise UnknownNameError("reading of machine data", reading, ())
    arm = machine_arm(read_machine_record(path))
    for joint, value in (lock or {}).items():
        arm = arm.with_locked_joint(joint, value)
    return arm


def raise_times(arm: Arm) -> tuple[float, ...]:
    """[s] From rest to rated speed of each axis, where the machine data of the arm say it; else empty."""
    return read_machine_record(arm.file).raise_time if arm.reading == MACHINE_DATA else ()


def machine_arm(record: MachineRecord) -> Arm:
    """The arm of machine data, its joints A1 to A6 in KUKA's zero and direction."""
    frames = {key: _pose(values) for key, values in record.frames.items()}
    along_a, along_b = (Pose(np.eye(3), np.array([x / 1e3, 0.0, 0.0])) for x in record.lengths)
    about_y = Pose(rot_x(-math.pi / 2), np.zeros(3))
    back = about_y.inverse()
    before = [
        frames["ROBROOT"] @ frames["TIRORO"],
        along_a @ about_y,
        along_b @ about_y,
        frames["TX3P3"],
        _wrist(record.wrist["DH_4"]),
        _wrist(record.wrist["DH_5"]),
    ]
    after = [Pose.identity(), back, back, Pose.identity(), Pose.identity(), Pose.identity()]
    links = []
    for i, (b, a, direction) in enumerate(zip(before, after, record.directions, strict=True), 1):
        # a joint that turns backwards turns forwards about the opposite axis
        half = Pose(rot_x(math.pi), np.zeros(3)) if direction < 0 else Pose.identity()
        links.append(ChainLink(f"A{i}", f"link_{i}", JointKind.REVOLUTE, b @ half, half.inverse() @ a))
    name = re.sub(r"[^a-z0-9]+", "_", record.name.lower()).strip("_") or "robot"
    chain = Chain(tuple(links), frames["TFLWP"], np.array(GRAVITY))
    return Arm(
        name=name, reading=MACHINE_DATA, title=f"{record.name}, from {Path(record.file).name}", chain=chain,
        limits=_limits(record), sources=_sources(record), digest=record.digest, file=str(Path(record.file).resolve()),
    )  # fmt: skip


def _pose(values: tuple[float, ...]) -> Pose:
    x, y, z, a, b, c = values
    T = KukaPose(x, y, z, a, b, c).matrix()
    return Pose(T[:3, :3], T[:3, 3])


def _wrist(row: tuple[float, float, float]) -> Pose:
    a, d, alpha = row
    return Pose(rot_x(math.radians(alpha)), np.array([a, 0.0, d]) / 1e3)


def _limits(record: MachineRecord) -> tuple[JointLimits, ...]:
    speed = record.speed or (None,) * 6
    return tuple(
        JointLimits(math.radians(low), math.radians(up), None if v is None else math.radians(v))
        for low, up, v in zip(record.lower, record.upper, speed, strict=True)
    )


def _sources(record: MachineRecord) -> dict[str, tuple[Source, ...]]:
    """Of limits and speeds: the variable and its line."""
    words = {"lower": ("SOFTN_END", record.lower), "upper": ("SOFTP_END", record.upper)}
    words["velocity"] = ("VEL_AXIS_MA" if "VEL_AXIS_MA" in record.lines else "speed", record.speed)
    return {
        f"A{i}.{quantity}": (Source(f"{word}[{i}]", _place(record, word), "machine data", value, unit, "to radians"),)
        for quantity, (word, values) in words.items()
        for unit in ("deg/s" if quantity == "velocity" else "deg",)
        for i, value in enumerate(values, 1)
    }


def _place(record: MachineRecord, word: str) -> str:
    line = record.lines.get(word)
    return Path(record.file).name if line is None else f"{Path(record.file).name}, to line {line}"
