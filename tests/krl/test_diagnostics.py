"""Broken programs: the right code, at the right place, in one sentence; what a run and the check of motions refuse."""

import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.krl.diagnostics import MOST, has_no_error, summary
from lwr_dyn.krl.project.program import load_program
from lwr_dyn.krl.running.cell import input_values
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import ProgramError, check_program, run_program
from tests.krl.short_programs import HOME, program_of, said

SPEED = "BAS(#VEL_PTP, 100)\n$VEL.CP = 0.2"
SYNTAX = {
    "WIAT SEC 2": (1, "unknown-keyword"), "  FRO i = 1 TO 2": (3, "unknown-keyword"),
    "PTP {X 1, Y 2": (5, "open-bracket"),
    "x = (1 + 2": (5, "open-bracket"), 'name[] = "hello': (10, "open-string"), "x = 1 ? 2": (7, "bad-character"),
    "x = 'B102'": (5, "bad-literal"), "WAIT 2": (6, "syntax"), "LIN p q": (7, "syntax"), "\tx = 3 +": (9, "syntax"),
    "off = 3": (1, "syntax"), "x = " + "1" * 41: (5, "number-range"), "x = " + "1" * 40: (5, "number-range"),
    "x = " + "1+" * 300 + "1": (206, "long-line"),
    'x[] = "' + "a" * 9000 + '"': (8193, "long-line"), "x = " + "-" * 200 + "1": (105, "long-line"),
}  # fmt: skip


@pytest.mark.parametrize("line", SYNTAX, ids=range(len(SYNTAX)))
def test_syntax_has_its_place(line):
    (diagnostic,) = [d for d in check_program(program_of(line)) if d.code == SYNTAX[line][1]]
    assert (diagnostic.position.line, diagnostic.position.column) == (2, SYNTAX[line][0])
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


POSE = "PTP {X 91, Y -1139, Z 1392, A 0, B 0, C 0, S %d, T %d}"
AT = f"{SPEED}\n{HOME}\n"
OF_RUN = {
    f"INT i\ni = 1\n{AT}i = i / (i - 1)": "division-by-zero", f"REAL x\n{AT}x = SQRT(-1)": "number-range",
    f"INT i\n{AT}i = 2000000000\ni = i * 2": "number-range",
    f"INT i\n{AT}i = -2147483647 - 1\ni = ABS(i)": "number-range",
    f"INT i\n{AT}i = ABS(TRUE)": "type", f"INT i\n{AT}i = i + 1": "no-value", f"INT i[2]\n{AT}i[3] = 1": "index-range",
    f"{AT}WAIT FOR $IN[7]": "unknown-input", f"{AT}WAIT FOR FALSE": "waits-forever", f"{AT}a()": "recursion",
    f"$VEL.CP = 0\nBAS(#VEL_PTP, 100)\n{HOME}\nLIN_REL {{X 10}}": "speed-range",
    f"DECL FRAME f\nf = {{X 1}}\n{AT}f = f : f": "no-value",
    f"{SPEED}\nLIN {{X 1000, Y 0, Z 1000, A 0, B 90, C 0}}": "first-motion",
    f"{SPEED}\nPTP {{A1 0, A2 -90}}": "first-motion",
    f"{SPEED}\nPTP {{X 1340, Y 0, Z 1810, A 0, B 90, C 0}}": "first-motion", f"{AT}PTP {{A1 190}}": "outside-limits",
    f"{AT}PTP {{X 3000, Y 0, Z 1000, A 0, B 90, C 0, S 2, T 2}}": "out-of-reach", AT + POSE % (2, 0): "status-turn",
    AT + POSE % (0, 63): "status-turn", f"{AT}LIN_REL {{X 2000}}": "out-of-reach",
    f"{AT}CIRC_REL {{X -10}}, {{X -20}}": "no-arc", "FOR i = 1 TO 3\nENDFOR": "undeclared",
    f"INT i\n{AT}FOR i = 1 TO 3 STEP 0\nENDFOR": "endless",
}  # fmt: skip
NESTED = "f(n+1)"
for _ in range(30):
    NESTED = f"(1+{NESTED})"
OF_RUN[f"INT i\n{AT}i = f(1)\nEND\nDEFFCT INT f(n :IN)\nINT n\nRETURN {NESTED}\nENDFCT\nDEF b( )"] = "recursion"


@pytest.mark.parametrize("lines", OF_RUN, ids=range(len(OF_RUN)))
def test_faults_of_a_run_are_those_of_the_check(arm, lines):
    program = program_of(lines)
    with pytest.raises(ProgramError) as fault:
        run_program(program, arm)
    assert fault.value.code == OF_RUN[lines]
    assert str(fault.value).startswith("a.src:")
    assert OF_RUN[lines] in [d.code for d in check_program(program, arm)]


def test_a_fault_of_the_dat_stands_in_its_line(arm):
    program = program_of(SPEED, HOME, "n[1] = m", data="DEFDAT a\nINT n[2]\nINT m=1\nn[3]=1\nENDDAT\n")
    with pytest.raises(ProgramError, match=r"^a\.dat:4:3: "):
        run_program(program, arm)
    for size, words in ((0, r"^a\.dat:2:5: n has the size 0; from 1 to 100000"), (100_001, r"size 100001"),
                        (1, ""), (100_000, "")):  # fmt: skip
        program = program_of(SPEED, HOME, data=f"DEFDAT a\nINT n[{size}]\nENDDAT\n")
        if words:
            with pytest.raises(ProgramError, match=words):
                run_program(program, arm)
        else:
            assert len(run_program(program, arm).executed) == 1


def test_a_sound_program_is_clean_and_a_missing_value_after_a_fault_is_no_other_fault(arm):
    def codes(*lines):
        return said(" | ".join(["BAS(#VEL_PTP, 100)", *lines]), arm=arm)

    slow, fast = ("$VEL.CP = 0.2", HOME), ("$VEL.CP = 2", HOME)
    assert codes(*slow, "LIN_REL {X -50}", HOME) == []
    after = ("X = 1e400", "Y = X", "WAIT SEC Y", "Y = 1", "WAIT SEC Y")
    assert said(" | ".join(["REAL X, Y", "BAS(#VEL_PTP, 100)", *slow, *after]), arm=arm) == ["6 number-range"]
    assert said(" | ".join(["REAL X", "BAS(#VEL_PTP, 100)", *slow, "X = X + 1", "WAIT SEC X"]), arm=arm) == [
        "6 no-value"
    ]
    # a motion of nanometres is planned and an endless one reported
    assert codes(*fast, "LIN_REL {X 0.0000015}", "LIN_REL {X 0.0000015, A 10}") == []
    assert codes("$VEL.CP = 0.2", "$VEL.ORI1 = 0.000001", "$OV_PRO = 1", HOME, "LIN_REL {A 10}") == ["7 speed-range"]


@pytest.mark.slow
def test_an_endless_loop_is_cut_and_reported(arm):
    # the counter keeps the state from coming back
    counting = ("REPEAT", "PTP_REL {A1 5}", "PTP_REL {A1 -5}", "$FILTER = $FILTER + 1", "UNTIL FALSE")
    for what, settings in (
        ("5000 statements", MachineData(steps=5000)),
        ("10 s of simulated time", MachineData(seconds=10.0)),
        ("30 motions", MachineData(motions=30)),
    ):
        (note,) = run_program(program_of(SPEED, HOME, *counting), arm, settings).diagnostics
        assert (note.severity, note.code, note.message) == ("note", "bound", f"stopped here after {what}")
    empty = program_of(SPEED, HOME, "LOOP", "ENDLOOP")
    assert run_program(empty, arm, MachineData(steps=2000)).diagnostics[0].code == "endless"


def test_an_input_without_a_value_names_the_option(arm):
    program = program_of(SPEED, HOME, "IF $IN[7] THEN", "PTP_REL {A1 10}", "ENDIF")
    with pytest.raises(ProgramError, match=r"--set '\$IN\[7\]=TRUE'"):
        run_program(program, arm)
    for text, count in (("$IN[7]=TRUE", 2), ("$IN[7] = FALSE", 1)):
        assert len(run_program(program, arm, inputs=input_values([text])).executed) == count
    for text in ("$IN[7]", "=3", "$IN[7]=", "$IN[7]=y"):
        with pytest.raises(OptionError):
            input_values([text])
    with pytest.raises(OptionError):
        run_program(program, lwr_dyn.load("lwr4plus"))


def test_files_that_are_missing_or_included(tmp_path, arm):
    source = tmp_path / "a.src"
    source.write_text(f"DEF a( )\n{SPEED}\nPTP XP1\nEND\n")
    (diagnostic,) = check_program(load_program(source), arm)
    assert (diagnostic.code, "no .dat" in diagnostic.hint) == ("undeclared", True)
    (tmp_path / "b.toml").write_text("")
    for name, included, words in (("b.src", (), "b.src"), ("a.txt", (), "a.txt"), ("a.src", ("b.toml",),
                                  "ends in '.toml'; allowed: a .src, .sub or .dat file, a folder")):  # fmt: skip
        with pytest.raises(FileAccessError) as fault:
            load_program(tmp_path / name, [tmp_path / x for x in included])
        assert words in str(fault.value)
    (tmp_path / "A.DAT").write_text("DEFDAT a\nDECL E6AXIS XP1={A1 0, A2 -90, A3 90, A4 0, A5 0, A6 0}\nENDDAT\n")
    # faults of an included file are not reported
    (tmp_path / "b.dat").write_text("DEFDAT b\nINT n=1\nINT n=2\nENDDAT\n")
    assert check_program(load_program(source, [tmp_path / "b.dat"]), arm) == ()


def test_at_most_a_hundred_of_a_kind_are_shown_and_the_rest_is_counted():
    found = check_program(program_of(*["WIAT SEC 1"] * 1000, "WHILE"))
    (rest,) = [d for d in found if d.code == "more"]
    assert [d.code for d in found] == ["unknown-keyword"] * MOST + ["more", "missing-end", "syntax"]
    assert (rest.severity, rest.position.line) == ("note", MOST + 2)
    assert rest.message == "from here 900 more of severity error and code unknown-keyword, not shown"
    assert rest.hint == f"{MOST} of them are shown"
    assert not has_no_error(found)
    assert has_no_error([rest])
    assert (summary(found), summary([rest]), summary([])) == (f"{MOST + 2} errors, 1 note", "1 note", "no findings")
    exact = check_program(program_of(*["WIAT SEC 1"] * MOST))
    assert [d.code for d in exact if d.code != "missing-end"] == ["unknown-keyword"] * MOST
