"""Equations in letters: every entry of B, C and g against the engine, as written by hand, in the command."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from matplotlib.mathtext import MathTextParser

import lwr_dyn
from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.dynamics.symbolic import equation_forms as forms
from lwr_dyn.dynamics.symbolic import link_motion
from lwr_dyn.dynamics.symbolic.arm_equations import equations_of_motion
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.model.chain import JointKind, link_frames
from lwr_dyn.model.spatial import Pose
from tests.dynamics.symbolic.evaluated import evaluated, state_letters
from tests.random_arms import random_arm
from tests.simulation.sample_runs import one_joint

AGREES = 1e-11


@pytest.mark.parametrize("joints", ["PR", pytest.param("RR", marks=pytest.mark.slow)])
def test_every_entry_is_the_engines(joints):
    arm = random_arm(2, joints)
    entries, dynamics = forms.symbolic_entries(arm.chain), lwr_dyn.dynamics_of(arm)
    q, dq = np.random.default_rng(5).uniform(-1, 1, (2, arm.n))
    known = {"B": dynamics.mass_matrix(q), "C": dynamics.coriolis_matrix(q, dq), "g": dynamics.gravity_vector(q)}
    letters = entries.values | state_letters(q, dq)
    for name, (letter, i, j) in forms.named_entries(arm.n).items():
        expected = known[letter][i] if letter == "g" else known[letter][i, j]
        assert abs(evaluated(entries.text(letter, i, j), letters) - expected) < AGREES, name


@pytest.mark.slow
def test_a_paper_names_its_lengths():
    assert forms.entry_text("lwr4plus", "B_66").endswith("m7*(c7z + d7)^2")


def test_an_entry_that_does_not_exist_and_an_arm_without_masses():
    for entry in ("B_88", "tau_1", "B66", ""):
        with pytest.raises(OptionError, match="B_23"):
            forms.entry_text("lwr4plus", entry)
    with pytest.raises(MissingDataError):
        forms.entry_text("lwr4", "B_11")


@pytest.fixture(scope="module")
def slider():
    """A mass on a slide that a hinge turns: its equations are those of a page."""
    hinge, slide = one_joint(JointKind.REVOLUTE, mass=2.0), one_joint(mass=3.0)
    links = (
        replace(hinge.chain.links[0], before=Pose.identity()),
        replace(slide.chain.links[0], joint="joint_2", link="link_2"),
    )
    chain = replace(hinge.chain, links=links, gravity=np.array([0.0, 0.0, -9.81]))
    arm = replace(hinge, chain=chain, limits=hinge.limits * 2)
    return equations_of_motion(arm, ("joint_1", "joint_2"))


WRITTEN = """\
v_C2.x = dq1*(-c2x*sin(q1) - c2y*cos(q1))
v_C2.y = dq1*(c2x*cos(q1) - c2y*sin(q1))
v_C2.z = dq2
omega_2.z = dq1
a_C2.x = ddq1*(-c2x*sin(q1) - c2y*cos(q1)) + dq1^2*(-c2x*cos(q1) + c2y*sin(q1))
a_C2.y = ddq1*(c2x*cos(q1) - c2y*sin(q1)) + dq1^2*(-c2x*sin(q1) - c2y*cos(q1))
a_C2.z = ddq2
domega_2.z = ddq1
K_1 = dq1^2*(I1zz/2 + m1*(c1x^2 + c1y^2)/2)
K_2 = dq1^2*(I2zz/2 + m2*(c2x^2 + c2y^2)/2) + dq2^2*m2/2
U_1 = c1z*g0*m1
U_2 = g0*m2*(c2z + q2)
B_11 = I1zz + I2zz + m1*(c1x^2 + c1y^2) + m2*(c2x^2 + c2y^2)
B_22 = m2
g_2 = g0*m2
tau_1 = ddq1*(I1zz + I2zz + m1*(c1x^2 + c1y^2) + m2*(c2x^2 + c2y^2))
tau_2 = ddq2*m2 + g0*m2""".splitlines()
"""By hand: a cylinder coordinate; what is not listed of link 2, B, C and g is 0."""


def test_equations_are_written_as_by_hand(slider):
    lines = forms.equations_text(slider.equations).splitlines()
    nothing = [line for line in lines if line.endswith("= 0")]
    assert [line for line in lines if line not in nothing and "C1" not in line and "_1.z" not in line] == WRITTEN
    assert "v_C1.x = dq1*(-c1x*sin(q1) - c1y*cos(q1))" in lines
    assert {"B_12 = 0", "B_21 = 0", "g_1 = 0", "C_12 = 0", "v_C1.z = 0", "omega_1.y = 0"} <= set(nothing)
    assert len(lines) == 2 * 12 + 4 + 4 + 4 + 2 + 2
    assert forms.equations_text(slider.equations, motions=False).splitlines() == lines[24:]
    latex = forms.equations_latex(slider.equations, motions=False)
    assert latex.startswith("\\documentclass{article}")
    assert latex.count("align*") == 2 * 16
    assert (
        "K_{2} &= \\dot{q}_{1}^{2} "
        "\\left(\\frac{I_{2,zz}}{2} + \\frac{m_{2} \\left(c_{2,x}^{2} + c_{2,y}^{2}\\right)}{2}"
        "\\right) \\\\\n&\\quad + \\frac{\\dot{q}_{2}^{2} m_{2}}{2}\n"
    ) in latex
    assert "\\tau_{2} &= \\ddot{q}_{2} m_{2} \\\\\n&\\quad + g_{0} m_{2}\n" in latex
    whole = forms.equations_latex(slider.equations)
    assert r"\dot{\omega}_{2,z} &= \ddot{q}_{1}" in whole
    assert r"v_{C2,z} &= \dot{q}_{2}" in whole
    parser, end = MathTextParser("path"), chr(92) * 2
    rows = [line.replace("&=", "=").replace("&", " ").removesuffix(end) for line in whole.splitlines() if "&" in line]
    assert len(rows) > 40
    for row in rows:
        parser.parse(f"${row}$")


def test_compiled_equations_are_the_engine_of_their_arm(slider):
    made = forms.compile_equations(slider.equations)
    ours, other = made.at({**slider.values, "unknown": 1.0}), lwr_dyn.dynamics_of(slider.arm, "newton-euler")
    q, dq, ddq = np.random.default_rng(3).uniform(-1.0, 1.0, (3, 5, 2))
    for name, state in (
        ("mass_matrix", (q,)), ("coriolis_matrix", (q, dq)), ("gravity_vector", (q,)), ("bias_torque", (q, dq)),
        ("inverse_dynamics", (q, dq, ddq)), ("forward_dynamics", (q, dq, ddq)),
    ):  # fmt: skip
        np.testing.assert_allclose(getattr(ours, name)(*state), getattr(other, name)(*state), atol=AGREES, err_msg=name)
    one = ours.mass_matrix(q[0])
    assert one.shape == (2, 2)
    h = 1e-6
    slopes = [(ours.potential_energy(q[0] + d) - ours.potential_energy(q[0] - d)) / (2 * h) for d in h * np.eye(2)]
    np.testing.assert_allclose(slopes, ours.gravity_vector(q[0]), atol=1e-7)
    lost = dict(slider.values)
    name = slider.equations.parameters[0].name
    del lost[name]
    with pytest.raises(OptionError, match=f"values: none for {name}; allowed: a number for each of {name}"):
        made.at(lost)


def test_names_beyond_nine_joints_stay_apart():
    assert len(forms.named_entries(11)) == 2 * 121 + 11
    assert forms.named_entries(11)["B_1,11"] == ("B", 0, 10)


def test_the_shortest_form_counts_sines_for_cosines_and_double_angles():
    a, b, q = sp.symbols("a b q1")
    s, c = sp.sin(q), sp.cos(q)
    short = {a * c**2 + a * s**2 + b * s**2 - a: b * s**2, a * c**2 - a: -a * s**2, 2 * a * s * c: a * sp.sin(2 * q),
             c**2 - s**2: sp.cos(2 * q), a * c**3 - a * c: -a * s**2 * c}  # fmt: skip
    assert {long: link_motion._shortest(long) for long in short} == short


TWO_LINKS = """\
A1 =
[cos(q1)  0  sin(q1)   0 ]
[                        ]
[sin(q1)  0  -cos(q1)  0 ]
[                        ]
[   0     1     0      d1]
[                        ]
[   0     0     0      1 ]
A2 =
[cos(q2)  -sin(q2)  0  0]
[                       ]
[sin(q2)  cos(q2)   0  0]
[                       ]
[   0        0      1  0]
[                       ]
[   0        0      0  1]
origin of frame 2 by full product: 4 products, 0 sums
origin of frame 2 by vector route: 0 products, 0 sums
  x = 0
  y = 0
  z = d1"""
"""By hand: axis 2 across axis 1 at the height d1."""


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_the_product_of_the_matrices_is_the_pose_of_the_last_frame(convention):
    """Also of a sliding joint, and of joints that turn and slide against their DH axes."""
    sign = "sign = { values = [{}1, {}1, 1]"
    text = template("x.toml", "x", "RPR", convention).replace(f"# {sign.replace('{}', '')}", sign.replace("{}", "-"))
    paper, q = parse_paper(text, "x.toml"), np.array([0.4, -0.3, 0.7])
    known = link_motion.length_values(paper) | {f"q{i + 1}": x for i, x in enumerate(q)}
    product = np.eye(4)
    for matrix in link_motion.dh_matrices(paper):
        product = product @ np.array(matrix.subs(known), dtype=float)
    assert paper.columns["dh.sign"].values == (-1.0, -1.0, 1.0)
    *_, last, _ = link_frames(arm_from_paper(paper).chain, q)
    np.testing.assert_allclose(product, last, rtol=0, atol=1e-12)


def test_symbols_print(lwr_dyn_command):
    text = template("two.toml", "two", "RR")
    assert link_motion.dh_matrices_text(parse_paper(text, "two.toml")) == TWO_LINKS
    bent = text.replace(
        "[flange]", '[dh.beta]\nvalues = [0, 0.1]\nunit = "rad"\nwhere = "x"\nkind = "assumed"\n[flange]'
    )
    with pytest.raises(OptionError, match=r"DH matrices of two.toml: dh.beta; allowed: a DH table without it"):
        link_motion.dh_matrices_text(parse_paper(bent, "two.toml"))
    lines = lwr_dyn_command("fk", "lwr4", "--symbolic")[1].splitlines()
    costs = ["full product: 68 products, 31 sums", "vector route: 12 products, 5 sums"]
    (at,) = (k for k, line in enumerate(lines) if line == f"origin of frame 7 by {costs[0]}")
    assert lines[at + 1] == f"origin of frame 7 by {costs[1]}"
    q = np.array([0.3, -0.7, 0.5, 1.1, 0.2, -0.4, 0.9])
    names = {"sin": np.sin, "cos": np.cos, "L": 0.4, "M": 0.39, **{f"q{i + 1}": x for i, x in enumerate(q)}}
    *_, last, _ = link_frames(lwr_dyn.load("lwr4").chain, q)
    for k, axis in enumerate("xyz"):
        name, _, expression = lines[at + 2 + k].strip().partition(" = ")
        assert name == axis
        assert abs(eval(expression, names) - last[k, 3]) < 1e-12
