"""The functions of KUKA's inline forms for S motions: `SPTP P WITH $VEL_AXIS[1]=SVEL_JOINT(100), ...`.

On a controller they stand in `bas.src`; here they give what their name says from the motion's data (PDAT, LDAT, FDAT),
the frames of `$config.dat` and the assumed machine data.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.running.bas import frame_of_table
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import Environment
from lwr_dyn.krl.running.values import AXIS_NAMES, ArrayValue, EnumValue, StructValue, Value, value_text

Values: TypeAlias = Sequence[Value]
Inline: TypeAlias = Callable[[ControllerState, Values, Environment], Value]


def _part(values: Values, i: int, name: str, otherwise: float) -> float:
    """A component of the i-th argument, a number; `otherwise` where it is left out."""
    whole = values[i] if i < len(values) else None
    value = whole.parts.get(name) if isinstance(whole, StructValue) else None
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else otherwise


def _first_number(values: Values, what: str) -> float:
    value = values[0] if values else None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ExecutionError("type", f"{what} of {value_text(value)}", "a number")
    return float(value)


def _word(values: Values, i: int, name: str, otherwise: str) -> EnumValue:
    whole = values[i] if i < len(values) else None
    value = whole.parts.get(name) if isinstance(whole, StructValue) else None
    return value if isinstance(value, EnumValue) and value.name != "NONE" else EnumValue(otherwise)


def _speeds(c: ControllerState, values: Values, env: Environment) -> Value:
    ori = c.machine.vel_ori
    return StructValue("CP", {"CP": _first_number(values, "SVEL_CP"), "ORI1": ori, "ORI2": ori})


def _ramps(c: ControllerState, values: Values, env: Environment) -> Value:
    share = _part(values, 0, "ACC", 100.0) / 100.0
    ori = c.machine.acc_ori * share
    return StructValue("CP", {"CP": c.machine.acc_cp * share, "ORI1": ori, "ORI2": ori})


def _jerk(c: ControllerState, values: Values, env: Environment) -> Value:
    # no jerk is modelled: a value of its type which no motion uses
    share = _part(values, 0, "JERK_FAC", 50.0)
    return StructValue("JERK_STRUC", {"CP": share, "ORI": share, "AX": _same_axes(share)})


def _same_axes(value: float) -> StructValue:
    return StructValue("E6AXIS", dict.fromkeys((*AXIS_NAMES, *(f"E{i}" for i in range(1, 7))), value))


def _approximation(c: ControllerState, values: Values, env: Environment) -> Value:
    """APO_DIST as a distance [mm] and as a share of the way [%]: the motion's keyword says which one counts."""
    distance = _part(values, 0, "APO_DIST", 0.0)
    return StructValue("CONT", {"CDIS": distance, "CPTP": distance, "CORI": distance, "CVEL": 100.0})


def _tool(c: ControllerState, values: Values, env: Environment) -> Value:
    table = "BASE_DATA" if _word(values, 0, "IPO_FRAME", "BASE").name == "TCP" else "TOOL_DATA"
    return frame_of_table(env, table, int(_part(values, 0, "TOOL_NO", 0.0)))


def _base(c: ControllerState, values: Values, env: Environment) -> Value:
    if values and isinstance(values[0], StructValue):
        return frame_of_table(env, "BASE_DATA", int(_part(values, 0, "BASE_NO", 0.0)))
    return frame_of_table(env, "BASE_DATA", int(_first_number(values, "SBASE")))


def _load(c: ControllerState, values: Values, env: Environment) -> Value:
    number = int(_first_number(values, "SLOAD"))
    whole = env.variable("LOAD_DATA").value
    load = whole.items.get((number,)) if isinstance(whole, ArrayValue) else None
    return load if load is not None else StructValue("LOAD", {"M": -1.0})


def _ipo_mode(c: ControllerState, values: Values, env: Environment) -> Value:
    word = values[0] if values else None
    if isinstance(word, StructValue):
        word = word.parts.get("IPO_FRAME")
    return EnumValue("TCP") if word == EnumValue("TCP") else EnumValue("BASE")


INLINE: dict[str, Inline] = {
    "SVEL_JOINT": lambda c, v, env: min(max(_first_number(v, "SVEL_JOINT"), 1.0), 100.0),
    "SACC_JOINT": lambda c, v, env: _part(v, 0, "ACC", 100.0),
    "SGEAR_JERK": lambda c, v, env: _part(v, 0, "GEAR_JERK", 100.0),
    "SVEL_CP": _speeds,
    "SACC_CP": _ramps,
    "SJERK": _jerk,
    "SAPO": _approximation,
    "SAPO_PTP": _approximation,
    "SORI_TYP": lambda c, v, env: _word(v, 0, "ORI_TYP", "VAR"),
    "STOOL": _tool,
    "STOOL2": _tool,
    "SBASE": _base,
    "SLOAD": _load,
    "SIPO_MODE": _ipo_mode,
}
"""Name -> its value from the arguments; a program's own routine of that name is not asked."""
