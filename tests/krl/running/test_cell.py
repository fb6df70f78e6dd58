"""RobotCell files: what they give a program, what is listed as assumed, one clear line on a bad one."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, PaperError
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.cell import new_cell_text, with_cell
from lwr_dyn.krl.running.program_run import ProgramError, check_program, run_program
from tests.krl.short_programs import HOME, cell, program_of, values_of


def test_a_state_that_nothing_gives_is_assumed_and_listed_once(arm):
    values, assumed = values_of(arm, ["A = $T1 OR $T1", "N = $ERR.NUMBER"], ["DECL BOOL A", "DECL INT N"])
    assert (values["A"], values["N"]) == (False, 0)
    assert [x for x in assumed if x.startswith("$T1")] == ["$T1 = FALSE (state default)"]


def test_an_option_that_is_not_installed_is_off(arm):
    values, assumed = values_of(arm, ["A = ARC20 OR (A10_OPTION == #ACTIVE)"], ["DECL BOOL A"])
    assert values["A"] is False
    assert assumed == ["ARC20 = FALSE (option not installed)", "A10_OPTION = #DISABLED (option not installed)"]


def test_what_the_program_sets_itself_is_no_assumption(arm):
    _, assumed = values_of(arm, ["$FILTER = 5", "N = $FILTER"], ["DECL INT N"])
    assert not assumed


def test_a_cell_gives_states_variables_tools_inputs(arm):
    given = cell("""
        inputs.3 = true
        inputs.others = false
        states."$MODE_OP" = "#T1"
        states."$ERR.NUMBER" = 7
        variables.PART = 4
        variables."P[2]" = "{X 1, Y 2}"
        tools.1 = [0, 0, 150, 0, 0, 0]
    """)
    lines = [
        "A = $IN[3]", "B = $IN[4]", "M = $MODE_OP == #T1", "N = $ERR.NUMBER + PART", "X = P[2].Y", "BAS(#TOOL, 1)",
        "Z = $TOOL.Z",
    ]  # fmt: skip
    values, assumed = values_of(arm, lines, ["DECL BOOL A, B, M", "DECL INT N", "DECL REAL X, Z"], given)
    assert values == {"A": True, "B": False, "M": True, "N": 11, "X": 2.0, "Z": 150.0}
    assert "$IN[3] = TRUE (given)" in assumed
    assert "$IN[4] = FALSE (inputs.others of the cell file)" in assumed


def test_a_stub_returns_and_sets_arguments(arm):
    given = cell("stubs.EKI_GETREAL = { returns = true, out = { 3 = 12.5 } }\nstubs.MSG = {}")
    lines = ["MSG(1, 2)", 'Y = EKI_GETREAL("c", "p", X)']
    values, assumed = values_of(arm, lines, ["DECL BOOL Y", "DECL REAL X"], given)
    assert values == {"Y": True, "X": 12.5}
    assert assumed == ["MSG( ) = nothing (stub)", "EKI_GETREAL( ) = TRUE (stub)"]


def test_the_checks_know_the_names_of_a_cell():
    given = cell('variables.PART = 4\nvariables."P[2]" = "{X 1}"\nstubs.GRIP = {}\nstubs.READY = { returns = true }')
    program = program_of("IF (PART > 3) AND READY() THEN", "GRIP(1)", "$OUT[1] = P[2].X > PART", "ENDIF")
    assert {d.code for d in check_program(program)} == {"undeclared", "unknown-call"}
    assert check_program(with_cell(program, given)) == ()


def test_a_stub_stands_in_for_a_routine_that_is_there(arm):
    source = f"DEF a( )\n{HOME}\nPTP {{A1 5}}\nb( )\nEND\nDEF b( )\nPTP {{A1 10}}\nEND\n"
    program = parse_program(source, name="a")
    assert len(run_program(program, arm).executed) == 3
    assert len(run_program(program, arm, cell=cell("stubs.B = {}")).executed) == 2


def test_every_other_function_can_be_an_empty_stub(arm):
    values, assumed = values_of(arm, ["Y = NOT EKI_X()", "N = SYNC() + 3"], ["DECL BOOL Y", "DECL INT N"],
                                cell("stubs.others = true\nstubs.EKI_X = { returns = false }"))  # fmt: skip
    assert values == {"Y": True, "N": 3}
    assert "SYNC( ) = 0 (stubs.others of the cell file)" in assumed
    declared = ["EXTFCT BOOL LAMP( )", "EXTFCT REAL FORCE( )", "DECL BOOL Y", "DECL REAL F"]
    values, assumed = values_of(arm, ["Y = LAMP()", "F = FORCE() + 2.5"], declared, cell("stubs.others = true"))
    assert values == {"Y": False, "F": 2.5}
    assert {"LAMP( ) = FALSE (stubs.others of the cell file)", "FORCE( ) = 0.0 (stubs.others of the cell file)"} <= {
        *assumed
    }


def test_the_cell_gives_the_arguments_of_the_routine_that_is_run(arm):
    program = parse_program(f"DEF a(JOB :IN)\nDECL INT JOB\n{HOME}\nPTP {{A1 JOB}}\nEND\n", name="a")
    with pytest.raises(ProgramError, match="JOB has no value"):
        run_program(program, arm)
    run = run_program(program, arm, cell=cell("arguments.JOB = 20"))
    assert run.executed[-1].q[0] == pytest.approx(np.radians(20))
    assert [str(x) for x in run.assumptions] == ["the argument JOB = 20 (given)"]


def test_a_fault_the_run_does_not_come_to_does_not_stop_it(arm):
    """The result says that a controller would refuse the program."""
    program = parse_program(f"DEF a( )\n{HOME}\nPTP {{A1 5}}\nIF $T1 THEN\nN = 3\nENDIF\nEND\n", name="a")
    assert [d.code for d in run_program(program, arm).diagnostics if d.severity == "error"] == ["undeclared"]


def test_a_condition_that_has_no_value_never_interrupts(arm):
    lines = ["INTERRUPT DECL 5 WHEN $IN[3] DO $OUT[1]=TRUE", "INTERRUPT ON 5", HOME]
    _, assumed = values_of(arm, lines)
    assert assumed == ["$IN[3] = FALSE (the input $IN[3] has no value)"]


def test_a_value_of_the_wrong_type_is_refused(arm):
    with pytest.raises(OptionError, match="N"):
        values_of(arm, [], ["DECL BOOL N"], cell("variables.N = 3"))


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("robots = 3", "robots"),
        ("robot = 3", "robot"),
        ("inputs.3 = 1", "inputs.3"),
        ("inputs.three = true", "inputs.three"),
        ("inputs.0 = true", "inputs.0"),
        ("inputs.others = 1", "inputs.others"),
        ("states.T1 = true", "states.T1"),
        ('variables."$T1" = true', r"variables.\$T1"),
        ('variables.A = "{X"', "variables.A"),
        ("variables.A = [1]", "variables.A"),
        ("tools.1 = [1, 2]", "tools.1"),
        ("tools.1 = [0, 0, nan, 0, 0, 0]", "tools.1"),
        ("stubs.F = 3", "stubs.F"),
        ("stubs.PTP = {}", "stubs.PTP"),
        ("stubs.ENDIF = {}", "stubs.ENDIF"),
        ('stubs."A B" = {}', "stubs.A B"),
        ('stubs."F(1)" = {}', r"stubs.F\(1\)"),
        ("stubs.F = { out = { x = 3 } }", "stubs.F.out.x"),
        ("unmet_wait_s = -1", "unmet_wait_s"),
        ('submits = ["a.src"]', "submits"),
        ('[[reply]]\nwhen = "$OUT["\nset = {}', r"reply\[0\].when"),
        ('[[reply]]\nwhen = "A"', r"reply\[0\].set"),
        ('home_deg = "x"', "home_deg"),
        ("home_deg = [0, 0]", "home_deg"),
        ("called_at_deg = 3", "called_at_deg"),
        ("ignore_turn = 1", "ignore_turn"),
        ("variables.WHEN = 3", "variables.WHEN"),
        ('states."$T1" = 3', r"states.\$T1"),
        ('[[reply]]\nset = { "$IN[1]" = 5 }', r"reply\[0\].set.\$IN\[1\]"),
    ],
)
def test_a_bad_file_is_one_line_that_names_the_field(text, named):
    with pytest.raises(PaperError, match=f"{named}: .*expected|{named}") as fault:
        cell(text)
    assert "\n" not in str(fault.value)


def test_a_routine_that_is_called_begins_where_the_arm_stands(arm):
    program = parse_program("DEF a( )\n$VEL.CP = 0.2\nLIN_REL {Y 40}\nEND\n", name="a")
    with pytest.raises(ProgramError, match="begin with a full PTP"):
        run_program(program, arm)
    run = run_program(program, arm, cell=cell("called_at_deg = [10, -90, 90, 0, 30, 0]"))
    assert [x.kind for x in run.executed] == ["LIN_REL"]
    np.testing.assert_allclose(run.motion.q[0], np.radians([10, -90, 90, 0, 30, 0]), atol=1e-12)
    assert "the routine is called = with the axes at 10, -90, 90, 0, 30, 0 deg (called_at_deg of the cell)" in [
        str(x) for x in run.assumptions
    ]


def test_a_turn_can_be_ignored_and_then_the_nearest_solution_is_taken(arm):
    point = "PTP {X 1100, Y 200, Z 1300, A 0, B 90, C 0, S 2, T 61}"
    program = parse_program(f"DEF a( )\n{HOME}\n{point}\nEND\n", name="a")
    with pytest.raises(ProgramError, match="T 61"):
        run_program(program, arm)
    run = run_program(program, arm, cell=cell("ignore_turn = true"))
    assert np.abs(np.diff([x.q for x in run.executed], axis=0)).max() < np.pi
    assert run.poses()[1].y_mm == pytest.approx(200)
    assert any("ignore_turn" in str(x) for x in run.assumptions)


def test_the_template_can_be_read_as_it_stands_and_with_every_line_filled_in(arm):
    text = new_cell_text("cell.toml")
    assert cell(text).robot == "kr30ha"
    filled = "\n".join(line.removeprefix("# ") if "=" in line or "[[" in line else line for line in text.splitlines())
    whole = cell(filled)
    assert whole.values["TOOL_DATA[1]"].parts["Z"] == 150
    assert whole.replies[0].after == 0.4
    assert whole.stubs["EKI_GETREAL"].out == {3: 12.5}


def test_the_commands_take_a_cell_and_list_what_is_assumed(printed, recorded, refused, folder):
    (folder / "a.src").write_text(
        "DEF a( )\nIF $IN[3] AND NOT $T1 THEN\nPTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}\nPTP {A1 5}\nENDIF\nEND\n"
    )
    printed("new", "cell", "cell.toml")
    (folder / "cell.toml").write_text((folder / "cell.toml").read_text().replace("# 3 = true", "3 = true"))
    names = {x["name"]: x for x in recorded("krl", "run", "a.src", "--cell", "cell.toml")["assumptions"]}
    assert names["$T1"] == {"name": "$T1", "value": "FALSE", "why": "state default"}
    assert names["$IN[3]"]["why"] == "given"
    printed("krl", "check", "a.src", "--cell", "cell.toml")
    assert "$IN[3]" in refused("krl", "run", "a.src")
