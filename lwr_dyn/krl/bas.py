"""BAS, the subprogram that sets speeds, blends, tool and base from numbers and from PDAT_ACT, LDAT_ACT, FDAT_ACT."""

from __future__ import annotations

from collections.abc import Callable

from lwr_dyn.krl.controller import Controller
from lwr_dyn.krl.values import HaltError, Many, Struct, filled, null_frame


def bas(c: Controller, command: str, value: float) -> None:
    """BAS(#command, value); raises `HaltError` for a value it cannot take."""
    act = _BAS.get(command)
    if act is None:
        raise HaltError("not-modelled", f"BAS(#{command}) is not modelled", f"modelled: {', '.join(_BAS)}")
    act(c, value)


def _set_axes(c: Controller, name: str, percent: float) -> None:
    """All six axes of `$VEL_AXIS` or `$ACC_AXIS` [%]."""
    c.slots[name].value = filled("INT", [round(percent)] * 6)
    c.written(name)


def _set_part(c: Controller, name: str, part: str, value: float) -> None:
    """A component of `$VEL`, `$ACC` or `$APO`."""
    whole = c.slots[name].value
    assert isinstance(whole, Struct)
    whole.parts[part] = float(value)
    c.written(name)


def _set_frame(c: Controller, name: str, table: str, number: float) -> None:
    """`$TOOL` or `$BASE` from TOOL_DATA or BASE_DATA; number 0 is the null frame."""
    if int(number) == 0:
        c.slots[name].value = null_frame()
        return
    slot = c.slot(table)
    data = slot.value if slot is not None else None
    frame = data.items.get((int(number),)) if isinstance(data, Many) else None
    if not isinstance(frame, Struct):
        hint = f"assign {table}[{int(number)}], or lend it with --with '$config.dat'"
        raise HaltError("no-value", f"{table}[{int(number)}] has no value", hint)
    c.slots[name].value = Struct("FRAME", dict(frame.parts))


def _act_part(c: Controller, name: str, part: str, default: float) -> float:
    """A number of PDAT_ACT, LDAT_ACT or FDAT_ACT."""
    slot = c.slot(name)
    whole = slot.value if slot is not None else None
    value = whole.parts.get(part) if isinstance(whole, Struct) else None
    return float(value) if isinstance(value, int | float) else default


def _initmov(c: Controller, _: float) -> None:
    c.initialise()


def _frames(c: Controller, _: float = 0.0) -> None:
    _set_frame(c, "$TOOL", "TOOL_DATA", _act_part(c, "FDAT_ACT", "TOOL_NO", 0.0))
    _set_frame(c, "$BASE", "BASE_DATA", _act_part(c, "FDAT_ACT", "BASE_NO", 0.0))


def _ptp_params(c: Controller, value: float) -> None:
    _set_axes(c, "$VEL_AXIS", value)
    _set_axes(c, "$ACC_AXIS", _act_part(c, "PDAT_ACT", "ACC", 100.0))
    _set_part(c, "$APO", "CPTP", min(_act_part(c, "PDAT_ACT", "APO_DIST", 0.0), 100.0))
    _set_part(c, "$APO", "CDIS", _act_part(c, "PDAT_ACT", "APO_DIST", 0.0))
    _frames(c)


def _cp_params(c: Controller, value: float) -> None:
    _set_part(c, "$VEL", "CP", value)
    _set_part(c, "$ACC", "CP", c.settings.acc_cp * _act_part(c, "LDAT_ACT", "ACC", 100.0) / 100.0)
    _set_part(c, "$APO", "CDIS", _act_part(c, "LDAT_ACT", "APO_DIST", 0.0))
    _frames(c)


_BAS: dict[str, Callable[[Controller, float], None]] = {
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
    "CP_DAT": lambda c, v: _cp_params(c, _act_part(c, "LDAT_ACT", "VEL", c.settings.vel_cp)),
    "EX_BASE": lambda c, v: None,
}
