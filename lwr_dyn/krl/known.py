"""What a controller knows without any declaration: system variables, functions, names of the standard `$config.dat`."""

from __future__ import annotations

from collections.abc import Mapping

from lwr_dyn.krl.types import BOOL, FRAME, INT, REAL, UNKNOWN, Type


def _all(kind: Type, names: str) -> dict[str, Type]:
    return dict.fromkeys(names.split(), kind)


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
"""Those whose type is used here; any other name that begins with $ is taken for a system variable of unknown type."""
CONFIG: Mapping[str, Type] = {
    **_all(Type("E6AXIS"), "XHOME XHOME1 XHOME2 XHOME3 XHOME4 XHOME5"),
    **_all(Type("FRAME", 1), "TOOL_DATA BASE_DATA"),
    "LOAD_DATA": Type("LOAD", 1),
    **_all(Type("FDAT"), "FDAT_ACT FHOME FHOME1 FHOME2"),
    **_all(Type("PDAT"), "PDAT_ACT PDEFAULT"),
    **_all(Type("LDAT"), "LDAT_ACT LDEFAULT"),
    **_all(UNKNOWN, "SUCCESS INUMVAR"),
}
"""Variables of the standard `$config.dat`, whatever it says of them."""
FUNCTIONS: Mapping[str, tuple[Type | None, int, int]] = {
    **dict.fromkeys(("SQRT", "SIN", "COS", "TAN", "ACOS"), (REAL, 1, 1)),
    "ABS": (REAL, 1, 1),
    "ATAN2": (REAL, 2, 2),
    "INV_POS": (FRAME, 1, 1),
    "FORWARD": (Type("E6POS"), 2, 2),
    "INVERSE": (Type("E6AXIS"), 3, 3),
    "SVEL": (INT, 1, 2),
    "SVEL_JOINT": (INT, 1, 1),
    "SVEL_CP": (REAL, 1, 3),
    "STOOL2": (FRAME, 1, 1),
    "SBASE": (FRAME, 1, 1),
    "STOOL": (FRAME, 1, 1),
    "SLOAD": (Type("LOAD"), 1, 1),
    "SAPO": (UNKNOWN, 1, 1),
    "SAPO_PTP": (REAL, 1, 1),
    "SIPO_MODE": (UNKNOWN, 1, 1),
    "PULSE": (None, 3, 3),
    "BAS": (None, 1, 2),
    "STRLEN": (INT, 1, 1),
    "STRDECLLEN": (INT, 1, 1),
    "STRCLEAR": (BOOL, 1, 1),
    "STRADD": (INT, 2, 2),
    "STRCOPY": (BOOL, 2, 2),
    "STRCOMP": (BOOL, 2, 3),
    "STRFIND": (INT, 3, 4),
    "VARSTATE": (UNKNOWN, 1, 1),
    "FRAND": (REAL, 0, 0),
    **dict.fromkeys(("SREAD", "SWRITE", "CREAD", "CWRITE", "COPEN", "CCLOSE", "CAST_TO", "CAST_FROM"), (None, 1, 99)),
    **dict.fromkeys(("IR_STOPM", "IR_STOPMESS", "USERSPOC", "RESUME", "LOCK", "UNLOCK", "WAIT_FOR"), (None, 0, 9)),
    **dict.fromkeys(("H50", "A10_INI", "ROB_STOP", "ROB_STOP_RELEASE", "DELAY", "CANCEL"), (None, 0, 9)),
}
"""Functions and subprograms that are always there: what they return (None: nothing), fewest and most arguments."""
