"""Every kind of broken program: the right code, at the right place, in one sentence."""

import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.krl.diagnostics import MOST, has_no_error
from lwr_dyn.krl.project.program import load_program, parse_program
from lwr_dyn.krl.running.cell import input_values
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import ProgramError, check_program, run_program
from tests.krl.short_programs import HOME, program_of

SPEED = "BAS(#VEL_PTP, 100)\n$VEL.CP = 0.2"


def codes(program, arm=None, **options):
    return [(d.position.line, d.code) for d in check_program(program, arm, **options)]


@pytest.mark.parametrize(
    ("line", "column", "code"),
    [
        ("WIAT SEC 2", 1, "unknown-keyword"),
        ("  FRO i = 1 TO 2", 3, "unknown-keyword"),
        ("PTP {X 1, Y 2", 5, "open-bracket"),
        ("x = (1 + 2", 5, "open-bracket"),
        ('name[] = "hello', 10, "open-string"),
        ("x = 1 ? 2", 7, "bad-character"),
        ("x = 'B102'", 5, "bad-literal"),
        ("WAIT 2", 6, "syntax"),
        ("LIN p q", 7, "syntax"),
        ("\tx = 3 +", 9, "syntax"),
        ("off = 3", 1, "syntax"),
        ("x = " + "1+" * 300 + "1", 206, "long-line"),
        ('x[] = "' + "a" * 9000 + '"', 8193, "long-line"),
        ("x = " + "-" * 200 + "1", 105, "long-line"),
    ],
)
def test_syntax_has_its_place(line, column, code):
    (diagnostic,) = [d for d in check_program(program_of(line)) if d.code == code]
    assert (diagnostic.position.line, diagnostic.position.column) == (2, column)
    assert "\n" not in str(diagnostic)
    assert diagnostic.hint


@pytest.mark.parametrize(
    ("line", "message", "hint"),
    [
        ("CIRC XP1", "CIRC needs an auxiliary point before the end", "CIRC AUX, TARGET"),
        ("SCIRC {X 1, Y 2}", "SCIRC needs an auxiliary point before the end", "SCIRC AUX, TARGET"),
        ("bla", "bla alone is no statement", "bla() calls a subprogram, bla = ... assigns"),
        ("CIRC XP1,", "the line ends too early", "allowed here: "),
    ],
)
def test_a_line_that_is_too_short_says_what_is_missing(line, message, hint):
    (diagnostic,) = [d for d in check_program(program_of(line)) if d.code == "syntax"]
    assert diagnostic.message == message
    assert diagnostic.hint.startswith(hint)


def test_a_keyword_as_a_name_is_reported_as_such():
    (diagnostic,) = check_program(program_of("DECL FRAME off"))
    assert diagnostic.message == "off is a keyword and no name"


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        (["IF TRUE THEN"], [(2, "missing-end")]),
        (["ENDIF"], [(2, "stray-end")]),
        (["LOOP", "IF TRUE THEN", "ENDLOOP"], [(3, "missing-end")]),
        (["ELSE"], [(2, "stray-end")]),
        (["EXIT"], [(2, "stray-exit")]),
        (["CASE 1"], [(2, "stray-end")]),
        (["GOTO nowhere"], [(2, "undeclared")]),
        (["HALT", "DECL INT i"], [(3, "late-declaration")]),
        (["DECL INT i = 3"], [(2, "initialiser-in-src")]),
        (["DECL p"], [(2, "missing-type")]),
        (["DECL FRAMM p"], [(2, "unknown-type")]),
        (["INT i", "INT i"], [(3, "duplicate-name")]),
        (["BOOL b", "b = 3"], [(3, "type")]),
        (["INT i", "i = #RED"], [(3, "type")]),
        (["DECL FRAME f", "f = {X 1, Q 2}"], [(3, "no-component")]),
        (["DECL FRAME f", "f.T = 1"], [(3, "no-component")]),
        (["INT i", "i[1] = 1"], [(3, "no-array")]),
        (["INT i[3]", "i[1,2] = 1"], [(3, "no-array")]),
        (["INT i", "i = 3000000000"], [(3, "number-range")]),
        (["REAL x", "x = 1E999"], [(3, "number-range")]),
        (["REAL x", "x = SIN(1, 2)"], [(3, "arguments")]),
        (["foo(1)"], [(2, "unknown-call")]),
        (["LIN {A1 3}"], [(2, "type")]),
        (["BOOL b", "b = 1 == 2 AND TRUE"], [(3, "type"), (3, "type")]),
        (["PTP {A1 0} C_DIS"], []),
        (["LIN {X 0} C_PTP"], [(2, "blend")]),
        (["DEF b( )", "END"], [(1, "missing-end"), (4, "stray-end")]),
        (["RETURN 3"], [(2, "type")]),
    ],
)
def test_language_faults(lines, expected):
    assert codes(program_of(*lines)) == expected


def test_a_sound_program_is_clean(arm):
    assert codes(program_of(SPEED, HOME, "LIN_REL {X -50}", HOME), arm) == []


def test_missing_end_and_missing_def():
    assert codes(parse_program("DEF a( )\nHALT\n", name="a")) == [(1, "missing-end")]
    assert codes(parse_program("", name="a")) == [(1, "missing-def")]
    assert codes(parse_program("DEF a( )\nEND\n", "DEFDAT a\n", "a")) == [(2 - 1, "missing-end")]


def test_wrong_encodings_are_reported_and_latin_1_is_not():
    assert codes(parse_program("DEF a( ) ; ü\nEND\n".encode("latin-1"), name="a")) == []
    assert codes(parse_program("DEF a( ) ; ü\nEND\n".encode(), name="a")) == [(1, "encoding")]
    assert (1, "encoding") in codes(parse_program("DEF a( )\nEND\n".encode("utf-16"), name="a"))


def test_tabs_and_every_kind_of_line_end(arm):
    for end in ("\n", "\r\n", "\r"):
        text = end.join(["DEF\ta( )", *SPEED.split("\n"), "\t" + HOME + "\t; home", "END"])
        assert codes(parse_program(text, name="a"), arm) == []


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        (["INT i", "i = 1", SPEED, HOME, "i = i / (i - 1)"], "division-by-zero"),
        (["REAL x", SPEED, HOME, "x = SQRT(-1)"], "number-range"),
        (["INT i", SPEED, HOME, "i = 2000000000", "i = i * 2"], "number-range"),
        (["INT i", SPEED, HOME, "i = -2147483647 - 1", "i = ABS(i)"], "number-range"),
        (["INT i", SPEED, HOME, "i = ABS(TRUE)"], "type"),
        (["INT i", SPEED, HOME, "i = i + 1"], "no-value"),
        (["INT i[2]", SPEED, HOME, "i[3] = 1"], "index-range"),
        ([SPEED, HOME, "WAIT FOR $IN[7]"], "unknown-input"),
        ([SPEED, HOME, "WAIT FOR FALSE"], "waits-forever"),
        ([SPEED, HOME, "a()"], "recursion"),
        (["$VEL.CP = 0", SPEED.split("\n")[0], HOME, "LIN_REL {X 10}"], "speed-range"),
        (["DECL FRAME f", "f = {X 1}", SPEED, HOME, "f = f : f"], "no-value"),
        ([SPEED, "LIN {X 1000, Y 0, Z 1000, A 0, B 90, C 0}"], "first-motion"),
        ([SPEED, "PTP {A1 0, A2 -90}"], "first-motion"),
        ([SPEED, "PTP {X 1340, Y 0, Z 1810, A 0, B 90, C 0}"], "first-motion"),
        ([SPEED, HOME, "PTP {A1 190}"], "outside-limits"),
        ([SPEED, HOME, "PTP {X 3000, Y 0, Z 1000, A 0, B 90, C 0, S 2, T 2}"], "out-of-reach"),
        ([SPEED, HOME, "PTP {X 91, Y -1139, Z 1392, A 0, B 0, C 0, S 2, T 0}"], "status-turn"),
        ([SPEED, HOME, "PTP {X 91, Y -1139, Z 1392, A 0, B 0, C 0, S 0, T 63}"], "status-turn"),
        ([SPEED, HOME, "LIN_REL {X 2000}"], "out-of-reach"),
        ([SPEED, HOME, "CIRC_REL {X -10}, {X -20}"], "no-arc"),
        (["FOR i = 1 TO 3", "ENDFOR"], "undeclared"),
        (["INT i", SPEED, HOME, "FOR i = 1 TO 3 STEP 0", "ENDFOR"], "endless"),
    ],
)
def test_faults_of_a_run(arm, lines, code):
    program = program_of(*lines)
    with pytest.raises(ProgramError) as fault:
        run_program(program, arm)
    assert fault.value.code == code
    assert str(fault.value).startswith("a.src:")
    checked = [d.code for d in check_program(program, arm)]
    assert code in checked or code in ("recursion",)


def test_the_check_reports_recursion_too(arm):
    assert "recursion" in [d.code for d in check_program(program_of(SPEED, HOME, "a()"), arm)]


def test_functions_nested_in_sums_without_end_are_reported_by_check_and_run(arm):
    nested = "f(n+1)"
    for _ in range(30):
        nested = f"(1+{nested})"
    lines = ["DEF a( )", "INT i", SPEED, HOME, "i = f(1)", "END", "DEFFCT INT f(n :IN)", "INT n", f"RETURN {nested}"]
    program = parse_program("\n".join([*lines, "ENDFCT", ""]), name="a")
    assert "recursion" in [d.code for d in check_program(program, arm)]
    with pytest.raises(ProgramError) as fault:
        run_program(program, arm)
    assert fault.value.code == "recursion"


def test_a_value_that_is_missing_after_a_fault_is_no_other_fault(arm):
    lines = ["REAL X, Y", SPEED, HOME, "X = 1e400", "Y = X", "WAIT SEC Y", "Y = 1", "WAIT SEC Y"]
    assert codes(program_of(*lines), arm) == [(6, "number-range")]
    assert codes(program_of("REAL X", SPEED, HOME, "X = X + 1", "WAIT SEC X"), arm) == [(6, "no-value")]


@pytest.mark.slow
def test_an_endless_loop_is_cut_and_reported(arm):
    # the counter keeps the state from coming back
    counting = ("REPEAT", "PTP_REL {A1 5}", "PTP_REL {A1 -5}", "$FILTER = $FILTER + 1", "UNTIL FALSE")
    for what, settings in (
        ("5000 statements", MachineData(steps=5000)),
        ("10 s of simulated time", MachineData(seconds=10.0)),
        ("30 motions", MachineData(motions=30)),
    ):
        run = run_program(program_of(SPEED, HOME, *counting), arm, settings)
        (note,) = run.diagnostics
        assert (note.severity, note.code) == ("note", "bound")
        assert what in note.message
    empty = program_of(SPEED, HOME, "LOOP", "ENDLOOP")
    assert run_program(empty, arm, MachineData(steps=2000)).diagnostics[0].code == "endless"


def test_an_input_without_a_value_names_the_option(arm):
    program = program_of(SPEED, HOME, "IF $IN[7] THEN", "PTP_REL {A1 10}", "ENDIF")
    with pytest.raises(ProgramError, match=r"--set '\$IN\[7\]=TRUE'"):
        run_program(program, arm)
    assert len(run_program(program, arm, inputs=input_values(["$IN[7]=TRUE"])).executed) == 2
    assert len(run_program(program, arm, inputs=input_values(["$IN[7] = FALSE"])).executed) == 1
    for text in ("$IN[7]", "=3", "$IN[7]=", "$IN[7]=y"):
        with pytest.raises(OptionError):
            input_values([text])


def test_files_that_are_missing(tmp_path, arm):
    source = tmp_path / "a.src"
    source.write_text(f"DEF a( )\n{SPEED}\nPTP XP1\nEND\n")
    (diagnostic,) = check_program(load_program(source), arm)
    assert diagnostic.code == "undeclared"
    assert "no .dat" in diagnostic.hint
    with pytest.raises(FileAccessError):
        load_program(tmp_path / "b.src")
    with pytest.raises(FileAccessError):
        load_program(tmp_path / "a.txt")
    (tmp_path / "A.DAT").write_text("DEFDAT a\nDECL E6AXIS XP1={A1 0, A2 -90, A3 90, A4 0, A5 0, A6 0}\nENDDAT\n")
    assert check_program(load_program(source), arm) == ()


def test_another_robot_is_refused():
    with pytest.raises(OptionError):
        run_program(program_of(SPEED, HOME), lwr_dyn.load("lwr4plus"))


def test_an_included_file_is_krl(tmp_path):
    (tmp_path / "a.src").write_text("DEF a( )\nEND\n")
    (tmp_path / "b.toml").write_text("")
    with pytest.raises(FileAccessError, match=r"ends in '.toml'; allowed: a .src, .sub or .dat file, a folder"):
        load_program(tmp_path / "a.src", [tmp_path / "b.toml"])


def test_faults_of_an_included_file_are_not_reported(tmp_path):
    (tmp_path / "a.src").write_text("DEF a( )\nHALT\nEND\n")
    (tmp_path / "b.dat").write_text("DEFDAT b\nINT n=1\nINT n=2\nENDDAT\n")
    assert check_program(load_program(tmp_path / "a.src", [tmp_path / "b.dat"])) == ()


def test_a_motion_of_nanometres_is_planned_and_an_endless_one_reported(arm):
    tiny = ["BAS(#VEL_PTP, 100)", "$VEL.CP = 2", HOME, "LIN_REL {X 0.0000015}", "LIN_REL {X 0.0000015, A 10}"]
    assert codes(program_of(*tiny), arm) == []
    slow = [SPEED, "$VEL.ORI1 = 0.000001", "$OV_PRO = 1", HOME, "LIN_REL {A 10}"]
    assert codes(program_of(*slow), arm) == [(7, "speed-range")]


def test_at_most_a_hundred_of_a_kind_are_shown_and_the_rest_is_counted():
    found = check_program(program_of(*["WIAT SEC 1"] * 1000, "WHILE"))
    assert [d.code for d in found].count("unknown-keyword") == MOST
    (rest,) = [d for d in found if d.code == "more"]
    assert (rest.severity, rest.position.line) == ("note", MOST + 2)
    assert rest.message == "from here 900 more of severity error and code unknown-keyword, not shown"
    assert [d.code for d in found][-1] == "syntax"
    assert not has_no_error(found)
