"""The schema of a data file: which tables and columns exist, their units and shapes; records of what was read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.dh import Convention, JointKind
from lwr_dyn.papers.units import to_si

SCHEMA = 1
KINDS = ("printed", "computed", "datasheet", "fitted", "estimated", "assumed")
ABOUT = ("com", "origin")
PRODUCTS = ("tensor", "integral")
STATUSES = ("proven", "likely", "open")


@dataclass(frozen=True, slots=True)
class ColumnRule:
    """What a column may hold: the shape of one row, its quantities, whether the table needs it."""

    row: tuple[int, ...]
    quantities: tuple[str, ...]
    per_joint: bool = True
    required: bool = False


TABLES: dict[str, dict[str, ColumnRule]] = {
    "base": {
        "gravity": ColumnRule((3,), ("acceleration",), per_joint=False),
        "mass": ColumnRule((), ("mass",), per_joint=False),
    },
    "dh": {
        "alpha": ColumnRule((), ("angle",), required=True),
        "a": ColumnRule((), ("length",), required=True),
        "d": ColumnRule((), ("length",), required=True),
        "theta_offset": ColumnRule((), ("angle",)),
        "sign": ColumnRule((), ("number",)),
    },
    "frames": {"origin": ColumnRule((3,), ("length",))},
    "flange": {
        "xyz": ColumnRule((3,), ("length",), per_joint=False),
        "rpy": ColumnRule((3,), ("angle",), per_joint=False),
    },
    "limits": {
        "zero": ColumnRule((), ("angle", "length")),
        "lower": ColumnRule((), ("angle", "length")),
        "upper": ColumnRule((), ("angle", "length")),
        "velocity": ColumnRule((), ("angular velocity", "velocity")),
        "effort": ColumnRule((), ("torque", "force")),
    },
    "poses": {
        "mastering": ColumnRule((), ("angle", "length")),
        "mastering_wrist": ColumnRule((3,), ("length",), per_joint=False),
        "zero_flange": ColumnRule((3,), ("length",), per_joint=False),
        "flange_rpy": ColumnRule((3,), ("angle",), per_joint=False),
        "axis": ColumnRule((3,), ("number",)),
    },
    "ratings": {
        "payload": ColumnRule((), ("mass",), per_joint=False),
        "mass": ColumnRule((), ("mass",), per_joint=False),
        "reach": ColumnRule((), ("length",), per_joint=False),
        "envelope_volume": ColumnRule((), ("volume",), per_joint=False),
    },
    "inertial": {
        "mass": ColumnRule((), ("mass",), required=True),
        "com": ColumnRule((3,), ("length",), required=True),
        "inertia": ColumnRule((3, 3), ("inertia",), required=True),
    },
    "rotors": {
        "gear_ratio": ColumnRule((), ("number",), required=True),
        "inertia": ColumnRule((), ("inertia",), required=True),
    },
    "friction": {
        "viscous": ColumnRule((), ("angular damping", "damping")),
        "coulomb": ColumnRule((), ("torque", "force")),
    },
    "drawing": {"pedestal": ColumnRule((), ("length",), per_joint=False), "radius": ColumnRule((), ("length",))},
}
"""Table -> column -> rule. `limits.zero` is the DH coordinate at which the printed coordinate reads zero; `poses` is a
second statement of the kinematics: joint positions of the mastering pose, where the wrist centre then stands, where the
flange stands at zero, how it is turned in both, and each joint's axis at zero, all in the base. `ratings` is what a
data sheet says of the whole arm (`mass` with its base)."""


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """One column of a table: values as the reading takes them, in the printed unit, and where they come from."""

    name: str
    values: tuple[Any, ...]
    unit: tuple[str, ...]
    where: str
    kind: str
    note: str = ""
    symbols: tuple[str, ...] = ()
    """The source's own letters for the entries, where it has some."""
    errata: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    """Row -> ids of the errata that changed it."""

    def si(self) -> Array:
        """The values in SI units."""
        return np.array([_row_si(row, unit) for row, unit in zip(self.values, self.unit, strict=True)])


def _row_si(row: Any, unit: str) -> Any:
    return [_row_si(cell, unit) for cell in row] if isinstance(row, tuple) else to_si(row, unit)


@dataclass(frozen=True, slots=True)
class Solid:
    """A drawn cylinder of a link, in the frame of its DH row: ends and radius [m]."""

    link: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    colour: str


@dataclass(frozen=True, slots=True)
class Solids:
    """The cylinders of an arm, where their sizes come from, and how sure they are."""

    cylinders: tuple[Solid, ...]
    where: str
    kind: str


@dataclass(frozen=True, slots=True)
class Patch:
    """One cell or field that an erratum reads differently: `at` is its path in the file."""

    at: str
    printed: Any
    read: Any


@dataclass(frozen=True, slots=True)
class Erratum:
    """A slip in a source: what is printed, how it is read, why, and what it changes."""

    id: str
    where: str
    printed: str
    read_as: str
    why: str
    effect: str
    status: str
    patches: tuple[Patch, ...]


@dataclass(frozen=True, slots=True)
class Reading:
    """One way to read the tables: the errata it applies."""

    name: str
    about: str
    errata: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Paper:
    """A data file under one reading: columns as printed with the reading's errata applied."""

    name: str
    title: str
    file: str
    document: Mapping[str, str]
    reading: Reading
    readings: Mapping[str, Reading]
    errata: tuple[Erratum, ...]
    joints: tuple[str, ...]
    kinds: tuple[JointKind, ...]
    convention: Convention
    columns: Mapping[str, Column]
    inertia_about: str
    inertia_products: tuple[str, ...]
    digest: str
    """SHA-256 of the file's text."""
    solids: Solids | None = None
    """What `drawing.solids` lists."""

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    def applied(self) -> tuple[Erratum, ...]:
        """The errata of this reading, in the file's order."""
        return tuple(e for e in self.errata if e.id in self.reading.errata)
