"""The state of the robot controller while a program runs: machine data, frames, speeds, blends, inputs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import MissingDataError, OptionError
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.planner import tool_pose
from lwr_dyn.krl.motion.settings import Blend, Speeds
from lwr_dyn.krl.names.predefined import CONFIG, SYSTEM
from lwr_dyn.krl.names.types import UNKNOWN
from lwr_dyn.krl.robot.kuka_pose import has_kuka_axes, status, turn
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
)
from lwr_dyn.model.arm import Arm

INPUTS = ("$IN", "$ANIN", "$DIGIN1", "$DIGIN2", "$DIGIN3", "$DIGIN4", "$DIGIN5", "$DIGIN6", "$STOPMESS")
"""Variables that are set from outside: without a value unless one is given."""

_OF_MOTION = ("$POS_ACT", "$POS_INT", "$POS_ACT_MES", "$AXIS_ACT", "$AXIS_INT", "$AXIS_ACT_MES")


@dataclass(frozen=True, slots=True)
class MachineData:
    """Assumed machine data (they are not published for this arm) and the bounds of a run; raises `OptionError`."""

    ramp: float = 0.4
    """[s] From rest to rated speed of each axis at 100 % of $ACC_AXIS (assumed)."""
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

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if not (isinstance(value, int | float) and math.isfinite(value) and 1e-3 <= value <= 1e9):
                raise OptionError(f.name, value, "a number from 0.001 to 1e9")

    def to_json(self) -> dict[str, Any]:
        """As JSON values."""
        return {f.name: getattr(self, f.name) for f in fields(self)}


@dataclass(slots=True, eq=False)
class ControllerState:
    """System variables, the axes of the arm, and the inputs."""

    arm: Arm
    machine: MachineData
    inputs: Mapping[str, Value] = field(default_factory=dict)
    """`$IN[3]` -> value; names in capitals without spaces."""
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
        self.initialise()

    def initialise(self) -> None:
        """Set the variables to the machine data, as BAS(#INITMOV, 0) does."""
        data = self.machine
        values: dict[str, Value] = {
            "$BASE": null_frame(), "$TOOL": null_frame(), "$NULLFRAME": null_frame(), "$WORLD": null_frame(),
            "$ROBROOT": null_frame(),
            "$VEL": StructValue("CP", {"CP": data.vel_cp, "ORI1": data.vel_ori, "ORI2": data.vel_ori}),
            "$ACC": StructValue("CP", {"CP": data.acc_cp, "ORI1": data.acc_ori, "ORI2": data.acc_ori}),
            "$VEL_AXIS": array_of("INT", [100] * 6), "$ACC_AXIS": array_of("INT", [100] * 6),
            "$APO": StructValue("APO_T", dict.fromkeys(("CDIS", "CORI", "CPTP", "CVEL"), 0.0)),
            "$OV_PRO": 100, "$ADVANCE": 3,
        }  # fmt: skip
        for name, value in values.items():
            self.variables[name] = Variable(SYSTEM[name], value)

    def holds(self, key: str) -> bool:
        """Whether a system variable has its value here, also where a `.dat` declares it."""
        return key in _OF_MOTION or key in self.variables or key in self.inputs

    def variable(self, name: str) -> Variable | None:
        """A system variable or one of the standard `$config.dat`; None for another name."""
        key = name.upper()
        if key in _OF_MOTION:
            return Variable(SYSTEM[key], self.position(key))
        if key not in self.variables and key in self.inputs:
            self.variables[key] = Variable(SYSTEM.get(key, UNKNOWN), self.inputs[key])
        if key not in self.variables and (key.startswith("$") or key in CONFIG):
            kind = SYSTEM.get(key) or CONFIG.get(key) or UNKNOWN
            self.variables[key] = Variable(kind, self._default(key, kind.name))
        return self.variables.get(key)

    def _default(self, key: str, type_name: str) -> Value | None:
        """The initial value of a predefined variable, None without one; raises `ExecutionError`."""
        if key.startswith("XHOME") or key == "$H_POS":
            return axes_value(self.home())
        if key in ("$FLAG", "$CYCFLAG", "$OUT", "$TIMER", "$TIMER_STOP"):
            return ArrayValue(type_name, ())
        if key in ("$TRUE", "$FALSE"):
            return key == "$TRUE"
        if key in ("PDAT_ACT", "PDEFAULT"):
            return StructValue("PDAT", {"VEL": 100.0, "ACC": 100.0, "APO_DIST": 100.0})
        if key in ("LDAT_ACT", "LDEFAULT"):
            return StructValue("LDAT", {"VEL": 2.0, "ACC": 100.0, "APO_DIST": 100.0})
        if key == "FDAT_ACT" or key.startswith("FHOME"):
            return StructValue("FDAT", {"TOOL_NO": 0, "BASE_NO": 0})
        return None

    def home(self) -> Array:
        """The mastering position (n,) [rad], the home of a new `$config.dat`; raises `ExecutionError`."""
        if not self.arm.mastering:
            raise ExecutionError("no-value", "the home position is not known", "give XHOME a value")
        return np.array(self.arm.mastering)

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        """An element of an input or output, a flag's default; None for an ordinary array; raises `ExecutionError`."""
        key = name.upper()
        text = f"{key}[{','.join(map(str, index))}]"
        if text in self.inputs:
            return self.inputs[text]
        if key == "$IN" and index == (1025,):
            return True
        if key == "$IN" and index == (1026,):
            return False
        if key in INPUTS:
            raise ExecutionError("unknown-input", f"the input {text} has no value", f"give one: --set '{text}=TRUE'")
        if key in ("$OUT", "$FLAG", "$CYCFLAG", "$TIMER_STOP", "$TIMER", "$ANOUT"):
            variable = self.variable(key)
            array = None if variable is None else variable.value
            value = array.items.get(index) if isinstance(array, ArrayValue) else None
            default: Value = 0 if key in ("$TIMER", "$ANOUT") else False
            return default if value is None else value
        return None

    def position(self, key: str) -> Value | None:
        """`$POS_ACT` or `$AXIS_ACT`; before the first motion the arm is assumed at mastering."""
        q = self.home() if self.q is None else self.q
        if key.startswith("$AXIS"):
            return axes_value(q)
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
        vel, acc = self._percents("$VEL_AXIS"), self._percents("$ACC_AXIS")
        override = _between("$OV_PRO", self.variables["$OV_PRO"].value, 100.0) / 100.0
        rated = self.arm.velocity
        cp, ori = self._part("$VEL", "CP", 100.0), np.radians(self._part("$VEL", "ORI1", 1e5))
        cp_ramp, ori_ramp = self._part("$ACC", "CP", 1e3), np.radians(self._part("$ACC", "ORI1", 1e6))
        axis, axis_ramp = rated * vel * override, rated / self.machine.ramp * acc
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

    def note_speed(self, name: str) -> None:
        """Remember which speed the program has set, if the variable is one."""
        kind = {"$VEL_AXIS": "PTP", "$VEL": "CP"}.get(name.upper())
        if kind is not None:
            self.speeds_set.add(kind)


def _between(what: str, value: Value | None, most: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 1e-6 <= value <= most:
        raise ExecutionError("speed-range", f"{what} = {value}", f"more than 0, at most {most:g}")
    return float(value)
