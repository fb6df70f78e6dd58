"""Functions of the controller and of the inline forms, texts, rows of arrays and VARSTATE: values by hand."""

import math

import numpy as np
import pytest

from lwr_dyn.krl.running.cell import constant_value
from lwr_dyn.krl.running.program_run import ProgramError, run_program
from lwr_dyn.krl.running.values import pose_matrix, text_of
from tests.krl.short_programs import HOME, program_of, values_of

DATA = ['DECL CHAR A[8]="ab"', 'DECL CHAR B[4]="CD"', "DECL INT N", "DECL BOOL Y", "DECL REAL X", "DECL INT G=3",
        "DECL CHAR W[3,5]", "DECL CHAR NAMES[2,4]", 'NAMES[1,]="ab"', "DECL INT U", "STRUC BOX INT K[3], REAL V",
        "DECL BOX O", "DECL E6AXIS Q", "DECL E6POS P", "EXT UNHEARD( )", "SIGNAL GROUP $OUT[1] TO $OUT[3]",
        "SIGNAL BIG $OUT[1] TO $OUT[33]", "SIGNAL ALL $OUT[1] TO $OUT[32]", "SIGNAL MIX $OUT[1] TO $IN[3]"]  # fmt: skip
VALUES = {
    "X = SIN(30)": ("X", 0.5), "X = ACOS(-1)": ("X", 180.0), "X = ATAN2(1, -1)": ("X", 135.0),
    "X = SQRT(2)": ("X", math.sqrt(2)), "X = ABS(-3)": ("X", 3.0), "N = ABS(-7) / 2": ("N", 3),
    "N = STRLEN(A[])": ("N", 2), "N = STRDECLLEN(A[])": ("N", 8), "N = STRADD(A[], B[])": ("A", "abCD"),
    'Y = STRCOPY(B[], "xyz")': ("B", "xyz"), 'Y = STRCOPY(B[], "longer")': ("Y", False),
    "Y = STRCLEAR(A[])": ("A", ""), 'Y = STRCOMP(A[], "AB", #NOT_CASE_SENS)': ("Y", True),
    'Y = STRCOMP(A[], "AB", #CASE_SENS)': ("Y", False), 'N = STRFIND(1, A[], "b", #CASE_SENS)': ("N", 2),
    'N = STRFIND(1, A[], "B", #CASE_SENS)': ("N", 0), 'Y = STRTOINT("-12", N)': ("N", -12),
    'Y = STRTOREAL("1.5e2", X)': ("X", 150.0), 'Y = STRTOREAL("nan", X)': ("Y", False),
    "N = STRLEN(NAMES[1,])": ("N", 2), "A[] = NAMES[1,]\nN = STRLEN(A[])": ("N", 2),
    'W[2,] = "xyz"\nN = STRLEN(W[2,])': ("N", 3), 'W[2,] = "xyz"\nY = W[2,3] == "z"': ("Y", True),
    'W[1,] = "long"\nW[1,] = "s"\nN = STRLEN(W[1,])': ("N", 1),
    'Y = VARSTATE("U") == #DECLARED': ("Y", True), 'U = 1\nY = VARSTATE("U") == #INITIALIZED': ("Y", True),
    'Y = VARSTATE("G") == #INITIALIZED': ("Y", True), 'Y = VARSTATE("nothing") == #UNDEFINED': ("Y", True),
    'Y = VARSTATE("W[9,9]") == #UNDEFINED': ("Y", True), 'A[] = "U"\nY = VARSTATE(A[]) == #DECLARED': ("Y", True),
    "X = 2.4\nN = 10 * X": ("N", 24), "N = 6.5": ("N", 7),
    'Y = STRCOMP(A[], "AB")': ("Y", False), 'N = STRFIND(1, A[], "B", #NOT_CASE_SENS)': ("N", 2),
    'N = STRFIND(A[], "b")': ("N", 2), 'N = STRFIND(3, "abab", "a")': ("N", 3), 'N = STRFIND(4, "abab", "a")': ("N", 0),
    'N = STRFIND(0, "abab", "a")': ("N", 1), 'Y = STRTOBOOL(" true ", Y)': ("Y", True),
    'U = 7\nY = STRTOINT("x", U)': ("U", 7), 'Y = STRTOBOOL("x", Y)': ("Y", False),
    'Y = STRTOSTRING("xy", B[])': ("B", "xy"),
    'Y = A[] == "ab"': ("Y", True), "N = A[1]": ("N", 97), 'Y = A[1] <> "a"': ("Y", False),
    "X = FRAND(1, 4)": ("X", 2.5), "X = COS(60)": ("X", 0.5), "X = TAN(45)": ("X", 1.0),
    "N = B_NOT 5": ("N", -6), "N = 6 B_AND 3": ("N", 2), "N = 6 B_OR 3": ("N", 7), "N = 6 B_EXOR 3": ("N", 5),
    "Y = (2 <= 2) AND (2 >= 2) AND NOT ((2 < 2) OR (2 > 2))": ("Y", True), "Y = TRUE EXOR TRUE": ("Y", False),
    "N = 'HFFFFFFFF'": ("N", -1), "N = 'H7FFFFFFF'": ("N", 2**31 - 1), "N = -2147483647 - 1": ("N", -(2**31)),
    "N = 7 / (-2)": ("N", -3), "N = (-7) / (-2)": ("N", 3), "X = 7 / 2.0": ("X", 3.5), "X = -0.5\nN = X": ("N", 0),
    "O = {K[2] 7, V 1}\nN = O.K[2]": ("N", 7), "O.K[3] = 4\nN = O.K[3]": ("N", 4), "O.V = 2\nX = O.V": ("X", 2.0),
    "GROUP = 5\nN = GROUP": ("N", 5), "ALL = 9\nN = ALL": ("N", 9),
    "X = $VEL_MA.CP": ("X", 2.0), "X = $VEL_MA.ORI2": ("X", 200.0), "X = $ACC_MA.CP": ("X", 2.3),
    "X = $ACC_MA.ORI1": ("X", 500.0), "N = $VEL_ACT_MA": ("N", 110), "N = $ACC_ACT_MA": ("N", 250),
    "X = $SOFTN_END[2]": ("X", -135.0), "X = $SOFTP_END[2]": ("X", 35.0), "Y = $TRUE": ("Y", True),
    "Y = $FALSE": ("Y", False), "Y = $IN[1025]": ("Y", True), "Y = $IN[1026]": ("Y", False),
    "X = PDAT_ACT.VEL": ("X", 100.0), "X = LDAT_ACT.VEL": ("X", 2.0), "X = LDEFAULT.ACC": ("X", 100.0),
    "X = PDEFAULT.APO_DIST": ("X", 100.0), "N = FDAT_ACT.TOOL_NO": ("N", 0), "N = FHOME.BASE_NO": ("N", 0),
    "X = XHOME.A2": ("X", -90.0), "X = $H_POS.A3": ("X", 90.0),
    "SWITCH G\nCASE 1, 2\nN = 1\nDEFAULT\nN = 2\nENDSWITCH": ("N", 2),
    "SWITCH G\nCASE 2, 3\nN = 1\nDEFAULT\nN = 2\nENDSWITCH": ("N", 1),
    "SWITCH G\nCASE 1\nN = 1\nENDSWITCH\nN = 7": ("N", 7),
    "U = 5\nFOR N = 3 TO 2\nU = 1\nENDFOR": ("U", 5), "FOR N = 2 TO 2\nU = N\nENDFOR": ("U", 2),
    "FOR N = 3 TO 1 STEP -1\nU = N\nENDFOR": ("U", 1), "FOR N = 1 TO 6 STEP 2\nU = N\nENDFOR": ("N", 5),
    # a function returns a value of its type
    "X = f(2.6) / 2\nEND\nDEFFCT INT f(V:IN)\nREAL V\nRETURN V\nENDFCT\nDEF g( )": ("X", 1.0),
}  # fmt: skip


@pytest.mark.parametrize("lines", VALUES)
def test_a_value_by_hand_keeps_its_type(arm, lines):
    name, expected = VALUES[lines]
    found = values_of(arm, lines.split("\n"), DATA)[0][name]
    found = text_of(found) if isinstance(expected, str) else found
    assert found == (pytest.approx(expected, abs=1e-12) if isinstance(expected, float) else expected)
    assert type(found) is type(expected)


REFUSED = {
    'W[4,] = "a"': "4:3: index 4 of W; 1 to 3", 'W[1,] = "sixsix"': "", "W[1,] = 3": "",
    'N = STRADD("abc", A[])': "4:1: a text function writes into what is no variable; a variable: T[]",
    "Q = {A1 1}\nP = FORWARD(Q, N)": "5:1: FORWARD needs A1 to A6; an E6AXIS with all six axes",
    "N = UNHEARD() + 1":
        "4:1: the function UNHEARD is not modelled; define it in the program, or give it a stub in the cell file",
    "N = 3E9": "4:1: 3000000000 is no INT; from -2147483648 to 2147483647", "N = STRLEN(G)": "", "N = B_NOT TRUE": "",
    "Y = NOT 3": "", "Y = 3 AND TRUE": "", "N = TRUE + 1": "", "Y = TRUE < FALSE": "", "Y = 3": "", "N = TRUE": "",
    "$BASE = {X 1.1E9, Y 0, Z 0, A 0, B 0, C 0}\nPTP {A1 0}": "5:1: X 1.1e+09 of $BASE; at most 1e+09 mm or deg",
    "G[1] = 3": "4:1: an index on what is no array; declare it with brackets", "G.X = 3": "",
    'A[] = "123456789"': "4:1: a text of 9 characters; at most 8", "N = W[1]": "4:1: the index 1 of W; 1 to 3, 1 to 5",
    "GROUP = TRUE": "", "BIG = 1": "4:1: the SIGNAL BIG; from 1 to 32 inputs or outputs",
    "MIX = 1": "4:1: the SIGNAL MIX; $IN[1] or $OUT[1] TO $OUT[8]", "IF 3 THEN\nENDIF": "",
    "BAS()": "4:1: BAS without a command; BAS(#INITMOV, 0)", "BAS(3)": "4:1: BAS without a command; BAS(#INITMOV, 0)",
    "BAS(#VEL_PTP, TRUE)": "4:1: the value of BAS is TRUE; a number",
    "X = SVEL_JOINT()": "4:1: SVEL_JOINT of nothing; a number",
    "BAS(#FOO, 1)": "4:1: BAS(#FOO) is not modelled; modelled: INITMOV, VEL_PTP, ACC_PTP, VEL_CP, ",
    "BAS(#TOOL, 5)": "4:1: TOOL_DATA[5] has no value; assign it, give it in the cell file under [tools], or lend it ",
    "BAS(#BASE, 6)": "4:1: BASE_DATA[6] has no value; assign it, give it in the cell file under [bases], or lend it ",
    "WAIT SEC 1.1E7": "4:1: WAIT SEC 1.1e+07; at most 1e+07 s", "LIN {A1 0}": "", "LIN 3": "", "PTP 3": "",
    "CIRC {X 1}, 3": "", "CIRC 3, {X 1}": "",
    "ASYPTP {E1 1}": "4:1: ASYPTP is not modelled; PTP, LIN, CIRC, SPTP, SLIN, SCIRC are",
    "BRAKE": "4:1: BRAKE outside an interrupt; in a subprogram that INTERRUPT DECL calls",
    "RESUME": "4:1: RESUME outside an interrupt; in a subprogram that INTERRUPT DECL calls", "GOTO nowhere": "",
    "TRIGGER WHEN DISTANCE=0.5 DELAY=0 DO $OUT[1]=TRUE": "4:1: DISTANCE = 0.5; 0 (the start) or 1 (the end)",
    "X = f()\nEND\nDEFFCT REAL f( )\nENDFCT\nDEF g( )": "4:1: f ended without RETURN; RETURN a value on every way",
    "X = SQRT(-1)": "4:1: SQRT of -1.0; not negative", "X = ACOS(2)": "4:1: ACOS of 2.0; from -1 to 1",
    "X = ATAN2(1)": "4:1: ATAN2 of 1.0; two numbers", "X = FRAND(1)": "4:1: FRAND of 1.0; the least and the most",
    "X = SIN(1, 2)": "4:1: SIN of 1.0, 2.0; one number", 'X = SIN("a")': "4:1: an argument of SIN is a; a number",
    "X = 1 / 0": "4:1: 1 / 0; test the divisor first", "N = 2147483647 + 1": "4:1: 2147483648 is beyond what INT holds",
    "X = 3E38 * 10": "4:1: 3e+39 is beyond what REAL holds",
    "N = -2147483647 - 2": "4:1: -2147483649 is beyond what INT holds",
}  # fmt: skip
"""Line, column and text; empty where the checks say it."""


@pytest.mark.parametrize("lines", REFUSED)
def test_what_has_no_value_is_refused_at_its_line(arm, lines):
    data = "\n".join(["DEFDAT a", *DATA, "ENDDAT", ""])
    with pytest.raises(ProgramError) as fault:
        run_program(program_of("BAS(#VEL_PTP, 100)", HOME, *lines.split("\n"), data=data), arm)
    assert str(fault.value).startswith(f"a.src:{REFUSED[lines]}")


def test_forward_and_inverse_undo_each_other_and_inverse_takes_the_solution_near_its_start(arm):
    data = ["DECL E6AXIS Q={A1 20,A2 -80,A3 95,A4 30,A5 -40,A6 50}", "DECL E6POS P", "DECL E6AXIS R,O",
            "DECL INT S1=-1", "DECL FRAME T,N"]  # fmt: skip
    lines = ["P = FORWARD(Q, S1)", "R = INVERSE(P, Q, S1)", "T = P : $NULLFRAME", "N = P : INV_POS(P)", "O = Q"]
    values, _ = values_of(
        arm, [*lines, "O.A4 = -140", "O.A5 = 30", "O.A6 = -120", "O = INVERSE(T, O, S1)", "T.X = 7"], data
    )
    axes = ("A1", "A2", "A3", "A4", "A5", "A6")
    assert (values["S1"], repr(values["T"].parts["X"])) == (0, "7.0")  # a component takes its type
    assert [values["R"].parts[x] for x in axes] == pytest.approx([20, -80, 95, 30, -40, 50], abs=1e-8)
    assert [values["O"].parts[x] for x in axes] == pytest.approx([20, -80, 95, -150, 40, -130], abs=1e-8)
    assert np.abs(pose_matrix(values["N"], "N") - np.eye(4)).max() < 1e-12


def test_a_motion_of_an_inline_form_takes_its_values_from_its_data(arm):
    data = [
        "DECL PDAT PP={VEL 100,ACC 50,APO_DIST 30,GEAR_JERK 40}",
        "DECL LDAT LL={VEL 2,ACC 50,APO_DIST 30,JERK_FAC 20,ORI_TYP #CONSTANT}",
        "DECL FDAT FF={TOOL_NO 3,BASE_NO 2,IPO_FRAME #BASE}", "DECL FRAME T,B,X,Y", "DECL CP V,A",
        "DECL REAL J,C,G,H,I",
        "DECL FDAT TT={TOOL_NO 2,BASE_NO 3,IPO_FRAME #TCP}", "DECL JERK_STRUC JJ", "DECL CONT K", "DECL LOAD L,U",
        "DECL IPO_MODE M,N", "DECL ORI_TYPE O,Z",
    ]  # fmt: skip
    lines = [
        "TOOL_DATA[3] = {X 1,Y 2,Z 3,A 0,B 0,C 0}", "BASE_DATA[2] = {X 4,Y 5,Z 6,A 0,B 0,C 0}", "T = STOOL2(FF)",
        "B = SBASE(FF.BASE_NO)", "V = SVEL_CP(0.3, , LL)", "A = SACC_CP(LL)", "J = SVEL_JOINT(130)",
        "C = SACC_JOINT(PP)", "G = SGEAR_JERK(PP)", "LOAD_DATA[2] = {M 7.0}", "JJ = SJERK(LL)", "K = SAPO(PP)",
        "L = SLOAD(1)", "U = SLOAD(2)", "M = SIPO_MODE(TT)", "N = SIPO_MODE(FF)", "X = STOOL2(TT)", "Y = SBASE(FF)",
        "O = SORI_TYP(LL)", "Z = SORI_TYP(PP)", "H = SACC_JOINT()", "I = SVEL_JOINT(0.5)",
    ]  # fmt: skip
    values, _ = values_of(arm, lines, data)
    assert (values["T"].parts["Z"], values["B"].parts["Z"]) == (3, 6)
    assert (values["V"].parts["CP"], values["A"].parts["CP"]) == (0.3, pytest.approx(2.3 / 2))
    assert [values[x] for x in "JCGHI"] == [100, 50, 40, 100, 1]
    assert values["A"].parts["ORI1"] == 500.0 / 2
    assert (values["JJ"].parts["CP"], values["JJ"].parts["AX"].parts["A6"], values["JJ"].parts["ORI"]) == (20, 20, 20)
    assert values["K"].parts == {"CDIS": 30, "CPTP": 30, "CORI": 30, "CVEL": 100}
    assert [values[x].parts["M"] for x in "LU"] == [-1, 7]
    assert [values[x].name for x in "MNOZ"] == ["TCP", "BASE", "CONSTANT", "VAR"]
    assert (values["X"].parts["Z"], values["Y"].parts["Z"]) == (6, 6)  # a fixed tool stands in the table of bases
    # a real `$config.dat` declares tools: the controller's own table must not be asked then
    data = ["DECL FRAME TOOL_DATA[2]", "TOOL_DATA[2]={X 0,Y 0,Z 7,A 0,B 0,C 0}", "DECL FRAME T"]
    values, _ = values_of(arm, [HOME, "BAS(#TOOL, 2)", "T = $TOOL"], data)
    assert values["T"].parts["Z"] == 7
    assert constant_value("{X 1, S 'B110'}").parts == {"X": 1, "S": 6}
