"""Rows of CSV files of poses or joint positions: a line of column names with units, then numbers, in SI.

    x, y, z, roll, pitch, yaw      poses, R = Rz(yaw) Ry(pitch) Rx(roll); m and rad, or in brackets: x [mm], roll [deg]
    q1, ..., qn                    joint positions, rad (m where they slide); q1 [deg] and q1 [mm] as well
    time                           [s], or time [ms]

Lines that begin with # and empty lines are skipped.
"""

import csv
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.arrays import Array, number_of
from lwr_dyn.foundation.files import read_bytes

PLACE, ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")

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
