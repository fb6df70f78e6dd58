"""Arguments of calls against the declared parameters; constants that cannot be meant: indices, speeds, percentages."""

import pytest

from tests.krl.short_programs import told

ROUTINES = """
DEF take(number :IN, name[] :OUT, mode :IN, place :OUT, open)
INT number
CHAR name[]
DECL COLOR mode
DECL FRAME place
number = number + 1
END
"""
DATA = "DEFDAT a\nENUM COLOR RED,GREEN\nDECL FRAME F={X 0}\nCHAR TEXT[9]\nREAL R=0\nDECL COLOR C=#RED\nENDDAT\n"


def told_of(call):
    found = told(call, "END", ROUTINES.removesuffix("END\n"), data=DATA)
    return [(line, code) for line, _, code in found if code != "parameter-type"]  # `open` has none, so it takes all


@pytest.mark.parametrize(
    "call",
    [
        'take(1, "long text", #GREEN, F, TRUE)', "take(R, TEXT[], C, F, 3)", "take()", "take(1, , , F)", "take(R * 2)",
    ],
)  # fmt: skip
def test_arguments_that_fit(call):
    assert told_of(call) == []


@pytest.mark.parametrize(
    ("call", "code"),
    [
        ("take(TRUE)", "type"),
        ("take(1, 2)", "type"),
        ("take(1, TEXT[], #GREN)", "no-constant"),
        ("take(1, TEXT[], 3)", "type"),
        ("take(1, TEXT[], C, R)", "type"),
        ("take(#RED)", "type"),
        ("take(1, TEXT[], C, F, TRUE, 6)", "arguments"),
    ],
)
def test_arguments_that_do_not_fit(call, code):
    assert told_of(call) == [(2, code)]


def told_by(*lines):
    return told(*lines, data="DEFDAT a\nCHAR TEXT[9]\nINT N=0\nDECL E6POS P\nDECL E6AXIS AX\nENDDAT\n")


@pytest.mark.parametrize(
    ("line", "severity", "code"),
    [
        ('N = STRADD("abc", TEXT[])', "error", "arguments"),
        ("N = STRLEN(5)", "error", "type"),
        ("AX = INVERSE(P, AX, 3)", "error", "arguments"),
        ("AX = INVERSE(AX, AX, N)", "error", "type"),
        ("BAS(#INITMOVQ, 0)", "warning", "no-constant"),
        ("BAS(TRUE, 0)", "warning", "type"),
        ("N = SIN(TEXT[])", "error", "type"),
    ],
)
def test_functions_of_the_controller(line, severity, code):
    assert told_by(line) == [(2, severity, code)]


def test_functions_of_the_controller_that_fit():
    calls = [
        'N = STRADD(TEXT[], "abc")',
        "N = STRLEN(TEXT[])",
        "AX = INVERSE(P, AX, N)",
        "BAS(#INITMOV, 0)",
        "BAS(#FRAMES)",
    ]
    assert told_by(*calls) == []


def test_what_ext_declares_counts():
    external = "EXT OTHER(BAS_COMMAND :IN, CHAR WORDS[] :OUT)"
    assert told_by(external, "OTHER(#INITMOV, TEXT[])") == []
    assert told_by(external, "OTHER(#INITMOVQ, TEXT[])") == [(3, "warning", "no-constant")]
    assert told_by(external, "OTHER(#INITMOV, 3)") == [(3, "error", "type")]


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        (["INT i[3]", "i[4] = 1"], "index-range"),
        (["INT i[3]", "i[0] = 1"], "index-range"),
        (["INT i[2,3]", "i[2,4] = 1"], "index-range"),
        (["INT i[3], k", "k = 2 + i[-1]"], "index-range"),
        (["STRUC BOX INT N[4]", "DECL BOX b", "b.N[5] = 1"], "index-range"),
        (["HALT", "$OUT[0] = TRUE"], "index-range"),
        (["SIGNAL LAMP $OUT[0] TO $OUT[8]"], "index-range"),
        (["HALT", "$UNHEARD_OF[0] = TRUE"], "index-range"),
        (["HALT", "$VEL_AXIS[1] = 150"], "percent-range"),
        (["HALT", "$OV_PRO = 101"], "percent-range"),
        (["HALT", "BAS(#VEL_PTP, 150)"], "percent-range"),
        (["HALT", "BAS(#ACC_PTP, 100.5)"], "percent-range"),
        (["ENUM COLOR RED,GREEN", "DECL COLOR c", "c = #GREN"], "no-constant"),
        (["ENUM COLOR RED,GREEN", "DECL COLOR c", "IF c == #GREN THEN", "ENDIF"], "no-constant"),
        (["ENUM COLOR RED,GREEN", "DECL COLOR c", "IF #GREN <> c THEN", "ENDIF"], "no-constant"),
        (["ENUM COLOR RED,GREEN", "DECL COLOR c", "SWITCH c", "CASE #RED, #GREN", "ENDSWITCH"], "no-constant"),
        (["INT n", "SWITCH n", "CASE #RED", "ENDSWITCH"], "type"),
        (["BOOL b", "IF b == #RED THEN", "ENDIF"], "type"),
        (["STRUC S1 INT A, S1 B"], "recursive-type"),
        (["STRUC S2 S3 A", "STRUC S3 INT K, S2 B"], "recursive-type"),
        (["STRUC S4 FRAMM A"], "unknown-type"),
    ],
)
def test_an_error_is_told_at_its_line(lines, code):
    found = told(*lines)
    assert [(severity, kind) for _, severity, kind in found if kind == code][:1] == [("error", code)]
    assert {kind for _, _, kind in found} == {code}


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        (["HALT", "$VEL.CP = 250"], "speed-unit"),
        (["HALT", "$VEL = {CP 250, ORI1 200, ORI2 200}"], "speed-unit"),
        (["HALT", "BAS(#VEL_CP, 250)"], "speed-unit"),
        (["DECL LDAT l", "l = {VEL 250, ACC 100}"], "speed-unit"),
        (["DECL PDAT p", "p = {VEL 110, ACC 100}"], "percent-range"),
        (["DECL PDAT p", "p.VEL = 110"], "percent-range"),
        (["HALT", "$UNHEARD_OF = #INITMVO"], "no-constant"),
        (["INT n", "n = RSI_ON(#ASBOLUTE)"], "no-constant"),
        (["HALT", "$MSG_T.VAILD = TRUE"], "no-component"),
        (["HALT", "$IPO_MODE = #TPC"], "no-constant"),
    ],
)
def test_a_doubtful_constant_is_a_warning(lines, code):
    assert told(*lines) == [(3, "warning", code)]


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
    assert told(*sound) == []
