"""The KR 30 HA report: every printed digit judged, the right solution beside it, every matrix entry by entry."""

import numpy as np
import pytest
import sympy as sp

import lwr_dyn
from lwr_dyn.checks.datasheet.envelope import working_envelope
from lwr_dyn.krl.robot.kuka_pose import pose_of_matrix
from lwr_dyn.reproduction.kr30ha.matrices import paper_matrices
from lwr_dyn.reproduction.kr30ha.points import paper_points
from lwr_dyn.reproduction.kr30ha.study import envelope_table, matrix_tables, point_tables


@pytest.fixture(scope="module")
def points():
    return paper_points()


@pytest.fixture(scope="module")
def matrices():
    return paper_matrices()


def test_every_digit_is_reproduced_or_has_its_erratum(points):
    assert points.holds
    differing = {(c.point, c.name): (c.erratum, c.value) for c in points.cells if not c.reproduced}
    given = {  # what the paper's own formulas give
        ("point_1", "theta_3"): ("theta3-p1", -88.774),
        ("point_1", "theta_3 (Table 5)"): ("theta3-p1", -88.774),
        ("point_2", "theta_1"): ("theta1-p2", -103.0545),
        ("point_2", "theta_1 (Table 5)"): ("theta1-p2", -103.0545),
        ("home", "phi"): ("phi-home", 39.493),
        ("home", "theta_2 (first)"): ("theta2-home", 90.0),
        ("home", "theta_2 (Table 5)"): ("theta2-home", 90.0),
    }
    assert differing == {cell: (erratum, pytest.approx(x, abs=5e-4)) for cell, (erratum, x) in given.items()}
    assert len(points.cells) == 29


def test_the_right_points(points):
    arm = lwr_dyn.load("kr30ha")
    first, second, home = points.right
    assert np.degrees(first.q) == pytest.approx([85.43, 29.91, -106.04, 0, -13.87, -85.43], abs=0.005)
    assert (first.target.s, first.target.t) == (4, 52)
    assert (second.target.s, second.target.t) == (4, 52)
    assert (home.target.s, home.target.t) == (2, 2)
    for point, xyz in ((first, (91, -1139, 1392)), (second, (91, -1117, 1447))):
        pose = pose_of_matrix(lwr_dyn.forward_kinematics(arm, point.q))
        stated = (pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg)
        assert stated == pytest.approx((*xyz, 0, 0, 0), abs=1e-9)
        assert point.wrist_mm == pytest.approx(np.array(xyz) - [0, 0, 170])
        assert (point.inside_limits, point.solutions) == (6, 12)
    assert second.travel_deg < 10.0


def test_the_papers_angles_miss(points):
    first, second, home = points.misses
    assert (first.wrist_miss_mm, first.flange_miss_mm) == pytest.approx((544.9, 676.8), abs=0.1)
    assert (second.wrist_miss_mm, second.flange_miss_mm) == pytest.approx((544.8, 678.7), abs=0.1)
    assert (home.wrist_miss_mm, home.flange_miss_mm) == pytest.approx((0.0, 170.0), abs=1e-9)


def test_symbolic_matrices(matrices):
    rows = {v.name: (v.is_row, v.erratum, len(v.differing)) for v in matrices.symbolic}
    assert rows == {
        "A1": ("alpha = -90 deg, theta = q1", "symbolic-signs", 3),
        "A2": ("alpha = 0 deg, theta = -q2 +90 deg", "symbolic-a2", 3),
        "A3": ("alpha = -90 deg, theta = q3", "symbolic-signs", 3),
        "A4": ("alpha = 90 deg, theta = q4", "symbolic-signs", 3),
        "A5": ("alpha = -90 deg, theta = q5", "symbolic-signs", 3),
        "A6": ("alpha = 0 deg, theta = q6 +180 deg", "table2-half-turn", 4),
    }


@pytest.mark.slow
def test_numeric_matrices_follow_the_table_but_for_the_half_turn(matrices):
    for group in (matrices.numeric, matrices.composite):
        assert {v.name for v in group if not v.same} == {group[-1].name}
        assert group[-1].erratum == "table2-half-turn"
    assert all(v.same for v in matrices.products)
    assert matrices.holds


def test_the_stated_order_of_composition_is_not_equation_1():
    q, a, d, alpha = sp.symbols("q a d alpha")
    c, s, ca, sa = sp.cos(q), sp.sin(q), sp.cos(alpha), sp.sin(alpha)
    turn = sp.Matrix([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    twist = sp.Matrix([[1, 0, 0, 0], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1]])
    shift = sp.eye(4) + sp.Matrix(4, 4, lambda i, j: (a if i == 0 else d if i == 2 else 0) if j == 3 else 0)
    equation_1 = sp.Matrix([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
    assert sp.simplify(turn * shift * twist - equation_1) == sp.zeros(4, 4)
    assert sp.simplify(shift * twist * turn - equation_1) != sp.zeros(4, 4)


def test_the_tables_of_points_show_what_is_printed_what_is_right_and_by_how_much_it_misses(points):
    cells, right, misses = point_tables(points)
    assert cells.cells[2] == ("point_1", "theta_3", "-88.78", "-88.7743", "erratum theta3-p1")
    assert cells.cells[3] == ("point_1", "alpha", "26.29", "26.2882", "reproduced")
    assert list(right.cells) == [
        ("point_1", "S 4 T 52", "85.43 29.91 -106.04 0.00 -13.87 -85.43", "500.68", "6 of 12", "91.0 -1139.0 1222.0"),
        ("point_2", "S 4 T 52", "85.34 25.86 -105.43 0.00 -10.43 -85.34", "8.29", "6 of 12", "91.0 -1117.0 1277.0"),
        ("home", "S 2 T 2", "0.00 -90.00 90.00 0.00 0.00 0.00", "492.40", "6 of 6", "1170.0 0.0 1810.0"),
    ]
    assert misses.cells[0] == (
        "point_1", "A = -theta", "-336.0 -1477.6 1393.1", "544.9", "-370.5 -1629.6 1325.3", "676.8",
    )  # fmt: skip
    assert misses.cells[2][1:] == ("A = theta", "1170.0 0.0 1810.0", "0.0", "1340.0 0.0 1810.0", "170.0")


def test_a_matrix_is_a_row_with_what_differs(matrices):
    groups = matrix_tables(matrices)
    assert [len(table.rows) for table in groups] == [6, 6, 5, 5]
    wrong = "(1,1) sin(q2) | -sin(q2); (1,4) a2*sin(q2) | -a2*sin(q2); (2,2) sin(q2) | -sin(q2)"
    verdict = "erratum symbolic-a2; it is alpha = 0 deg, theta = -q2 +90 deg"
    assert groups[0].rows[1] == ("A2", "13 of 16", wrong, verdict)
    assert groups[1].rows[0] == ("T1", "16 of 16", "-", "right")
    assert groups[3].rows[4] == ("T06", "14 of 16", "(2,2) -1 | 1; (3,1) 1 | -1", "erratum table2-half-turn")


def test_the_envelope_stands_beside_the_data_sheet():
    arm = lwr_dyn.load("kr30ha")
    table = envelope_table(working_envelope(arm), arm)
    assert [row[1:] for row in table.rows] == [
        ("2032.72", "2033"), ("27.2428", "27.24"), ("1083.76", "-"), ("28.3425", "-"),
    ]  # fmt: skip
