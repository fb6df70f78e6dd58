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
from collections.abc import Iterable, Iterator, Mapping
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
from lwr_dyn.krl.robot.kuka_pose import frame_matrix
from lwr_dyn.model.arm import Arm, JointLimits, Source
from lwr_dyn.model.chain import Chain, ChainLink, JointKind
from lwr_dyn.model.spatial import Pose, rot_x


def plain_value(x: e.Expression | None) -> Any:
    """A number, text, truth value, the name of an enumeration's constant, a dict of components; None for another.

    >>> plain_value(e.Aggregate((e.Item("X", e.Unary("-", e.Real(1.5))),)))
    {'X': -1.5}
    """
    if isinstance(x, e.Aggregate):
        return {item.name.upper(): plain_value(item.value) for item in x.items}
    if isinstance(x, e.EnumLiteral):
        return x.name.upper()
    return x.value if isinstance(x, e.Bool | e.Text) else e.number_of(x)


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


class MachineWords:
    """A robot in the words of its machine data, mm and deg; raises `PaperError` for one that is missing or wrong."""

    def __init__(self, path: str | Path) -> None:
        self.file, self.lines = str(path), dict[str, int]()
        """Of each variable, the line of the `.dat` that gives it its value."""
        if ends_in(path, ".toml"):
            text = read_text(path, NEEDED)
            self.values, content = _of_toml(parse_toml(text, self.file), self.file), text.encode()
        else:
            content = read_bytes(path, NEEDED)
            self.values, self.lines = _of_data(content, Path(path).name)
        self.digest = hashlib.sha256(content).hexdigest()

    @property
    def name(self) -> str:
        """As the maker writes it."""
        return str(self.values.get("TRAFONAME") or Path(self.file).stem).strip("# ")

    def refuse_other_robots(self) -> None:
        """Raises `PaperError` for a robot of a kind that is not modelled."""
        for word, wanted in _WORDS.items():
            if self.values.get(word, wanted) != wanted:
                found = repr(self.values[word])
                raise PaperError(self.file, f"${word}", found, f"{wanted}: other robots are not modelled")
        if self.six("AXIS_SEQ", (1, 2, 3, 4, 5, 6)) != (1, 2, 3, 4, 5, 6):
            raise PaperError(self.file, "$AXIS_SEQ", "another order of the axes", "1 to 6")

    def directions(self) -> tuple[int, ...]:
        """-1 or 1 of each axis."""
        found = tuple(int(x) for x in self.six("AXIS_DIR", _KUKA_DIRECTIONS))
        if any(x not in (-1, 1) for x in found):
            raise PaperError(self.file, "$AXIS_DIR", repr(found), "six directions, -1 or 1")
        return found

    def limits(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """[deg] The lower and the upper ones of the axes."""
        lower, upper = self.six("SOFTN_END"), self.six("SOFTP_END")
        if any(a >= b for a, b in zip(lower, upper, strict=True)):
            raise PaperError(self.file, "$SOFTN_END", repr(lower), "less than $SOFTP_END")
        return lower, upper

    def raise_time(self) -> tuple[float, ...]:
        """[s] From rest to the speed of each axis; empty where it is not given, as for newer controllers."""
        raised = self.six("RAISE_TIME", ())
        return tuple(x / 1e3 for x in raised) if all(x > 0 for x in raised) else ()

    def place(self, key: str) -> str:
        """The file, and the line of a variable."""
        line = self.lines.get(key)
        return Path(self.file).name if line is None else f"{Path(self.file).name}, to line {line}"

    def checked(self, key: str, value: Any) -> float:
        """A number below 1e9."""
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e9:
            raise PaperError(self.file, f"${key}", "missing" if value is None else repr(value), "a finite number")
        return float(value)

    def six(self, key: str, default: tuple[float, ...] | None = None) -> tuple[float, ...]:
        """The values of axes 1 to 6."""
        given = self.values.get(key)
        if default is not None and not isinstance(given, dict):
            return default
        given = given if isinstance(given, dict) else {}
        return tuple(self.checked(f"{key}[{i}]", given.get(i)) for i in range(1, 7))

    def frame(self, key: str) -> Pose:
        """ROBROOT, TIRORO (axis 1 in the robot), TX3P3 (axis 4 in axis 3) or TFLWP (flange in wrist)."""
        given = self.values.get(key, {} if key == "ROBROOT" else None)
        if not isinstance(given, dict) or not set(given) <= set(FRAME):
            raise PaperError(self.file, f"${key}", "missing" if given is None else repr(given), "X, Y, Z, A, B, C")
        T = frame_matrix([self.checked(f"{key}.{x}", given.get(x, 0.0)) for x in FRAME])
        return Pose(T[:3, :3], T[:3, 3])

    def wrist(self, key: str, alpha: float) -> Pose:
        """DH_4 or DH_5 by its length A, length D and angle ALPHA."""
        given = self.values.get(key, {})
        given = {k.removeprefix("DHART_"): v for k, v in given.items()} if isinstance(given, dict) else {"A": given}
        names = {"A": 0.0, "D": 0.0, "ALPHA": alpha}
        a, d, turn = (self.checked(f"{key}.{x}", given.get(x, default)) for x, default in names.items())
        return Pose(rot_x(math.radians(turn)), np.array([a, 0.0, d]) / 1e3)

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
        turns = abs(n / d) if d else 0.0
        if not 0.0 < turns < math.inf:  # tiny numbers vanish in the division
            raise PaperError(self.file, f"$RAT_MOT_AX[{i}]", f"{n:g} to {d:g}", "a ratio that is not zero")
        return turns


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
    arm = machine_arm(MachineWords(path))
    for joint, value in (lock or {}).items():
        arm = arm.with_locked_joint(joint, value)
    return arm


def raise_times(arm: Arm) -> tuple[float, ...]:
    """[s] From rest to rated speed of each axis, where the machine data of the arm say it; else empty."""
    return MachineWords(arm.file).raise_time() if arm.reading == MACHINE_DATA else ()


def machine_arm(words: MachineWords) -> Arm:
    """The arm of machine data, its joints A1 to A6 in KUKA's zero and direction."""
    words.refuse_other_robots()
    directions, (lower, upper) = words.directions(), words.limits()
    words.raise_time()  # is refused here where it is wrong
    frames = {key: words.frame(key) for key in ("ROBROOT", "TIRORO", "TX3P3", "TFLWP")}
    lengths = [words.checked(key, words.values.get(key)) for key in ("LENGTH_A", "LENGTH_B")]
    along_a, along_b = (Pose(np.eye(3), np.array([x / 1e3, 0.0, 0.0])) for x in lengths)
    about_y = Pose(rot_x(-math.pi / 2), np.zeros(3))
    back = about_y.inverse()
    wrist = [frames["TX3P3"], words.wrist("DH_4", 90.0), words.wrist("DH_5", -90.0)]
    before = [frames["ROBROOT"] @ frames["TIRORO"], along_a @ about_y, along_b @ about_y, *wrist]
    after = [Pose.identity(), back, back, Pose.identity(), Pose.identity(), Pose.identity()]
    links = []
    for i, (b, a, direction) in enumerate(zip(before, after, directions, strict=True), 1):
        # a joint that turns backwards turns forwards about the opposite axis
        half = Pose(rot_x(math.pi), np.zeros(3)) if direction < 0 else Pose.identity()
        links.append(ChainLink(f"A{i}", f"link_{i}", JointKind.REVOLUTE, b @ half, half.inverse() @ a))
    name = re.sub(r"[^a-z0-9]+", "_", words.name.lower()).strip("_") or "robot"
    chain, speed = Chain(tuple(links), frames["TFLWP"], np.array(GRAVITY)), words.speed()
    limits = tuple(
        JointLimits(math.radians(low), math.radians(up), None if v is None else math.radians(v))
        for low, up, v in zip(lower, upper, speed or (None,) * 6, strict=True)
    )
    rated = "VEL_AXIS_MA" if "VEL_AXIS_MA" in words.lines else "speed"
    of_axes = (
        ("lower", "SOFTN_END", lower, "deg"),
        ("upper", "SOFTP_END", upper, "deg"),
        ("velocity", rated, speed, "deg/s"),
    )
    return Arm(
        name=name, reading=MACHINE_DATA, title=f"{words.name}, from {Path(words.file).name}", chain=chain,
        limits=limits, sources=_sources(words, of_axes), digest=words.digest, file=str(Path(words.file).resolve()),
    )  # fmt: skip


def _sources(
    words: MachineWords, of_axes: Iterable[tuple[str, str, tuple[float, ...], str]]
) -> dict[str, tuple[Source, ...]]:
    """Of limits and speeds: the variable and its line."""
    return {
        f"A{i}.{quantity}": (Source(f"{word}[{i}]", words.place(word), "machine data", value, unit, "to radians"),)
        for quantity, word, given, unit in of_axes
        for i, value in enumerate(given, 1)
    }
