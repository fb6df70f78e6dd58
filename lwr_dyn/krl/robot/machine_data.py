"""The machine data of a six-axis KUKA robot, from a `$machine.dat` or a TOML file in its words, and its `Arm`.

    REAL $LENGTH_A=350.000        LENGTH_A = 350
    $SOFTN_END[1]=-185.0          SOFTN_END = [-185, ...]
    FRAME $TIRORO={X 0, Z 675}    TIRORO = { Z = 675 }

Lengths are in mm, angles in deg. The speed of an axis is `$VEL_AXIS_MA` [rev/min of the motor] over the ratio
`$RAT_MOT_AX`; a TOML file may give `speed` [deg/s] instead. No masses are known. A1 to A6 count and turn as on the
controller, each in the sense of `$AXIS_DIR`: axis 1 about z, axes 2 and 3 about y, axes 4 to 6 about z of their frames.

    T = ROBROOT TIRORO R(A1) X(LENGTH_A) R(A2) X(LENGTH_B) R(A3) TX3P3 R(A4) DH_4 R(A5) DH_5 R(A6) TFLWP
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import PaperError, UnknownNameError
from lwr_dyn.foundation.fields import Fields, parse_toml
from lwr_dyn.foundation.files import ends_in, read_bytes, read_text
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.declarations import Declaration
from lwr_dyn.krl.language.source import parse_bytes
from lwr_dyn.krl.language.statements import Assign
from lwr_dyn.krl.robot.kuka_pose import KukaPose
from lwr_dyn.model.arm import Arm, JointLimits, Source
from lwr_dyn.model.chain import Chain, ChainLink, JointKind
from lwr_dyn.model.spatial import Pose, rot_x


def plain_value(x: e.Expression | None) -> Any:
    """A number, text, truth value, the name of an enumeration's constant, a dict of components; None for another.

    >>> plain_value(e.Aggregate((e.Item("X", e.Unary("-", e.Real(1.5))),)))
    {'X': -1.5}
    """
    if isinstance(x, e.Unary) and x.operator in ("-", "+"):
        value = plain_value(x.operand)
        return (-value if x.operator == "-" else value) if isinstance(value, int | float) else None
    if isinstance(x, e.Aggregate):
        return {item.name.upper(): plain_value(item.value) for item in x.items}
    if isinstance(x, e.EnumLiteral):
        return x.name.upper()
    return x.value if isinstance(x, e.Integer | e.Real | e.Bool | e.Text) else None


def given_values(x: object) -> Iterator[tuple[str, int | None, Any]]:
    """Name in capitals, index (None for the whole) and plain value of what a line of a `.dat` gives."""
    if isinstance(x, Declaration):
        yield from ((d.name.upper(), None, plain_value(d.value)) for d in x.names if d.value is not None)
    if not isinstance(x, Assign):
        return
    target, index = x.target, None
    if isinstance(target, e.Index):
        only = target.indices[0] if len(target.indices) == 1 else None
        index, target = (only.value if isinstance(only, e.Integer) else None), target.of
        if index is None and not isinstance(x.value, e.Text):
            return
    if isinstance(target, e.Name):
        yield target.name.upper(), index, plain_value(x.value)


NEEDED = "a $machine.dat, or a TOML file with its words"
FRAME = ("X", "Y", "Z", "A", "B", "C")
_OPTIONAL = ("ROBROOT", "DH_4", "DH_5")
_KUKA_DIRECTIONS = (-1, 1, 1, -1, -1, -1)
_LISTS = ("AXIS_DIR", "AXIS_SEQ", "SOFTN_END", "SOFTP_END", "VEL_AXIS_MA", "RAISE_TIME")
_WORDS = {"MAIN_AXIS": "NR", "WRIST_AXIS": "ZEH", "TRAFO_AXIS": 6, "DEF_A4FIX": False, "DEF_A5LINK": False}
"""Values of the one kind of robot that is modelled: an articulated arm with a central wrist, all six axes driven."""


@dataclass(frozen=True, slots=True, eq=False)
class MachineRecord:
    """A robot in the words of its machine data; mm and deg. None, or an empty tuple, where it is not given."""

    name: str
    file: str
    digest: str
    frames: Mapping[str, tuple[float, ...]]
    """X, Y, Z, A, B, C of ROBROOT, TIRORO (axis 1 in the robot), TX3P3 (axis 4 in axis 3), TFLWP (flange in wrist)."""
    lengths: tuple[float, float]
    """LENGTH_A from axis 1 to axis 2, LENGTH_B from axis 2 to axis 3."""
    wrist: Mapping[str, tuple[float, float, float]]
    """Length A, length D and angle ALPHA of DH_4 and DH_5."""
    directions: tuple[int, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    speed: tuple[float, ...] = ()
    """[deg/s] Of each axis."""
    raise_time: tuple[float, ...] = ()
    """[s] From rest to that speed; not in the machine data of newer controllers."""
    lines: Mapping[str, int] = field(default_factory=dict)
    """Of each variable, the line of the `.dat` that gives it its value."""


def read_machine_record(path: str | Path) -> MachineRecord:
    """Raises `FileAccessError`, or `PaperError` for what is missing, wrong, or not modelled."""
    if ends_in(path, ".toml"):
        text = read_text(path, NEEDED)
        values = _of_toml(parse_toml(text, str(path)), str(path))
        lines: dict[str, int] = {}
        content = text.encode()
    else:
        content = read_bytes(path, NEEDED)
        values, lines = _of_data(content, Path(path).name)
    return _MachineDataReader(str(path), values, lines).record(hashlib.sha256(content).hexdigest())


Values = dict[str, Any]
"""Variable without its $ -> number, word, frame by component, or list by index."""


def _of_data(content: bytes, name: str) -> tuple[Values, dict[str, int]]:
    values: Values = {}
    lines: dict[str, int] = {}
    file, _ = parse_bytes(content, name)
    for i, line in enumerate(file.lines):
        for variable, index, value in given_values(line.statement):
            key = variable.lstrip("$")
            lines[key] = i + 1
            if index is None:
                values[key] = value
            elif isinstance(values.setdefault(key, {}), dict):
                values[key][index] = value
    return values, lines


def _of_toml(table: Mapping[str, Any], file: str) -> Values:
    top = Fields(table, file, "")
    values: Values = {"TRAFONAME": top.take("name", str)}
    for key in ("TIRORO", "ROBROOT", "TX3P3", "TFLWP", "DH_4", "DH_5"):
        given = top.take(key, dict, {}) if key in _OPTIONAL else top.take(key, dict)
        values[key] = {str(k).upper(): v for k, v in given.items()}
    values["TX3P3"].setdefault("B", 90)
    for key in ("LENGTH_A", "LENGTH_B"):
        values[key] = top.take(key, int | float)
    for key in (*_LISTS, "speed", "RAT_MOT_AX"):
        given = top.take(key, list, None)
        if given is not None:
            values[key] = dict(enumerate(given, 1))
    top.refuse_unknown()
    return values


class _MachineDataReader:
    """Takes values of the machine data; raises `PaperError` for one that is missing or wrong."""

    def __init__(self, file: str, values: Values, lines: Mapping[str, int]) -> None:
        self.file, self.values, self.lines = file, values, lines

    def record(self, digest: str) -> MachineRecord:
        for word, wanted in _WORDS.items():
            if self.values.get(word, wanted) != wanted:
                raise PaperError(
                    self.file, f"${word}", repr(self.values[word]), f"{wanted}: other robots are not modelled"
                )
        if self.six("AXIS_SEQ", (1, 2, 3, 4, 5, 6)) != (1, 2, 3, 4, 5, 6):
            raise PaperError(self.file, "$AXIS_SEQ", "another order of the axes", "1 to 6")
        directions = tuple(int(x) for x in self.six("AXIS_DIR", _KUKA_DIRECTIONS))
        if any(x not in (-1, 1) for x in directions):
            raise PaperError(self.file, "$AXIS_DIR", repr(directions), "six directions, -1 or 1")
        lower, upper = self.six("SOFTN_END"), self.six("SOFTP_END")
        if any(a >= b for a, b in zip(lower, upper, strict=True)):
            raise PaperError(self.file, "$SOFTN_END", repr(lower), "less than $SOFTP_END")
        raised = self.six("RAISE_TIME", ())
        return MachineRecord(
            name=str(self.values.get("TRAFONAME") or Path(self.file).stem).strip("# "), file=self.file, digest=digest,
            frames={key: self.frame(key) for key in ("ROBROOT", "TIRORO", "TX3P3", "TFLWP")},
            lengths=(self.number("LENGTH_A"), self.number("LENGTH_B")),
            wrist={"DH_4": self.wrist("DH_4", 90.0), "DH_5": self.wrist("DH_5", -90.0)},
            directions=directions, lower=lower, upper=upper, speed=self.speed(),
            raise_time=tuple(x / 1e3 for x in raised) if all(x > 0 for x in raised) else (), lines=self.lines,
        )  # fmt: skip

    def number(self, key: str) -> float:
        return self.checked(key, self.values.get(key))

    def checked(self, key: str, value: Any, allowed: str = "a finite number") -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e9:
            raise PaperError(self.file, f"${key}", "missing" if value is None else repr(value), allowed)
        return float(value)

    def six(self, key: str, default: tuple[float, ...] | None = None) -> tuple[float, ...]:
        """The values of axes 1 to 6."""
        given = self.values.get(key)
        if default is not None and not isinstance(given, dict):
            return default
        given = given if isinstance(given, dict) else {}
        return tuple(self.checked(f"{key}[{i}]", given.get(i)) for i in range(1, 7))

    def frame(self, key: str) -> tuple[float, ...]:
        given = self.values.get(key, {} if key == "ROBROOT" else None)
        if not isinstance(given, dict) or not set(given) <= set(FRAME):
            raise PaperError(self.file, f"${key}", "missing" if given is None else repr(given), "X, Y, Z, A, B, C")
        return tuple(self.checked(f"{key}.{x}", given.get(x, 0.0)) for x in FRAME)

    def wrist(self, key: str, alpha: float) -> tuple[float, float, float]:
        given = self.values.get(key, {})
        given = {k.removeprefix("DHART_"): v for k, v in given.items()} if isinstance(given, dict) else {"A": given}
        names = {"A": 0.0, "D": 0.0, "ALPHA": alpha}
        a, d, turn = (self.checked(f"{key}.{x}", given.get(x, default)) for x, default in names.items())
        return a, d, turn

    def speed(self) -> tuple[float, ...]:
        """[deg/s] Of each axis; empty where it is not given."""
        given = self.six("speed", ())
        motors, ratios = self.six("VEL_AXIS_MA", ()), self.values.get("RAT_MOT_AX")
        if not given and motors and isinstance(ratios, dict):
            turns = [self.ratio(ratios.get(i), i) for i in range(1, 7)]
            given = tuple(6.0 * v / n for v, n in zip(motors, turns, strict=True))
        if any(v <= 0.0 for v in given):
            raise PaperError(self.file, "speed of the axes", repr(given), "six numbers above 0")
        return given

    def ratio(self, given: Any, i: int) -> float:
        """Turns of the motor for one of the axis: {N 1798, D 7}, or a number."""
        parts = given if isinstance(given, dict) else {"N": given, "D": 1}
        n, d = (self.checked(f"RAT_MOT_AX[{i}].{x}", parts.get(x)) for x in ("N", "D"))
        if n == 0.0 or d == 0.0:
            raise PaperError(self.file, f"$RAT_MOT_AX[{i}]", f"{n:g} to {d:g}", "a ratio that is not zero")
        return abs(n / d)


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
    wrist = [frames["TX3P3"], *(_wrist(record.wrist[key]) for key in ("DH_4", "DH_5"))]
    before = [frames["ROBROOT"] @ frames["TIRORO"], along_a @ about_y, along_b @ about_y, *wrist]
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
