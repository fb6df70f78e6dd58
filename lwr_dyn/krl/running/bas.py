"""BAS, KUKA's subprogram that sets speeds, blends, tool and base: from a number, or PDAT_ACT, LDAT_ACT, FDAT_ACT."""

from collections.abc import Callable

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import Environment
from lwr_dyn.krl.running.values import ArrayValue, StructValue, array_of, null_frame

LEFT_OUT = ("EX_BASE", "ACC_GLUE", "OUT_SYNC", "OUT_ASYNC", "GROUP")
"""Commands of BAS that change nothing a motion needs."""


def bas(env: Environment, c: ControllerState, command: str, value: float) -> None:
    """Execute BAS(#command, value) with the names that `env` sees; raises `ExecutionError`."""
    if command in LEFT_OUT:
        return
    function = _BAS.get(command)
    if function is None:
        raise ExecutionError("not-modelled", f"BAS(#{command}) is not modelled", f"modelled: {', '.join(_BAS)}")
    function(env, c, value)


def frame_of_table(env: Environment, table: str, number: int) -> StructValue:
    """A frame of TOOL_DATA or BASE_DATA; number 0 is the null frame; raises `ExecutionError` where it has no value."""
    if number == 0:
        return null_frame()
    data = env.variable(table).value
    frame = data.items.get((number,)) if isinstance(data, ArrayValue) else None
    if not isinstance(frame, StructValue):
        kind = "tools" if table == "TOOL_DATA" else "bases"
        hint = f"assign it, give it in the cell file under [{kind}], or lend it with --with '$config.dat'"
        raise ExecutionError("no-value", f"{table}[{number}] has no value", hint)
    return StructValue("FRAME", dict(frame.parts))


def _set_axes(c: ControllerState, name: str, percent: float) -> None:
    """All six axes of `$VEL_AXIS` or `$ACC_AXIS` [%]."""
    c.variables[name].value = array_of("REAL", [float(percent)] * 6)
    c.note_written(name)


def _set_part(c: ControllerState, name: str, part: str, value: float) -> None:
    """A component of `$VEL`, `$ACC` or `$APO`."""
    whole = c.variables[name].value
    assert isinstance(whole, StructValue)
    whole.parts[part] = float(value)
    c.note_written(name)


def _set_frame(env: Environment, c: ControllerState, name: str, table: str, number: float) -> None:
    """`$TOOL` or `$BASE` from TOOL_DATA or BASE_DATA."""
    c.variables[name].value = frame_of_table(env, table, int(number))


def _act_part(env: Environment, name: str, part: str, default: float) -> float:
    """A number of PDAT_ACT, LDAT_ACT or FDAT_ACT."""
    whole = env.variable(name).value
    value = whole.parts.get(part) if isinstance(whole, StructValue) else None
    return float(value) if isinstance(value, int | float) else default


def _initmov(env: Environment, c: ControllerState, _: float) -> None:
    c.initialise()


def _frames(env: Environment, c: ControllerState, _: float = 0.0) -> None:
    _set_frame(env, c, "$TOOL", "TOOL_DATA", _act_part(env, "FDAT_ACT", "TOOL_NO", 0.0))
    _set_frame(env, c, "$BASE", "BASE_DATA", _act_part(env, "FDAT_ACT", "BASE_NO", 0.0))


def _ptp_data(env: Environment, c: ControllerState, value: float) -> None:
    """Speed, acceleration and approximation of PDAT_ACT; the frames stay."""
    _set_axes(c, "$VEL_AXIS", value)
    _set_axes(c, "$ACC_AXIS", _act_part(env, "PDAT_ACT", "ACC", 100.0))
    _set_part(c, "$APO", "CPTP", min(_act_part(env, "PDAT_ACT", "APO_DIST", 0.0), 100.0))
    _set_part(c, "$APO", "CDIS", _act_part(env, "PDAT_ACT", "APO_DIST", 0.0))


def _ptp_params(env: Environment, c: ControllerState, value: float) -> None:
    _ptp_data(env, c, value)
    _frames(env, c)


def _cp_data(env: Environment, c: ControllerState, value: float) -> None:
    """Those of LDAT_ACT; the frames stay."""
    _set_part(c, "$VEL", "CP", value)
    _set_part(c, "$ACC", "CP", c.machine.acc_cp * _act_part(env, "LDAT_ACT", "ACC", 100.0) / 100.0)
    _set_part(c, "$APO", "CDIS", _act_part(env, "LDAT_ACT", "APO_DIST", 0.0))


def _cp_params(env: Environment, c: ControllerState, value: float) -> None:
    _cp_data(env, c, value)
    _frames(env, c)


_BAS: dict[str, Callable[[Environment, ControllerState, float], None]] = {
    "INITMOV": _initmov,
    "VEL_PTP": lambda env, c, v: _set_axes(c, "$VEL_AXIS", v),
    "ACC_PTP": lambda env, c, v: _set_axes(c, "$ACC_AXIS", v),
    "VEL_CP": lambda env, c, v: _set_part(c, "$VEL", "CP", v),
    "ACC_CP": lambda env, c, v: _set_part(c, "$ACC", "CP", v),
    "TOOL": lambda env, c, v: _set_frame(env, c, "$TOOL", "TOOL_DATA", v),
    "BASE": lambda env, c, v: _set_frame(env, c, "$BASE", "BASE_DATA", v),
    "PTP_PARAMS": _ptp_params,
    "CP_PARAMS": _cp_params,
    "FRAMES": _frames,
    "PTP_DAT": lambda env, c, v: _ptp_data(env, c, _act_part(env, "PDAT_ACT", "VEL", 100.0)),
    "CP_DAT": lambda env, c, v: _cp_data(env, c, _act_part(env, "LDAT_ACT", "VEL", c.machine.vel_cp)),
}
