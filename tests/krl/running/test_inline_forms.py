"""BAS: what each command of the inline forms sets, and what it leaves."""

import pytest

from tests.krl.short_programs import values_of

ACT = [
    "TOOL_DATA[1] = {X 1.0,Y 0,Z 0,A 0,B 0,C 0}",
    "BASE_DATA[2] = {X 2.0,Y 0,Z 0,A 0,B 0,C 0}",
    "$TOOL = $NULLFRAME",
    "$BASE = $NULLFRAME",
    "FDAT_ACT = {TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}",
    "PDAT_ACT = {VEL 30.0,ACC 40.0,APO_DIST 50.0}",
    "LDAT_ACT = {VEL 0.6,ACC 70.0,APO_DIST 80.0}",
]
SEEN = ["T = $TOOL.X", "F = $BASE.X", "V = $VEL_AXIS[3]", "P = $APO.CPTP", "S = $VEL.CP", "D = $APO.CDIS"]


@pytest.mark.parametrize(
    ("command", "frames", "others"),
    [
        ("BAS(#PTP_DAT)", (0.0, 0.0), {"V": 30.0, "P": 50.0}),
        ("BAS(#CP_DAT)", (0.0, 0.0), {"S": 0.6, "D": 80.0}),
        ("BAS(#FRAMES)", (1.0, 2.0), {}),
        ("BAS(#PTP_PARAMS, 20)", (1.0, 2.0), {"V": 20.0, "P": 50.0}),
        ("BAS(#CP_PARAMS, 0.3)", (1.0, 2.0), {"S": 0.3, "D": 80.0}),
    ],
)
def test_a_command_sets_its_part_only(arm, command, frames, others):
    lines = ["BAS(#INITMOV, 0)", *ACT, command, *SEEN]
    values, _ = values_of(arm, lines, ["DECL REAL T, F, V, P, S, D"])
    assert (values["T"], values["F"]) == frames
    assert {name: values[name] for name in others} == others
