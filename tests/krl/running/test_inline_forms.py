"""BAS: what each command of the inline forms sets, and what it leaves; what stands after WITH holds for one motion."""

import math

import pytest

from lwr_dyn.krl.running.program_run import run_program
from tests.krl.short_programs import HOME, program_of, run_of, values_of

ACT = [
    "TOOL_DATA[1] = {X 1.0,Y 0,Z 0,A 0,B 0,C 0}", "BASE_DATA[2] = {X 2.0,Y 0,Z 0,A 0,B 0,C 0}", "$TOOL = $NULLFRAME",
    "$BASE = $NULLFRAME", "$VEL_AXIS[3] = 11", "$ACC_AXIS[3] = 12", "$APO.CPTP = 13", "$VEL.CP = 0.14", "$ACC.CP = 1.5",
    "$APO.CDIS = 16", "FDAT_ACT = {TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}",
    "PDAT_ACT = {VEL 30.0,ACC 40.0,APO_DIST %s}", "LDAT_ACT = {VEL 0.6,ACC 70.0,APO_DIST 80.0}",
]  # fmt: skip
NAMES = {"T": "$TOOL.X", "F": "$BASE.X", "V": "$VEL_AXIS[3]", "A": "$ACC_AXIS[3]", "P": "$APO.CPTP", "S": "$VEL.CP",
         "R": "$ACC.CP", "D": "$APO.CDIS"}  # fmt: skip
BEFORE = {"T": 0.0, "F": 0.0, "V": 11.0, "A": 12.0, "P": 13.0, "S": 0.14, "R": 1.5, "D": 16.0}
FRAMES = {"T": 1.0, "F": 2.0}
OF_PTP, OF_CP = {"V": 30.0, "A": 40.0, "P": 50.0, "D": 50.0}, {"S": 0.6, "R": 0.7 * 2.3, "D": 80.0}


@pytest.mark.parametrize(
    ("command", "distance", "changed"),
    [
        ("BAS(#PTP_DAT)", "50.0", OF_PTP),
        ("BAS(#PTP_DAT)", "150.0", OF_PTP | {"P": 100.0, "D": 150.0}),
        ("BAS(#CP_DAT)", "50.0", OF_CP),
        ("BAS(#FRAMES)", "50.0", FRAMES),
        ("BAS(#PTP_PARAMS, 20)", "50.0", FRAMES | OF_PTP | {"V": 20.0}),
        ("BAS(#CP_PARAMS, 0.3)", "50.0", FRAMES | OF_CP | {"S": 0.3}),
        ("BAS(#VEL_PTP, 20)", "50.0", {"V": 20.0}),
        ("BAS(#ACC_PTP, 21)", "50.0", {"A": 21.0}),
        ("BAS(#VEL_CP, 0.2)", "50.0", {"S": 0.2}),
        ("BAS(#ACC_CP, 0.7)", "50.0", {"R": 0.7}),
        ("BAS(#TOOL, 1)", "50.0", {"T": 1.0}),
        ("BAS(#BASE, 2)", "50.0", {"F": 2.0}),
        ("BAS(#EX_BASE, 1)", "50.0", {}),
        ("BAS(#INITMOV, 0)", "50.0", {**dict.fromkeys("VA", 100.0), **dict.fromkeys("PD", 0.0), "S": 2.0, "R": 2.3}),
    ],
)
def test_a_command_sets_its_part_only(arm, command, distance, changed):
    lines = ["BAS(#INITMOV, 0)", *(x.replace("%s", distance) for x in ACT), command]
    values, _ = values_of(arm, [*lines, *(f"{x} = {of}" for x, of in NAMES.items())], [f"DECL REAL {', '.join(NAMES)}"])
    assert {x: values[x] for x in NAMES} == pytest.approx(BEFORE | changed)


@pytest.mark.parametrize(
    ("data", "command", "changed"),
    [
        ("DECL PDAT PDAT_ACT={VEL 30.0}", "BAS(#PTP_DAT)", {"V": 30.0, "A": 100.0, "P": 0.0, "D": 0.0}),
        ("DECL PDAT PDAT_ACT={ACC 40.0}", "BAS(#PTP_DAT)", {"V": 100.0, "A": 40.0, "P": 0.0, "D": 0.0}),
        ("DECL LDAT LDAT_ACT={APO_DIST 7.0}", "BAS(#CP_DAT)", {"S": 2.0, "R": 2.3, "D": 7.0}),
        ("DECL LDAT LDAT_ACT={VEL 0.6}", "BAS(#CP_DAT)", {"S": 0.6, "R": 2.3, "D": 0.0}),
        ("DECL FDAT FDAT_ACT={IPO_FRAME #BASE}", "BAS(#FRAMES)", {"T": 0.0, "F": 0.0}),
    ],
)
def test_what_the_data_of_a_motion_leave_out_is_full_speed_without_a_blend_or_a_frame(arm, data, command, changed):
    lines = [*(x for x in ACT if "_ACT" not in x), "BAS(#TOOL, 1)", "BAS(#BASE, 2)", command]
    names = f"DECL REAL {', '.join(NAMES)}"
    values, _ = values_of(arm, [*lines, *(f"{x} = {of}" for x, of in NAMES.items())], [names, data])
    assert {x: values[x] for x in NAMES} == pytest.approx(BEFORE | FRAMES | changed)


def seconds(arm, *lines):
    return [x.end - x.begin for x in run_of(arm, HOME, *lines).executed[1:]]


def test_with_holds_for_its_motion_alone(arm):
    slow, *plain = seconds(arm, "SLIN_REL {Y 100} WITH $VEL.CP = 0.1", "LIN_REL {Y -100}", "LIN_REL {Y 100}")
    assert slow == pytest.approx(0.1 / 0.1 + 0.1 / 2.3, abs=1e-9)
    assert plain == pytest.approx([0.1 / 0.2 + 0.2 / 2.3] * 2, abs=1e-9)
    # that of axis 1 counts for all axes
    half, full, _ = seconds(arm, "SPTP_REL {A6 90} WITH $VEL_AXIS[1] = 50", "PTP_REL {A6 -90}", "PTP_REL {A1 20}")
    rated = math.degrees(arm.velocity[5])
    assert half == pytest.approx(90 / (0.5 * rated) + 0.2, abs=1e-6)
    assert full == pytest.approx(2 * math.sqrt(90 * 0.4 / rated), abs=1e-6)
    lines = ("SLIN_REL {Y 100} WITH $APO.CDIS = 20 C_SPL", "SLIN_REL {Z 50} C_SPL", "SLIN_REL {Y 50}")
    assert [x.overlap > 0.0 for x in run_of(arm, HOME, *lines).executed[1:]] == [False, True, False]


def test_with_of_one_motion_is_no_speed_for_the_next_and_an_unset_speed_after_initmov_is_assumed(arm):
    run = run_program(program_of(HOME, "SLIN_REL {Y 50} WITH $VEL.CP = 0.1", "LIN_REL {Y 50}"), arm)
    warned = [(d.position.line, d.code) for d in run.diagnostics if "before the first LIN" in d.message]
    assert warned == [(4, "no-velocity")]
    for speed, assumed in (
        ((), ["$VEL.CP after BAS(#INITMOV, 0) = 2 m/s (no velocity is set after it)"]),
        (("$VEL.CP = 0.2",), []),
    ):
        run = run_program(program_of("BAS(#INITMOV, 0)", *speed, HOME, "LIN_REL {Y 50}"), arm)
        assert (run.diagnostics, [str(x) for x in run.assumptions if "INITMOV" in x.name]) == ((), assumed)
