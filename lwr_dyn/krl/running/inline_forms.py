"""What KUKA's inline forms use: BAS, the functions of S motions, and assignments after WITH, which hold for one motion.

BAS sets speeds, blends, tool and base from a number, or from PDAT_ACT, LDAT_ACT, FDAT_ACT. The functions of S motions,
`SPTP P WITH $VEL_AXIS[1]=SVEL_JOINT(100), ...`, stand in `bas.src` on a controller; here they give what their name says
from the motion's data (PDAT, LDAT, FDAT), the frames of `$config.dat` and the assumed machine data.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.running import values as v
from lwr_dyn.krl.running.evaluate import number_of
from lwr_dyn.krl.running.running_program import RunningProgram
from lwr_dyn.krl.running.values import AXIS_NAMES, ArrayValue, EnumValue, StructValue, Value

LEFT_OUT = ("EX_BASE", "ACC_GLUE", "OUT_SYNC", "OUT_ASYNC", "GROUP")
"""Commands of BAS that change nothing a motion needs."""


def bas(m: RunningProgram, x: e.FunctionCall) -> None:
    """Execute BAS(#command, value); raises `ExecutionError`."""
    arguments = [a for a in x.arguments if a is not None]
    if not arguments or not isinstance(arguments[0], e.EnumLiteral):
        raise ExecutionError("type", "BAS without a command", "BAS(#INITMOV, 0)")
    value = number_of(m, arguments[1], "the value of BAS") if len(arguments) > 1 else 0.0
    command = arguments[0].name.upper()
    if command in LEFT_OUT:
        return
    if command not in _BAS:
        raise ExecutionError("not-modelled", f"BAS(#{command}) is not modelled", f"modelled: {', '.join(_BAS)}")
    for function in _BAS[command]:
        function(m, value)


def frame_of_table(m: RunningProgram, table: str, number: int) -> StructValue:
    """A frame of TOOL_DATA or BASE_DATA; number 0 is the null frame; raises `ExecutionError` where it has no value."""
    if number == 0:
        return v.null_frame()
    frame = _row(m, table, number)
    if not isinstance(frame, StructValue):
        kind = "tools" if table == "TOOL_DATA" else "bases"
        hint = f"assign it, give it in the cell file under [{kind}], or lend it with --with '$config.dat'"
        raise ExecutionError("no-value", f"{table}[{number}] has no value", hint)
    return StructValue("FRAME", dict(frame.parts))


def _row(m: RunningProgram, table: str, number: int) -> Value | None:
    """An element of a table; None where it has no value."""
    whole = m.variable(table).value
    return whole.items.get((number,)) if isinstance(whole, ArrayValue) else None


def _part(whole: Value | None, name: str, otherwise: float) -> float:
    """A component of a structure, a number; `otherwise` where it is left out."""
    value = whole.parts.get(name) if isinstance(whole, StructValue) else None
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else otherwise


def _set_axes(m: RunningProgram, name: str, percent: float) -> None:
    """All six axes of `$VEL_AXIS` or `$ACC_AXIS` [%]."""
    m.controller.variables[name].value = v.reals([float(percent)] * 6)
    m.controller.note_written(name)


def _set_part(m: RunningProgram, name: str, part: str, value: float) -> None:
    """A component of `$VEL`, `$ACC` or `$APO`."""
    whole = m.controller.variables[name].value
    assert isinstance(whole, StructValue)
    whole.parts[part] = float(value)
    m.controller.note_written(name)


def _set_frame(m: RunningProgram, name: str, table: str, number: float) -> None:
    """`$TOOL` or `$BASE` from TOOL_DATA or BASE_DATA."""
    m.controller.variables[name].value = frame_of_table(m, table, int(number))


def _act_part(m: RunningProgram, name: str, part: str, default: float) -> float:
    """A number of PDAT_ACT, LDAT_ACT or FDAT_ACT."""
    return _part(m.variable(name).value, part, default)


def _frames(m: RunningProgram, _: float) -> None:
    _set_frame(m, "$TOOL", "TOOL_DATA", _act_part(m, "FDAT_ACT", "TOOL_NO", 0.0))
    _set_frame(m, "$BASE", "BASE_DATA", _act_part(m, "FDAT_ACT", "BASE_NO", 0.0))


def _ptp_data(m: RunningProgram, value: float) -> None:
    """Speed, acceleration and approximation of PDAT_ACT; the frames stay."""
    _set_axes(m, "$VEL_AXIS", value)
    _set_axes(m, "$ACC_AXIS", _act_part(m, "PDAT_ACT", "ACC", 100.0))
    _set_part(m, "$APO", "CPTP", min(_act_part(m, "PDAT_ACT", "APO_DIST", 0.0), 100.0))
    _set_part(m, "$APO", "CDIS", _act_part(m, "PDAT_ACT", "APO_DIST", 0.0))


def _cp_data(m: RunningProgram, value: float) -> None:
    """Those of LDAT_ACT; the frames stay."""
    _set_part(m, "$VEL", "CP", value)
    _set_part(m, "$ACC", "CP", m.controller.machine.acc_cp * _act_part(m, "LDAT_ACT", "ACC", 100.0) / 100.0)
    _set_part(m, "$APO", "CDIS", _act_part(m, "LDAT_ACT", "APO_DIST", 0.0))


_BAS: dict[str, tuple[Callable[[RunningProgram, float], None], ...]] = {
    "INITMOV": (lambda m, x: m.controller.initialise(), lambda m, x: m.controller.speeds_set.add("INITMOV")),
    "VEL_PTP": (lambda m, x: _set_axes(m, "$VEL_AXIS", x),),
    "ACC_PTP": (lambda m, x: _set_axes(m, "$ACC_AXIS", x),),
    "VEL_CP": (lambda m, x: _set_part(m, "$VEL", "CP", x),),
    "ACC_CP": (lambda m, x: _set_part(m, "$ACC", "CP", x),),
    "TOOL": (lambda m, x: _set_frame(m, "$TOOL", "TOOL_DATA", x),),
    "BASE": (lambda m, x: _set_frame(m, "$BASE", "BASE_DATA", x),),
    "PTP_PARAMS": (_ptp_data, _frames),
    "CP_PARAMS": (_cp_data, _frames),
    "FRAMES": (_frames,),
    "PTP_DAT": (lambda m, x: _ptp_data(m, _act_part(m, "PDAT_ACT", "VEL", 100.0)),),
    "CP_DAT": (lambda m, x: _cp_data(m, _act_part(m, "LDAT_ACT", "VEL", m.controller.machine.vel_cp)),),
}


def _number(value: Value | None, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ExecutionError("type", f"{what} of {v.value_text(value)}", "a number")
    return float(value)


def _word(whole: Value | None, name: str, otherwise: str) -> EnumValue:
    value = whole.parts.get(name) if isinstance(whole, StructValue) else None
    return value if isinstance(value, EnumValue) and value.name != "NONE" else EnumValue(otherwise)


def _ramps(m: RunningProgram, given: Value | None) -> Value:
    share = _part(given, "ACC", 100.0) / 100.0
    return v.speed_value(m.controller.machine.acc_cp * share, m.controller.machine.acc_ori * share)


def _jerk(m: RunningProgram, given: Value | None) -> Value:
    # no jerk is modelled: a value of its type which no motion uses
    share = _part(given, "JERK_FAC", 50.0)
    axes = StructValue("E6AXIS", dict.fromkeys((*AXIS_NAMES, *(f"E{i}" for i in range(1, 7))), share))
    return StructValue("JERK_STRUC", {"CP": share, "ORI": share, "AX": axes})


def _approximation(m: RunningProgram, given: Value | None) -> Value:
    """APO_DIST as a distance [mm] and as a share of the way [%]: the motion's keyword says which one counts."""
    distance = _part(given, "APO_DIST", 0.0)
    return StructValue("CONT", {"CDIS": distance, "CPTP": distance, "CORI": distance, "CVEL": 100.0})


def _tool(m: RunningProgram, given: Value | None) -> Value:
    table = "BASE_DATA" if _word(given, "IPO_FRAME", "BASE").name == "TCP" else "TOOL_DATA"
    return frame_of_table(m, table, int(_part(given, "TOOL_NO", 0.0)))


def _base(m: RunningProgram, given: Value | None) -> Value:
    if isinstance(given, StructValue):
        return frame_of_table(m, "BASE_DATA", int(_part(given, "BASE_NO", 0.0)))
    return frame_of_table(m, "BASE_DATA", int(_number(given, "SBASE")))


def _load(m: RunningProgram, given: Value | None) -> Value:
    load = _row(m, "LOAD_DATA", int(_number(given, "SLOAD")))
    return load if load is not None else StructValue("LOAD", {"M": -1.0})


def _ipo_mode(m: RunningProgram, given: Value | None) -> Value:
    word = given.parts.get("IPO_FRAME") if isinstance(given, StructValue) else given
    return EnumValue("TCP") if word == EnumValue("TCP") else EnumValue("BASE")


INLINE: dict[str, Callable[[RunningProgram, Value | None], Value]] = {
    "SVEL_JOINT": lambda m, x: min(max(_number(x, "SVEL_JOINT"), 1.0), 100.0),
    "SACC_JOINT": lambda m, x: _part(x, "ACC", 100.0),
    "SGEAR_JERK": lambda m, x: _part(x, "GEAR_JERK", 100.0),
    "SVEL_CP": lambda m, x: v.speed_value(_number(x, "SVEL_CP"), m.controller.machine.vel_ori),
    "SACC_CP": _ramps,
    "SJERK": _jerk,
    "SAPO": _approximation,
    "SAPO_PTP": _approximation,
    "SORI_TYP": lambda m, x: _word(x, "ORI_TYP", "VAR"),
    "STOOL": _tool,
    "STOOL2": _tool,
    "SBASE": _base,
    "SLOAD": _load,
    "SIPO_MODE": _ipo_mode,
}
"""Name -> its value from the first argument, if any; a program's own routine of that name is not asked."""

TIMED = ("$VEL", "$ACC", "$APO", "$VEL_AXIS", "$ACC_AXIS", "$TOOL", "$BASE", "$IPO_MODE", "$ADVANCE", "$OV_PRO")
"""Variables that change where or when the arm moves; another one that cannot be computed is only noted."""
OF_ALL_AXES = ("$VEL_AXIS", "$ACC_AXIS", "$GEAR_JERK")
"""Given for axis 1 alone, as inline forms do, they count for all axes."""


@contextmanager
def with_settings(m: RunningProgram, settings: Sequence[s.Assign]) -> Iterator[None]:
    """Applies assignments, and takes them back at the end; raises `ExecutionError`."""
    c, known, speeds = m.controller, set(m.controller.speeds_set), set[str]()
    before: dict[str, Value | None] = {}
    try:
        for setting in settings:
            name = e.root_name(setting.target)
            variable = c.variable(name) if name.startswith("$") else None
            if variable is not None and name not in before:
                before[name] = None if variable.value is None else v.copied(variable.value)
            try:
                m.assign(setting)
            except ExecutionError as fault:
                if name in TIMED or fault.code != "not-modelled":
                    raise
                m.motions.note_unmodelled(f"{name} after WITH")
        for name in OF_ALL_AXES:
            _spread(m, settings, name)
        speeds = c.speeds_set - known
        yield
    finally:
        for name, value in before.items():
            c.variables[name].value = value
        c.speeds_set -= speeds


def _spread(m: RunningProgram, settings: Sequence[s.Assign], name: str) -> None:
    """Give the value of axis 1 to all axes when no other one is set."""
    targets = [x.target for x in settings if e.root_name(x.target) == name]
    variable = m.controller.variables.get(name)
    if len(targets) == 1 and isinstance(targets[0], e.Index) and variable is not None:
        array = variable.value
        if isinstance(array, ArrayValue) and targets[0].indices == (e.Integer(1),) and (1,) in array.items:
            m.controller.assume(f"{name}[1] after WITH", "", "counts for all axes")
            array.items.update(dict.fromkeys([(i,) for i in range(1, 7)], array.items[1,]))
