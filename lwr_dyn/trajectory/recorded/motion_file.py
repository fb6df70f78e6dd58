"""The CSV file of a motion: a column time, and joint positions or poses of the tip, a row for each moment.

    time                           [s], or time [ms]; rising; the motion begins with the first row
    q1, ..., qn                    joint positions, rad (m where they slide); q1 [deg] and q1 [mm] as well
    x, y, z, roll, pitch, yaw      poses, R = Rz(yaw) Ry(pitch) Rx(roll); m and rad, or x [mm], roll [deg]

Other columns are left out, so the CSV of a run or a log can be given as it is. Lines that begin with # and empty lines
are skipped.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.arrays import Array, number_of
from lwr_dyn.foundation.errors import FaultError
from lwr_dyn.foundation.files import read_bytes
from lwr_dyn.model.spatial import from_rpy

POSE = ("x", "y", "z", "roll", "pitch", "yaw")
_LENGTHS, _TURNS, _TIMES = {"m": 1.0, "mm": 1e-3}, {"rad": 1.0, "deg": np.pi / 180.0}, {"s": 1.0, "ms": 1e-3}
_COLUMN = re.compile(r"(time|x|y|z|roll|pitch|yaw|q[1-9]\d{0,2})\s*(?:\[([^\]]*)\])?")
ALLOWED = "time, and q1, q2, ... or x, y, z, roll, pitch, yaw"
LEAST_ROWS, MOST_ROWS = 6, 1_000_000
"""A spline of degree 5 needs six points."""
LARGEST, SHORTEST = 1e9, 1e-6
"""Numbers beyond, and times closer together [s], come from a broken file, and would lose their digits."""


class MotionFileError(FaultError, ValueError):
    """A motion file cannot be used: which `file`, where in it."""

    def __init__(self, file: str, where: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {where}", found, allowed)
        self.file = file


@dataclass(frozen=True, slots=True, eq=False)
class RecordedMotion:
    """The rows of a file in SI: `t` (m,) [s] from 0, and `joints` (m, n) [rad or m] or `poses` (m, 4, 4).

    `in_degrees` where the header says so; `left_out` names the columns that were not used.
    """

    t: Array
    joints: Array | None = None
    poses: Array | None = None
    in_degrees: bool = False
    left_out: tuple[str, ...] = ()


def read_motion(path: str | Path) -> RecordedMotion:
    """The motion of a CSV file.

    Raises
    ------
    FileAccessError
        The file cannot be read.
    MotionFileError
        A column that is missing, twice or of another unit; a cell that is no finite number; times that do not rise; too
        few rows or too many.
    """
    file = str(path)
    try:
        text = read_bytes(path, "a readable .csv file of a motion").decode("utf-8-sig")
    except UnicodeDecodeError:
        raise MotionFileError(file, "content", "not text", "a CSV file in UTF-8") from None
    lines = [(k, x) for k, x in enumerate(text.splitlines(), 1) if x.strip() and not x.lstrip().startswith("#")]
    if not lines:
        raise MotionFileError(file, "content", "empty", "a line of column names, then a row for each moment")
    if not LEAST_ROWS <= len(lines) - 1 <= MOST_ROWS:
        raise MotionFileError(file, "rows", str(len(lines) - 1), f"{LEAST_ROWS} to {MOST_ROWS} moments")
    rows = list(csv.reader([line for _, line in lines]))
    header = [cell.strip() for cell in rows[0]]
    used, units = _used_columns(file, header)
    numbers = [number for number, _ in lines[1:]]
    columns = {name: _column(file, name, k, len(header), rows[1:], numbers) for name, k in used.items()}
    for name, unit in units.items():
        columns[name] = columns[name] * _units(name)[unit]
    left_out = tuple(cell for k, cell in enumerate(header) if k not in used.values())
    return _motion(file, columns, numbers, "deg" in units.values(), left_out)


def _used_columns(file: str, header: Sequence[str]) -> tuple[dict[str, int], dict[str, str]]:
    """Name -> its place, and name -> its unit where the header gives one, of the columns that are used."""
    places, units = _known_columns(file, header)
    joints = [name for name in places if name.startswith("q")]
    wanted = ["time", *(joint_names(len(joints)) if joints else POSE)]
    for name in wanted:
        if name not in places:
            raise MotionFileError(file, f"column {name}", "missing", ALLOWED)
    for kind in (joints, POSE[:3], POSE[3:]):
        bare = [name for name in kind if name in wanted and name not in units]
        if bare and any(name in units for name in kind):
            raise MotionFileError(
                file, f"unit of column {bare[0]}", "none", "a unit in all columns of a kind, or in none"
            )
    return {name: places[name] for name in wanted}, {name: unit for name, unit in units.items() if name in wanted}


def _known_columns(file: str, header: Sequence[str]) -> tuple[dict[str, int], dict[str, str]]:
    places: dict[str, int] = {}
    units: dict[str, str] = {}
    for k, match in ((k, match) for k, match in enumerate(map(_COLUMN.fullmatch, header)) if match):
        name, unit = match[1], match[2]
        if name in places:
            raise MotionFileError(file, f"column {name}", "stands twice", "each column once")
        if unit is not None and unit not in _units(name):
            raise MotionFileError(file, f"unit of column {name}", repr(unit), ", ".join(_units(name)))
        places[name] = k
        units |= {} if unit is None else {name: unit}
    return places, units


def joint_names(n: int) -> list[str]:
    """q1 to qn."""
    return [f"q{k + 1}" for k in range(n)]


def _units(name: str) -> Mapping[str, float]:
    if name == "time":
        return _TIMES
    return {**_TURNS, **_LENGTHS} if name.startswith("q") else _LENGTHS if name in POSE[:3] else _TURNS


def _column(file: str, name: str, k: int, width: int, rows: Sequence[Sequence[str]], numbers: Sequence[int]) -> Array:
    out = np.empty(len(rows))
    for i, row in enumerate(rows):
        if len(row) != width:
            raise MotionFileError(file, f"line {numbers[i]}", f"{len(row)} cells", f"{width}, as columns")
        try:
            out[i] = number_of(row[k].strip())
        except ValueError:
            out[i] = np.nan
        if not abs(out[i]) <= LARGEST:
            allowed = f"a finite number up to {LARGEST:g}"
            raise MotionFileError(file, f"line {numbers[i]}, column {name}", repr(row[k].strip()), allowed)
    return out


def _motion(
    file: str, columns: Mapping[str, Array], numbers: Sequence[int], in_degrees: bool, left_out: tuple[str, ...]
) -> RecordedMotion:
    t = columns["time"]
    if not (np.diff(t) >= SHORTEST).all():
        row = int(np.argmax(np.diff(t) < SHORTEST)) + 1
        found = f"{t[row]:g} s after {t[row - 1]:g} s"
        raise MotionFileError(file, f"line {numbers[row]}, column time", found, "rising times")
    t = t - t[0]
    names = list(columns)[1:]
    values = np.stack([columns[name] for name in names], axis=1)
    if names[0] == "q1":
        return RecordedMotion(t, joints=values, in_degrees=in_degrees, left_out=left_out)
    poses = np.tile(np.eye(4), (t.size, 1, 1))
    poses[:, :3, 3] = values[:, :3]
    poses[:, :3, :3] = [from_rpy(rpy) for rpy in values[:, 3:]]
    return RecordedMotion(t, poses=poses, in_degrees=in_degrees, left_out=left_out)
