"""The schema of a data file: tables, columns, shapes, the records that the reader returns, and units.

Here alone degrees and millimetres of data files are converted.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Convention, JointKind
from lwr_dyn.model.file_layout import DrawnCylinder

UNITS: dict[str, tuple[str, float]] = {
    "rad": ("angle", 1.0),
    "deg": ("angle", math.pi / 180.0),
    "m": ("length", 1.0),
    "mm": ("length", 1e-3),
    "m^3": ("volume", 1.0),
    "kg": ("mass", 1.0),
    "g": ("mass", 1e-3),
    "kg m^2": ("inertia", 1.0),
    "kg mm^2": ("inertia", 1e-6),
    "kg cm^2": ("inertia", 1e-4),
    "N m": ("torque", 1.0),
    "N mm": ("torque", 1e-3),
    "N": ("force", 1.0),
    "rad/s": ("angular velocity", 1.0),
    "deg/s": ("angular velocity", math.pi / 180.0),
    "rpm": ("angular velocity", math.pi / 30.0),
    "m/s": ("velocity", 1.0),
    "mm/s": ("velocity", 1e-3),
    "m/s^2": ("acceleration", 1.0),
    "N m s/rad": ("angular damping", 1.0),
    "N m/rad": ("angular stiffness", 1.0),
    "N m/(rad s)": ("angular integral gain", 1.0),
    "N s/m": ("damping", 1.0),
    "N/m": ("stiffness", 1.0),
    "N/(m s)": ("integral gain", 1.0),
    "s/rad": ("slope of a sigmoid", 1.0),
    "1": ("number", 1.0),
}
"""Unit -> (quantity, factor to SI)."""


def to_si(value: float, unit: str) -> float:
    """A number in its printed unit as SI; degrees go through `math.radians`, so 90 deg is exactly pi/2.

    >>> to_si(90.0, "deg") == math.pi / 2
    True
    """
    if unit.startswith("deg"):
        return math.radians(value)
    return value * UNITS[unit][1]


def units_of(*quantities: str) -> tuple[str, ...]:
    """The units in which quantities may be printed.

    >>> units_of("mass")
    ('kg', 'g')
    """
    return tuple(unit for unit, (quantity, _) in UNITS.items() if quantity in quantities)


SCHEMA = 1
KINDS = ("printed", "computed", "datasheet", "fitted", "estimated", "assumed")
ABOUT = ("com", "origin")
PRODUCTS = ("tensor", "integral")
STATUSES = ("proven", "likely", "open")
SEVERITIES = ("model", "result", "text")
"""What an erratum changes: the model or controller, a printed result only, or text only."""
RESULTS = "results."
"""Start of the path of a patch to a paper's printed results, which `lwr_dyn.reproduction` applies."""
RESULT, RUN = "result", "run"
"""Tables of a user's own file: printed results and closed loops, which `lwr_dyn.reproduction` reads."""
UNKNOWN = "unknown"  # in place of a mass, a centre of mass or an inertia, or of one number in them; of a limit, a rotor
PER_JOINT = 0
"""In the shape of a row: one entry per joint."""
FRAMES = ("dh", "urdf")
"""Frames of a set: those of the DH table of its reading, or of a URDF whose joints its table `origins` places."""
ORIGINS = "origins"
TABLES_OF_A_SET = ("base", "dh", "flange", "limits", "inertial", ORIGINS, "rotors", "transmission", "friction")
"""Tables that a published set may bring; each takes the place of the file's whole table."""
TORQUES = ("motor", "link")
"""Where torques are measured: before the gears, or by sensors behind them, where rotors are no part of them."""
FRICTION_SIDES = ("joint", "motor")
SIGMOID = ("sigmoid_level", "sigmoid_slope", "sigmoid_shift")
"""Columns of friction as a sigmoid of the speed."""
LOAD = "load"
"""Column of friction that grows with the load."""
SIDES = ("positive", "negative")
"""Directions of motion, for friction that differs between them."""


@dataclass(frozen=True, slots=True)
class ColumnRule:
    """What a column may hold: the shape of one row, its quantities, whether it is required."""

    row: tuple[int, ...]
    quantities: tuple[str, ...]
    per_joint: bool = True
    required: bool = False
    may_be_unknown: bool = False
    """Whether a row, or a number in it, may be the word "unknown", which is read as NaN."""


_SPRING = ("angular stiffness", "stiffness")
_DAMPING, _FORCE, _SPEED = ("angular damping", "damping"), ("torque", "force"), ("angular velocity", "velocity")
_POSE = {"xyz": ColumnRule((3,), ("length",), per_joint=False), "rpy": ColumnRule((3,), ("angle",), per_joint=False)}
FRICTION_OF_A_SIDE = {"coulomb": _FORCE, "viscous": _DAMPING, "static": _FORCE, "stribeck_velocity": _SPEED}
"""Column of one direction ("positive_coulomb") -> quantities."""

TABLES: dict[str, dict[str, ColumnRule]] = {
    "base": {
        "gravity": ColumnRule((3,), ("acceleration",), per_joint=False),
        "mass": ColumnRule((), ("mass",), per_joint=False),
        **_POSE,
    },
    "dh": {
        "alpha": ColumnRule((), ("angle",), required=True),
        "a": ColumnRule((), ("length",), required=True),
        "d": ColumnRule((), ("length",), required=True),
        "theta_offset": ColumnRule((), ("angle",)),
        "beta": ColumnRule((), ("angle",)),
        "sign": ColumnRule((), ("number",)),
    },
    "frames": {"origin": ColumnRule((3,), ("length",))},
    ORIGINS: {
        "xyz": ColumnRule((3,), ("length",), required=True),
        "rpy": ColumnRule((3,), ("angle",), required=True),
        "axis": ColumnRule((3,), ("number",)),
    },
    "flange": _POSE,
    "limits": {
        "zero": ColumnRule((), ("angle", "length")),
        "lower": ColumnRule((), ("angle", "length"), may_be_unknown=True),
        "upper": ColumnRule((), ("angle", "length"), may_be_unknown=True),
        "velocity": ColumnRule((), ("angular velocity", "velocity"), may_be_unknown=True),
        "effort": ColumnRule((), ("torque", "force"), may_be_unknown=True),
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
        "mass": ColumnRule((), ("mass",), required=True, may_be_unknown=True),
        "com": ColumnRule((3,), ("length",), required=True, may_be_unknown=True),
        "inertia": ColumnRule((3, 3), ("inertia",), required=True, may_be_unknown=True),
        "rpy": ColumnRule((3,), ("angle",)),
    },
    "rotors": {
        "gear_ratio": ColumnRule((), ("number",), may_be_unknown=True),
        "inertia": ColumnRule((), ("inertia",), may_be_unknown=True),
        "armature": ColumnRule((), ("inertia", "mass"), may_be_unknown=True),
    },
    "transmission": {
        "ratio": ColumnRule((), ("number",)),
        "stage": ColumnRule((), ("number",)),
        "signs": ColumnRule((PER_JOINT,), ("number",)),
        "matrix": ColumnRule((PER_JOINT,), ("number",)),
    },
    "gains": {
        "kp": ColumnRule((), _SPRING, required=True),
        "ki": ColumnRule((), ("angular integral gain", "integral gain")),
        "kd": ColumnRule((), _DAMPING, required=True),
        "effort": ColumnRule((), _FORCE),
    },
    "elasticity": {x: ColumnRule((), q, required=True) for x, q in (("stiffness", _SPRING), ("damping", _DAMPING))},
    "friction": {
        "viscous": ColumnRule((), _DAMPING, may_be_unknown=True),
        "coulomb": ColumnRule((), _FORCE, may_be_unknown=True),
        **{f"{s}_{x}": ColumnRule((), quantities) for s in SIDES for x, quantities in FRICTION_OF_A_SIDE.items()},
        "offset": ColumnRule((), _FORCE),
        "covered": ColumnRule((), _SPEED),
        LOAD: ColumnRule((), ("number",)),
        "sigmoid_level": ColumnRule((), _FORCE),
        "sigmoid_slope": ColumnRule((), ("slope of a sigmoid",)),
        "sigmoid_shift": ColumnRule((), _SPEED),
    },
    "drawing": {"pedestal": ColumnRule((), ("length",), per_joint=False), "radius": ColumnRule((), ("length",))},
}
"""Table -> column -> rule. `limits.zero` is the DH coordinate at which the printed coordinate reads zero.

`base.xyz` and `base.rpy` place DH frame 0 in the base. `inertial.rpy` turns each tensor's own axes, as the origin of a
URDF's inertial does. `origins` places each joint of a URDF in the one before, as `<origin>` does at q = 0, with its
`axis` (z if not given): `inertial` is then in these frames. `rotors` gives gear ratio and inertia of the rotor, or
`armature`, its inertia reflected to the joint. The motor map is dq_m = T dq with T_ij = signs_ij ratio_j / stage_j, or
T is printed as `matrix`, a row a motor.
`elasticity` is each gear's spring and damper, seen at the joint. `friction` is one pair for both directions, or columns
per direction that hold up to the speed `covered`, seen at the joints or, with `side = "motor"`, at the motors, and
`load`, the share of the torque carried by which friction grows in both; or a sigmoid, level/(1 + exp(-slope (dq +
shift))) less its value at rest. `poses` is a second description of the kinematics, all in the base: joint positions of
the mastering pose, its wrist centre, the flange's position at zero, the flange's orientation in both, and each joint's
axis at zero. `ratings` are data sheet values of the whole arm (`mass` includes the base).
"""


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """One column of a table: values under the reading, in the printed unit, and their source."""

    name: str
    values: tuple[Any, ...]
    unit: tuple[str, ...]
    where: str
    kind: str
    note: str = ""
    symbols: tuple[str, ...] = ()
    """The source's own symbols for the entries, if any."""
    errata: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    """Row -> ids of the errata that changed it."""
    sigma: tuple[Any, ...] = ()  # standard errors, as `values`, NaN where unknown; empty if not given
    how: str = ""  # of what is estimated or assumed, in a few words: "from drawn solids"

    def si(self) -> Array:
        """The values in SI units."""
        return np.array([_row_si(row, unit) for row, unit in zip(self.values, self.unit, strict=True)])


def _row_si(row: Any, unit: str) -> Any:
    return [_row_si(cell, unit) for cell in row] if isinstance(row, tuple) else to_si(row, unit)


@dataclass(frozen=True, slots=True)
class Solids:
    """The drawn cylinders of an arm in the frames of the DH rows, the source of their sizes, and its kind."""

    cylinders: tuple[DrawnCylinder, ...]
    where: str
    kind: str


@dataclass(frozen=True, slots=True)
class Patch:
    """One cell or field that an erratum changes: `at` is its path in the file."""

    at: str
    printed: Any
    read: Any
    kind: str = ""
    """The kind of the value read, where it differs from the column's ("fitted")."""
    fitted_to: tuple[str, ...] = ()
    """The printed results that a fitted value was chosen to reproduce: they are no evidence for it."""


@dataclass(frozen=True, slots=True)
class Erratum:
    """An error in a source: what is printed, how it is read, why, and what that changes."""

    id: str
    where: str
    printed: str
    read_as: str
    why: str
    effect: str
    status: str
    patches: tuple[Patch, ...]
    severity: str = ""  # one of `SEVERITIES`; empty where not given
    set_name: str = ""  # the published set whose tables it is about; empty for those of the file itself

    @property
    def changes_arm(self) -> bool:
        """Whether it is proven, changes the model, and says how to read cells of the file's own tables."""
        return self.status == "proven" and self.severity == "model" and bool(self.of_tables())

    def of_results(self) -> tuple[Patch, ...]:
        """The patches of printed results."""
        return tuple(p for p in self.patches if p.at.startswith(RESULTS))

    def tables(self) -> set[str]:
        """The file's tables that its patches change."""
        return {p.at.partition(".")[0] for p in self.of_tables()}

    def of_tables(self) -> tuple[Patch, ...]:
        """The patches of the file's own cells."""
        return tuple(p for p in self.patches if not p.at.startswith(RESULTS))


@dataclass(frozen=True, slots=True)
class PublishedSet:
    """One published set of a robot's numbers, whose tables take the place of those of the file."""

    name: str
    about: str
    where: str
    frames: str
    """One of `FRAMES`."""
    tables: Mapping[str, Any]
    """Table -> its columns, as printed."""


@dataclass(frozen=True, slots=True)
class Reading:
    """One way to read the tables: the published set it takes, and the errata it applies on top."""

    name: str
    about: str
    errata: tuple[str, ...]
    set_name: str = ""
    """Empty for the tables of the file itself."""


DOCUMENT_KINDS = ("paper", "maker's sheet", "exercise", "course report", "software")
"""What sort of document numbers are from."""
SOURCE_FIELDS = ("title", "kind", "year", "place", "text", "gives")
"""Of a `[[source]]` beside the document: all are needed, as text; `place` is a DOI, an address, or what is known."""


@dataclass(frozen=True, slots=True, eq=False)
class Paper:
    """A data file under one reading: columns as printed with the reading's errata applied."""

    name: str
    title: str
    file: str
    document: Mapping[str, str]
    sources: tuple[Mapping[str, str], ...]
    """Further documents that numbers are from, each with `SOURCE_FIELDS`."""
    reading: Reading
    readings: Mapping[str, Reading]
    default_reading: str
    sets: Mapping[str, PublishedSet]
    """Published sets by name, beside the tables of the file itself."""
    errata: tuple[Erratum, ...]
    joints: tuple[str, ...]
    kinds: tuple[JointKind, ...]
    torques: str
    """Where the robot's own torques are measured, one of `TORQUES`; empty where the file does not say."""
    convention: Convention
    printed: Mapping[str, Any]
    """The parsed tables as printed, without any erratum: those of the reading's set in place of the file's."""
    columns: Mapping[str, Column]
    inertia_about: str
    inertia_products: tuple[str, ...]
    friction_side: str
    """Where `friction` is seen, one of `FRICTION_SIDES`."""
    digest: str
    """SHA-256 of the file's text."""
    solids: Solids | None = None
    """What `drawing.solids` lists."""

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def reading_names(self) -> tuple[str, ...]:
        """Names of the readings, the default first."""
        return (self.default_reading, *(name for name in self.readings if name != self.default_reading))

    def cell(self, column: str, row: int = 0) -> float | None:
        """One number of a column in SI units; None where the file has no such column, or says that it is unknown."""
        value = float(self.columns[column].si()[row]) if column in self.columns else np.nan
        return None if np.isnan(value) else value

    def numbers(self, column: str) -> tuple[float, ...]:
        """The numbers of a column in SI units; empty where the file has no such column."""
        return tuple(self.columns[column].si().tolist()) if column in self.columns else ()

    def left_in_place(self, reading: str = "") -> tuple[str, ...]:
        """Ids of the proven errata that change the arm, and that a reading, this one if not named, does not apply."""
        read = self.readings[reading] if reading else self.reading
        return tuple(e.id for e in self.errata_of(read.set_name) if e.changes_arm and e.id not in read.errata)

    def errata_of(self, set_name: str) -> tuple[Erratum, ...]:
        """The errata about tables that a reading of a published set uses; "" for one of the file's own tables."""
        brought = self.sets[set_name].tables.keys() if set_name else set()
        return tuple(e for e in self.errata if e.set_name == set_name or not (e.set_name or e.tables() & brought))

    def __repr__(self) -> str:
        return f"Paper({self.name!r}, reading={self.reading.name!r}, file={self.file!r})"
