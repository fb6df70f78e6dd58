"""Functions of the controller and of the inline forms: values by hand."""

import math

import numpy as np
import pytest

from lwr_dyn.krl.running.cell import constant_value
from lwr_dyn.krl.running.values import pose_matrix, text_of
from tests.krl.short_programs import HOME, values_of


@pytest.mark.parametrize(
    ("expression", "value"),
    [("SIN(30)", 0.5), ("ACOS(-1)", 180.0), ("ATAN2(1, -1)", 135.0), ("SQRT(2)", math.sqrt(2)), ("ABS(-3)", 3)],
)
def test_mathematics_is_in_degrees(arm, expression, value):
    values, _ = values_of(arm, [f"X = {expression}"], ["DECL REAL X"])
    assert values["X"] == pytest.approx(value, abs=1e-12)


def test_abs_keeps_the_type_of_a_whole_number(arm):
    values, _ = values_of(arm, ["N = ABS(-7) / 2"], ["DECL INT N"])
    assert values["N"] == 3


def test_forward_and_inverse_undo_each_other(arm):
    data = ["DECL E6AXIS Q={A1 20,A2 -80,A3 95,A4 30,A5 -40,A6 50}", "DECL E6POS P", "DECL E6AXIS R", "DECL INT S1=-1"]
    values, _ = values_of(arm, ["P = FORWARD(Q, S1)", "R = INVERSE(P, Q, S1)"], data)
    assert values["S1"] == 0
    for axis in ("A1", "A2", "A3", "A4", "A5", "A6"):
        assert values["R"].parts[axis] == pytest.approx(values["Q"].parts[axis], abs=1e-8)


def test_inverse_takes_the_solution_near_its_start(arm):
    data = ["DECL E6AXIS Q={A1 20,A2 -80,A3 95,A4 30,A5 -40,A6 50}", "DECL E6POS P", "DECL E6AXIS R", "DECL INT S1=-1"]
    lines = [
        "P = FORWARD(Q, S1)",
        "T = P : $NULLFRAME",
        "Q.A4 = -140",
        "Q.A5 = 30",
        "Q.A6 = -120",
        "R = INVERSE(T, Q, S1)",
    ]
    values, _ = values_of(arm, lines, [*data, "DECL FRAME T"])
    wrist = [values["R"].parts[axis] for axis in ("A4", "A5", "A6")]
    assert wrist == pytest.approx([-150, 40, -130], abs=1e-8)


def test_the_inverse_of_a_pose_undoes_it(arm):
    values, _ = values_of(arm, ["N = P : INV_POS(P)"], ["DECL FRAME P={X 1,Y 2,Z 3,A 40,B 50,C 60}", "DECL FRAME N"])
    assert np.abs(pose_matrix(values["N"], "N") - np.eye(4)).max() < 1e-12


TEXT = ['DECL CHAR A[8]="ab"', 'DECL CHAR B[4]="CD"', "DECL INT N", "DECL BOOL Y", "DECL REAL X"]


@pytest.mark.parametrize(
    ("line", "name", "value"),
    [
        ("N = STRLEN(A[])", "N", 2),
        ("N = STRDECLLEN(A[])", "N", 8),
        ("N = STRADD(A[], B[])", "A", "abCD"),
        ('Y = STRCOPY(B[], "xyz")', "B", "xyz"),
        ('Y = STRCOPY(B[], "longer")', "Y", False),
        ("Y = STRCLEAR(A[])", "A", ""),
        ('Y = STRCOMP(A[], "AB", #NOT_CASE_SENS)', "Y", True),
        ('Y = STRCOMP(A[], "AB", #CASE_SENS)', "Y", False),
        ('N = STRFIND(1, A[], "b", #CASE_SENS)', "N", 2),
        ('N = STRFIND(1, A[], "B", #CASE_SENS)', "N", 0),
        ('Y = STRTOINT("-12", N)', "N", -12),
        ('Y = STRTOREAL("1.5e2", X)', "X", 150.0),
        ('Y = STRTOREAL("nan", X)', "Y", False),
    ],
)
def test_text(arm, line, name, value):
    values, _ = values_of(arm, [line], TEXT)
    found = text_of(values[name]) if isinstance(value, str) else values[name]
    assert found == value
    assert type(found) is type(value)


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


def test_bas_finds_tools_and_motion_data_that_a_file_declares(arm):
    """A real `$config.dat` declares them; the controller's own table must not be asked then."""
    data = ["DECL FRAME TOOL_DATA[2]", "TOOL_DATA[2]={X 0,Y 0,Z 7,A 0,B 0,C 0}", "DECL FRAME T"]
    values, _ = values_of(arm, [HOME, "BAS(#TOOL, 2)", "T = $TOOL"], data)
    assert values["T"].parts["Z"] == 7


def test_constants_are_those_of_the_language():
    assert constant_value("{X 1, S 'B110'}").parts == {"X": 1, "S": 6}
