"""BAS, KUKA's subprogram that sets speeds, blends, tool and base: from a number, or PDAT_ACT, LDAT_ACT, FDAT_ACT."""

from collections.abc import Callable

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.values import ArrayValue, StructValue, array_of, null_frame


def bas(c: ControllerState, command: str, value: float) -> None:
    """Execute BAS(#command, value); raises `ExecutionError`."""
    function = _BAS.get(command)
    if function is None:
        raise ExecutionError("not-modelled", f"BAS(#{command}) is not modelled", f"modelled: {', '.join(_BAS)}")
    function(c, value)


def _set_axes(c: ControllerState, name: str, percent: float) -> None:
    """All six axes of `$VEL_AXIS` or `$ACC_AXIS` [%]."""
    c.variables[name].value = array_of("INT", [round(percent)] * 6)
    c.note_speed(name)


def _set_part(c: ControllerState, name: str, part: str, value: float) -> None:
    """A component of `$VEL`, `$ACC` or `$APO`."""
    whole = c.variables[name].value
    assert isinstance(whole, StructValue)
    whole.parts[part] = float(value)
    c.note_speed(name)


def _set_frame(c: ControllerState, name: str, table: str, number: float) -> None:
    """`$TOOL` or `$BASE` from TOOL_DATA or BASE_DATA; number 0 is the null frame."""
    if int(number) == 0:
        c.variables[name].value = null_frame()
        return
    variable = c.variable(table)
    data = variable.value if variable is not None else None
    frame = data.items.get((int(number),)) if isinstance(data, ArrayValue) else None
    if not isinstance(frame, StructValue):
        hint = f"assign {table}[{int(number)}], or lend it with --with '$config.dat'"
        raise ExecutionError("no-value", f"{table}[{int(number)}] has no value", hint)
    c.variables[name].value = StructValue("FRAME", dict(frame.parts))


def _act_part(c: ControllerState, name: str, part: str, default: float) -> float:
    """A number of PDAT_ACT, LDAT_ACT or FDAT_ACT."""
    variable = c.variable(name)
    whole = variable.value if variable is not None else None
    value = whole.parts.get(part) if isinstance(whole, StructValue) else None
    return float(value) if isinstance(value, int | float) else default


def _initmov(c: ControllerState, _: float) -> None:
    c.initialise()


def _frames(c: ControllerState, _: float = 0.0) -> None:
    _set_frame(c, "$TOOL", "TOOL_DATA", _act_part(c, "FDAT_ACT", "TOOL_NO", 0.0))
    _set_frame(c, "$BASE", "BASE_DATA", _act_part(c, "FDAT_ACT", "BASE_NO", 0.0))


def _ptp_params(c: ControllerState, value: float) -> None:
    _set_axes(c, "$VEL_AXIS", value)
    _set_axes(c, "$ACC_AXIS", _act_part(c, "PDAT_ACT", "ACC", 100.0))
    _set_part(c, "$APO", "CPTP", min(_act_part(c, "PDAT_ACT", "APO_DIST", 0.0), 100.0))
    _set_part(c, "$APO", "CDIS", _act_part(c, "PDAT_ACT", "APO_DIST", 0.0))
    _frames(c)


def _cp_params(c: ControllerState, value: float) -> None:
    _set_part(c, "$VEL", "CP", value)
    _set_part(c, "$ACC", "CP", c.machine.acc_cp * _act_part(c, "LDAT_ACT", "ACC", 100.0) / 100.0)
    _set_part(c, "$APO", "CDIS", _act_part(c, "LDAT_ACT", "APO_DIST", 0.0))
    _frames(c)


_BAS: dict[str, Callable[[ControllerState, float], None]] = {
    "INITMOV": _initmov,
    "VEL_PTP": lambda c, v: _set_axes(c, "$VEL_AXIS", v),
    "ACC_PTP": lambda c, v: _set_axes(c, "$ACC_AXIS", v),
    "VEL_CP": lambda c, v: _set_part(c, "$VEL", "CP", v),
    "ACC_CP": lambda c, v: _set_part(c, "$ACC", "CP", v),
    "TOOL": lambda c, v: _set_frame(c, "$TOOL", "TOOL_DATA", v),
    "BASE": lambda c, v: _set_frame(c, "$BASE", "BASE_DATA", v),
    "PTP_PARAMS": _ptp_params,
    "CP_PARAMS": _cp_params,
    "FRAMES": _frames,
    "PTP_DAT": lambda c, v: _ptp_params(c, _act_part(c, "PDAT_ACT", "VEL", 100.0)),
    "CP_DAT": lambda c, v: _cp_params(c, _act_part(c, "LDAT_ACT", "VEL", c.machine.vel_cp)),
    "EX_BASE": lambda c, v: None,
}
