"""The columns of a log: what they are called, which units they may declare, and how they become SI.

    time, q1 .. qn, tau1 .. taun, optionally dq1 .. dqn, motor positions qm1 .. qmn, motor currents i1 .. in

A column may give its unit in brackets, `q1 [deg]`; without, it is in the unit declared for its quantity, or SI.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi

from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.model.dh import JointKind

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
        listed = ", ".join(f"{quantity}1.." for quantity in needs)
        raise LogError(
            file, "columns", found, f"time, {listed}" + ("" if "dq" in needs else " (and dq1.. if measured)")
        )
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
