"""The KR 30 HA report: every printed digit judged, the right solution beside it, every matrix entry by entry."""

import numpy as np
import pytest
import sympy as sp

import lwr_dyn
from lwr_dyn.krl.robot.kuka_pose import pose_of_matrix
from lwr_dyn.reproduction.kr30ha.matrices import paper_matrices
from lwr_dyn.reproduction.kr30ha.points import paper_points


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
