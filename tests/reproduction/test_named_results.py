"""Quantities and expressions of a user's own paper: by hand for two links, by other roads for seven."""

import math

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.reproduction.named_results import QUANTITIES, formula_of
from tests.reproduction.two_links import TEXT

A1, A2, C1, C2, M1, M2, I1, I2, G = 0.5, 0.4, 0.25, 0.2, 2.0, 1.5, 0.05, 0.02, 9.81


@pytest.fixture(scope="module")
def paper():
    return parse_paper(TEXT, "two_links.toml")


def value(text, paper, **state):
    arrays = {name: np.array(x, dtype=np.float64) for name, x in state.items()}
    return formula_of(text, paper).value(paper, lambda: arm_from_paper(paper), arrays)


@pytest.mark.parametrize("q", [(0.0, 0.0), (0.3, -1.2), (-2.0, 0.7)])
def test_two_links_by_hand(paper, q):
    """B, g and the flange of the textbook's planar arm; C2 from the second joint's axis."""
    q1, q2 = q
    c2 = math.cos(q2)
    b22 = M2 * C2**2 + I2
    b12 = M2 * A1 * C2 * c2 + b22
    b11 = M1 * C1**2 + I1 + M2 * A1**2 + 2 * M2 * A1 * C2 * c2 + b22
    B = np.array([[b11, b12], [b12, b22]])
    g2 = M2 * G * C2 * math.cos(q1 + q2)
    g1 = (M1 * C1 + M2 * A1) * G * math.cos(q1) + g2
    np.testing.assert_allclose(value("mass_matrix", paper, q=q), B, rtol=1e-12)
    np.testing.assert_allclose(value("gravity", paper, q=q), [g1, g2], rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(value("eigenvalue", paper, q=q).prod(), b11 * b22 - b12**2, rtol=1e-12)
    x, y = A1 * math.cos(q1) + A2 * math.cos(q1 + q2), A1 * math.sin(q1) + A2 * math.sin(q1 + q2)
    np.testing.assert_allclose(value("pose", paper, q=q), [x, y, 0.0], atol=1e-15)
    np.testing.assert_allclose(value("jacobian", paper, q=q)[[0, 1, 5], 0], [-y, x, 1.0], atol=1e-15)
    h = -M2 * A1 * C2 * math.sin(q2)
    dq = (0.7, -0.4)
    bias = [h * (2 * dq[0] * dq[1] + dq[1] ** 2) + g1, -h * dq[0] ** 2 + g2]
    np.testing.assert_allclose(value("bias_torque", paper, q=q, dq=dq), bias, rtol=1e-12)
    ddq = (1.5, 2.5)
    np.testing.assert_allclose(value("inverse_dynamics", paper, q=q, dq=dq, ddq=ddq), B @ ddq + bias, rtol=1e-12)
    C = value("coriolis_matrix", paper, q=q, dq=dq)
    np.testing.assert_allclose(C @ dq, np.array(bias) - [g1, g2], rtol=1e-10, atol=1e-14)
    assert value("mass_matrix[1,2]", paper, q=q) == pytest.approx(b12, rel=1e-12)
    assert value("eigenvalue[1]", paper, q=q) == pytest.approx(np.linalg.eigvalsh(B)[0], rel=1e-12)


def test_the_largest_inertia_is_that_of_the_stretched_arm(paper):
    """B_11 is largest where q2 = 0 is within the limits, which here are unknown: a whole turn."""
    stretched = value("mass_matrix[1,1]", paper, q=(0.0, 0.0))
    assert value("largest_inertia[1]", paper) == pytest.approx(stretched, rel=1e-9)
    assert value("largest_inertia[2]", paper) == pytest.approx(M2 * C2**2 + I2, rel=1e-9)


def test_expressions_take_si_values_of_cells_and_quantities(paper):
    assert value("inertial.mass[1] + inertial.mass[2]", paper) == pytest.approx(M1 + M2, rel=1e-15)
    assert value("total_mass", paper) == pytest.approx(M1 + M2, rel=1e-15)
    assert value("inertial.com[2,1] / dh.a[2]", paper) == pytest.approx(-0.5, rel=1e-15)
    assert value("base.gravity[2]", paper) == -G
    assert value("inertial.inertia[1,3,3]", paper) == I1
    assert value("2 * pi", paper) == 2 * math.pi
    moment = "gravity[1] - (inertial.mass[1]*0.25 + inertial.mass[2]*dh.a[1]) * 9.81 * cos(pi/3) - gravity[2]"
    assert value(moment, paper, q=(math.pi / 3, 0.4)) == pytest.approx(0.0, abs=1e-14)


def test_quantities_are_those_of_the_other_engine():
    """Pinocchio through the front door, at a pose of an arm with seven joints."""
    paper = open_paper("lwr4plus")
    arm = arm_from_paper(paper)
    other = lwr_dyn.dynamics_of(arm, engine="pinocchio")
    rng = np.random.default_rng(5)
    q, dq, ddq = rng.uniform(-1, 1, (3, 7))
    for name, known in {
        "mass_matrix": other.mass_matrix(q), "gravity": other.gravity_vector(q),
        "bias_torque": other.bias_torque(q, dq),
        "coriolis_matrix": other.coriolis_matrix(q, dq), "inverse_dynamics": other.inverse_dynamics(q, dq, ddq),
        "pose": lwr_dyn.forward_kinematics(arm, q)[:3, 3], "rotation": lwr_dyn.forward_kinematics(arm, q)[:3, :3],
        "armature": arm.armature,
    }.items():  # fmt: skip
        np.testing.assert_allclose(value(name, paper, q=q, dq=dq, ddq=ddq), known, rtol=1e-10, atol=1e-12, err_msg=name)


def test_shapes_and_powers_belong_together():
    """Powers of m, kg and s have the shape of the value; first entry: joint 1 turns, last entry: joint 2 slides."""
    sliding = TEXT.replace('"revolute"]', '"prismatic"]').replace(
        '[40, 10], unit = "N m"', '[40, 10], unit = ["N m", "N"]'
    )
    paper = parse_paper(sliding, "two_links.toml")
    turning = np.array([1.0, 0.0])
    units = {  # turning, sliding
        "N m, N": ([2, 1, -2], [1, 1, -2]), "kg m^2, kg": ([2, 1, 0], [0, 1, 0]), "rad, m": ([0, 0, 0], [1, 0, 0]),
        "kg m^2/s, kg/s": ([2, 1, -1], [0, 1, -1]), "m": ([1, 0, 0],) * 2, "kg": ([0, 1, 0],) * 2,
        "s": ([0, 0, 1],) * 2, "": ([0, 0, 0],) * 2, "rad/s, m/s": ([0, 0, -1], [1, 0, -1]),
        "m, 1/m": ([1, 0, 0], [-1, 0, 0]),
    }  # fmt: skip
    unit_of = dict.fromkeys(QUANTITIES, "N m, N") | dict.fromkeys(("pose", "tip_rms", "tip_max"), "m")
    unit_of |= dict.fromkeys(("mass_matrix", "eigenvalue", "largest_inertia", "armature"), "kg m^2, kg")
    unit_of |= dict.fromkeys(("position_rms", "position_mean", "position_max", "limit_margin"), "rad, m")
    unit_of |= {"coriolis_matrix": "kg m^2/s, kg/s", "total_mass": "kg", "saturated_s": "s", "rotation": ""}
    unit_of |= {"peak_speed": "rad/s, m/s", "jacobian": "m, 1/m"}
    for name, quantity in QUANTITIES.items():
        term = formula_of(name, paper).term
        powers = term.powers(turning)
        assert powers.shape == (*term.shape(2), 3), name
        assert tuple(powers.reshape(-1, 3)[[0, -1]].tolist()) == units[unit_of[name]], name
        assert quantity.about
    assert formula_of("mass_matrix[1,2]", paper).term.powers(turning).tolist() == [1, 1, 0]
    assert formula_of("coriolis_matrix[2,1]", paper).term.powers(turning).tolist() == [1, 1, -1]
    assert formula_of("gravity[2]", paper).term.powers(turning).tolist() == [1, 1, -2]
    assert formula_of("jacobian[1,2]", paper).term.powers(turning).tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("mass_matrx[1,1]", "no quantity or column 'mass_matrx' (did you mean mass_matrix?)"),
        ("limits.velocity[1]", "no quantity or column 'limits.velocity'"),
        ("mass_matrix[1,3]", "mass_matrix[1 to 2,1 to 2], counted from 1"),
        ("mass_matrix[0,1]", "mass_matrix[1 to 2,1 to 2], counted from 1"),
        ("gravity[1,1]", "gravity[1 to 2], counted from 1"),
        ("total_mass[1]", "total_mass, one number"),
        ("gravity / 2", "gravity, 2 numbers; allowed: one of them: gravity[1]"),
        ("mass_matrix[True,1]", "'mass_matrix[True,1]'; allowed: a quantity"),
        ("mass_matrix[1][1]", "allowed: a quantity"),
        ("__import__('os')", "allowed: a quantity"),
        ("gravity[1].real", "no quantity or column"),
        ("", "allowed: a quantity"),
        ("1+" * 150 + "1", "at most 200 characters"),
    ],
)
def test_what_is_no_formula(text, words, paper):
    with pytest.raises(OptionError) as fault:
        formula_of(text, paper)
    assert words in str(fault.value)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize("text", ["1/0", "gravity[1] / dh.d[1]", "sqrt(-1)", "log(0)", "2^99", "sqrt(1,2)"])
def test_expressions_without_a_value(text, paper):
    formula = formula_of(text, paper)
    with pytest.raises(OptionError, match="has no value"):
        formula.value(paper, lambda: arm_from_paper(paper), {"q": np.zeros(2)})


def test_a_number_that_the_file_does_not_know():
    paper = parse_paper(TEXT.replace("values = [40, 10]", 'values = [40, "unknown"]'), "two_links.toml")
    with pytest.raises(OptionError, match=r"limits.effort\[2\] is unknown"):
        value("gravity[1] / limits.effort[2]", paper, q=(0, 0))
