"""Values of variables that the controller has before a program sets them: home, machine data, states, standard data."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np

from lwr_dyn.arms.papers.fields import parse_toml
from lwr_dyn.krl.running.constants import constant_value
from lwr_dyn.krl.running.values import ArrayValue, EnumValue, StructValue, Value, array_of, axes_value, copied

if TYPE_CHECKING:
    from lwr_dyn.krl.running.controller import ControllerState

FROM = {"controller": "state default", "option": "option not installed"}
"""Where the values of a table of `states.toml` come from, in the list of assumptions."""


@lru_cache(maxsize=1)
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
        return axes_value(c.home()), "home of the cell file" if c.cell.home_deg else "mastering of the robot's data"
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
    return (None, "") if state is None else (copied(state[0]), state[1])


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
        cp, ori = (data.vel_cp, data.vel_ori) if key == "$VEL_MA" else (data.acc_cp, data.acc_ori)
        return StructValue("CP", {"CP": cp, "ORI1": ori, "ORI2": ori})
    if key in ("$SOFTN_END", "$SOFTP_END"):
        return array_of("REAL", map(float, np.degrees(arm.lower if key == "$SOFTN_END" else arm.upper)))
    if key in ("$VEL_ACT_MA", "$ACC_ACT_MA"):
        return 110 if key == "$VEL_ACT_MA" else 250
    return arm.name if key in ("$TRAFONAME", "$MODEL_NAME", "$ROBNAME") else None
