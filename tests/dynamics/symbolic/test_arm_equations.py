"""Euler-Lagrange in symbols: the derivation agrees with itself, with Pinocchio and with both of its own texts."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.dynamics.symbolic.arm_equations import equations_of_motion, euler_lagrange, reduced_chain, symbolic_links
from lwr_dyn.dynamics.symbolic.equation_forms import compile_equations
from lwr_dyn.dynamics.symbolic.link_motion import Variables, normal_form, readable
from lwr_dyn.foundation.errors import OptionError, ShapeError, UnknownNameError
from tests.random_arms import random_arm

KR30, LWR, RPR = lwr_dyn.load("kr30ha"), lwr_dyn.load("lwr4plus"), random_arm(3, "RPR")
PAPERS = {"kr30ha": open_paper("kr30ha"), "lwr4plus": open_paper("lwr4plus")}
RELATIVE = 1e-12
"""Of the largest entry: a few hundred roundings of 1e-16."""
CASES = {
    "first two of the KR 30": (KR30, ("A1", "A2"), None, True),
    "first two of the LWR, with rotors": (LWR, ("joint_1", "joint_2"), None, True),
    "numbers instead of letters": (LWR, ("joint_1", "joint_2"), None, False),
    "a held joint before and between": (LWR, ("joint_2", "joint_4"), {"joint_1": 0.3, "joint_3": np.pi / 2}, True),
    "elbow and wrist of the KR 30": (KR30, ("A3", "A5"), {"A1": 0.0, "A2": -np.pi / 2, "A4": 0.0}, True),
    "a sliding joint": (RPR, RPR.joint_names, None, False),
    "a held joint beyond, at no right angle": (KR30, ("A2",), {"A1": 0.0, "A3": 0.4}, True),
}


def derived(case, keep_zeros=True):
    arm, joints, held, letters = CASES[case]
    return equations_of_motion(arm, joints, held, PAPERS[arm.name] if letters else None, keep_zeros)


@pytest.fixture(scope="module")
def kr30():
    return derived("first two of the KR 30")


QUICK = ("first two of the LWR, with rotors", "numbers instead of letters", "a held joint beyond, at no right angle")


@pytest.mark.parametrize("case", [x if x in QUICK else pytest.param(x, marks=pytest.mark.slow) for x in CASES])
def test_the_numbers_are_pinocchios_on_the_reduced_model(case):
    part = derived(case)
    symbolic = compile_equations(part.equations).at(part.values)
    engine = lwr_dyn.dynamics_of(part.arm)
    assert isinstance(symbolic, Dynamics)
    q, dq, ddq = np.random.default_rng(1).uniform(-2, 2, (3, 50, part.arm.n))
    tau = engine.inverse_dynamics(q, dq, ddq)
    pairs = {
        "B": (symbolic.mass_matrix(q), engine.mass_matrix(q)),
        "C": (symbolic.coriolis_matrix(q, dq), engine.coriolis_matrix(q, dq)),
        "g": (symbolic.gravity_vector(q), engine.gravity_vector(q)),
        "bias": (symbolic.bias_torque(q, dq), engine.bias_torque(q, dq)),
        "tau": (symbolic.inverse_dynamics(q, dq, ddq), tau),
    }
    for name, (ours, theirs) in pairs.items():
        assert np.abs(ours - theirs).max() <= RELATIVE * max(np.abs(theirs).max(), np.abs(tau).max()), name
    assert np.abs(symbolic.forward_dynamics(q, dq, tau) - ddq).max() < 1e-10  # through the inverse of B
    difference = symbolic.potential_energy(q) - engine.potential_energy(q)
    assert np.ptp(difference) <= RELATIVE * np.ptp(engine.potential_energy(q))


def test_the_lagrange_equations_are_B_ddq_plus_C_dq_plus_g_exactly(kr30):
    assert kr30.equations.residual() == sp.zeros(2, 1)
    broken = replace(kr30.equations, C=2 * kr30.equations.C)
    assert broken.residual() != sp.zeros(2, 1)


def test_laws_hold_in_symbols(kr30):
    e, x = kr30.equations, kr30.equations.variables
    assert e.B == e.B.T
    assert normal_form(x.derivative(e.B) - e.C - e.C.T, x.q) == sp.zeros(2, 2)
    rates = sp.Matrix(x.dq)
    assert normal_form(e.kinetic - (rates.T * e.B * rates)[0] / 2, x.q) == 0
    assert e.lagrangian == e.kinetic - e.potential


def test_the_first_two_joints_of_a_mirror_symmetric_kr30_come_out_as_by_hand(kr30):
    a1, a2, c1x, c2x, m1, m2, g0, q2 = sp.symbols("a1 a2 c1x c2x m1 m2 g0 q2")
    I1yy, I2xx, I2yy, I2zz = sp.symbols("I1yy I2xx I2yy I2zz")
    reach = a1 + (a2 + c2x) * sp.cos(q2)
    b11 = I1yy + I2xx * sp.sin(q2) ** 2 + I2yy * sp.cos(q2) ** 2 + m1 * (a1 + c1x) ** 2 + m2 * reach**2
    e, q = kr30.equations, kr30.equations.variables.q
    assert normal_form(sp.diag(b11, I2zz + m2 * (a2 + c2x) ** 2), q) == e.B
    assert e.g == normal_form(sp.Matrix([0, -m2 * g0 * (a2 + c2x) * sp.cos(q2)]), q)


def test_right_angles_leave_exact_zeros_and_only_the_letters_that_matter():
    part = derived("first two of the KR 30", keep_zeros=False)
    e = part.equations
    assert (e.g[0], e.C[1, 1]) == (0, 0)
    assert not any(number.is_Float for m in (e.B, e.C, e.g, e.tau) for number in m.atoms(sp.Number))
    names = {s.name for s in e.parameters}
    assert {"a1", "a2", "d1", "g0", "m1", "m2", "I1yy", "I2xy"} <= names
    assert not names & {"I1xx", "I1zz", "d4", "m3"}


def test_velocities_and_accelerations_are_those_of_the_position(kr30):
    x = kr30.equations.variables
    for motion in kr30.equations.motions:
        p = motion.position_in_base()
        v = motion.in_base(motion.velocity, x.q)
        assert normal_form(x.derivative(p), x.q) == v
        assert normal_form(x.derivative(v), x.q) == motion.in_base(motion.acceleration, x.q)
        omega = motion.in_base(motion.omega, x.q)
        R = motion.pose[:3, :3]
        spin = normal_form(x.derivative(R) * R.T, x.q)
        assert sp.Matrix([spin[2, 1], spin[0, 2], spin[1, 0]]) == omega
        assert normal_form(x.derivative(omega), x.q) == motion.in_base(motion.domega, x.q)


@pytest.mark.slow
def test_readable_changes_the_look_and_not_the_value(kr30):
    e = kr30.equations
    assert normal_form(readable(e.tau, e.rates, e.weights) - e.tau, e.variables.q) == sp.zeros(2, 1)


def test_normal_form_distinguishes_equal_from_unequal():
    a, b = sp.symbols("a b")
    assert normal_form(sp.sin(a + b) - sp.sin(a) * sp.cos(b) - sp.cos(a) * sp.sin(b), [a, b]) == 0
    assert normal_form(sp.cos(3 * a) - 4 * sp.cos(a) ** 3 + 3 * sp.cos(a), [a]) == 0
    assert normal_form(sp.sin(a) - sp.sin(b), [a, b]) != 0


def test_bad_input_is_named(kr30):
    links = symbolic_links(KR30.chain, PAPERS["kr30ha"])
    with pytest.raises(OptionError, match=r"moving \[2\], held \[\]; allowed: 1 to k"):
        reduced_chain(links, [1])
    with pytest.raises(OptionError, match=r"moving \[1, 1\]"):
        reduced_chain(links, [0, 0])
    with pytest.raises(OptionError, match="none with a joint; allowed: at least one"):
        euler_lagrange([], sp.zeros(3, 1))
    with pytest.raises(UnknownNameError, match="no joint named 'A7'"):
        equations_of_motion(KR30, ["A7"])
    with pytest.raises(ShapeError, match="q: 3 numbers; allowed: 2 numbers, one per joint"):
        compile_equations(kr30.equations).at(kr30.values).mass_matrix([0, 0, 0])


def test_derivatives_in_time_follow_the_chain_rule():
    x = Variables.of([sp.Symbol("q1")])
    q, dq, ddq = x.q[0], x.dq[0], x.ddq[0]
    assert sp.expand(x.derivative(sp.sin(q) * dq) - (sp.cos(q) * dq**2 + sp.sin(q) * ddq)) == 0
