"""CSV files of poses or joint positions, in SI: waypoints, and motions that a person brings.

A line of column names with units, then numbers:

    x, y, z, roll, pitch, yaw      poses, R = Rz(yaw) Ry(pitch) Rx(roll); m and rad, or in brackets: x [mm], roll [deg]
    q1, ..., qn                    joint positions, rad (m where they slide); q1 [deg] and q1 [mm] as well
    time                           [s], or time [ms]

Lines that begin with # and empty lines are skipped. Waypoints, a row each, are poses of the tip in the base, its places
alone (the orientation is then free), or joint positions, and perhaps the time at which each is reached. A motion has a
column time that rises, and joint positions or poses of the tip, a row for each moment; it begins with the first. Its
other columns are left out, so the CSV of a run or a log can be given as it is.
"""

import csv
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.arrays import Array, number_of
from lwr_dyn.foundation.errors import FaultError
from lwr_dyn.foundation.files import read_bytes
from lwr_dyn.model.spatial import from_rpy

PLACE, ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")
POSE = (*PLACE, *ANGLES)

_COLUMN = re.compile(r"(time|x|y|z|roll|pitch|yaw|q[1-9]\d{0,2})\s*(?:\[([^\]]*)\])?")
_LENGTHS, _TURNS = {"m": 1.0, "mm": 1e-3}, {"rad": 1.0, "deg": np.pi / 180.0}
_UNITS = {
    "time": {"s": 1.0, "ms": 1e-3}, "q": {**_TURNS, **_LENGTHS},
    **dict.fromkeys(PLACE, _LENGTHS), **dict.fromkeys(ANGLES, _TURNS),
}  # fmt: skip

Columns = Mapping[str, tuple[int, str | None]]
"""Name -> its place in a row, and the unit that the header gives."""


@dataclass(frozen=True, slots=True, eq=False)
class CsvRows:
    """The cells of a file; `error` is made of its name, where in it, what is found and what is allowed."""

    file: str
    error: Callable[[str, str, str, str], Exception]
    header: list[str]
    rows: dict[int, list[str]]
    """Number of a line -> its cells."""

    def known(self, allowed: str = "") -> Columns:
        """The columns whose names are known; others are left out, or refused where it is said what is `allowed`."""
        out: dict[str, tuple[int, str | None]] = {}
        for k, cell in enumerate(self.header):
            match = _COLUMN.fullmatch(cell)
            if match is None and allowed:
                raise self.error(self.file, "column", repr(cell), allowed)
            if match is None:
                continue
            name, unit = match[1], match[2]
            if name in out:
                raise self.error(self.file, f"column {name}", "stands twice", "each column once")
            if unit is not None and unit not in _units(name):
                raise self.error(self.file, f"unit of column {name}", repr(unit), ", ".join(_units(name)))
            out[name] = k, unit
        return out

    def numbers(self, columns: Columns, largest: float = math.inf) -> dict[str, Array]:
        """Columns in SI, (rows,) each; of a kind all have a unit or none, lest one was forgotten and taken for SI."""
        for kind in (_LENGTHS, _TURNS, _UNITS["q"]):
            units = {name: unit for name, (_, unit) in columns.items() if _units(name) is kind}
            bare = [name for name, unit in units.items() if unit is None]
            if 0 < len(bare) < len(units):
                allowed = "a unit in all columns of a kind, or in none"
                raise self.error(self.file, f"unit of column {bare[0]}", "none", allowed)
        table = np.array([self._row(line, cells, columns, largest) for line, cells in self.rows.items()])
        factors = [1.0 if unit is None else _units(name)[unit] for name, (_, unit) in columns.items()]
        return dict(zip(columns, (table * factors).T, strict=True))

    def _row(self, line: int, cells: list[str], columns: Columns, largest: float) -> list[float]:
        if len(cells) != len(self.header):
            raise self.error(self.file, f"line {line}", f"{len(cells)} cells", f"{len(self.header)}, as columns")
        out = []
        for name, (k, _) in columns.items():
            try:
                out.append(number_of(cells[k]))
            except ValueError:
                out.append(math.nan)
            if not (math.isfinite(out[-1]) and abs(out[-1]) <= largest):
                allowed = "a finite number" + (f" up to {largest:g}" if largest < math.inf else "")
                raise self.error(self.file, f"line {line}, column {name}", repr(cells[k]), allowed)
        return out


def _units(name: str) -> Mapping[str, float]:
    return _UNITS["q" if name.startswith("q") else name]


def read_rows(
    path: str | Path, error: Callable[[str, str, str, str], Exception], of: str, each: str, least: int, most: int
) -> CsvRows:
    """The rows of a CSV file `of` something, `least` to `most`, one for `each`; raises `FileAccessError`, `error`."""
    file = str(path)
    try:
        text = read_bytes(path, f"a readable .csv file of {of}").decode("utf-8-sig")
    except UnicodeDecodeError:
        raise error(file, "content", "not text", "a CSV file in UTF-8") from None
    lines = [(k, x) for k, x in enumerate(text.splitlines(), 1) if x.strip() and not x.lstrip().startswith("#")]
    if not lines:
        raise error(file, "content", "empty", f"a line of column names, then a row for each {each}")
    if not least <= len(lines) - 1 <= most:
        raise error(file, "rows", str(len(lines) - 1), f"{least} to {most} {each}s")
    cells = {number: [cell.strip() for cell in next(csv.reader([line]))] for number, line in lines}
    return CsvRows(file, error, cells.pop(lines[0][0]), cells)


WAYPOINT_COLUMNS = "x, y, z and perhaps roll, pitch, yaw; or q1, q2, ...; and perhaps time"

MOST_WAYPOINTS = 10_000
"""Of a file."""


class MotionFileError(FaultError, ValueError):
    """A motion file cannot be used: which `file`, where in it."""

    def __init__(self, file: str, where: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {where}", found, allowed)
        self.file = file


class WaypointError(MotionFileError):
    """A waypoint file cannot be used."""


@dataclass(frozen=True, slots=True, eq=False)
class Waypoints:
    """The rows of a file in SI: `poses` (m, 4, 4), `places` (m, 3) or `joints` (m, n); `times` (m,) [s] where given."""

    poses: Array | None = None
    places: Array | None = None
    joints: Array | None = None
    times: Array | None = None

    def tip_poses(self) -> Array:
        """Poses (m, 4, 4) of the tip; places alone with the orientation of the base."""
        if self.poses is not None:
            return self.poses.copy()
        return _poses(np.zeros((0, 3)) if self.places is None else self.places)

    def joint_positions(self, n: int, file: str) -> Array:
        """Joint positions (m, n); raises `WaypointError` for another number of joints."""
        joints = np.zeros((0, 0)) if self.joints is None else self.joints
        if joints.shape[1] != n:
            raise WaypointError(file, "columns", f"q1 to q{joints.shape[1]}", f"q1 to q{n}")
        return joints


def read_waypoints(path: str | Path) -> Waypoints:
    """The waypoints of a CSV file.

    Raises `FileAccessError` (the file cannot be read), `WaypointError` (columns that are missing, unknown, twice or of
    another unit; a cell that is no finite number; fewer than two rows or more than `MOST_WAYPOINTS`; times that do not
    rise).
    """
    rows = read_rows(path, WaypointError, "waypoints", "waypoint", 2, MOST_WAYPOINTS)
    columns = rows.numbers(rows.known(WAYPOINT_COLUMNS))
    times = columns.pop("time", None)
    if times is not None and not (np.diff(times) > 0.0).all():
        row = int(np.argmax(np.diff(times) <= 0.0)) + 2
        found = f"{times[row - 1]:g} s after {times[row - 2]:g} s"
        raise WaypointError(rows.file, f"row {row}, time", found, "rising times")
    joints = joint_names(len(columns))
    if joints and set(columns) == set(joints):
        return Waypoints(joints=_stacked(columns, joints), times=times)
    if set(columns) not in (set(PLACE), set(POSE)):
        raise WaypointError(rows.file, "columns", ", ".join(columns) or "time alone", WAYPOINT_COLUMNS)
    places = _stacked(columns, PLACE)
    if len(columns) == len(PLACE):
        return Waypoints(places=places, times=times)
    return Waypoints(poses=_poses(places, _stacked(columns, ANGLES)), times=times)


MOTION_COLUMNS = "time, and q1, q2, ... or x, y, z, roll, pitch, yaw"

LEAST_MOMENTS, MOST_MOMENTS = 6, 1_000_000
"""Of a motion: a spline of degree 5 needs six points."""

LARGEST, SHORTEST = 1e9, 1e-6
"""Numbers beyond, and times closer together [s], come from a broken file, and would lose their digits."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedMotion:
    """The rows of a file in SI: `t` (m,) [s] from 0, and `joints` (m, n) [rad or m] or `poses` (m, 4, 4).

    `in_degrees` where the header says so; `left_out` names the columns that were not used.
    """

    t: Array
    joints: Array | None
    poses: Array | None
    in_degrees: bool
    left_out: tuple[str, ...]


def read_motion(path: str | Path) -> RecordedMotion:
    """The motion of a CSV file.

    Raises `FileAccessError` (the file cannot be read), `MotionFileError` (a column that is missing, twice or of another
    unit; a cell that is no finite number; times that do not rise; too few rows or too many).
    """
    rows = read_rows(path, MotionFileError, "a motion", "moment", LEAST_MOMENTS, MOST_MOMENTS)
    known = rows.known()
    joints = joint_names(sum(name.startswith("q") for name in known))
    wanted = ["time", *(joints or POSE)]
    for name in (name for name in wanted if name not in known):
        raise MotionFileError(rows.file, f"column {name}", "missing", MOTION_COLUMNS)
    used = {name: known[name] for name in wanted}
    places, units = zip(*used.values(), strict=True)
    columns = rows.numbers(used, LARGEST)
    t = columns["time"]
    if not (np.diff(t) >= SHORTEST).all():
        row = int(np.argmax(np.diff(t) < SHORTEST)) + 1
        found = f"{t[row]:g} s after {t[row - 1]:g} s"
        raise MotionFileError(rows.file, f"line {list(rows.rows)[row]}, column time", found, "rising times")
    left_out = tuple(cell for k, cell in enumerate(rows.header) if k not in places)
    positions = _stacked(columns, joints) if joints else None
    poses = None if joints else _poses(_stacked(columns, PLACE), _stacked(columns, ANGLES))
    return RecordedMotion(t - t[0], positions, poses, "deg" in units, left_out)


def joint_names(n: int) -> list[str]:
    """q1 to qn."""
    return [f"q{k + 1}" for k in range(n)]


def _stacked(columns: Mapping[str, Array], names: Sequence[str]) -> Array:
    """(rows, columns)."""
    return np.stack([columns[name] for name in names], axis=1)


def _poses(places: Array, angles: Array | None = None) -> Array:
    """Poses (m, 4, 4) at places (m, 3) [m], turned by angles (m, 3) [rad] where they are given."""
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, 3] = places
    if angles is not None:
        poses[:, :3, :3] = [from_rpy(rpy) for rpy in angles]
    return poses
