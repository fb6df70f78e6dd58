"""The columns of a log: what they are called, which units they may declare, and how they become SI.

    time, q1 .. qn, tau1 .. taun, optionally dq1 .. dqn, motor positions qm1 .. qmn, motor currents i1 .. in

A column may give its unit in brackets, `q1 [deg]`; without, it is in the unit declared for its quantity, or SI.

Column maps: what a file calls its columns, where it does not say time, q1, tau1 ...

    time = "stamp"                   # a name
    q = "joint_pos_*"                # the number of the joint, from 0 or 1, or its name, in place of the star
    tau = ["T_base", "T_elbow"]      # names in the order of the joints
    joints = ["base", "elbow"]       # what stands in place of a star, if neither numbers nor the robot's own names

    [units]
    time = "ms"
    q = "deg"

A quantity that is not in the map has our names. The unit of a mapped column stands in its name, `joint_pos_1 [deg]` or
`joint_pos_1 (deg)`, or in the map, or in `--units`; it is asked for, never guessed.

Recordings: the pieces of a log without a gap in time, and their step.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import pi
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, LogError, OptionError
from lwr_dyn.foundation.files import read_text
from lwr_dyn.model.chain import JointKind

_TURN = {"rad": 1.0, "deg": pi / 180}
_SHIFT = {"m": 1.0, "mm": 1e-3}
UNITS: Mapping[str, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "q": {**_TURN, **_SHIFT},
    "dq": {f"{unit}/s": factor for unit, factor in {**_TURN, **_SHIFT}.items()},
    "tau": {"N m": 1.0, "Nm": 1.0, "mN m": 1e-3, "N": 1.0},
    "qm": {**_TURN, **_SHIFT},
    "i": {"A": 1.0, "mA": 1e-3},
}
"""Quantity -> the units it may be in, and their factor to SI."""
SI: Mapping[str, str] = {"time": "s", "q": "rad", "dq": "rad/s", "tau": "N m", "qm": "rad", "i": "A"}
"""The unit of a column that declares none (m, m/s and N for a sliding joint)."""
_COLUMN = re.compile(r"^(time|dq|qm|q|tau|i)(\d*)\s*(?:\[([^\]]*)\])?$")


@dataclass(frozen=True, slots=True)
class LogColumn:
    """One column as the file has it: `index` counts from 0, `joint` from 1 (0 for time), `unit` is the declared one.

    `written` is what the file calls it, where that is not `name`.
    """

    index: int
    quantity: str
    joint: int
    unit: str
    written: str = ""

    @property
    def factor(self) -> float:
        """What turns its numbers into SI."""
        return UNITS[self.quantity][self.unit]

    @property
    def name(self) -> str:
        """`time`, `q1`, `tau1`, `dq1`, `qm1`, `i1`."""
        return self.quantity if self.quantity == "time" else f"{self.quantity}{self.joint}"

    @property
    def shown(self) -> str:
        """The name for people, with the file's own where it has another: `q1 (joint_pos_1)`."""
        return f"{self.name} ({self.written})" if self.written else self.name


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns that can be used: time, and per joint q, tau, dq, qm, i."""

    joints: tuple[int, ...]
    columns: Mapping[str, LogColumn]

    def has(self, quantity: str) -> bool:
        """Whether every joint has it."""
        return all(f"{quantity}{j}" in self.columns for j in self.joints)


def declared_units(text: str | None) -> dict[str, str]:
    """Units from `time=ms,q=deg`; raises `OptionError` for another quantity or unit.

    >>> declared_units("time=ms,q=deg")
    {'time': 'ms', 'q': 'deg'}
    """
    units: dict[str, str] = {}
    for part in (text or "").split(",") if text else ():
        quantity, _, unit = (x.strip() for x in part.partition("="))
        if quantity not in UNITS:
            raise OptionError("units", repr(part), f"QUANTITY=UNIT with {', '.join(UNITS)}")
        if unit not in UNITS[quantity]:
            raise OptionError(f"units of {quantity}", repr(unit), ", ".join(UNITS[quantity]))
        units[quantity] = unit
    return units


def layout_of(
    file: str, names: Sequence[str], units: Mapping[str, str] | None = None, needs: Sequence[str] = ("q", "tau"),
    own: Sequence[str] = (),
) -> Layout:  # fmt: skip
    """The columns that can be used among `names`; others are ignored.

    Raises
    ------
    LogError
        A column of a quantity in `needs` is missing, or one stands twice, or declares a unit its quantity cannot have,
        or another than `units` gives; or one has no unit at all that the file calls otherwise (`own`, empty where not).

    >>> layout_of("run.csv", ["time [ms]", "q1 [deg]", "tau1", "note"]).columns["q1"].unit
    'deg'
    """
    columns: dict[str, LogColumn] = {}
    for index, name in enumerate(names):
        column = _column(file, index, name.strip(), units or {}, own)
        if column is None:
            continue
        if column.name in columns:
            raise LogError(file, f"column {column.shown}", "stands twice", "each column once")
        columns[column.name] = column
    joints = tuple(sorted({c.joint for c in columns.values() if c.joint}))
    wanted = ["time", *(f"{quantity}{j}" for quantity in needs for j in joints or (1,))]
    missing = [name for name in wanted if name not in columns]
    if missing:
        found = f"{', '.join(missing)} missing; the file has {', '.join(filter(None, names)) or 'no columns'}"
        listed = ", ".join(["time", *(f"{quantity}1.." for quantity in needs)])
        raise LogError(file, "columns", found, listed + ("" if "dq" in needs else " (and dq1.. if measured)"))
    return Layout(joints, columns)


def _column(file: str, index: int, name: str, units: Mapping[str, str], own: Sequence[str]) -> LogColumn | None:
    match = _COLUMN.match(name)
    if match is None or (match[1] == "time") != (match[2] == "") or match[2] in ("0", "00"):
        return None
    quantity, joint, unit = match[1], int(match[2] or 0), match[3]
    written = own[index] if own else ""
    declared = units.get(quantity)
    if unit is None:
        if written and declared is None:
            needed = f"--units {quantity}=UNIT with one of {', '.join(UNITS[quantity])}"
            raise LogError(file, f"column {LogColumn(index, quantity, joint, '', written).shown}", "no unit", needed)
        return LogColumn(index, quantity, joint, declared or SI[quantity], written)
    unit = " ".join(unit.split())
    column = LogColumn(index, quantity, joint, unit, written)
    where = f"column {column.shown if written else name}"
    if unit not in UNITS[quantity]:
        raise LogError(file, where, f"unit [{unit}]", f"one of {', '.join(UNITS[quantity])}")
    if declared is not None and UNITS[quantity][declared] != UNITS[quantity][unit]:
        raise LogError(file, where, f"[{unit}] in the file, {declared} declared", "one unit, or none declared")
    return column


def check_kinds(file: str, layout: Layout, kinds: Sequence[JointKind]) -> None:
    """Turning joints in rad or deg, sliding ones in m or mm; raises `LogError`. An undeclared unit fits both."""
    for column in layout.columns.values():
        if column.quantity not in ("q", "dq", "tau") or column.unit == SI[column.quantity]:
            continue
        slides = column.unit.split("/")[0] in (*_SHIFT, "N")
        if slides != (kinds[column.joint - 1] is JointKind.PRISMATIC):
            moves = "turns" if slides else "slides"
            needed = "rad, deg, N m for a turning joint; m, mm, N for a sliding one"
            raise LogError(file, f"column {column.name}", f"[{column.unit}], but the joint {moves}", needed)


NEEDED = "a map of columns: quantity = name, name with *, or list of names, and [units]"
_UNIT = re.compile(r"\s*[\[(]([^\])]*)[\])]\s*$")


@dataclass(frozen=True, slots=True)
class MappedColumns:
    """The columns of one file: our `names`, for the mapped ones the file's `own` (else ""), units of the map."""

    names: tuple[str, ...]
    own: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ColumnMap:
    """Quantity (time, q, dq, tau, qm, i) -> the names of its columns.

    Parameters
    ----------
    columns : mapping
        Quantity -> a name with a star, or names in the order of the joints (time: one name).
    units : mapping
        Quantity -> unit.
    joints : tuple of str
        What stands in place of the star, in the order of the joints; empty for numbers or the names of the robot.
    source : str
        Where the map is from.
    """

    columns: Mapping[str, tuple[str, ...]]
    units: Mapping[str, str] = field(default_factory=dict)
    joints: tuple[str, ...] = ()
    source: str = "--columns"

    def of(self, file: str, names: Sequence[str], joint_names: Sequence[str] = ()) -> MappedColumns:
        """What the columns of a file (`names`) are called here; `joint_names` are those of the robot, if it is known.

        Raises
        ------
        LogError
            No column has a mapped name, or one name fits two columns, or some joints are numbered from 0, some from 1.

        >>> ColumnMap({"q": ("pos_*",)}).of("run.csv", ["time", "pos_0 [deg]", "pos_1 [deg]", "q1"]).names
        ('time', 'q1 [deg]', 'q2 [deg]', '')
        """
        if not self.columns:
            return MappedColumns(tuple(names))
        bare = [_UNIT.sub("", name).strip() for name in names]
        found = {quantity: self._places(file, quantity, bare, joint_names) for quantity in self.columns}
        counted = [places for quantity, (places, numbers) in found.items() if numbers and quantity != "time"]
        from_zero = any(0 in places for places in counted)
        if from_zero and not all(0 in places for places in counted):
            raise LogError(file, "columns", "joints numbered from 0 and from 1", f"one numbering ({self.source})")
        place = {
            index: quantity if quantity == "time" else f"{quantity}{number + (from_zero and numbers)}"
            for quantity, (places, numbers) in found.items()
            for number, index in places.items()
        }
        ours = [
            place[i] + (f" [{unit[1]}]" if (unit := _UNIT.search(name)) else "") if i in place else self._kept(name)
            for i, name in enumerate(names)
        ]
        own = ["" if place.get(i, "") in ("", bare[i]) else name.strip() for i, name in enumerate(names)]
        return MappedColumns(tuple(ours), tuple(own), self.units)

    def _kept(self, name: str) -> str:
        """A column that is not mapped keeps its name, unless it stands in the way of a mapped quantity."""
        return "" if re.match(rf"^({'|'.join(self.columns)})\d*\s*(\[|$)", name) else name

    def _places(
        self, file: str, quantity: str, bare: Sequence[str], joint_names: Sequence[str]
    ) -> tuple[dict[int, int], bool]:
        """Joint -> index of its column, and whether the joint is a number in the name, counted as the file does."""
        wanted, numbers = self.columns[quantity], False
        if quantity != "time" and len(wanted) == 1 and "*" in wanted[0]:
            before, _, after = wanted[0].partition("*")
            pattern = re.compile(rf"^{re.escape(before)}(.+){re.escape(after)}$")
            stars = [(match[1], i) for i, name in enumerate(bare) if (match := pattern.match(name))]
            known = next((x for x in (self.joints, tuple(joint_names)) if any(star in x for star, _ in stars)), ())
            numbers = not known
            places = [(known.index(star) + 1, i) for star, i in stars if star in known]
            places += [(int(star), i) for star, i in stars if numbers and star.isdecimal()]
        else:
            places = [(k, i) for k, name in enumerate(wanted, 1) for i, other in enumerate(bare) if name == other]
            if len({k for k, _ in places}) < len(wanted):
                places = []
        if not places:
            raise LogError(
                file, f"columns of {quantity}", f"none fits {', '.join(wanted)}; the file has {', '.join(bare)}",
                f"names as in the file ({self.source})",
            )  # fmt: skip
        if len(dict(places)) < len(places):
            raise LogError(file, f"columns of {quantity}", "two for one joint", f"one each ({self.source})")
        return dict(places), numbers


NO_MAP = ColumnMap({})


def column_map(*given: str | Path | None) -> ColumnMap:
    """A map from `q=joint_pos_*,tau=effort_*`, or from the file named by a path that ends in .toml; several as one.

    Raises
    ------
    OptionError
        A quantity or unit that does not exist, a name that is empty, a quantity that is mapped twice.
    FileAccessError
        The file cannot be read, or is not TOML.

    >>> column_map("time=stamp", "q=joint_pos_*").columns
    {'time': ('stamp',), 'q': ('joint_pos_*',)}
    """
    maps = [_one_map(str(text)) for text in given if text is not None]
    if not maps:
        return NO_MAP
    rows = [row for one in maps for row in (*one.columns.items(), *(("joints", one.joints),) * bool(one.joints))]
    units = [row for one in maps for row in one.units.items()]
    for found in ([name for name, _ in rows], [f"units of {name}" for name, _ in units]):
        for name in found:
            if found.count(name) > 1:
                raise OptionError("--columns", f"{name} twice", "each quantity once")
    columns = dict(rows)
    joints = columns.pop("joints", ())
    return ColumnMap(columns, dict(units), joints, ", ".join(dict.fromkeys(one.source for one in maps)))


def _one_map(text: str) -> ColumnMap:
    if text.endswith(".toml"):
        return _from_file(text)
    parts = [part.partition("=") for part in text.split(",") if part.strip()]
    names = [quantity.strip() for quantity, _, _ in parts]
    if len(set(names)) < len(names):
        again = next(name for name in names if names.count(name) > 1)
        raise OptionError("--columns", f"{again} twice", "each quantity once")
    return _checked({quantity.strip(): [name.strip()] for quantity, _, name in parts}, "--columns")


def _from_file(path: str) -> ColumnMap:
    try:
        table = tomllib.loads(read_text(path, NEEDED))
    except tomllib.TOMLDecodeError as fault:
        raise FileAccessError(path, f"not TOML: {' '.join(str(fault).split())}", NEEDED) from None
    units, joints = table.pop("units", {}), table.pop("joints", [])
    if not isinstance(units, dict) or not all(isinstance(unit, str) for unit in units.values()):
        raise OptionError(f"{path}: units", repr(units), "a table of quantity = unit")
    if not isinstance(joints, list) or not all(isinstance(name, str) for name in joints):
        raise OptionError(f"{path}: joints", repr(joints), "a list of names")
    declared = declared_units(",".join(f"{quantity}={unit}" for quantity, unit in units.items()))
    named = {quantity: [names] if isinstance(names, str) else names for quantity, names in table.items()}
    return _checked(named, path, declared, tuple(joints))


def _checked(
    named: Mapping[str, object], source: str, units: Mapping[str, str] | None = None, joints: tuple[str, ...] = ()
) -> ColumnMap:
    columns = {}
    for quantity, names in named.items():
        if quantity not in UNITS:
            raise OptionError(source, repr(quantity), f"QUANTITY=NAME with {', '.join(UNITS)}")
        if not isinstance(names, list) or not names or not all(isinstance(name, str) and name for name in names):
            raise OptionError(f"{source}: {quantity}", repr(names), "a name, a name with *, or a list of names")
        columns[quantity] = tuple(names)
    return ColumnMap(columns, units or {}, joints, source)


GAP = 3.0
"""A step between rows longer than this many usual ones ends a recording and begins another."""
JITTER = 0.05
"""Share of the usual step by which rows may miss an even grid before accelerations cannot be had."""


def recordings(t: Array) -> Iterator[slice]:
    """The rows (slices) of t (k,) [s] that stand without a gap in time.

    >>> list(recordings(np.array([0.0, 0.1, 0.2, 0.9, 1.0])))
    [slice(0, 3, None), slice(3, 5, None)]
    """
    steps = np.diff(t)
    ends = np.flatnonzero(steps > GAP * np.median(steps)) + 1 if steps.size else np.empty(0, dtype=np.intp)
    for first, last in zip([0, *ends.tolist()], [*ends.tolist(), t.size], strict=True):
        yield slice(first, last)


def even_step(source: str, t: Array, start: int = 0) -> float:
    """The step of even rows t (k,) [s]; raises `LogError` that names the uneven ones, counted from `start`."""
    steps = np.diff(t)
    step = float(np.median(steps)) if steps.size else 0.0
    uneven = np.flatnonzero(np.abs(steps - step) > JITTER * step)
    if uneven.size:
        where = f"rows {start + uneven[0] + 1} and {start + uneven[0] + 2}"
        found = f"{steps[uneven[0]]:.6g} s apart, {step:.6g} s as a rule"
        raise LogError(source, where, found, "evenly spaced rows, where accelerations are wanted")
    return step
