"""The state of the robot controller while a program runs: machine data, frames, speeds, blends, inputs.

Values that neither the program nor its files give (home, machine data, states, standard data) are assumed, each listed
once.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.foundation.fields import parse_toml
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.motion_segments import tool_pose
from lwr_dyn.krl.motion.pose_paths import Blend, Speeds
from lwr_dyn.krl.names.known_names import CONFIG, SYSTEM, UNKNOWN
from lwr_dyn.krl.robot.kuka_pose import has_kuka_axes, status, turn
from lwr_dyn.krl.running import values as v
from lwr_dyn.krl.running.cell import RobotCell, constant_value
from lwr_dyn.krl.running.values import ArrayValue, EnumValue, StructValue, Value, Variable
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True)
class Assumption:
    """One thing assumed: its name (`$T1`, `LIN with C_DIS`), what is taken, and where that comes from."""

    name: str
    value: str
    why: str

    def __str__(self) -> str:
        return f"{self.name} = {self.value} ({self.why})" if self.value else f"{self.name}: {self.why}"


FROM = {"controller": "state default", "option": "option not installed"}
"""Where the values of a table of `states.toml` come from, in the list of assumptions."""


@cache
def state_defaults() -> Mapping[str, tuple[Value, str]]:
    """The states of a controller in automatic operation without faults or options, and where each comes from.

    >>> state_defaults()["$T1"]
    (False, 'state default')
    """
    text = (files("lwr_dyn.krl.running") / "states.toml").read_text(encoding="utf-8")
    tables = parse_toml(text, "states.toml")
    return {name: (constant_value(value), FROM[key]) for key in FROM for name, value in tables[key].items()}


def default_value(c: ControllerState, key: str, type_name: str) -> tuple[Value | None, str]:
    """The initial value of a predefined variable and where it comes from; None without one.

    Raises `ExecutionError` for the home of an arm that has none.
    """
    if key.startswith("XHOME") or key == "$H_POS":
        return v.axes_value(c.home()), "home of the cell file" if c.cell.home_deg else "mastering of the robot's data"
    if key in ("$FLAG", "$CYCFLAG", "$OUT", "$TIMER", "$TIMER_STOP", "$ANOUT"):
        return ArrayValue(type_name, ()), ""
    if key in ("$TRUE", "$FALSE"):
        return key == "$TRUE", ""
    if key in _STANDARD or key.startswith("FHOME"):
        kind, parts = _STANDARD.get(key, _STANDARD["FDAT_ACT"])
        return StructValue(kind, dict(parts)), "as in a new $config.dat"
    machine = _machine_value(c, key)
    if machine is not None:
        return machine, "assumed machine data"
    state = state_defaults().get(key)
    return (None, "") if state is None else (v.copied(state[0]), state[1])


_MOTION: dict[str, Value] = {"VEL": 100.0, "ACC": 100.0, "APO_DIST": 100.0}

_STANDARD: dict[str, tuple[str, dict[str, Value]]] = {
    **dict.fromkeys(("PDAT_ACT", "PDEFAULT"), ("PDAT", _MOTION)),
    **dict.fromkeys(("LDAT_ACT", "LDEFAULT"), ("LDAT", {**_MOTION, "VEL": 2.0})),
    "FDAT_ACT": ("FDAT", {"TOOL_NO": 0, "BASE_NO": 0, "IPO_FRAME": EnumValue("BASE")}),
}
"""Variables of a new `$config.dat`: their type and components."""


def _machine_value(c: ControllerState, key: str) -> Value | None:
    data, arm = c.machine, c.arm
    if key in ("$VEL_MA", "$ACC_MA"):
        return v.speed_value(*((data.vel_cp, data.vel_ori) if key == "$VEL_MA" else (data.acc_cp, data.acc_ori)))
    if key in ("$SOFTN_END", "$SOFTP_END"):
        return v.reals(map(float, np.degrees(arm.lower if key == "$SOFTN_END" else arm.upper)))
    if key in ("$VEL_ACT_MA", "$ACC_ACT_MA"):
        return 110 if key == "$VEL_ACT_MA" else 250
    return arm.name if key in ("$TRAFONAME", "$MODEL_NAME", "$ROBNAME") else None


INPUTS = ("$IN", "$ANIN", "$DIGIN1", "$DIGIN2", "$DIGIN3", "$DIGIN4", "$DIGIN5", "$DIGIN6")
"""Variables that are set from outside: without a value unless one is given."""

AT_START: dict[str, Value] = {
    "$OUT": False, "$FLAG": False, "$CYCFLAG": False, "$TIMER_STOP": True, "$TIMER": 0, "$ANOUT": 0,
}  # fmt: skip
"""Arrays of the controller -> the value of each element at the start."""

HOME_DEG = (0.0, -90.0, 90.0, 0.0, 0.0, 0.0)
"""Where mastering is not known."""

OF_MOTION = frozenset({
    "$POS_ACT", "$POS_INT", "$POS_FOR", "$POS_ACT_MES", "$AXIS_ACT", "$AXIS_INT", "$AXIS_FOR", "$AXIS_ACT_MES",
    "$AXIS_ACT_MEAS",
})  # fmt: skip
"""Variables that say where the arm is."""


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
    assumptions: dict[str, Assumption] = field(default_factory=dict)
    """By name, in the order in which they were first needed."""
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
        self._set({"$NULLFRAME": v.null_frame(), "$WORLD": v.null_frame(), "$ROBROOT": v.null_frame(), "$OV_PRO": 100})
        self.initialise()
        if self.cell.ignore_turn:
            self.assume("T of points", "", "not obeyed: the nearest solution with their S (ignore_turn)")
        if self.cell.called_at_deg is not None:
            self.q = np.radians(self.cell.called_at_deg)
            axes = ", ".join(f"{x:g}" for x in self.cell.called_at_deg)
            self.assume("the routine is called", f"with the axes at {axes} deg", "called_at_deg of the cell")

    def initialise(self) -> None:
        """Set frames, speeds and blends to the machine data, as BAS(#INITMOV, 0) does; the override stays."""
        data = self.machine
        values: dict[str, Value] = {
            "$BASE": v.null_frame(), "$TOOL": v.null_frame(),
            "$VEL": v.speed_value(data.vel_cp, data.vel_ori), "$ACC": v.speed_value(data.acc_cp, data.acc_ori),
            "$VEL_AXIS": v.reals([100.0] * 6), "$ACC_AXIS": v.reals([100.0] * 6),
            "$APO": StructValue("CONT", dict.fromkeys(("CDIS", "CORI", "CPTP", "CVEL"), 0.0)),
            "$ADVANCE": 3,
        }  # fmt: skip
        self._set(values)

    def _set(self, values: Mapping[str, Value]) -> None:
        for name, value in values.items():
            self.variables[name] = Variable(SYSTEM[name], value)

    def assume(self, name: str, value: str, why: str) -> None:
        """Note an assumption, unless there is one of that name already."""
        self.assumptions.setdefault(name, Assumption(name, value, why))

    def holds(self, key: str) -> bool:
        """Whether a system variable has its value here, also where a `.dat` declares it."""
        return key in OF_MOTION or key in self.variables or key in self.given

    def variable(self, name: str) -> Variable | None:
        """A system variable, one of the standard `$config.dat` or of the cell; None for another name."""
        key = name.upper()
        if key in OF_MOTION:
            return Variable(SYSTEM[key], self.position(key))
        if key not in self.variables and (key.startswith("$") or key in CONFIG or key in self.given):
            kind = SYSTEM.get(key) or CONFIG.get(key) or UNKNOWN
            value, why = default_value(self, key, kind.name)
            self.variables[key] = Variable(kind, value)
            if why:
                self.unread[key] = why
        return self.variables.get(key)

    def element(self, key: str, index: tuple[int, ...]) -> Value | None:
        """An element of an input or output, a flag; None for an ordinary array; raises `ExecutionError`."""
        text = f"{key}[{','.join(map(str, index))}]"
        if text in self.inputs:
            self.assume(text, v.value_text(self.inputs[text]), "given")
            return self.inputs[text]
        if key == "$IN" and index in ((1025,), (1026,)):
            return index == (1025,)
        if key not in INPUTS and key not in AT_START:
            return None
        variable = self.variables.get(key) if key in INPUTS else self.variable(key)
        value = variable.value.items.get(index) if variable and isinstance(variable.value, ArrayValue) else None
        if value is None and key in INPUTS:
            return self._other_input(key, text)
        if value is None:
            self.assume(f"{key}[]", v.value_text(AT_START[key]), "at the start")
        return AT_START[key] if value is None else value

    def _other_input(self, key: str, text: str) -> Value:
        """An input that nothing gives; raises `ExecutionError` unless the cell file says what others are."""
        others = self.cell.other_inputs
        if others is None:
            hint = f"give one: --set '{text}=TRUE', or in a cell file"
            raise ExecutionError("unknown-input", f"the input {text} has no value", hint)
        value: Value = others if key == "$IN" else 0.0 if key == "$ANIN" else 0
        self.assume(text, v.value_text(value), "inputs.others of the cell file")
        return value

    def note_read(self, key: str) -> None:
        """List a value as assumed that the program reads and has not set itself."""
        why = self.unread.pop(key, None)
        if why is not None:
            self.assume(key, v.value_text(self.variables[key].value) if key in self.variables else "", why)

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
        self.assume("home", "A2 -90, A3 90, all others 0", "not known of this robot: home_deg in a cell file")
        return np.radians(HOME_DEG)

    def position(self, key: str, q: Array | None = None) -> Value | None:
        """`$POS_ACT` or `$AXIS_ACT` at q (n,) [rad], where the planned motions end without it.

        Before the first motion the arm is assumed at mastering.
        """
        q = self.q if q is None else q
        q = self.home() if q is None else q
        return v.axes_value(q) if key.startswith("$AXIS") else self.pose_at(q)

    def pose_at(self, q: Array) -> StructValue:
        """The tool at q (n,) [rad] in the base, with Status and Turn."""
        return v.pose_value(self.tcp_in_base(q), "E6POS", {"S": status(self.arm, q), "T": turn(q)})

    def tcp_in_base(self, q: Array) -> Array:
        """The tool centre point at q (n,) [rad] in the active base (4, 4) [m]."""
        return np.asarray(np.linalg.inv(self.base) @ tool_pose(self.arm, q, self.tool))

    @property
    def base(self) -> Array:
        """(4, 4) [m]"""
        return v.pose_matrix(self.variables["$BASE"].value, "$BASE")

    @property
    def tool(self) -> Array:
        """(4, 4) [m]"""
        return v.pose_matrix(self.variables["$TOOL"].value, "$TOOL")

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
        values = self.variables[name].value  # a program that sets it whole has left no array
        items = values.items if isinstance(values, ArrayValue) else {}
        return np.array([_between(f"{name}[{i}]", items.get((i,)), 100.0) for i in range(1, 7)]) / 100.0

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
        found = f"{what} has no value" if value is None else f"{what} = {value}"
        raise ExecutionError("speed-range", found, f"more than 0, at most {most:g}")
    return float(value)
