"""Types, declarations and constants: values, arguments of calls, indices, speeds, percentages; what is told where."""

import pytest

from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.program_run import check_program
from tests.krl.short_programs import program_of, said

COLOR, BOX = "ENUM COLOR RED,GREEN | DECL COLOR c | ", "STRUC BOX INT N[4] | DECL BOX b | "
FAULTS = {
    "IF TRUE THEN": "2 missing-end", "ENDIF": "2 stray-end", "LOOP | IF TRUE THEN | ENDLOOP": "3 missing-end",
    "ELSE": "2 stray-end", "IF TRUE THEN | ELSE | ELSE | ENDIF": "4 stray-end",
    "BOOL b | b = 1 B_AND 3": "3 type", "INT i | i = 1.5 B_OR 2": "3 type", "INT i | i = 1 B_EXOR 2": "",
    "DECL FRAME f | f = {X 1, X 2}": "3 duplicate-name", "DECL FRAME f | f = {NIX: X 1}": "3 unknown-type",
    "INT abcdefghijklmnopqrstuvwx": "", "INT abcdefghijklmnopqrstuvwxy": "2 long-name?",
    "f() | END | DEFFCT INT f( ) | RETURN 1 | ENDFCT | DEF g( )": "2 unused-value?", "EXIT": "2 stray-exit",
    "CASE 1": "2 stray-end", "GOTO nowhere": "2 undeclared",
    "HALT | DECL INT i": "3 late-declaration", "DECL INT i = 3": "2 initialiser-in-src", "DECL p": "2 missing-type",
    "DECL FRAMM p": "2 unknown-type", "INT i | INT i": "3 duplicate-name", "BOOL b | b = 3": "3 type",
    "INT i | i = #RED": "3 type", "DECL FRAME f | f = {X 1, Q 2}": "3 no-component",
    "DECL FRAME f | f.T = 1": "3 no-component", "INT i | i[1] = 1": "3 no-array", "INT i[3] | i[1,2] = 1": "3 no-array",
    "INT i | i = 3000000000": "3 number-range", "INT i | i = 2147483648": "3 number-range",
    "INT i | i = -2147483647": "", "INT i | i = 'HFFFFFFFF'": "", "INT i | i = 'H100000000'": "3 number-range",
    "REAL x | x = 1E999": "3 number-range", "REAL x | x = 3.4E38": "", "REAL x | x = 3.5E38": "3 number-range",
    "REAL x | x = SIN(1, 2)": "3 arguments", "foo(1)": "2 unknown-call", "LIN {A1 3}": "2 type",
    "BOOL b | b = 1 == 2 AND TRUE": "3 type, 3 type", "PTP {A1 0} C_DIS": "", "LIN {X 0} C_PTP": "2 blend",
    "DEF b( ) | END": "1 missing-end, 4 stray-end", "RETURN 3": "2 type", "INT i[3], b | b = i[TRUE]": "3 type",
    "INT i[3], b | b = i": "3 type", "INT i | i.X = 1": "3 no-component",
    "INT i[3] | i[4] = 1": "3 index-range", "INT i[3] | i[0] = 1": "3 index-range",
    "INT i[2,3] | i[2,4] = 1": "3 index-range", "INT i[3], k | k = 2 + i[-1]": "3 index-range",
    BOX + "b.N[5] = 1": "4 index-range", "HALT | $OUT[0] = TRUE": "3 index-range",
    "SIGNAL LAMP $OUT[0] TO $OUT[8]": "2 index-range", "HALT | $UNHEARD_OF[0] = TRUE": "3 index-range",
    "HALT | $VEL_AXIS[1] = 150": "3 percent-range", "HALT | $OV_PRO = 101": "3 percent-range",
    "HALT | BAS(#VEL_PTP, 150)": "3 percent-range", "HALT | BAS(#ACC_PTP, 100.5)": "3 percent-range",
    COLOR + "c = #GREN": "4 no-constant", COLOR + "IF c == #GREN THEN | ENDIF": "4 no-constant",
    COLOR + "IF #GREN <> c THEN | ENDIF": "4 no-constant",
    COLOR + "SWITCH c | CASE #RED, #GREN | ENDSWITCH": "5 no-constant",
    "INT n | SWITCH n | CASE #RED | ENDSWITCH": "4 type", "BOOL b | IF b == #RED THEN | ENDIF": "3 type",
    "STRUC S1 INT A, S1 B": "2 recursive-type",
    "STRUC S2 S3 A | STRUC S3 INT K, S2 B": "2 recursive-type, 3 recursive-type",
    "STRUC S4 FRAMM A": "2 unknown-type",
    "HALT | $VEL.CP = 250": "3 speed-unit?", "HALT | $VEL = {CP 250, ORI1 200, ORI2 200}": "3 speed-unit?",
    "HALT | BAS(#VEL_CP, 250)": "3 speed-unit?", "DECL LDAT l | l = {VEL 250, ACC 100}": "3 speed-unit?",
    "DECL PDAT p | p = {VEL 110, ACC 100}": "3 percent-range?", "DECL PDAT p | p.VEL = 110": "3 percent-range?",
    "HALT | $UNHEARD_OF = #INITMVO": "3 no-constant?", "INT n | n = RSI_ON(#ASBOLUTE)": "3 no-constant?",
    "HALT | $MSG_T.VAILD = TRUE": "3 no-component?", "HALT | $IPO_MODE = #TPC": "3 no-constant?",
    "HALT | $MOTION_MODE = #DYNAIMC": "3 no-constant?", "HALT | $MOTION_MODE = #OTHER": "",
    "HALT | $UNHEARD_OF = #CHARGE_OK": "",
}  # fmt: skip


@pytest.mark.parametrize("lines", FAULTS)
def test_a_fault_is_told_at_its_line(lines):
    assert ", ".join(said(lines)) == FAULTS[lines]


def test_what_is_within_its_bounds_is_not_told():
    sound = [
        "INT i[3], n", "REAL r[2,5]", "CHAR text[12]", "ENUM COLOR RED,GREEN", "DECL COLOR c", "DECL PDAT p",
        "DECL LDAT l",
        "STRUC IN_BOX INT N[4]", "STRUC BOX IN_BOX A, IN_BOX B",
        "i[1] = 3", "i[3] = 3", "r[2,5] = 250", "text[12] = \"a\"", "n = 0", "i[n] = 1", "$OUT[1] = TRUE",
        "$VEL.CP = 3",
        "$VEL_AXIS[1] = 100", "$OV_PRO = 100", "BAS(#VEL_PTP, 100)", "BAS(#VEL_CP, 2)", "$VEL.ORI1 = 400",
        "$ACC.CP = 10", "$APO.CDIS = 500", "p = {VEL 100, ACC 100, APO_DIST 500}", "l = {VEL 2, ACC 100, APO_DIST 500}",
        "c = #green", "IF c == #RED THEN", "ENDIF", "SWITCH c", "CASE #RED", "CASE #GREEN", "ENDSWITCH",
        "$MSG_T.UNLISTED = TRUE", "n = RSI_ON(#UNLISTED)", "$IPO_MODE = #BASE", "$UNHEARD_OF = #UNHEARD",
        "$UNHEARD_OF = #INITMOV",
        "SWITCH n", "CASE 1", "ENDSWITCH",
    ]  # fmt: skip
    assert said(" | ".join(sound)) == []


TAKE = (
    "DEF take(number :IN, name[] :OUT, mode :IN, place :OUT, open)", "INT number", "CHAR name[]", "DECL COLOR mode",
    "DECL FRAME place", "number = number + 1",
)  # fmt: skip
DATA = (
    "ENUM COLOR RED,GREEN", "DECL FRAME F={X 0}", "CHAR TEXT[9]", "REAL R=0", "DECL COLOR C=#RED", "INT N=0",
    "DECL E6POS P", "DECL E6AXIS AX", "EXT OTHER(BAS_COMMAND :IN, CHAR WORDS[] :OUT)",
)  # fmt: skip
CALLS = {
    'take(1, "long text", #GREEN, F, TRUE)': "", "take(R, TEXT[], C, F, 3)": "", "take()": "", "take(1, , , F)": "",
    "take(R * 2)": "", "take(TRUE)": "type", "take(1, 2)": "type", "take(1, TEXT[], #GREN)": "no-constant",
    "take(1, TEXT[], 3)": "type", "take(1, TEXT[], C, R)": "type", "take(#RED)": "type",
    "take(1, TEXT[], C, F, TRUE, 6)": "arguments",
    # of the controller
    'N = STRADD(TEXT[], "abc")': "", "N = STRLEN(TEXT[])": "", "AX = INVERSE(P, AX, N)": "", "BAS(#INITMOV, 0)": "",
    "BAS(#FRAMES)": "", 'N = STRADD("abc", TEXT[])': "arguments", "N = STRLEN(5)": "type",
    "AX = INVERSE(P, AX, 3)": "arguments", "AX = INVERSE(AX, AX, N)": "type", "BAS(#INITMOVQ, 0)": "no-constant?",
    "BAS(TRUE, 0)": "type?", "N = SIN(TEXT[])": "type",
    # as EXT declares it
    "OTHER(#INITMOV, TEXT[])": "", "OTHER(#INITMOVQ, TEXT[])": "no-constant?", "OTHER(#INITMOV, 3)": "type",
}  # fmt: skip


@pytest.mark.parametrize("call", CALLS)
def test_arguments_fit_the_declared_parameters(call):
    found = said(" | ".join([call, "END", *TAKE]), data="\n".join(["DEFDAT a", *DATA, "ENDDAT", ""]))
    told = [x for x in found if "parameter-type" not in x]  # `open` has none, so it takes all
    assert told == ([f"2 {CALLS[call]}"] if CALLS[call] else [])


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        (("x = 1", "X = x + 1", "WAIT SEC x"),
         ["2:1 x is not declared (4 places), declare it in the .dat or with DECL; no .dat is there"]),
        (("foo(1)", "foo(2)"),
         ["2:1 the subprogram foo is not known (2 places), define it, declare it with EXT, or lend its file with "
          "--with, its names with --names"]),
        (("DECL FRAMM p", "DECL FRAMM q"), ["2:1 FRAMM is no type (2 places), did you mean FRAME?"]),
        (("DECL FRAME off",), ["2:12 off is a keyword and no name, use another name"]),
        (("RETRUN (3)",), ["2:1 RETRUN is no keyword, did you mean RETURN?"]),
        (("REAL x", "x = SIN(1, 2)"), ["3:5 SIN is given 2 arguments, it takes 1"]),
        (("INT i[2]", "i[1,2] = 3"), ["3:1 2 indices on an array of 1, 1 indices"]),
        (("INT i", "i[1] = 3"), ["3:1 an index on what is no array, declare it with brackets"]),
        (("BOOL b", "b = 3"), ["3:5 b is BOOL, the value is INT, a value of type BOOL"]),
        (("INT i", "i = 3000000000"), ["3:5 3000000000 is no INT, from -2147483648 to 2147483647, or a REAL"]),
    ],
)  # fmt: skip
def test_it_is_said_in_a_sentence_with_its_place(lines, expected):
    found = check_program(program_of(*lines))
    texts = [f"{d.position.line}:{d.position.column} {d.message}{', ' * bool(d.hint)}{d.hint}" for d in found]
    assert texts == expected


def test_of_an_unknown_type_nothing_more_is_told():
    lines = "DECL BOXES b | DECL BOXES c[3] | b.HIGH = TRUE | c[1].LOW = b.HIGH + 1 | b = c[2] | PTP b | c[4] = b"
    assert said(lines) == ["2 unknown-type", "8 index-range"]
    assert said("STRUC S1 BOXES K | DECL S1 s | s.K.HIGH = 3 | PTP s.K") == ["2 unknown-type"]
    assert said("take(3) | END | DEF take(x :IN) | DECL BOXES x") == ["5 unknown-type"]
    assert said("$unheard( )") == ["2 unknown-call"]
    assert said("INT n | n(3) | $OV_PRO(3)") == ["3 type", "4 type"]


def test_what_lacks_its_begin_or_end_or_is_in_a_wrong_encoding():
    def codes(source, data=None):
        return [(d.position.line, d.code) for d in check_program(parse_program(source, data, name="a"))]

    assert codes("DEF a( )\nHALT\n") == [(1, "missing-end")]
    assert codes("") == [(1, "missing-def")]
    assert codes("DEF a( )\nEND\n", "DEFDAT a\n") == [(1, "missing-end")]
    assert codes("DEF a( ) ; ü\nEND\n".encode("latin-1")) == []
    assert codes("DEF a( ) ; ü\nEND\n".encode()) == [(1, "encoding")]
    assert (1, "encoding") in codes("DEF a( )\nEND\n".encode("utf-16"))
    for end in ("\n", "\r\n", "\r"):
        assert codes(end.join(["DEF\ta( )", "\tHALT\t; home", "END"])) == []
