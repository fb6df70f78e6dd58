"""Names that need no declaration: system variables, variables of the standard `$config.dat`, functions."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from lwr_dyn.krl.names.types import BOOL, FRAME, INT, REAL, UNKNOWN, Type

T = TypeVar("T")


def _all(value: T, names: str) -> dict[str, T]:
    return dict.fromkeys(names.split(), value)


SYSTEM: Mapping[str, Type] = {
    **_all(FRAME, "$BASE $TOOL $NULLFRAME $WORLD $ROBROOT $FLANGE"),
    **_all(Type("E6POS"), "$POS_ACT $POS_INT $POS_FOR $POS_RET $POS_ACT_MES"),
    **_all(Type("E6AXIS"), "$AXIS_ACT $AXIS_INT $AXIS_FOR $AXIS_RET $AXIS_ACT_MES $H_POS"),
    **_all(Type("CP"), "$VEL $ACC $VEL_ACT_MA $ACC_ACT_MA"),
    **_all(Type("INT", 1), "$VEL_AXIS $ACC_AXIS $TIMER"),
    **_all(Type("BOOL", 1), "$IN $OUT $FLAG $CYCFLAG $TIMER_STOP $TIMER_FLAG"),
    **_all(Type("REAL", 1), "$ANIN $ANOUT $SOFTN_END $SOFTP_END"),
    **_all(INT, "$ADVANCE $OV_PRO $OV_ROB $INTERRUPT $ACT_TOOL $ACT_BASE $DIGIN1 $DIGIN2 $DIGIN3"),
    **_all(BOOL, "$TRUE $FALSE $STOPMESS $PERI_RDY $ALARM_STOP $USER_SAF $IN_HOME $CYCFLAG1 $POWER_FAIL $DRIVES_ON"),
    **_all(REAL, "$VEL_ACT $DISTANCE $PATHTIME"),
    "$APO": Type("APO_T"),
    "$LOAD": Type("LOAD"),
    "$IPO_MODE": Type("IPO_MODE"),
    "$ORI_TYPE": Type("ORI_TYPE"),
    "$CIRC_TYPE": Type("CIRC_TYPE"),
}
"""System variables whose type is known here; any other name that begins with $ is one of unknown type."""
CONFIG: Mapping[str, Type] = {
    **_all(Type("E6AXIS"), "XHOME XHOME1 XHOME2 XHOME3 XHOME4 XHOME5"),
    **_all(Type("FRAME", 1), "TOOL_DATA BASE_DATA"),
    "LOAD_DATA": Type("LOAD", 1),
    **_all(Type("FDAT"), "FDAT_ACT FHOME FHOME1 FHOME2"),
    **_all(Type("PDAT"), "PDAT_ACT PDEFAULT"),
    **_all(Type("LDAT"), "LDAT_ACT LDEFAULT"),
    **_all(UNKNOWN, "SUCCESS INUMVAR"),
}
"""Variables of the standard `$config.dat`."""


@dataclass(frozen=True, slots=True)
class Function:
    """A function or subprogram of every controller; `compute` is its value for numbers, angles in degrees."""

    returns: Type | None
    """None for a subprogram without a value."""
    least: int
    """Fewest arguments."""
    most: int
    """Most arguments."""
    compute: Callable[..., float] | None = None
    """None for a function of other values, or one that is not modelled."""


FUNCTIONS: Mapping[str, Function] = {
    "SQRT": Function(REAL, 1, 1, math.sqrt),
    "SIN": Function(REAL, 1, 1, lambda x: math.sin(math.radians(x))),
    "COS": Function(REAL, 1, 1, lambda x: math.cos(math.radians(x))),
    "TAN": Function(REAL, 1, 1, lambda x: math.tan(math.radians(x))),
    "ACOS": Function(REAL, 1, 1, lambda x: math.degrees(math.acos(x))),
    "ATAN2": Function(REAL, 2, 2, lambda y, x: math.degrees(math.atan2(y, x))),
    "ABS": Function(REAL, 1, 1),
    "INV_POS": Function(FRAME, 1, 1),
    "FORWARD": Function(Type("E6POS"), 2, 2),
    "INVERSE": Function(Type("E6AXIS"), 3, 3),
    "SVEL": Function(INT, 1, 2),
    "SVEL_JOINT": Function(INT, 1, 1),
    "SVEL_CP": Function(REAL, 1, 3),
    "STOOL2": Function(FRAME, 1, 1),
    "SBASE": Function(FRAME, 1, 1),
    "STOOL": Function(FRAME, 1, 1),
    "SLOAD": Function(Type("LOAD"), 1, 1),
    "SAPO": Function(UNKNOWN, 1, 1),
    "SAPO_PTP": Function(REAL, 1, 1),
    "SIPO_MODE": Function(UNKNOWN, 1, 1),
    "PULSE": Function(None, 3, 3),
    "BAS": Function(None, 1, 2),
    "STRLEN": Function(INT, 1, 1),
    "STRDECLLEN": Function(INT, 1, 1),
    "STRCLEAR": Function(BOOL, 1, 1),
    "STRADD": Function(INT, 2, 2),
    "STRCOPY": Function(BOOL, 2, 2),
    "STRCOMP": Function(BOOL, 2, 3),
    "STRFIND": Function(INT, 3, 4),
    "VARSTATE": Function(UNKNOWN, 1, 1),
    "FRAND": Function(REAL, 0, 0),
    **_all(Function(None, 1, 99), "SREAD SWRITE CREAD CWRITE COPEN CCLOSE CAST_TO CAST_FROM"),
    **_all(Function(None, 0, 9), "IR_STOPM IR_STOPMESS USERSPOC RESUME LOCK UNLOCK WAIT_FOR"),
    **_all(Function(None, 0, 9), "H50 A10_INI ROB_STOP ROB_STOP_RELEASE DELAY CANCEL"),
}
"""The functions and subprograms of every controller, by name in capitals."""
