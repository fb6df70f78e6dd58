"""BAS: what each command of the inline forms sets, and what it leaves; what stands after WITH holds for one motion."""

import math

import pytest

from lwr_dyn.krl.running.program_run import run_program
from tests.krl.short_programs import HOME, program_of, run_of, values_of

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


def seconds(run):
    return [x.end - x.begin for x in run.executed[1:]]


def test_with_holds_for_its_motion_alone(arm):
    run = run_of(arm, HOME, "SLIN_REL {Y 100} WITH $VEL.CP = 0.1", "LIN_REL {Y -100}", "LIN_REL {Y 100}")
    slow, plain, again = seconds(run)
    assert slow == pytest.approx(0.1 / 0.1 + 0.1 / 2.3, abs=1e-9)
    assert [plain, again] == pytest.approx([0.1 / 0.2 + 0.2 / 2.3] * 2, abs=1e-9)


def test_a_blend_distance_after_with_is_that_of_its_motion(arm):
    lines = ("SLIN_REL {Y 100} WITH $APO.CDIS = 20 C_SPL", "SLIN_REL {Z 50} C_SPL", "SLIN_REL {Y 50}")
    run = run_of(arm, HOME, *lines)
    assert [x.overlap > 0.0 for x in run.executed[1:]] == [False, True, False]


def test_the_speed_of_axis_1_counts_for_all_axes_and_is_taken_back(arm):
    run = run_of(arm, HOME, "SPTP_REL {A6 90} WITH $VEL_AXIS[1] = 50", "PTP_REL {A6 -90}", "PTP_REL {A1 20, A6 90}")
    half, full, _ = seconds(run)
    rated = math.degrees(arm.velocity[5])
    assert half == pytest.approx(90 / (0.5 * rated) + 0.2, abs=1e-6)
    assert full == pytest.approx(2 * math.sqrt(90 * 0.4 / rated), abs=1e-6)


def test_with_of_one_motion_is_no_speed_for_the_next(arm):
    run = run_program(program_of(HOME, "SLIN_REL {Y 50} WITH $VEL.CP = 0.1", "LIN_REL {Y 50}"), arm)
    warned = [(d.position.line, d.code) for d in run.diagnostics if "before the first LIN" in d.message]
    assert warned == [(4, "no-velocity")]


def test_initmov_sets_a_velocity_and_an_unset_path_speed_is_assumed(arm):
    run = run_program(program_of("BAS(#INITMOV, 0)", HOME, "LIN_REL {Y 50}"), arm)
    assert [d.code for d in run.diagnostics] == []
    assert [str(x) for x in run.assumptions if "INITMOV" in x.name] == [
        "$VEL.CP after BAS(#INITMOV, 0) = 2 m/s (no velocity is set after it)"
    ]
    given = run_program(program_of("BAS(#INITMOV, 0)", "$VEL.CP = 0.2", HOME, "LIN_REL {Y 50}"), arm)
    assert [x.name for x in given.assumptions if "INITMOV" in x.name] == []
