"""RobotCell files: what they give a program, what is listed as assumed, one clear line on a bad one."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, PaperError
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.cell import cell_of, new_cell_text, with_cell
from lwr_dyn.krl.running.program_run import ProgramError, check_program, run_program
from tests.krl.short_programs import HOME, cell, program_of, values_of

GIVEN = """
    inputs.3 = true
    inputs.others = false
    states."$MODE_OP" = "#T1"
    states."$ERR.NUMBER" = 7
    variables.PART = 4
    variables."P[2]" = "{X 1, Y 2}"
    tools.1 = [0, 0, 150, 0, 0, 0]
"""
STUBS = "stubs.EKI_GETREAL = { returns = true, out = { 3 = 12.5 } }\nstubs.MSG = {}"
OTHERS, OF_CELL = "stubs.others = true\n", "(stubs.others of the cell file)"
FALSE_INPUT = "$IN[4] = FALSE (inputs.others of the cell file)"
ERR = "INTERPRETER #R_INT, INT_TYPE #I_NORMAL, INT_PRIO 0, LINE_NR 0"
OUTER = ", ".join(f"E{i} 0.0" for i in range(1, 7))
VALUES = {
    "a state that nothing gives is assumed and listed once": (
        "", ["A = $T1 OR $T1", "N = $ERR.NUMBER"], {"A": False, "N": 0},
        ["$T1 = FALSE (state default)", f"$ERR = {{NUMBER 0, {ERR}}} (state default)"]),
    "an option that is not installed is off": (
        "", ["A = ARC20 OR (A10_OPTION == #ACTIVE)"], {"A": False},
        ["ARC20 = FALSE (option not installed)", "A10_OPTION = #DISABLED (option not installed)"]),
    "what the program sets itself is no assumption": ("", ["$FILTER = 5", "N = $FILTER"], {"N": 5}, []),
    "states, variables, tools, inputs": (
        GIVEN,
        ["A = $IN[3]", "B = $IN[4]", "M = $MODE_OP == #T1", "N = $ERR.NUMBER + PART", "X = P[2].Y", "BAS(#TOOL, 1)",
         "Z = $TOOL.Z"],
        {"A": True, "B": False, "M": True, "N": 11, "X": 2.0, "Z": 150.0}, ["$IN[3] = TRUE (given)", FALSE_INPUT]),
    "a stub returns and sets arguments": (
        STUBS, ["MSG(1, 2)", 'A = EKI_GETREAL("c", "p", X)'], {"A": True, "X": 12.5},
        ["MSG( ) = nothing (stub)", "EKI_GETREAL( ) = TRUE (stub)"]),
    "every other function can be an empty stub": (
        OTHERS + "stubs.EKI_X = { returns = false }", ["A = NOT EKI_X()", "N = SYNC() + 3"], {"A": True, "N": 3},
        ["EKI_X( ) = FALSE (stub)", f"SYNC( ) = 0 {OF_CELL}"]),
    "an empty stub of its type": (
        OTHERS, ["A = LAMP()", "X = FORCE() + 2.5"], {"A": False, "X": 2.5},
        [f"LAMP( ) = FALSE {OF_CELL}", f"FORCE( ) = 0.0 {OF_CELL}"]),
    "the home of the cell is that of programs": (
        "home_deg = [1, -91, 92, 2, 4, 5]", ["X = XHOME.A3"], {"X": 92.0},
        [f"XHOME = {{A1 1.0, A2 -91.0, A3 92.0, A4 2.0, A5 4.0, A6 5.0, {OUTER}}} (home of the cell file)"]),
    "what is given and not read is said": (
        "variables.OTHER = 3", ["N = 1"], {"N": 1}, ["OTHER: given, but nothing reads it"]),
    "a condition without a value never interrupts": (
        "", ["INTERRUPT DECL 5 WHEN $IN[3] DO $OUT[1]=TRUE", "INTERRUPT ON 5", HOME], {},
        ["$IN[3] = FALSE (the input $IN[3] has no value)"]),
}  # fmt: skip
DECLARED = ["DECL BOOL A, B, M", "DECL INT N", "DECL REAL X, Z", "EXTFCT BOOL LAMP( )", "EXTFCT REAL FORCE( )"]


@pytest.mark.parametrize(("text", "lines", "expected", "assumed"), VALUES.values(), ids=VALUES)
def test_what_a_cell_gives_and_what_is_assumed(arm, text, lines, expected, assumed):
    values, found = values_of(arm, lines, DECLARED, cell(text))
    assert {name: values[name] for name in expected} == expected
    assert [x for x in found if text is not GIVEN or x in assumed] == assumed


def test_the_checks_know_the_names_of_a_cell():
    given = cell('variables.PART = 4\nvariables."P[2]" = "{X 1}"\nvariables."Q[1,2]" = 0.5\nvariables.S = "a"\n'
                 'variables.F = "{FRAME: X 1}"\n'
                 'stubs.GRIP = {}\nstubs.READY = { returns = true }')  # fmt: skip
    lines = ("IF (PART > 3) AND READY() THEN", f"GRIP(1{', 2' * 39})", "$OUT[1] = P[2].X > PART", "ENDIF")
    program = program_of(*lines)
    assert {d.code for d in check_program(program)} == {"undeclared", "unknown-call"}
    assert check_program(with_cell(program, given)) == ()
    assert [d.code for d in check_program(with_cell(program_of(f"GRIP(1{', 2' * 40})"), given))] == ["arguments"]
    types = {name: str(x.type) for name, x in program.names.variables.items()}
    assert types == {"PART": "INT", "P": "?[]", "Q": "?[,]", "S": "?", "F": "FRAME"}
    externals = program.names.externals
    assert {name: externals[name].returns for name in ("GRIP", "READY")} == {"GRIP": None, "READY": "BOOL"}


def test_a_stub_stands_in_for_a_routine_and_the_cell_gives_the_arguments_of_the_one_that_is_run(arm):
    program = parse_program(f"DEF a( )\n{HOME}\nPTP {{A1 5}}\nb( )\nEND\nDEF b( )\nPTP {{A1 10}}\nEND\n", name="a")
    assert [len(run_program(program, arm, cell=x).executed) for x in (None, cell("stubs.B = {}"))] == [3, 2]
    program = parse_program(f"DEF a(JOB :IN)\nDECL INT JOB\n{HOME}\nPTP {{A1 JOB}}\nEND\n", name="a")
    with pytest.raises(ProgramError, match="JOB has no value"):
        run_program(program, arm)
    run = run_program(program, arm, cell=cell("arguments.JOB = 20"))
    assert run.executed[-1].q[0] == pytest.approx(np.radians(20))
    assert [str(x) for x in run.assumptions] == ["the argument JOB = 20 (given)"]
    with pytest.raises(OptionError, match=r"the cell's arguments\.JOB: TRUE; allowed: a number"):
        run_program(program, arm, cell=cell("arguments.JOB = true"))


def test_a_fault_the_run_does_not_come_to_does_not_stop_it(arm):
    """The result says that a controller would refuse the program."""
    program = program_of(HOME, "PTP {A1 5}", "IF $T1 THEN", "N = 3", "ENDIF")
    assert [d.code for d in run_program(program, arm).diagnostics if d.severity == "error"] == ["undeclared"]


BAD = {
    "robots = 3": "robots", "robot = 3": "robot", "inputs.3 = 1": "inputs.3", "inputs.three = true": "inputs.three",
    "inputs.0 = true": "inputs.0", "inputs.others = 1": "inputs.others", "states.T1 = true": "states.T1",
    'variables."$T1" = true': "variables.$T1", 'variables.A = "{X"': "variables.A", "variables.A = [1]": "variables.A",
    "tools.1 = [1, 2]": "tools.1", "tools.1 = [0, 0, nan, 0, 0, 0]": "tools.1", "stubs.F = 3": "stubs.F",
    "stubs.PTP = {}": "stubs.PTP", "stubs.ENDIF = {}": "stubs.ENDIF", 'stubs."A B" = {}': "stubs.A B",
    'stubs."F(1)" = {}': "stubs.F(1)", "stubs.F = { out = { x = 3 } }": "stubs.F.out.x",
    "unmet_wait_s = -1": "unmet_wait_s", 'submits = ["a.src"]': "submits",
    '[[reply]]\nwhen = "$OUT["\nset = {}': "reply[0].when", '[[reply]]\nwhen = "A"': "reply[0].set",
    "inputs.8193 = true": "inputs.8193", "unmet_wait_s = 1.1e6": "unmet_wait_s",
    "bases.1 = [0, 0, 1.1e9, 0, 0, 0]": "bases.1", '[[reply]]\nafter_s = 1.1e6\nset = {}': "reply[0].after_s",
    'home_deg = "x"': "home_deg", "home_deg = [0, 0]": "home_deg", "called_at_deg = 3": "called_at_deg",
    "ignore_turn = 1": "ignore_turn", "variables.WHEN = 3": "variables.WHEN", 'states."$T1" = 3': "states.$T1",
    '[[reply]]\nset = { "$IN[1]" = 5 }': "reply[0].set.$IN[1]",
}  # fmt: skip


@pytest.mark.parametrize(("text", "named"), BAD.items())
def test_a_bad_file_is_one_line_that_names_the_field(text, named):
    with pytest.raises(PaperError) as fault:
        cell(text)
    assert f"{named}: " in str(fault.value)
    assert "\n" not in str(fault.value)


def test_what_is_within_its_bounds_is_read_and_paths_are_relative_to_the_file():
    table = {"robot": "arms/a.urdf", "submits": ["b.SUB"], "inputs": {"8192": True}, "unmet_wait_s": 1e6,
             "tools": {"1": [1e9, 0, 0, 0, 0, 0]}}  # fmt: skip
    found = cell_of(table, "there/cell.toml")
    assert (found.robot, found.submits) == ("there/arms/a.urdf", ("there/b.SUB",))
    assert (found.values["$IN[8192]"], found.values["TOOL_DATA[1]"].parts["X"], found.unmet_wait) == (True, 1e9, 1e6)
    assert cell_of({"robot": "kr30ha"}, "there/cell.toml").robot == "kr30ha"


def test_a_value_of_the_wrong_type_is_refused(arm):
    with pytest.raises(OptionError, match="N"):
        values_of(arm, [], ["DECL BOOL N"], cell("variables.N = 3"))


def test_a_routine_that_is_called_begins_where_the_arm_stands(arm):
    program = program_of("$VEL.CP = 0.2", "LIN_REL {Y 40}")
    with pytest.raises(ProgramError, match="begin with a full PTP"):
        run_program(program, arm)
    run = run_program(program, arm, cell=cell("called_at_deg = [10, -90, 90, 0, 30, 0]"))
    assert [x.kind for x in run.executed] == ["LIN_REL"]
    np.testing.assert_allclose(run.motion.q[0], np.radians([10, -90, 90, 0, 30, 0]), atol=1e-12)
    assert "the routine is called = with the axes at 10, -90, 90, 0, 30, 0 deg (called_at_deg of the cell)" in [
        str(x) for x in run.assumptions
    ]


def test_a_turn_can_be_ignored_and_then_the_nearest_solution_is_taken(arm):
    program = program_of(HOME, "PTP {X 1100, Y 200, Z 1300, A 0, B 90, C 0, S 2, T 61}")
    with pytest.raises(ProgramError, match="T 61"):
        run_program(program, arm)
    run = run_program(program, arm, cell=cell("ignore_turn = true"))
    assert np.abs(np.diff([x.q for x in run.executed], axis=0)).max() < np.pi
    assert run.poses()[1].y_mm == pytest.approx(200)
    assert any("ignore_turn" in str(x) for x in run.assumptions)


def test_the_template_can_be_read_as_it_stands_and_with_every_line_filled_in():
    text = new_cell_text("cell.toml")
    assert cell(text).robot == "kr30ha"
    filled = "\n".join(line.removeprefix("# ") if "=" in line or "[[" in line else line for line in text.splitlines())
    whole = cell(filled)
    assert whole.values["TOOL_DATA[1]"].parts["Z"] == 150
    assert (whole.replies[0].after, whole.stubs["EKI_GETREAL"].out) == (0.4, {3: 12.5})


def test_the_commands_take_a_cell_and_list_what_is_assumed(printed, recorded, refused, folder):
    text = f"DEF a( )\nIF $IN[3] AND NOT $T1 THEN\n{HOME}\nPTP {{A1 5}}\nENDIF\nEND\n"
    (folder / "a.src").write_text(text)
    printed("new", "cell", "cell.toml")
    (folder / "cell.toml").write_text((folder / "cell.toml").read_text().replace("# 3 = true", "3 = true"))
    names = {x["name"]: x for x in recorded("krl", "run", "a.src", "--cell", "cell.toml")["assumptions"]}
    assert names["$T1"] == {"name": "$T1", "value": "FALSE", "why": "state default"}
    assert names["$IN[3]"]["why"] == "given"
    printed("krl", "check", "a.src", "--cell", "cell.toml")
    assert "$IN[3]" in refused("krl", "run", "a.src")


def test_the_override_outlives_the_initialisation_and_speeds_of_axes_that_are_set_whole_are_refused(
    recorded, refused, folder
):
    def write(*lines):
        (folder / "a.src").write_text("\n".join(["DEF a( )", "BAS(#INITMOV, 0)", *lines, "PTP_REL {A1 70}", "END", ""]))

    write("BAS(#VEL_PTP, 100)", HOME)
    whole, half = (recorded("krl", "run", "a.src", "--set", f"$OV_PRO={x}") for x in (100, 50))
    assert whole["cycle_time"] == pytest.approx(70 / 140 + 0.4)
    assert half["cycle_time"] == pytest.approx(70 / 70 + 0.2)
    assert [a["value"] for a in half["assumptions"] if a["name"] == "$OV_PRO"] == ["50"]
    for line in ("$VEL_AXIS = 50", "$ACC_AXIS = {A1 5}"):  # found by fuzzing
        write(line, HOME)
        assert f"a.src:5:1: {line.split()[0]}[1] has no value; more than 0" in refused("krl", "run", "a.src")
