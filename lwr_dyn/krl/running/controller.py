"""The state of the robot controller while a program runs: machine data, frames, speeds, blends, inputs."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.planner import tool_pose
from lwr_dyn.krl.motion.settings import Blend, Speeds
from lwr_dyn.krl.names.predefined import CONFIG, SYSTEM
from lwr_dyn.krl.names.types import UNKNOWN
from lwr_dyn.krl.robot.kuka_pose import has_kuka_axes, status, turn
from lwr_dyn.krl.running.assumptions import Assumptions
from lwr_dyn.krl.running.cell import RobotCell
from lwr_dyn.krl.running.default_values import default_value
from lwr_dyn.krl.running.values import (
    ArrayValue,
    StructValue,
    Value,
    Variable,
    array_of,
    axes_value,
    null_frame,
    pose_matrix,
    pose_value,
    value_text,
)
from lwr_dyn.model.arm import Arm

INPUTS = ("$IN", "$ANIN", "$DIGIN1", "$DIGIN2", "$DIGIN3", "$DIGIN4", "$DIGIN5", "$DIGIN6")
"""Variables that are set from outside: without a value unless one is given."""
HOME_DEG = (0.0, -90.0, 90.0, 0.0, 0.0, 0.0)
_OF_MOTION = frozenset({
    "$POS_ACT", "$POS_INT", "$POS_FOR", "$POS_ACT_MES", "$AXIS_ACT", "$AXIS_INT", "$AXIS_FOR", "$AXIS_ACT_MES",
    "$AXIS_ACT_MEAS",
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class MachineData:
    """Assumed machine data (they are not published for this arm) and the bounds of a run; raises `OptionError`."""

    ramp: float = 0.4
    """[s] From rest to rated speed of each axis at 100 % of $ACC_AXIS (assumed)."""
    ramps: tuple[float, ...] = ()
    """[s] The same of each axis, where the robot's machine data give it ($RAISE_TIME); empty otherwise."""
    vel_cp: float = 2.0
    """[m/s] $VEL.CP after BAS(#INITMOV, 0) (assumed)."""
    acc_cp: float = 2.3
    """[m/s^2] $ACC.CP (assumed)."""
    vel_ori: float = 200.0
    """[deg/s] $VEL.ORI1 and ORI2 (assumed)."""
    acc_ori: float = 500.0
    """[deg/s^2] $ACC.ORI1 and ORI2 (assumed)."""
    steps: int = 200_000
    """Most statements that are executed."""
    seconds: float = 3600.0
    """[s] Longest simulated time."""
    motions: int = 20_000
    """Most motions."""
    passes: int = 100
    """Most passes of a LOOP without a way out."""

    def __post_init__(self) -> None:
        named = [(f.name, getattr(self, f.name)) for f in fields(self) if f.name != "ramps"]
        for name, value in (*named, *(("ramps", x) for x in self.ramps)):
            if not (isinstance(value, int | float) and math.isfinite(value) and 1e-3 <= value <= 1e9):
                raise OptionError(name, value, "a number from 0.001 to 1e9")

    def to_json(self) -> dict[str, Any]:
        """As JSON values."""
        return {f.name: getattr(self, f.name) for f in fields(self) if f.name != "ramps" or self.ramps}


@dataclass(slots=True, eq=False)
class ControllerState:
    """System variables, the axes of the arm, and the inputs."""

    arm: Arm
    machine: MachineData
    cell: RobotCell = field(default_factory=RobotCell)
    inputs: dict[str, Value] = field(default_factory=dict)
    """Those of the cell, and what replies and triggers change: `$IN[3]` -> value."""
    given: Mapping[str, Mapping[str, Value]] = field(init=False)
    """Other values of the cell by the name that they begin with: `$ERR` -> `$ERR.NUMBER` -> 3."""
    assumptions: Assumptions = field(default_factory=Assumptions)
    unread: dict[str, str] = field(default_factory=dict)
    """Name of a value that is assumed, and not yet read or set by the program -> where it comes from."""
    variables: dict[str, Variable] = field(default_factory=dict)
    q: Array | None = None
    """(n,) [rad]; None before the first motion."""
    speeds_set: set[str] = field(default_factory=set)
    """The speeds that the program has set: "PTP", "CP"."""

    def __post_init__(self) -> None:
        if not has_kuka_axes(self.arm):
            raise OptionError("robot", self.arm.name, "an arm with KUKA's axes A1 to A6 (kr30ha)")
        if not np.isfinite(self.arm.velocity).all():
            raise MissingDataError(self.arm.name, "axis speeds", "the timing of motions")
        given: dict[str, dict[str, Value]] = {}
        for name, value in self.cell.values.items():
            root = re.split(r"[\[.]", name, maxsplit=1)[0]
            if root in INPUTS:
                self.inputs[name] = value
            else:
                given.setdefault(root, {})[name] = value
        self.given = given
        self._set({"$NULLFRAME": null_frame(), "$WORLD": null_frame(), "$ROBROOT": null_frame(), "$OV_PRO": 100})
        self.initialise()
        if self.cell.ignore_turn:
            self.assumptions.note("T of points", "", "not obeyed: the nearest solution with their S (ignore_turn)")
        if self.cell.called_at_deg is not None:
            self.q = np.radians(self.cell.called_at_deg)
            axes = ", ".join(f"{x:g}" for x in self.cell.called_at_deg)
            self.assumptions.note("the routine is called", f"with the axes at {axes} deg", "called_at_deg of the cell")

    def initialise(self) -> None:
        """Set frames, speeds and blends to the machine data, as BAS(#INITMOV, 0) does; the override stays."""
        data = self.machine
        values: dict[str, Value] = {
            "$BASE": null_frame(), "$TOOL": null_frame(),
            "$VEL": StructValue("CP", {"CP": data.vel_cp, "ORI1": data.vel_ori, "ORI2": data.vel_ori}),
            "$ACC": StructValue("CP", {"CP": data.acc_cp, "ORI1": data.acc_ori, "ORI2": data.acc_ori}),
            "$VEL_AXIS": array_of("REAL", [100.0] * 6), "$ACC_AXIS": array_of("REAL", [100.0] * 6),
            "$APO": StructValue("CONT", dict.fromkeys(("CDIS", "CORI", "CPTP", "CVEL"), 0.0)),
            "$ADVANCE": 3,
        }  # fmt: skip
        self._set(values)

    def _set(self, values: Mapping[str, Value]) -> None:
        for name, value in values.items():
            self.variables[name] = Variable(SYSTEM[name], value)

    def holds(self, key: str) -> bool:
        """Whether a system variable has its value here, also where a `.dat` declares it."""
        return key in _OF_MOTION or key in self.variables or key in self.given

    def variable(self, name: str) -> Variable | None:
        """A system variable, one of the standard `$config.dat` or of the cell; None for another name."""
        key = name.upper()
        if key in _OF_MOTION:
            return Variable(SYSTEM[key], self.position(key))
        if key not in self.variables and (key.startswith("$") or key in CONFIG or key in self.given):
            kind = SYSTEM.get(key) or CONFIG.get(key) or UNKNOWN
            value, why = default_value(self, key, kind.name)
            self.variables[key] = Variable(kind, value)
            if why:
                self.unread[key] = why
        return self.variables.get(key)

    def give(self, key: str, value: Value) -> None:
        """Set an input from outside: `$IN[3]`."""
        self.inputs[key] = value

    def note_read(self, key: str) -> None:
        """List a value as assumed that the program reads and has not set itself."""
        why = self.unread.pop(key, None)
        if why is not None:
            self.assumptions.note(key, value_text(self.variables[key].value) if key in self.variables else "", why)

    def note_written(self, key: str) -> None:
        """The program, or its data, has set a variable: its value is no assumption any more."""
        self.unread.pop(key, None)
        kind = {"$VEL_AXIS": "PTP", "$VEL": "CP"}.get(key)
        if kind is not None:
            self.speeds_set.add(kind)

    def home(self) -> Array:
        """The home of the cell, else the mastering position of the arm, else that of most KUKA robots (n,) [rad]."""
        if self.cell.home_deg is not None:
            return np.radians(self.cell.home_deg)
        if self.arm.mastering:
            return np.array(self.arm.mastering)
        self.assumptions.note("home", "A2 -90, A3 90, all others 0", "not known of this robot: home_deg in a cell file")
        return np.radians(HOME_DEG)

    def position(self, key: str) -> Value | None:
        """`$POS_ACT` or `$AXIS_ACT`; before the first motion the arm is assumed at mastering."""
        q = self.home() if self.q is None else self.q
        if key.startswith("$AXIS"):
            return axes_value(q)
        return self.pose_at(q)

    def pose_at(self, q: Array) -> StructValue:
        """The tool at q (n,) [rad] in the base, with Status and Turn."""
        T = np.linalg.inv(self.base) @ tool_pose(self.arm, q, self.tool)
        return pose_value(T, "E6POS", {"S": status(self.arm, q), "T": turn(q)})

    @property
    def base(self) -> Array:
        """(4, 4) [m]"""
        return pose_matrix(self.variables["$BASE"].value, "$BASE")

    @property
    def tool(self) -> Array:
        """(4, 4) [m]"""
        return pose_matrix(self.variables["$TOOL"].value, "$TOOL")

    def speeds(self) -> Speeds:
        """The speeds that are set now; raises `ExecutionError` for one that is not positive or too high."""
        self.note_read("$OV_PRO")
        vel, acc = self._percents("$VEL_AXIS"), self._percents("$ACC_AXIS")
        override = _between("$OV_PRO", self.variables["$OV_PRO"].value, 100.0) / 100.0
        rated = self.arm.velocity
        cp, ori = self._part("$VEL", "CP", 100.0), np.radians(self._part("$VEL", "ORI1", 1e5))
        cp_ramp, ori_ramp = self._part("$ACC", "CP", 1e3), np.radians(self._part("$ACC", "ORI1", 1e6))
        axis, axis_ramp = rated * vel * override, rated / (self.machine.ramps or self.machine.ramp) * acc
        return Speeds(axis, axis_ramp, cp * override, cp_ramp, ori * override, ori_ramp, self.advance)

    @property
    def advance(self) -> int:
        """$ADVANCE."""
        value = self.variables["$ADVANCE"].value
        return value if isinstance(value, int) and 0 <= value <= 5 else 3

    def _percents(self, name: str) -> Array:
        values = self.variables[name].value
        assert isinstance(values, ArrayValue)
        return np.array([_between(f"{name}[{i}]", values.items.get((i,)), 100.0) for i in range(1, 7)]) / 100.0

    def _part(self, name: str, part: str, most: float) -> float:
        whole = self.variables[name].value
        return _between(f"{name}.{part}", whole.parts.get(part) if isinstance(whole, StructValue) else None, most)

    def blend(self, kinds: tuple[str, ...]) -> Blend | None:
        """The blend with the distances of `$APO` now; None without a blend keyword (C_PTP, C_DIS ...)."""
        if not kinds:
            return None
        apo = self.variables["$APO"].value
        parts = apo.parts if isinstance(apo, StructValue) else {}
        values = map(parts.get, ("CDIS", "CPTP", "CORI", "CVEL"))
        cdis, cptp, cori, cvel = (max(float(x), 0.0) if isinstance(x, int | float) else 0.0 for x in values)
        return Blend(kinds, cdis / 1e3, cptp, float(np.radians(cori)), cvel)


def _between(what: str, value: Value | None, most: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 1e-6 <= value <= most:
        raise ExecutionError("speed-range", f"{what} = {value}", f"more than 0, at most {most:g}")
    return float(value)
