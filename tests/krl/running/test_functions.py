"""Functions of the controller and of the inline forms, texts, rows of arrays and VARSTATE: values by hand."""

import math

import numpy as np
import pytest

from lwr_dyn.krl.running.cell import constant_value
from lwr_dyn.krl.running.program_run import ProgramError, run_program
from lwr_dyn.krl.running.values import pose_matrix, text_of
from tests.krl.short_programs import HOME, program_of, values_of

DATA = ['DECL CHAR A[8]="ab"', 'DECL CHAR B[4]="CD"', "DECL INT N", "DECL BOOL Y", "DECL REAL X", "DECL INT G=3",
        "DECL CHAR W[3,5]", "DECL CHAR NAMES[2,4]", 'NAMES[1,]="ab"', "DECL INT U"]  # fmt: skip
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


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('W[4,] = "a"', r"index 4 of W; 1 to 3"),
        ('W[1,] = "sixsix"', "is given 6 values; up to 5"),
        ("W[1,] = 3", "is INT|given 3"),
    ],
)
def test_wrong_rows_are_refused(arm, line, message):
    data = "\n".join(["DEFDAT a", *DATA, "ENDDAT", ""])
    with pytest.raises(ProgramError, match=message):
        run_program(program_of(line, HOME, data=data), arm)


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
        "DECL PDAT PP={VEL 100,ACC 50,APO_DIST 30,GEAR_JERK 40}", "DECL LDAT LL={VEL 2,ACC 50,APO_DIST 30}",
        "DECL FDAT FF={TOOL_NO 3,BASE_NO 2,IPO_FRAME #BASE}", "DECL FRAME T,B", "DECL CP V,A", "DECL REAL J,C,G",
    ]  # fmt: skip
    lines = [
        "TOOL_DATA[3] = {X 1,Y 2,Z 3,A 0,B 0,C 0}", "BASE_DATA[2] = {X 4,Y 5,Z 6,A 0,B 0,C 0}", "T = STOOL2(FF)",
        "B = SBASE(FF.BASE_NO)", "V = SVEL_CP(0.3, , LL)", "A = SACC_CP(LL)", "J = SVEL_JOINT(130)",
        "C = SACC_JOINT(PP)", "G = SGEAR_JERK(PP)",
    ]  # fmt: skip
    values, _ = values_of(arm, lines, data)
    assert (values["T"].parts["Z"], values["B"].parts["Z"]) == (3, 6)
    assert (values["V"].parts["CP"], values["A"].parts["CP"]) == (0.3, pytest.approx(2.3 / 2))
    assert (values["J"], values["C"], values["G"]) == (100, 50, 40)
    # a real `$config.dat` declares tools: the controller's own table must not be asked then
    data = ["DECL FRAME TOOL_DATA[2]", "TOOL_DATA[2]={X 0,Y 0,Z 7,A 0,B 0,C 0}", "DECL FRAME T"]
    values, _ = values_of(arm, [HOME, "BAS(#TOOL, 2)", "T = $TOOL"], data)
    assert values["T"].parts["Z"] == 7
    assert constant_value("{X 1, S 'B110'}").parts == {"X": 1, "S": 6}
